/* Sets up the verified root: what `dmsetup create root --readonly --table ...` does, in a hundredth of its size.
 *
 *   verity SECTORS PARAMETERS   makes /dev/dm-0 of so many sectors by the kernel's `verity` target; where it is there
 *                               already, in use or not, it goes by these parameters from now on
 *
 * Exit status: 0 it is there; 1 the kernel refused.
 */
#include <errno.h>
#include <fcntl.h>
#include <linux/dm-ioctl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>

/* The request that all three commands take, and what a table has behind it. */
static struct {
	struct dm_ioctl head;
	struct dm_target_spec target;
	char parameters[4096];
} request;

static int ask(int control, unsigned long command, unsigned int flags)
{
	memset(&request.head, 0, sizeof(request.head));
	request.head.version[0] = DM_VERSION_MAJOR;
	request.head.data_size = sizeof(request);
	request.head.data_start = sizeof(request.head);
	request.head.flags = flags;
	request.head.target_count = command == DM_TABLE_LOAD;
	strcpy(request.head.name, "root");
	return ioctl(control, command, &request) == 0;
}

int main(int count, char **words)
{
	int control = open("/dev/mapper/control", O_RDWR | O_CLOEXEC);

	if (count != 3 || control < 0 || strlen(words[2]) >= sizeof(request.parameters))
		return 1;
	if (!ask(control, DM_DEV_CREATE, 0) && errno != EBUSY)
		return 1;
	request.target.length = strtoull(words[1], NULL, 10);
	strcpy(request.target.target_type, "verity");
	strcpy(request.parameters, words[2]);
	/* A table that is loaded comes into force when the device is resumed. */
	return !(ask(control, DM_TABLE_LOAD, DM_READONLY_FLAG) && ask(control, DM_DEV_SUSPEND, DM_SKIP_LOCKFS_FLAG));
}
