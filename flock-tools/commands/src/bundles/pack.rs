//! `dreams pack`: from a flock to a bundle.
//!
//! Owns the command and its order: a flock with faults is refused before anything is written, and the seal is written last.
//! Never changes the flock. A bundle that does not verify is not sealed.
//!
//! Start at [`run`].

use std::fs;
use std::path::{Path, PathBuf};

use bundle::{
    Addressees, Contents, Folder, KeyId, ObjectId, PutMethod, SealBody, SecretKey, Sequence, Trust, UnitId,
    UnverifiedSeal,
};
use flock::{FILE_NAME, Fault, FaultKind, Flock, Manifest};
use indicatif::DecimalBytes;
use operations::check;
use operations::credits::{CreditsFile, FlockCredits, NotForSale};
use operations::decoder::Decoder;
use operations::flock_folder::{file_list, open};
use operations::program::{Exit, Fatal, now, print, progress};

use super::counter::Counter;
use super::{bundle_folder, folder_fatal, passphrase, refusal_fatal, sign_fatal};

/// The most clips that are named before a sale.
const MOST_WARNINGS: usize = 20;

/// Check a flock, and sign it as a bundle that travels to its units
///
/// The flock is checked as `dreams check --joins` does, and refused if it has a fault. The bundle is a folder: copy it
/// to a stick or a web server, or let `dreams publish` do it. It has files of its own, which take no room where the file
/// system can clone files: whatever happens to them does not change the flock, nor the other way round. Several bundles
/// may be in one folder, one for each unit, and share equal files. The bundle carries the flock's credits.toml,
/// too. Each bundle of a key gets a higher number than the one before; the last number is in a file beside the key.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the bundle is there
  1  the flock has faults, each of which is named; or the key does not open, or others can read it
  2  the command line, the manifest, the system or the key is wrong
  3  a file could not be read or written")]
#[expect(clippy::struct_excessive_bools, reason = "independent switches")]
pub struct Args {
    /// Folder of the flock
    pub(super) dir: PathBuf,
    /// Folder of the bundle; made if it is not there
    pub(super) bundle: PathBuf,
    /// The folder is a system, as `make image` leaves it
    #[arg(long, conflicts_with = "allow_jumps")]
    pub system: bool,
    /// The secret key that signs
    #[arg(long, value_name = "KEY")]
    pub(super) key: PathBuf,
    /// A unit that it is for; may be repeated [default: every unit that trusts the key]
    #[arg(long = "unit", value_name = "UNIT", value_parser = UnitId::new)]
    pub(super) units: Vec<UnitId>,
    /// The bundle's number, above all earlier ones of this key [default: the next]
    #[arg(long, value_name = "N", value_parser = Sequence::parse)]
    pub(super) sequence: Option<Sequence>,
    /// A statement about keys, as `dreams keygen` writes it, to send along; may be repeated
    #[arg(long = "statement", value_name = "FILE")]
    pub(super) statements: Vec<PathBuf>,
    /// Pack a system that does not trust the key; its units must trust it by their owners' settings
    #[arg(long, requires = "system")]
    pub(super) allow_untrusted: bool,
    /// Pack it even if joins jump
    #[arg(long)]
    allow_jumps: bool,
    /// It is sold, or shown for money: name the clips whose licences do not allow that, or that have none
    #[arg(long, conflicts_with = "system")]
    for_sale: bool,
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
    /// With --for-sale: the clips that may not be sold, or are not known to be.
    #[serde(skip_serializing_if = "Option::is_none")]
    not_for_sale: Option<&'a [NotForSale]>,
    #[serde(flatten)]
    bundle: Option<&'a BundleSummary>,
}

/// The bundle in the answer.
#[derive(serde::Serialize)]
struct BundleSummary {
    flock: String,
    /// Empty if it is for every unit.
    units: Vec<String>,
    sequence: Sequence,
    signer: KeyId,
    files: usize,
    bytes: u64,
    #[serde(flatten)]
    objects: ObjectCounts,
}

/// The number of objects that were cloned, copied, or there already.
#[derive(Clone, Copy, Default, serde::Serialize)]
struct ObjectCounts {
    cloned: usize,
    copied: usize,
    kept: usize,
    /// Always 0: no object is a hard link to a file of the flock. For programs that read this answer.
    linked: usize,
}

