/* The first program that the firmware starts: passes on to the boot loader of a partition on which nothing is damaged.
 *
 * A unit has two boot partitions. This program lies on both, and looks first at the one that it was started from. There it
 * reads the boot loader and every start file through. If all of them are whole it starts the boot loader, which counts and
 * chooses. If the boot loader or a start file is damaged it starts the other partition's boot loader if all is whole there;
 * else any start file that is whole, on either partition. It writes nothing and says nothing.
 *
 * A whole file bears its own sum, as `stamp` has written it: at 0x28 of the file `dreams`, zero, zero; then its size
 * and its CRC-32, both little endian. The sum is that of so many bytes of the file with zeros in the place of these sixteen,
 * of the checksum of the PE header and of its pointer to a signature: a file may be signed later.
 */
#include <efi.h>
#include <efilib.h>

#define LOADER L"\\EFI\\systemd\\systemd-bootx64.efi"
#define ENTRIES L"\\EFI\\Linux\\"
#define STAMP_AT 0x28
/* Of a path of a start file; the longest version is much shorter. */
#define PATH_LENGTH 128

struct stamp {
	CHAR8 word[8];
	UINT32 size;
	UINT32 sum;
};

/* A boot partition, and what is known of it. */
struct volume {
	EFI_HANDLE handle;
	/* Whether its boot loader and all of its start files are whole, and there is one at least. */
	BOOLEAN is_whole;
	/* Some start file that is whole, or empty. */
	CHAR16 entry[PATH_LENGTH];
};

static EFI_HANDLE self;

/* Zeros so many bytes of a file at an offset that the file itself has told. */
static void clear(UINT8 *bytes, UINTN size, UINTN at, UINTN count)
{
	if (at <= size && count <= size - at)
		ZeroMem(bytes + at, count);
}

/* Whether a file in memory, which is changed, is what its stamp says. */
static BOOLEAN is_whole(UINT8 *bytes, UINTN length)
{
	struct stamp stamp;
	UINT32 header, sum;

	if (length < STAMP_AT + sizeof(stamp))
		return FALSE;
	CopyMem(&stamp, bytes + STAMP_AT, sizeof(stamp));
	CopyMem(&header, bytes + 0x3c, sizeof(header));
	if (CompareMem(stamp.word, "dreams\0\0", sizeof(stamp.word)) != 0 || stamp.size > length)
		return FALSE;
	clear(bytes, stamp.size, STAMP_AT, sizeof(stamp));
	/* In the optional header, which follows 24 bytes: the checksum, and the fifth of the data directories. */
	clear(bytes, stamp.size, (UINTN)header + 24 + 64, 4);
	clear(bytes, stamp.size, (UINTN)header + 24 + 112 + 4 * 8, 8);
	return BS->CalculateCrc32(bytes, stamp.size, &sum) == EFI_SUCCESS && sum == stamp.sum;
}

/* Whether the file at this path can be read and is whole. */
static BOOLEAN is_whole_at(EFI_FILE_PROTOCOL *root, CHAR16 *path)
{
	EFI_FILE_PROTOCOL *file;
	EFI_FILE_INFO *info;
	BOOLEAN result = FALSE;

	if (root->Open(root, &file, path, EFI_FILE_MODE_READ, 0) != EFI_SUCCESS)
		return FALSE;
	info = LibFileInfo(file);
	if (info) {
		UINTN length = info->FileSize;
		UINT8 *bytes = AllocatePool(length);

		if (bytes && file->Read(file, &length, bytes) == EFI_SUCCESS && length == info->FileSize)
			result = is_whole(bytes, length);
		if (bytes)
			FreePool(bytes);
		FreePool(info);
	}
	file->Close(file);
	return result;
}

/* Whether a name is that of a start file: one that is being written has another ending. */
static BOOLEAN is_entry(const EFI_FILE_INFO *info)
{
	UINTN length = StrLen(info->FileName);

	return !(info->Attribute & EFI_FILE_DIRECTORY) && length > 4 && StrLen(ENTRIES) + length < PATH_LENGTH
		&& StriCmp(info->FileName + length - 4, L".efi") == 0;
}

