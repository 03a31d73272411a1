//! Files on exFAT, the file system of new sticks.
//!
//! Owns copying a folder into a file system that `mkfs.exfat` made; `fsck.exfat` checks the result. exfatprogs has no
//! tool that copies files, mtools knows FAT only, and mounting needs root and a kernel with exFAT.
//!
//! Start at [`make`].

use aligned::{A1, Aligned};
use claims::programs::succeed;
use exfat_slim::blocking::BlockDevice;
use exfat_slim::blocking::file_system::FileSystem;
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::process::Command;

/// The size of a sector.
const SECTOR: usize = 512;
/// The number of sectors that the library keeps in memory.
const CACHE: usize = 4;

/// An image as a disk of sectors.
struct Disk(File);

impl BlockDevice<SECTOR> for Disk {
    type Error = io::Error;
    type Align = A1;

    fn read(&mut self, first: u32, sectors: &mut [Aligned<A1, [u8; SECTOR]>]) -> io::Result<()> {
        let offsets = (u64::from(first)..).map(|sector| sector * SECTOR as u64);
        sectors.iter_mut().zip(offsets).try_for_each(|(sector, at)| self.0.read_exact_at(&mut sector[..], at))
    }

    fn write(&mut self, first: u32, sectors: &[Aligned<A1, [u8; SECTOR]>]) -> io::Result<()> {
        let offsets = (u64::from(first)..).map(|sector| sector * SECTOR as u64);
        sectors.iter().zip(offsets).try_for_each(|(sector, at)| self.0.write_all_at(&sector[..], at))
    }

    fn size(&mut self) -> io::Result<u64> {
        Ok(self.0.metadata()?.len())
    }
}

/// Makes the file system `image` of `bytes` bytes with the files in `folder`.
pub(crate) fn make(image: &Path, bytes: u64, folder: &Path) {
    File::create(image).unwrap().set_len(bytes).unwrap();
    succeed(Command::new("mkfs.exfat").args(["-c", "32K"]).arg(image));
    let disk = Disk(File::options().read(true).write(true).open(image).unwrap());
    let mut exfat = FileSystem::<_, SECTOR, CACHE>::new(disk);
    exfat.mount().unwrap();
    copy(folder, "", &mut exfat);
    exfat.unmount();
    succeed(Command::new("fsck.exfat").arg("-n").arg(image));
}

/// Copies the files in `folder`, none of which is empty, to the path `to`.
fn copy(folder: &Path, to: &str, exfat: &mut FileSystem<Disk, SECTOR, CACHE>) {
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        let to = format!("{to}/{}", path.file_name().unwrap().to_str().unwrap());
        if path.is_dir() {
            exfat.create_directory(&to).unwrap();
            copy(&path, &to, exfat);
        } else {
            exfat.write(&to, fs::read(&path).unwrap()).unwrap();
        }
    }
}
