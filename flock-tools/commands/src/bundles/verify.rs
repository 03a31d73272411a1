//! `dreams verify`: whether its units would take a bundle.
//!
//! Owns the command and its answer. `bundle_folder.rs` finds the faults.

use std::path::PathBuf;

use bundle::{KeyId, Sequence, Trust, UnitId};
use indicatif::DecimalBytes;
use operations::program::{Exit, Fatal, print};

use super::bundle_folder::{self, BundleEntry, Fault, Kind};
use super::fleet::{self, Fleet};
use super::{key_fatal, settings, system};

/// Tell whether bundles are what a trusted key signed, whole and undamaged, and name everything that is not
///
/// Signatures first, then the lists of files, then every byte of every file, on all cores.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  every bundle would be taken in
  1  something is forged, damaged or missing, or is for others; each is named
  2  the command line or a key is wrong
  3  something could not be read")]
pub struct Args {
    /// Folder of the bundles: on a disk, on a stick, under a web server
    bundle: PathBuf,
    /// The public key to trust, or a folder of such keys
    #[arg(long, value_name = "PUB")]
    trust: PathBuf,
    /// Check only the bundle of this unit, and whether it would take it; may be repeated
    #[arg(long = "unit", value_name = "UNIT", value_parser = UnitId::new)]
    units: Vec<UnitId>,
    /// The table of units: those with bundles of their own take none for every unit [default: fleet.toml beside the
    /// bundles]
    #[arg(long, value_name = "FILE", requires = "units")]
    fleet: Option<PathBuf>,
    /// Answer with one JSON document: {"ok": ..., "bundles": [...], "systems": [...], "settings": [...], "faults": [...]}
    #[arg(long)]
    json: bool,
}

#[derive(serde::Serialize)]
struct Answer<'a> {
    ok: bool,
    bundles: Vec<BundleSummary<'a>>,
    systems: Vec<String>,
    settings: Vec<String>,
    faults: &'a [Fault],
}

/// A bundle whose seal and list are good.
#[derive(serde::Serialize)]
struct BundleSummary<'a> {
    seal: &'a str,
    flock: &'a str,
    /// Empty if it is for every unit.
    units: Vec<String>,
    sequence: Sequence,
    created: &'a str,
    signer: KeyId,
    files: usize,
    bytes: u64,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let trust = Trust::read(&args.trust).map_err(key_fatal)?;
    let systems = system::read(&args.bundle, &trust, &args.units)?;
    let settings = settings::read(&args.bundle, &trust, &args.units)?;
    let is_other = !systems.is_empty() || !settings.is_empty();
    let entries = bundle_folder::read_beside_others(&args.bundle, &trust, &args.units, is_other)?;
    let table = args.fleet.clone().unwrap_or_else(|| args.bundle.join(fleet::FILE_NAME));
    let fleet = if args.units.is_empty() { Fleet::default() } else { Fleet::read(&table)? };
    let entries = bundle_folder::admit(entries, &args.units, &fleet);
    let mut faults = bundle_folder::faults(&args.bundle, &entries, &systems);
    let (settings, refused) = settings::lines(&settings);
    faults.extend(refused);
    let good = systems.iter().filter_map(|entry| Some((entry.unit.as_ref(), entry.system.as_ref().ok()?)));
    let systems: Vec<String> = good.map(|(unit, system)| system::line(unit, system)).collect();
    let bundles = entries.iter().filter_map(summary).collect();
    let exit = match &faults[..] {
        [] => Exit::Fine,
        faults if faults.iter().all(|fault| fault.kind == Kind::Unreadable) => Exit::Unreadable,
        _ => Exit::No,
    };
    if args.json {
        print::json(&Answer { ok: faults.is_empty(), bundles, systems, settings, faults: &faults })?;
    } else {
        let good = bundles.iter().map(line).chain(systems).chain(settings);
        print::lines(good.chain(faults.iter().map(|fault| fault.message.clone())))?;
        print::note(&print::count(faults.len(), "fault"));
    }
    Ok(exit)
}

fn summary(entry: &BundleEntry) -> Option<BundleSummary<'_>> {
    let bundle = entry.bundle.as_ref().ok()?;
    let letter = bundle.seal().letter();
    let units = match &letter.addressees {
        bundle::Addressees::Anyone => Vec::new(),
        bundle::Addressees::Units(units) => units.iter().map(ToString::to_string).collect(),
    };
    Some(BundleSummary {
        seal: &entry.seal,
        flock: &letter.flock,
        units,
        sequence: letter.sequence,
        created: &letter.created,
        signer: bundle.seal().signer(),
        files: bundle.contents().files().len(),
        bytes: bundle.contents().objects().iter().map(|file| file.size).sum(),
    })
}

fn line(summary: &BundleSummary<'_>) -> String {
    let BundleSummary { seal, flock, units, sequence, created, signer, files, bytes } = summary;
    let units = if units.is_empty() { "every unit".to_owned() } else { units.join(", ") };
    let size = DecimalBytes(*bytes);
    let files = print::count(*files, "file");
    format!("`{seal}`: `{flock}` for {units}, sequence {sequence} of {created}, key {signer}, {files}, {size}")
}
