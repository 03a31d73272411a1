//! The boot files of a system: its boot loader entry, the kernel, and the initramfs.
//!
//! Owns the format of `dreams.start`, the file that contains them, and their layout on a boot partition, where there
//! are two copies of each system. The entry has the system's version, its root hash, and the size and SHA-256 of each
//! part and of itself. `image-build/start` writes the file. No file is read or written here.
//!
//! Start at [`StartFile::read`] and [`lay_out`].

use crate::names::{NameError, Version};
use sha2::{Digest, Sha256};
use std::fmt::Write;

/// The boot loader's folder of entries on a boot partition.
pub const ENTRIES: &str = "loader/entries";
/// The folder of kernels and initramfs there, with a subfolder for each copy of each system.
pub const SYSTEMS: &str = "EFI/dreams";
/// The number of copies of a good system on each boot partition. They are named 1 and 2.
pub const COPIES: u8 = 2;
/// The copy number in a start file.
const FIRST: u8 = 1;
/// The kernel parameters with the version and the root hash.
const VERSION: &[u8] = b"dreams.version=";
const ROOT: &[u8] = b"dreams.root=";
/// A line of an entry with name, size and SHA-256 of a part; the parts follow the entry in the same order.
const PART: &str = "# part ";
/// The last line of an entry: the SHA-256 of all lines above.
const SEAL: &str = "# entry ";

/// The head of a start file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StartFile {
    /// The version of its system.
    pub version: Version,
    /// The UUID in the verity superblock of a slot with this root, in hex digits.
    pub slot: String,
    /// The number of 4096-byte blocks of the root. The superblock and the hash tree follow them.
    pub blocks: u64,
    /// The salt of every hash, in hex digits.
    pub salt: String,
    /// The root hash, in hex digits.
    pub hash: String,
}

/// The files of one copy of a system on a boot partition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BootFiles<'b> {
    /// The text of its entry.
    pub entry: String,
    /// The path of each part on the boot partition, and its contents.
    pub parts: Vec<(String, &'b [u8])>,
}

/// Why a file is no start file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StartFileError {
    /// It names no system or no root.
    #[error("the boot entry does not name its system")]
    Mute,
    /// It names a version which is none.
    #[error("the boot entry names no valid system version")]
    Unversioned(#[source] NameError),
}

/// A part as listed in the entry.
struct Part<'b> {
    name: &'b str,
    size: usize,
    sum: &'b str,
}

impl<'b> Part<'b> {
    /// `None` if the line has another form.
    fn read(line: &'b str) -> Option<Self> {
        let words: Vec<_> = line.split(' ').collect();
        let [name, size, sum] = words[..] else { return None };
        let is_name = !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_lowercase());
        is_name.then_some(Self { name, size: size.parse().ok()?, sum })
    }
}

impl StartFile {
    /// Parses the start file `bytes`, or an entry alone. Checksums are verified in [`lay_out`].
    ///
    /// # Errors
    /// [`StartFileError`] if version or root hash are missing or invalid.
    pub fn read(bytes: &[u8]) -> Result<Self, StartFileError> {
        let version = word(bytes, VERSION).ok_or(StartFileError::Mute)?;
        let version = Version::parse(version).map_err(StartFileError::Unversioned)?;
        let words: Vec<_> = word(bytes, ROOT).ok_or(StartFileError::Mute)?.splitn(4, ':').collect();
        let [slot, blocks, salt, hash] = words[..] else { return Err(StartFileError::Mute) };
        let blocks = blocks.parse().map_err(|_| StartFileError::Mute)?;
        Ok(Self { version, slot: slot.to_owned(), blocks, salt: salt.to_owned(), hash: hash.to_owned() })
    }
}

/// The folder of a copy, below [`SYSTEMS`].
#[must_use]
pub fn copy_folder(version: &Version, copy: u8) -> String {
    format!("{version}_{copy}")
}

/// The files of the start file `bytes` on a boot partition as this copy; `None` if any byte is damaged.
#[must_use]
pub fn lay_out(bytes: &[u8], copy: u8) -> Option<BootFiles<'_>> {
    let entry = sealed(bytes)?;
    let version = StartFile::read(entry.as_bytes()).ok()?.version;
    let folder = copy_folder(&version, copy);
    let mut rest = &bytes[entry.len()..];
    let mut parts = Vec::new();
    for Part { name, size, sum } in listed(entry)? {
        let (part, behind) = rest.split_at_checked(size)?;
        if sha256(part) != sum {
            return None;
        }
        parts.push((format!("{SYSTEMS}/{folder}/{name}"), part));
        rest = behind;
    }
    let entry = entry.replace(&copy_folder(&version, FIRST), &folder);
    rest.is_empty().then_some(BootFiles { entry, parts })
}

