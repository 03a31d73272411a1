//! `dreams settings`: from an owner's file to a signed one on a stick.
//!
//! Owns the command, and the reading of signed settings in a folder as their units read them. The file is read with the
//! unit's own parser, so that a unit that the stick is for takes it. Never changes the file.
//!
//! Start at [`run`].

use std::path::{Path, PathBuf};

use bundle::{
    Addressees, Folder, KeyId, Refusal, Sequence, SettingsBody, SignedSettings, Trust, UnitId, UnverifiedSettings,
    settings_path,
};
use operations::program::{Exit, Fatal, now, print};
use settings::owners_text::{self, NoText};
use settings::{ConfigError, Owner};

use super::bundle_folder::Fault;
use super::counter::Counter;
use super::{bundle_folder, folder_fatal, passphrase, refusal_fatal, sign_fatal};

/// Check an owner's file, and sign it for a unit that takes it from a stick
///
/// FILE is a `dreams.toml`, as on the small partition of a unit: `config/dreams.toml` explains every key. It replaces the
/// one of the unit as a whole, so begin with a copy of that one. The unit takes it within seconds after the stick is
/// plugged in, without a restart, and keeps the previous one beside it as `dreams-before.toml`. Anybody who holds the
/// stick can read the file, the password of the Wi-Fi too. The number is the next one of the key, as of a bundle: a unit
/// takes only settings with a higher number than those before. The stick may have bundles, too.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the signed settings are in the folder
  1  the key does not open, or others can read it
  2  the command line, the file or the key is wrong
  3  a file could not be read or written")]
pub struct Args {
    /// The owner's file
    file: PathBuf,
    /// A unit that it is for; may be repeated [default: every unit that trusts the key]
    #[arg(long = "unit", value_name = "UNIT", value_parser = UnitId::new)]
    units: Vec<UnitId>,
    /// The secret key that signs: its public key is in the image of the unit
    #[arg(long, value_name = "KEY")]
    key: PathBuf,
    /// Folder of the stick; made if it is not there
    #[arg(long, value_name = "STICK")]
    out: PathBuf,
    /// The number of the settings, above all earlier ones of this key [default: the next]
    #[arg(long, value_name = "N", value_parser = Sequence::parse)]
    sequence: Option<Sequence>,
    /// Take the passphrase from the first line of this file
    #[arg(long, value_name = "FILE")]
    passphrase_file: Option<PathBuf>,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct Answer<'a> {
    /// The paths of the written files in the folder.
    written: Vec<String>,
    /// Empty if they are for every unit.
    units: Vec<String>,
    sequence: Sequence,
    created: &'a str,
    signer: KeyId,
    /// What people should know of these settings.
    warnings: &'a [String],
}

/// Why a file of settings is not signed.
#[derive(Debug, thiserror::Error)]
enum SettingsError {
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error("`{path}`: {why}", path = .path.display())]
    NoText { path: PathBuf, why: NoText },
    #[error("`{path}` names one unit, `{unit}`, and is to be signed for {units}", path = .path.display())]
    SameName { path: PathBuf, unit: UnitId, units: String },
}

/// Signed settings in a folder, if they are good.
pub(super) struct SettingsEntry {
    /// Their path in the folder.
    pub(super) path: String,
    /// The settings, or why a unit would refuse them.
    pub(super) settings: Result<SignedSettings, Box<Refusal>>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let (owner, text) = read_file(&args.file).map_err(settings_fatal)?;
    let addressees = Addressees::of(args.units.iter().cloned());
    one_name(&args.file, &owner, &addressees).map_err(settings_fatal)?;
    let key = passphrase::open_key(&args.key, args.passphrase_file.as_deref())?;
    let folder = Folder::create(&args.out).map_err(folder_fatal)?;
    let trust = Trust::of([key.public()]);
    let mut counter = Counter::lock(&args.key)?;
    for entry in read(&args.out, &trust, &[])? {
        if let Ok(there) = entry.settings {
            counter.raise_to(there.body().sequence);
        }
    }
    let body = SettingsBody { addressees, sequence: counter.advance(args.sequence)?, created: now::date(), text };
    let bytes = body.sign(&key).map_err(sign_fatal)?;
    UnverifiedSettings::new(bytes.clone()).verify(&trust).map_err(refusal_fatal)?;
    folder.put_settings(&body.addressees, &bytes).map_err(folder_fatal)?;
    let warnings = warnings(&owner, &body.addressees);
    for warning in &warnings {
        print::note(&format!("warning: {warning}"));
    }
    let written: Vec<String> = body.addressees.file_stems().into_iter().map(settings_path).collect();
    let units = args.units.iter().map(ToString::to_string).collect();
    let signer = key.public().id();
    if args.json {
        let SettingsBody { sequence, created, .. } = &body;
        print::json(&Answer { written, units, sequence: *sequence, created, signer, warnings: &warnings })?;
    } else {
        let signed = format!("signed settings for {}: sequence {}, key {signer}", everybody(&units), body.sequence);
        let path = |path: &String| format!("wrote `{}`", args.out.join(path).display());
        print::lines([signed].into_iter().chain(written.iter().map(path)))?;
    }
    Ok(Exit::Fine)
}