/// Why a flock was not packed.
#[derive(Debug, thiserror::Error)]
enum PackError {
    #[error("flock `{name}` is not packed, it has {faults}: `{first}` first")]
    Faulty { name: String, faults: String, first: String },
    #[error("`{path}` is not a statement about keys")]
    NoStatement { path: PathBuf },
}

/// Runs the command.
pub fn run(args: &Args, decoder: &'static dyn Decoder) -> Result<Exit, Fatal> {
    let flock = Flock::new(open::manifest(&args.dir)?);
    let statements = statements(args)?;
    let not_for_sale = not_for_sale(args, flock.manifest())?;
    // Before the check, which takes long.
    let key = passphrase::open_key(&args.key, args.passphrase_file.as_deref())?;
    if args.json && args.passphrase_file.is_none() {
        // For a program that shows for what this one waits.
        print::note("the key is open");
    }
    let faults = faults(args, &flock, decoder)?;
    if let Some(first) = faults.first() {
        if args.json {
            print::json(&Answer {
                packed: false,
                faults: &faults,
                not_for_sale: not_for_sale.as_deref(),
                bundle: None,
            })?;
        } else {
            print::lines(faults.iter().map(check::line))?;
        }
        let name = flock.manifest().name.clone();
        let faulty = PackError::Faulty { name, faults: print::count(faults.len(), "fault"), first: check::line(first) };
        return Err(Fatal::new(Exit::No, faulty).hint(hint(&faults)));
    }
    let contents = file_list::contents(&args.dir, flock.manifest())?;
    let folder = Folder::create(&args.bundle).map_err(folder_fatal)?;
    let objects = put_objects(&folder, &args.dir, &contents)?;
    let summary = seal(args, &flock, &key, &contents, &folder, &statements, objects)?;
    warn(not_for_sale.as_deref().unwrap_or_default());
    if args.json {
        let not_for_sale = not_for_sale.as_deref();
        print::json(&Answer { packed: true, faults: &[], not_for_sale, bundle: Some(&summary) })?;
    } else {
        print::lines(lines(&summary))?;
    }
    Ok(Exit::Fine)
}

/// The clips that may not be sold, or are not known to be, if the bundle is for sale.
/// Errors: If `credits.toml`, which travels along, is malformed.
fn not_for_sale(args: &Args, manifest: &Manifest) -> Result<Option<Vec<NotForSale>>, Fatal> {
    if args.for_sale {
        return Ok(Some(FlockCredits::of_licences(&args.dir, manifest)?.not_for_sale(manifest)));
    }
    CreditsFile::read(&args.dir)?;
    Ok(None)
}

/// Names the clips that may not be sold, or are not known to be. The bundle is packed all the same: the artist may have the
/// permission of those who made them, which no file tells.
fn warn(not_for_sale: &[NotForSale]) {
    for clip in not_for_sale.iter().take(MOST_WARNINGS) {
        print::note(&format!("warning: {}", clip.line()));
    }
    if let Some(more) = not_for_sale.len().checked_sub(MOST_WARNINGS).filter(|more| *more > 0) {
        let more = print::count(more, "clip");
        print::note(&format!("warning: and {more} more, which `dreams credits --for-sale` names"));
    }
}

/// The faults that keep the flock from being packed.
fn faults(args: &Args, flock: &Flock, decoder: &'static dyn Decoder) -> Result<Vec<Fault>, Fatal> {
    let mut faults = check::every_fault(&args.dir, flock, decoder)?;
    if args.allow_jumps {
        let (jumps, others): (Vec<_>, Vec<_>) = faults.into_iter().partition(|fault| fault.kind == FaultKind::Jump);
        for jump in &jumps {
            print::note(&format!("note: {}", check::line(jump)));
        }
        faults = others;
    }
    Ok(faults)
}

/// What to do about `faults`, of which there is one at least.
fn hint(faults: &[Fault]) -> &'static str {
    if faults.iter().all(|fault| fault.kind == FaultKind::Jump) {
        "`dreams check DIR --joins --contact-sheet FILE` draws them; --allow-jumps packs the flock with them"
    } else {
        "a unit would not show it as it is meant; --allow-jumps allows jumps, and no other fault"
    }
}

