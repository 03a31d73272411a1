//! `flock pack`: from a flock to a bundle.
//!
//! Owns the command and its order: what would not play is refused before anything is written, and the seal comes last.
//! Never changes the flock, and never hands out a bundle that it could not have taken in itself.
//!
//! Start at [`run`].

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use bundle::{
    Addressees, Contents, Folder, FolderError, KeyId, ObjectId, PutMethod, SealBody, SecretKey, Sequence, Trust,
    UnitId, UnverifiedSeal,
};
use flock::{FILE_NAME, Fault, FaultKind, Flock, Manifest};
use indicatif::DecimalBytes;

use super::counter::Counter;
use super::{listing, passphrase, refused, shelf, unmoved, unsigned};
use crate::check;
use crate::now;
use crate::open;
use crate::progress;
use crate::report::{self, Exit, Fatal};

/// Check a flock, and sign it as a bundle that travels to its units
///
/// The flock is checked as `flock check --joins` does, and refused if it has a fault. The bundle is a folder: copy it
/// to a stick or a web server, or let `flock publish` do it. Clips are shared with the flock where the disk can do that, so leave them unchanged:
/// make new ones in new files, as all commands here do. Several bundles
/// may lie in one folder, one for each unit, and share what they have in common. Each bundle of a key gets a higher
/// number than the one before; the last one stands in a file beside the key.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the bundle is there
  1  the flock has faults, each of which is named; or the key does not open, or others can read it
  2  the command line, the manifest, the system or the key is wrong
  3  a file could not be read or written")]
#[expect(clippy::struct_excessive_bools, reason = "independent switches")]
pub(crate) struct Args {
    /// Folder of the flock
    pub(super) dir: PathBuf,
    /// Folder of the bundle; made if it is not there
    pub(super) bundle: PathBuf,
    /// The folder is no flock but a system, as `make image` leaves it
    #[arg(long, conflicts_with = "allow_jumps")]
    pub(crate) system: bool,
    /// The secret key that signs
    #[arg(long, value_name = "KEY")]
    pub(super) key: PathBuf,
    /// A unit that it is for; may be repeated [default: every unit that trusts the key]
    #[arg(long = "unit", value_name = "UNIT", value_parser = UnitId::new)]
    pub(super) units: Vec<UnitId>,
    /// The bundle's number, above all earlier ones of this key [default: the next]
    #[arg(long, value_name = "N", value_parser = Sequence::parse)]
    pub(super) sequence: Option<Sequence>,
    /// A statement about keys, as `flock keygen` writes it, that is to travel along; may be repeated
    #[arg(long = "statement", value_name = "FILE")]
    pub(super) statements: Vec<PathBuf>,
    /// Pack a system that does not itself trust the key: its units do otherwise, as by their owners' word
    #[arg(long, requires = "system")]
    pub(super) allow_untrusted: bool,
    /// Pack it even if joins jump
    #[arg(long)]
    allow_jumps: bool,
    /// Take the passphrase from the first line of this file
    #[arg(long, value_name = "FILE")]
    pub(super) passphrase_file: Option<PathBuf>,
    /// Answer with one JSON document
    #[arg(long)]
    pub(super) json: bool,
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct Answer<'a> {
    packed: bool,
    faults: &'a [Fault],
    #[serde(flatten)]
    bundle: Option<&'a Packed>,
}

/// A bundle that was packed.
#[derive(serde::Serialize)]
struct Packed {
    flock: String,
    /// Empty if it is for every unit.
    units: Vec<String>,
    sequence: Sequence,
    signer: KeyId,
    files: usize,
    bytes: u64,
    /// How the objects came there.
    #[serde(flatten)]
    moved: Moved,
}

/// Objects by how they came into a folder.
#[derive(Clone, Copy, Default, serde::Serialize)]
struct Moved {
    cloned: usize,
    copied: usize,
    kept: usize,
    linked: usize,
}

