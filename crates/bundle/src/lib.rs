//! A signed flock ready to travel, and the store of a unit that takes it in.
//!
//! Owns the bundle: a folder that lies equally well on a stick and on any static web server. A signed [`Seal`] says
//! for whom it is and names the list of files, the list names the files by their content, and nothing is believed
//! before it was checked: [`Unverified::verify`] leads to a [`Seal`], [`Seal::fetch`] to a [`Verified`] bundle, and
//! only that has files. A [`System`] travels in the same way. Owns also the store of a unit, shared by its generations. No archives, no compression.
//! Never opens a socket, never mounts, never reads a clock.
//!
//! Start at [`Unverified`], then [`Store`].
#![forbid(unsafe_code)]

mod beneath;
mod contents;
mod envelope;
mod folder;
mod key;
pub mod limits;
mod lines;
mod names;
mod refused;
mod seal;
mod secret;
mod signed;
mod source;
mod start_file;
mod store;
mod system;
mod trust;

pub use contents::{Contents, FileEntry, Verified};
pub use envelope::SignError;
pub use folder::{Folder, FolderError, Put, Swept};
pub use key::{KeyError, KeyId, PublicKey};
pub use names::{Addressees, FilePath, NameError, ObjectId, Sequence, UnitId, Version, few};
pub use refused::{Part, Refused};
pub use seal::{Letter, Seal, Unverified, path as seal_path};
pub use secret::SecretKey;
pub use source::{STATEMENTS, Source};
pub use start_file::{COPIES, ENTRIES, LaidOut, SYSTEMS, StartFile, StartFileError, copy_folder, gather, lay_out};
pub use store::{
    Admission, Append, CURRENT, Consent, Disk, Frozen, Generation, Held, Intake, JOINS, Judge, LocalDisk, Plan,
    Playing, STARTS, Scrubbed, Shortfall, State, Store, StoreError, SystemAdmission, Trial, Unknown, Unread, Verdict,
    Wanted, plan,
};
pub use system::{Release, System, UnverifiedSystem, copy_object, path as system_path};
pub use trust::{Learned, Lesson, Statement, Trust, statements};