/// The owner's file at `path`, read as a unit reads it.
fn read_file(path: &Path) -> Result<(Owner, String), SettingsError> {
    let unread = |source| ConfigError::Read { path: path.to_owned(), source };
    let text = owners_text::read_file(path).map_err(unread)?;
    let text = text.map_err(|why| SettingsError::NoText { path: path.to_owned(), why })?;
    Ok((Owner::parse(path, &text)?, text))
}

/// Two units cannot have the name that the file gives to one.
fn one_name(path: &Path, owner: &Owner, addressees: &Addressees) -> Result<(), SettingsError> {
    let units = match addressees {
        Addressees::Anyone => "every unit".to_owned(),
        Addressees::Units(units) if units.len() > 1 => print::count(units.len(), "unit"),
        Addressees::Units(_) => return Ok(()),
    };
    let Some(unit) = owner.unit.clone() else { return Ok(()) };
    Err(SettingsError::SameName { path: path.to_owned(), unit, units })
}

/// What is no mistake, and may surprise.
fn warnings(owner: &Owner, addressees: &Addressees) -> Vec<String> {
    let mut warnings = Vec::new();
    if let Some(wifi) = owner.wifi().filter(|wifi| wifi.password.is_some()) {
        let name = wifi.name.as_str().escape_debug();
        warnings.push(format!(
            "anybody who finds the signed file can read the password of the Wi-Fi `{name}` in it: erase the folder \
             `settings` when the unit has it"
        ));
    }
    match (addressees, &owner.unit) {
        (Addressees::Units(units), Some(name)) if !units.contains(name) => {
            warnings.push(format!("the file calls the unit `{name}`: from then on, sign for that name"));
        }
        (_, None) => warnings.push(
            "the file has no `unit`: a unit that its owner has named is then called by its host name again".to_owned(),
        ),
        (_, Some(_)) => {}
    }
    warnings
}

/// Ends a command that cannot use the owner's file.
fn settings_fatal(error: SettingsError) -> Fatal {
    match error {
        SettingsError::Config(ConfigError::Read { .. }) => Fatal::new(Exit::Unreadable, error),
        SettingsError::Config(ConfigError::Malformed { .. }) | SettingsError::NoText { .. } => {
            Fatal::new(Exit::Malformed, error).hint("`config/dreams.toml` explains every key")
        }
        SettingsError::SameName { .. } => {
            Fatal::new(Exit::Malformed, error).hint("--unit with one unit, and a file for each")
        }
    }
}

/// Reads all signed settings in the folder at `path`, or those that `units` would be given. `pinned` are the keys to trust;
/// statements in the folder count.
pub(super) fn read(path: &Path, pinned: &Trust, units: &[UnitId]) -> Result<Vec<SettingsEntry>, Fatal> {
    let mut folder = Folder::open(path).map_err(folder_fatal)?;
    let there = folder.settings().map_err(folder_fatal)?;
    let given = |unit: &UnitId| [Some(unit.clone()), None].into_iter().find(|addressee| there.contains(addressee));
    let wanted = if units.is_empty() { there.clone() } else { units.iter().filter_map(given).collect() };
    let trust = bundle_folder::trust_with_statements(&mut folder, pinned);
    let mut entry = |unit: Option<UnitId>| {
        let addressees = Addressees::of(unit.clone());
        let path = settings_path(addressees.file_stems().first().copied().unwrap_or_default());
        let missing = || Refusal::Read { part: bundle::Part::Settings, source: std::io::ErrorKind::NotFound.into() };
        let read = UnverifiedSettings::addressed(&mut folder, &addressees).and_then(|read| read.ok_or_else(missing));
        let settings = read.and_then(|unverified| unverified.verify(&trust)).and_then(|signed| {
            let mut given = units.iter().filter(|asked| unit.as_ref().is_none_or(|unit| unit == *asked)).chain(&unit);
            given.try_for_each(|unit| signed.body().addressees.admit(unit, None))?;
            Ok(signed)
        });
        SettingsEntry { path, settings: settings.map_err(Box::new) }
    };
    Ok(wanted.into_iter().map(&mut entry).collect())
}

/// The good ones of `entries`, each in a line, and the faults of the others.
pub(super) fn lines(entries: &[SettingsEntry]) -> (Vec<String>, Vec<Fault>) {
    let (mut good, mut faults) = (Vec::new(), Vec::new());
    for SettingsEntry { path, settings } in entries {
        match settings {
            Ok(signed) => good.push(line(path, signed)),
            Err(refused) => faults.push(bundle_folder::refusal(path, refused)),
        }
    }
    (good, faults)
}

fn line(path: &str, signed: &SignedSettings) -> String {
    let SettingsBody { addressees, sequence, created, .. } = signed.body();
    let units = match addressees {
        Addressees::Anyone => Vec::new(),
        Addressees::Units(units) => units.iter().map(ToString::to_string).collect(),
    };
    let signer = signed.signer();
    format!("`{path}`: settings for {}, sequence {sequence} of {created}, key {signer}", everybody(&units))
}

fn everybody(units: &[String]) -> String {
    if units.is_empty() { "every unit".to_owned() } else { units.join(", ") }
}