/// Puts all of `contents` into `folder`. Shows its progress on a terminal.
fn put_objects(folder: &Folder, from: &Path, contents: &Contents) -> Result<ObjectCounts, Fatal> {
    let objects = contents.objects();
    let bar = progress::bytes("packing", objects.iter().map(|file| file.size).sum());
    let mut counts = ObjectCounts::default();
    for file in objects {
        let before = bar.position();
        let path = from.join(file.path.as_str());
        let put = folder.put_file(&file.id, file.size, &path, &mut |bytes| bar.inc(bytes));
        counts.add(put.map_err(folder_fatal)?);
        bar.set_position(before + file.size);
    }
    bar.finish_and_clear();
    Ok(counts)
}

/// Signs the bundle in `folder`, verifies it as a unit does, and writes the seal.
fn seal(
    args: &Args,
    flock: &Flock,
    key: &SecretKey,
    contents: &Contents,
    folder: &Folder,
    statements: &[Vec<u8>],
    objects: ObjectCounts,
) -> Result<BundleSummary, Fatal> {
    let list = contents.to_text().into_bytes();
    let id = ObjectId::of(&list);
    folder.put(&id, list.len() as u64, &mut &list[..], folder.path(), &mut |_| ()).map_err(folder_fatal)?;
    let trust = Trust::of([key.public()]);
    let mut counter = Counter::lock(&args.key)?;
    for entry in bundle_folder::read(folder.path(), &trust, &[]).unwrap_or_default() {
        if let Ok(bundle) = entry.bundle {
            counter.raise_to(bundle.seal().letter().sequence);
        }
    }
    let letter = SealBody {
        flock: flock.manifest().name.clone(),
        addressees: Addressees::of(args.units.iter().cloned()),
        sequence: counter.advance(args.sequence)?,
        created: now::date(),
        contents: id,
        contents_size: list.len() as u64,
        statements: folder.put_statements(statements).map_err(folder_fatal)?,
    };
    let bytes = letter.sign(key).map_err(sign_fatal)?;
    let toml = args.dir.join(FILE_NAME);
    let text = fs::read(&toml).map_err(|source| Fatal::read(&toml, source))?;
    let verified = UnverifiedSeal::new(bytes.clone()).verify(&trust).and_then(|seal| seal.open(list));
    verified.and_then(|bundle| bundle.flock(&text)).map_err(refusal_fatal)?;
    folder.add_statements(statements).map_err(folder_fatal)?;
    folder.put_seal(&letter.addressees, &bytes).map_err(folder_fatal)?;
    Ok(BundleSummary {
        flock: letter.flock,
        units: args.units.iter().map(ToString::to_string).collect(),
        sequence: letter.sequence,
        signer: key.public().id(),
        files: contents.files().len(),
        bytes: contents.objects().iter().map(|file| file.size).sum(),
        objects,
    })
}

/// The statements in the files that `args` name.
pub(super) fn statements(args: &Args) -> Result<Vec<Vec<u8>>, Fatal> {
    let mut all = Vec::new();
    for path in &args.statements {
        let bytes = fs::read(path).map_err(|source| Fatal::read(path, source))?;
        let statements = bundle::statements(&bytes);
        if statements.is_empty() || statements.concat() != bytes {
            return Err(Fatal::new(Exit::Malformed, PackError::NoStatement { path: path.clone() }));
        }
        all.extend(statements.into_iter().map(<[u8]>::to_vec));
    }
    Ok(all)
}

fn lines(summary: &BundleSummary) -> Vec<String> {
    let BundleSummary { flock, units, sequence, signer, files, bytes, objects } = summary;
    let units = if units.is_empty() { "every unit".to_owned() } else { units.join(", ") };
    let written = objects.cloned + objects.copied;
    vec![
        format!("packed `{flock}` for {units}: sequence {sequence}, key {signer}"),
        format!("{}, {}", print::count(*files, "file"), DecimalBytes(*bytes)),
        format!("{written} written, {} there already", objects.kept),
    ]
}

impl ObjectCounts {
    fn add(&mut self, put: PutMethod) {
        match put {
            PutMethod::Cloned => self.cloned += 1,
            PutMethod::Copied => self.copied += 1,
            PutMethod::Kept => self.kept += 1,
        }
    }
}
