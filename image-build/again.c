/* Starts the boot loader again when that comes back.
 *
 * A boot loader comes back when what it was to start is damaged. Most firmware then goes on to whatever else it finds: its
 * menus, a shell, another disk. Here the boot loader is started twice from this boot partition, twice from the other one on
 * the same disk, and then the machine is reset. The boot loader itself counts: each time it takes another copy.
 *
 * `init` makes it the first entry of the boot loader, but where Secure Boot is on with keys that are not the artist's: there
 * shim does the like. It leaves the boot loader a word, in memory, that what is wanted now is a system. It says nothing.
 */
#include <efi.h>
#include <efilib.h>

#define LOADER L"\\EFI\\BOOT\\grubx64.efi"
/* As many as there are copies of a system on a partition. */
#define ATTEMPTS 2
/* Systemd's own name for its variables, and which entries are wanted: those of systems, not this one. */
#define LOADER_GUID { 0x4a67b082, 0x0a4c, 0x41cf, { 0xb6, 0xc7, 0x44, 0x0b, 0x29, 0xbb, 0x8c, 0x4f } }
#define WANTED L"dreams_*"

/* How many bytes of a device path name the disk that a partition lies on; 0 if it is no partition. */
static UINTN disk_length(EFI_DEVICE_PATH *path)
{
	EFI_DEVICE_PATH *node;

	for (node = path; node && !IsDevicePathEnd(node); node = NextDevicePathNode(node))
		if (DevicePathType(node) == MEDIA_DEVICE_PATH && DevicePathSubType(node) == MEDIA_HARDDRIVE_DP)
			return (UINT8 *)node - (UINT8 *)path;
	return 0;
}

/* Whether two partitions lie on one disk. */
static BOOLEAN is_beside(EFI_HANDLE one, EFI_HANDLE other)
{
	EFI_DEVICE_PATH *a = DevicePathFromHandle(one), *b = DevicePathFromHandle(other);
	UINTN length = disk_length(a);

	return length && disk_length(b) == length && CompareMem(a, b, length) == 0;
}

/* Starts the boot loader of a partition as often as there are copies to start. */
static void start(EFI_HANDLE self, EFI_HANDLE partition)
{
	EFI_GUID guid = LOADER_GUID;
	EFI_HANDLE image;
	UINTN i;

	for (i = 0; i < ATTEMPTS; i++) {
		RT->SetVariable(L"LoaderEntryOneShot", &guid, EFI_VARIABLE_BOOTSERVICE_ACCESS | EFI_VARIABLE_RUNTIME_ACCESS,
			sizeof(WANTED), WANTED);
		if (BS->LoadImage(FALSE, self, FileDevicePath(partition, LOADER), NULL, 0, &image) == EFI_SUCCESS)
			BS->StartImage(image, NULL, NULL);
	}
}

EFI_STATUS efi_main(EFI_HANDLE image, EFI_SYSTEM_TABLE *table)
{
	EFI_LOADED_IMAGE_PROTOCOL *loaded;
	EFI_HANDLE *handles = NULL;
	UINTN count = 0, i;

	InitializeLib(image, table);
	if (BS->HandleProtocol(image, &LoadedImageProtocol, (void **)&loaded) != EFI_SUCCESS)
		return EFI_LOAD_ERROR;
	start(image, loaded->DeviceHandle);

	/* A firmware in a hurry knows of no file system but the one that it has started from. */
	if (LibLocateHandle(ByProtocol, &BlockIoProtocol, NULL, &count, &handles) == EFI_SUCCESS)
		for (i = 0; i < count; i++)
			if (is_beside(loaded->DeviceHandle, handles[i]))
				BS->ConnectController(handles[i], NULL, NULL, TRUE);
	if (LibLocateHandle(ByProtocol, &FileSystemProtocol, NULL, &count, &handles) == EFI_SUCCESS)
		for (i = 0; i < count; i++)
			if (handles[i] != loaded->DeviceHandle && is_beside(loaded->DeviceHandle, handles[i]))
				start(image, handles[i]);
	RT->ResetSystem(EfiResetCold, EFI_SUCCESS, 0, NULL);
	return EFI_LOAD_ERROR;
}