/// The start file from the files of this copy, which `read` returns by path; `None` if one is missing or has another
/// size. Checksums are not verified.
pub fn gather(entry: &str, copy: u8, mut read: impl FnMut(&str) -> Option<Vec<u8>>) -> Option<Vec<u8>> {
    let version = StartFile::read(entry.as_bytes()).ok()?.version;
    let folder = copy_folder(&version, copy);
    let mut bytes = entry.replace(&folder, &copy_folder(&version, FIRST)).into_bytes();
    for Part { name, size, .. } in listed(entry)? {
        let part = read(&format!("{SYSTEMS}/{folder}/{name}"))?;
        if part.len() != size {
            return None;
        }
        bytes.extend(part);
    }
    Some(bytes)
}

/// The entry at the start of `bytes`, if its checksum is right.
fn sealed(bytes: &[u8]) -> Option<&str> {
    let seal = format!("\n{SEAL}");
    let at = bytes.windows(seal.len()).position(|window| window == seal.as_bytes())? + 1;
    let line = bytes[at..].split(|byte| *byte == b'\n').next()?;
    let sum = std::str::from_utf8(line).ok()?.strip_prefix(SEAL)?;
    let entry = std::str::from_utf8(bytes.get(..at + line.len() + 1)?).ok()?;
    (sha256(&bytes[..at]) == sum).then_some(entry)
}

/// The parts listed in an entry.
fn listed(entry: &str) -> Option<Vec<Part<'_>>> {
    entry.lines().filter_map(|line| line.strip_prefix(PART)).map(Part::read).collect()
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").expect("a string takes all");
        text
    })
}

/// The value of the parameter `key` in `bytes`.
fn word<'b>(bytes: &'b [u8], key: &[u8]) -> Option<&'b str> {
    let at = bytes.windows(key.len()).position(|window| window == key)? + key.len();
    let end = bytes[at..].iter().position(|byte| byte.is_ascii_whitespace() || *byte == 0)?;
    std::str::from_utf8(&bytes[at..at + end]).ok()
}

#[cfg(test)]
mod tests {
    use super::{BootFiles, StartFile, StartFileError, gather, lay_out, sha256};
    use std::fmt::Write;

    /// A start file as `image-build/start` writes it.
    fn started() -> Vec<u8> {
        let (linux, initramfs) = ([7; 300], [9; 200]);
        let mut entry = "title x\nversion 0.2.0\nlinux /EFI/dreams/0.2.0_1/linux\noptions initrd=\\EFI\\dreams\\0.2.0_1\\initramfs \
                         dreams.version=0.2.0 dreams.root=ab:4:cd:ef\n"
            .to_owned();
        for (name, part) in [("linux", &linux[..]), ("initramfs", &initramfs[..])] {
            writeln!(entry, "# part {name} {} {}", part.len(), sha256(part)).unwrap();
        }
        let sum = sha256(entry.as_bytes());
        writeln!(entry, "# entry {sum}").unwrap();
        [entry.as_bytes(), &linux, &initramfs].concat()
    }

    #[test]
    fn any_byte_that_changes_is_seen() {
        let whole = started();
        assert!(lay_out(&whole, 1).is_some());
        for at in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 0x10;
            assert_eq!(lay_out(&damaged, 1), None, "byte {at}");
            assert_eq!(lay_out(&whole[..at], 1), None, "{at} bytes are left");
        }
        assert_eq!(lay_out(&[&whole[..], b"more"].concat(), 1), None);
    }

    #[test]
    fn a_copy_starts_what_lies_in_its_own_folder_and_is_the_same_start_file() {
        let whole = started();
        for copy in [1, 2] {
            let BootFiles { entry, parts } = lay_out(&whole, copy).unwrap();
            assert!(entry.contains(&format!("linux /EFI/dreams/0.2.0_{copy}/linux\n")), "{entry}");
            assert!(entry.contains(&format!("initrd=\\EFI\\dreams\\0.2.0_{copy}\\initramfs ")), "{entry}");
            let read = |path: &str| parts.iter().find(|(name, _)| *name == path).map(|(_, part)| part.to_vec());
            assert_eq!(gather(&entry, copy, read).unwrap(), whole);
            assert_eq!(gather(&entry, copy, |_| Some(vec![7; 300])), None, "a part of another size");
            let other = gather(&entry, 3 - copy, read);
            assert!(other.is_none_or(|bytes| lay_out(&bytes, 1).is_none()), "the entry starts another folder");
        }
    }

    #[test]
    fn a_start_file_says_which_system_and_which_root_it_starts() {
        let says = |text: &str| StartFile::read(format!("options quiet {text} gpt\n").as_bytes());
        let found = says("dreams.version=0.2.0 dreams.root=ab12:40:cd:ef").unwrap();
        assert_eq!((found.version.to_string(), found.blocks), ("0.2.0".to_owned(), 40));
        assert_eq!([found.slot, found.salt, found.hash], ["ab12", "cd", "ef"]);
        for mute in ["", "dreams.version=0.2.0", "dreams.root=a:2:b:c", "dreams.version=1 dreams.root=a:b:c:d"] {
            assert_eq!(says(mute), Err(StartFileError::Mute), "`{mute}`");
        }
        assert!(matches!(says("dreams.version=next dreams.root=a:2:b:c"), Err(StartFileError::Unversioned(_))));
    }
}
