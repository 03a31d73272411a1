//! Bundles (signed flocks for transfer to units), and the store of a unit that installs them.
//!
//! Owns the bundle: a folder that works on a stick and on any static web server. A signed [`Seal`] names the addressees
//! and the digest of the list of files; the list names the files by their digests. Everything is verified before it is
//! used: [`UnverifiedSeal::verify`] returns a [`Seal`], [`Seal::fetch`] a [`VerifiedBundle`], and only that has files.
//! A [`System`] is transferred in the same way, and [`SignedSettings`] beside them. Owns also the store of a unit, shared by its generations. No archives,
//! no compression. Never opens a socket, mounts or reads a clock.
//!
//! Start at [`UnverifiedSeal`], then [`Store`].
#![forbid(unsafe_code)]

mod beneath;
mod contents;
mod envelope;
mod folder;
mod key;
pub mod limits;
mod lines;
mod names;
mod refusal;
mod seal;
mod secret;
mod settings;
mod signed;
mod source;
mod start_file;
mod store;
mod system;
mod trust;

pub use contents::{Contents, FileEntry, VerifiedBundle};
pub use envelope::SignError;
pub use folder::{Folder, FolderError, PutMethod, Sweep};
pub use key::{KeyError, KeyId, PublicKey};
pub use names::{Addressees, FilePath, NameError, ObjectId, Sequence, UnitId, Version, few};
pub use refusal::{Part, Refusal};
pub use seal::{Seal, SealBody, UnverifiedSeal, path as seal_path};
pub use secret::SecretKey;
pub use settings::{SettingsBody, SignedSettings, UnverifiedSettings, path as settings_path};
pub use source::{STATEMENTS, Source};
pub use start_file::{BootFiles, COPIES, ENTRIES, SYSTEMS, StartFile, StartFileError, copy_folder, gather, lay_out};
pub use store::{
    Admission, CURRENT, Consent, CurrentGeneration, Disk, FetchItem, FetchPlan, Generation, Intake, JOINS, LocalDisk,
    Presence, Protection, STARTS, Scrub, Shortfall, StagedSystems, State, Store, StoreError, SystemAdmission, Trial,
    TrialRecorder, Unknown, UnreadableObject, Verdict, plan, with_learned,
};
pub use system::{Release, System, UnverifiedSystem, copy_object, path as system_path};
pub use trust::{Statement, Trust, TrustChange, TrustUpdate, statements};