/* Reads through what is to be started from a volume. */
static void look(struct volume *volume)
{
	EFI_FILE_PROTOCOL *root = LibOpenRoot(volume->handle), *folder;
	UINT8 buffer[1024];
	EFI_FILE_INFO *info = (EFI_FILE_INFO *)buffer;
	BOOLEAN is_sound;

	if (!root)
		return;
	is_sound = is_whole_at(root, LOADER);
	if (root->Open(root, &folder, ENTRIES, EFI_FILE_MODE_READ, 0) == EFI_SUCCESS) {
		for (;;) {
			UINTN size = sizeof(buffer);
			CHAR16 path[PATH_LENGTH];

			if (folder->Read(folder, &size, buffer) != EFI_SUCCESS) {
				is_sound = FALSE;
				break;
			}
			if (size == 0)
				break;
			if (!is_entry(info))
				continue;
			StrCpy(path, ENTRIES);
			StrCat(path, info->FileName);
			if (is_whole_at(root, path))
				StrCpy(volume->entry, path);
			else
				is_sound = FALSE;
		}
		folder->Close(folder);
	}
	root->Close(root);
	volume->is_whole = is_sound && volume->entry[0];
}

/* Starts a file of a volume; comes back if it can't be started or gives up. */
static void start(struct volume *volume, CHAR16 *path)
{
	EFI_HANDLE image;

	if (BS->LoadImage(FALSE, self, FileDevicePath(volume->handle, path), NULL, 0, &image) == EFI_SUCCESS)
		BS->StartImage(image, NULL, NULL);
}

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

/* The partitions of the disk on which `here` lies that have this protocol; the caller frees them. */
static EFI_HANDLE *neighbours(EFI_HANDLE here, EFI_GUID *protocol, UINTN *count)
{
	EFI_HANDLE *handles = NULL;
	UINTN all = 0, i;

	*count = 0;
	if (LibLocateHandle(ByProtocol, protocol, NULL, &all, &handles) != EFI_SUCCESS)
		return NULL;
	for (i = 0; i < all; i++)
		if (handles[i] != here && is_beside(here, handles[i]))
			handles[(*count)++] = handles[i];
	return handles;
}

EFI_STATUS efi_main(EFI_HANDLE image, EFI_SYSTEM_TABLE *table)
{
	EFI_LOADED_IMAGE_PROTOCOL *loaded;
	EFI_HANDLE *handles;
	struct volume *volumes;
	UINTN count, i;

	InitializeLib(image, table);
	self = image;
	if (BS->HandleProtocol(image, &LoadedImageProtocol, (void **)&loaded) != EFI_SUCCESS)
		return EFI_LOAD_ERROR;
	/* A firmware in a hurry knows of no file system but the one that it has started from. */
	handles = neighbours(loaded->DeviceHandle, &BlockIoProtocol, &count);
	for (i = 0; i < count; i++)
		BS->ConnectController(handles[i], NULL, NULL, TRUE);
	handles = neighbours(loaded->DeviceHandle, &FileSystemProtocol, &count);
	volumes = AllocateZeroPool((count + 1) * sizeof(*volumes));
	if (!volumes)
		return EFI_OUT_OF_RESOURCES;
	volumes[0].handle = loaded->DeviceHandle;
	for (i = 0; i < count; i++)
		volumes[i + 1].handle = handles[i];

	for (i = 0; i <= count; i++) {
		look(&volumes[i]);
		if (volumes[i].is_whole)
			start(&volumes[i], LOADER);
	}
	for (i = 0; i <= count; i++)
		if (volumes[i].entry[0])
			start(&volumes[i], volumes[i].entry);
	/* The firmware goes on with what else it may start. */
	return EFI_LOAD_ERROR;
}