/// Why a flock was not packed.
#[derive(Debug, thiserror::Error)]
enum Unpacked {
    #[error("flock `{name}` would not play as it should: {faults}, `{first}` first")]
    Faulty { name: String, faults: String, first: String },
    #[error("`{path}` is no statement about keys")]
    NoStatement { path: PathBuf },
    #[error("cannot read `{path}`")]
    Read { path: PathBuf, source: io::Error },
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Fatal> {
    let flock = Flock::new(open::manifest(&args.dir)?);
    let statements = statements(args)?;
    // Who is asked for a passphrase would rather be asked now than when all was checked.
    let key = passphrase::known(&args.key, args.passphrase_file.as_deref())?;
    let faults = faults(args, &flock)?;
    if let Some(first) = faults.first() {
        if args.json {
            report::json(&Answer { packed: false, faults: &faults, bundle: None })?;
        } else {
            report::lines(faults.iter().map(check::line))?;
        }
        let name = flock.manifest().name.clone();
        let faulty = Unpacked::Faulty { name, faults: report::count(faults.len(), "fault"), first: check::line(first) };
        return Err(Fatal::new(Exit::No, faulty));
    }
    let contents = listing::contents(&args.dir, flock.manifest())?;
    let folder = Folder::create(&args.bundle).map_err(unmoved)?;
    let moved = fill(&folder, &args.dir, flock.manifest(), &contents)?;
    let packed = seal(args, &flock, &key, &contents, &folder, &statements, moved)?;
    if args.json {
        report::json(&Answer { packed: true, faults: &[], bundle: Some(&packed) })?;
    } else {
        report::lines(told(&packed))?;
    }
    Ok(Exit::Fine)
}

/// What keeps the flock from being packed.
fn faults(args: &Args, flock: &Flock) -> Result<Vec<Fault>, Fatal> {
    let mut faults = check::every_fault(&args.dir, flock)?;
    if args.allow_jumps {
        let (jumps, others): (Vec<_>, Vec<_>) = faults.into_iter().partition(|fault| fault.kind == FaultKind::Jump);
        for jump in &jumps {
            report::note(&format!("note: {}", check::line(jump)));
        }
        faults = others;
    }
    Ok(faults)
}

/// Puts all of `contents` into `folder`. Shows its progress on a terminal.
fn fill(folder: &Folder, from: &Path, manifest: &Manifest, contents: &Contents) -> Result<Moved, Fatal> {
    let clips: BTreeSet<&str> = manifest.clips().map(|clip| clip.path.as_str()).collect();
    let objects = contents.objects();
    let bar = progress::bytes("packing", objects.iter().map(|file| file.size).sum());
    let mut moved = Moved::default();
    for file in objects {
        let before = bar.position();
        let (path, mut moves) = (from.join(file.path.as_str()), |bytes| bar.inc(bytes));
        // Clips are made anew in new files. Texts are edited, and many an editor writes them where they lie.
        let put = if clips.contains(file.path.as_str()) {
            folder.put_file(&file.id, file.size, &path, &mut moves)
        } else {
            let unread = |source| FolderError::Read { path: path.clone(), source };
            let text = File::open(&path).map_err(unread);
            text.and_then(|mut text| folder.put(&file.id, file.size, &mut text, &path, &mut moves))
        };
        moved.count(put.map_err(unmoved)?);
        bar.set_position(before + file.size);
    }
    bar.finish_and_clear();
    Ok(moved)
}

/// Signs what lies in `folder`, makes sure that a unit would take it, and lays the seal out.
fn seal(
    args: &Args,
    flock: &Flock,
    key: &SecretKey,
    contents: &Contents,
    folder: &Folder,
    statements: &[Vec<u8>],
    moved: Moved,
) -> Result<Packed, Fatal> {
    let list = contents.to_text().into_bytes();
    let id = ObjectId::of(&list);
    folder.put(&id, list.len() as u64, &mut &list[..], folder.path(), &mut |_| ()).map_err(unmoved)?;
    let trust = Trust::of([key.public()]);
    let mut counter = Counter::take(&args.key)?;
    for found in shelf::read(folder.path(), &trust, &[]).unwrap_or_default() {
        if let Ok(bundle) = found.bundle {
            counter.seen(bundle.seal().letter().sequence);
        }
    }
    let letter = SealBody {
        flock: flock.manifest().name.clone(),
        addressees: Addressees::of(args.units.iter().cloned()),
        sequence: counter.spend(args.sequence)?,
        created: now::date(),
        contents: id,
        contents_size: list.len() as u64,
        statements: folder.put_statements(statements).map_err(unmoved)?,
    };
    let bytes = letter.sign(key).map_err(unsigned)?;
    let toml = args.dir.join(FILE_NAME);
    let text = fs::read(&toml).map_err(|source| Fatal::new(Exit::Unreadable, Unpacked::Read { path: toml, source }))?;
    let taken = UnverifiedSeal::new(bytes.clone()).verify(&trust).and_then(|seal| seal.open(list));
    taken.and_then(|bundle| bundle.flock(&text)).map_err(refused)?;
    folder.add_statements(statements).map_err(unmoved)?;
    folder.put_seal(&letter.addressees, &bytes).map_err(unmoved)?;
    Ok(Packed {
        flock: letter.flock,
        units: args.units.iter().map(ToString::to_string).collect(),
        sequence: letter.sequence,
        signer: key.public().id(),
        files: contents.files().len(),
        bytes: contents.objects().iter().map(|file| file.size).sum(),
        moved,
    })
}

/// The statements in the files that `args` name.
pub(super) fn statements(args: &Args) -> Result<Vec<Vec<u8>>, Fatal> {
    let mut found = Vec::new();
    for path in &args.statements {
        let unread = |source| Fatal::new(Exit::Unreadable, Unpacked::Read { path: path.clone(), source });
        let bytes = fs::read(path).map_err(unread)?;
        let statements = bundle::statements(&bytes);
        if statements.is_empty() || statements.concat() != bytes {
            return Err(Fatal::new(Exit::Malformed, Unpacked::NoStatement { path: path.clone() }));
        }
        found.extend(statements.into_iter().map(<[u8]>::to_vec));
    }
    Ok(found)
}

fn told(packed: &Packed) -> Vec<String> {
    let Packed { flock, units, sequence, signer, files, bytes, moved } = packed;
    let units = if units.is_empty() { "every unit".to_owned() } else { units.join(", ") };
    let Moved { cloned, copied, kept, linked } = moved;
    vec![
        format!("packed `{flock}` for {units}: sequence {sequence}, key {signer}"),
        format!("{}, {}", report::count(*files, "file"), DecimalBytes(*bytes)),
        format!("{} shared with the flock, {copied} copied, {kept} there already", cloned + linked),
    ]
}

impl Moved {
    fn count(&mut self, put: PutMethod) {
        match put {
            PutMethod::Cloned => self.cloned += 1,
            PutMethod::Copied => self.copied += 1,
            PutMethod::Kept => self.kept += 1,
            PutMethod::Linked => self.linked += 1,
        }
    }
}
