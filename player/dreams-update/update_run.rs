//! One update, from the first look at the source to the switch of generations.
//!
//! Owns the order: nothing is believed before it was verified, nothing is fetched that is refused, is here or does not
//! fit, and what plays is not touched until everything else is on the disk. Each step may fail or be the last; the
//! next run goes on from there.
//!
//! Start at [`run`].

use crate::answer::{Answer, Outcome, SystemOutcome};
use crate::fatal::Fatal;
use crate::fetch::Fetcher;
use crate::options::Order;
use crate::origin::Origin;
use crate::progress::Progress;
use crate::rate_limit::RateLimit;
use crate::schedule::Schedule;
use crate::sentences;
use crate::slot;
use crate::statements;
use crate::status_report;
use crate::system;
use bundle::{
    Admission, FetchItem, KeyError, LocalDisk, Refusal, Seal, StagedSystems, Store, StoreError, Trust,
    UnreadableObject, UnverifiedSeal, VerifiedBundle,
};
use diagnostics::{Exit, chain};
use player::{Contact, Output, now};
use settings::kept;
use std::io::{self, ErrorKind};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;
use tracing::{info, warn};

/// The time between two looks whether another update has ended.
const PAUSE: Duration = Duration::from_millis(250);

/// Does what was ordered, and writes notices about it.
/// Errors: [`Fatal`]. What plays is what played before.
pub(crate) fn run(order: Order) -> Result<Output<Answer>, Fatal> {
    let stop = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&stop);
    ctrlc::set_handler(move || raised.store(true, Ordering::Relaxed)).map_err(Fatal::Signals)?;
    let ended = in_time(&order, &stop);
    let said = match &ended {
        Ok(answer) => sentences::of_answer(answer.outcome, &answer.system)
            .map(str::to_owned)
            .or_else(|| answer.astray.as_ref().map(sentences::of_astray)),
        Err(fatal) => Some(sentences::of_fatal(fatal)),
    };
    if let Some(said) = said {
        Progress::new(order.notice).ended(&said);
    }
    Ok(Output { answer: ended?, json: order.json })
}

/// Updates if it is time, and remembers when that is next.
fn in_time(order: &Order, stop: &AtomicBool) -> Result<Answer, Fatal> {
    let Some(path) = &order.schedule else { return update(order, stop) };
    let schedule = Schedule::read(path).by(&format!("{:?}", kept::versions(&order.config.owner)));
    let is_idle = order.source.is_none() && order.config.report_to.is_none();
    let clock = order.clock.read();
    if is_idle || !schedule.is_due(clock.up_s, clock.known_s(), order.config.window) {
        if order.report_every_s.is_some() && schedule.is_report_due(clock.up_s) {
            let error = schedule.error().map(str::to_owned);
            save_schedule(&reported(order, schedule, Err(error)), path);
        }
        return Ok(Answer::of(Outcome::NotNow, None));
    }
    let ended = update(order, stop);
    let is_failure = ended.as_ref().is_err_and(|fatal| fatal.exit() == Exit::Unreadable);
    let next = schedule.after(is_failure, order.clock.read().up_s, order.config.every_minutes * 60, rand::random());
    let error = ended.as_ref().err().map(|fatal| chain(fatal));
    let next = next.with_error(error.as_deref());
    save_schedule(&reported(order, next, ended.as_ref().map_err(|_| error)), path);
    ended
}

/// Sends a report of how the last look `ended`, with an answer or with an error, if one is due; returns when the next is.
fn reported(order: &Order, schedule: Schedule, ended: Result<&Answer, Option<String>>) -> Schedule {
    let up_s = order.clock.read().up_s;
    if order.report_every_s.is_none() || schedule.is_report_due(up_s) {
        status_report::send(order, ended);
    } else {
        return schedule;
    }
    match order.report_every_s {
        Some(every_s) => schedule.reported(up_s, every_s),
        None => schedule,
    }
}

fn save_schedule(next: &Schedule, path: &Path) {
    if let Err(error) = next.write(path) {
        warn!(path = %path.display(), error = chain(&error), "cannot save the time of the next update");
    }
}

fn update(order: &Order, stop: &AtomicBool) -> Result<Answer, Fatal> {
    if let Some(format) = order.unreadable {
        return Err(Fatal::Format { format });
    }
    let systems = system_trust(order)?;
    if let Some((device, boot)) = &order.slot {
        let store = StagedSystems::open(locked(order, stop, LocalDisk::open_to_read)?, &systems)?;
        let system = slot::write(order, &store, device, boot)?;
        return Ok(Answer { system, ..Answer::of(Outcome::NotNow, store.playing()) });
    }
    let disk = locked(order, stop, LocalDisk::open)?;
    let mut store = Store::open(Box::new(disk), trust(order, &systems)?)?.with_system_keys(systems);
    store.remove_dropped()?;
    let rate_limit = RateLimit::new(order.config.bandwidth_kib, now());
    if order.scrub {
        scrub(&store, stop)?;
    }
    let Some(place) = &order.source else {
        let missing = store.missing().map_or(0, |missing| missing.len());
        return Ok(Answer { missing, ..Answer::of(Outcome::NotNow, store.state().playing()) });
    };
    let mut source = Origin::open(place, order.config.proxy.as_deref(), order.judgement())?;
    let progress = Progress::new(order.notice.clone());
    let mut fetcher = Fetcher { source: &mut source, rate_limit, progress, stop, objects: 0, bytes: 0 };
    let brought = bring(order, &mut store, place, &mut fetcher);
    save_contact(order, &store, fetcher.source.is_far(), &brought);
    let (fetched, fetched_bytes) = (fetcher.objects, fetcher.bytes);
    if brought.is_err() && fetched_bytes > 0 {
        info!(fetched, fetched_bytes, "keeping what was fetched");
    }
    Ok(Answer { fetched, fetched_bytes, ..brought? })
}

/// Saves the result of this run for people.
fn save_contact(order: &Order, store: &Store, is_far: bool, brought: &Result<Answer, Fatal>) {
    let contact = Contact {
        clock_s: order.clock.read().known_s(),
        source: if is_far { "network" } else { "stick" }.to_owned(),
        result: sentences::of_look(brought.as_ref().map(|answer| answer.outcome)).to_owned(),
        trusted: store.trust().keys().map(|key| key.id().to_string()).collect(),
        revoked: store.trust().revoked().map(|id| id.to_string()).collect(),
    };
    if let Err(error) = contact.tell(&order.config.store) {
        warn!(error = chain(&error), "cannot save the result of this update");
    }
}

/// Brings what `place` has for this unit: a flock, a system, what the store lacks.
fn bring(order: &Order, store: &mut Store, place: &str, fetcher: &mut Fetcher<'_>) -> Result<Answer, Fatal> {
    let taken = take(order, store, place, fetcher);
    // What keeps one from coming need not keep the other, unless it is the source.
    let system = match &taken {
        Err(fatal) if fatal.exit() == Exit::Unreadable => SystemOutcome::None,
        Ok(_) | Err(_) => system::take(order, store, fetcher)?,
    };
    let outcome = taken?;
    if matches!(outcome, Outcome::NoBundle) && fetcher.source.is_shut() {
        let refuses = io::Error::other("the server answers 403 to all that it is asked for: let it be read by anybody");
        return Err(Fatal::Read { name: place.to_owned(), source: refuses });
    }
    let is_empty = matches!((outcome, &system), (Outcome::NoBundle, SystemOutcome::None));
    let astray = is_empty.then(|| fetcher.source.astray()).flatten();
    let (mended, missing) = mend(store, fetcher)?;
    Ok(Answer { system, mended, missing, astray, ..Answer::of(outcome, store.state().playing()) })
}

/// The keys that this unit trusts: by its config, and by its owner. A key for `systems` may sign flocks, too.
fn trust(order: &Order, systems: &Trust) -> Result<Trust, Fatal> {
    let owners = &order.owners_keys;
    let with_others = |trust: &Trust| Trust::of(trust.keys().chain(systems.keys()).chain(owners).cloned());
    match Trust::read(&order.config.keys) {
        Ok(trust) => Ok(with_others(&trust)),
        Err(KeyError::Read { .. }) if !owners.is_empty() => Ok(with_others(&Trust::default())),
        Err(error) => Err(Fatal::Keys(error)),
    }
}

/// The keys for systems: by its config alone, the owner cannot set them.
fn system_trust(order: &Order) -> Result<Trust, Fatal> {
    let is_missing =
        |error: &KeyError| matches!(error, KeyError::Read { source, .. } if source.kind() == ErrorKind::NotFound);
    match Trust::read(&order.config.system_keys) {
        Err(error) if is_missing(&error) => match Trust::read(&order.config.keys) {
            // Reading these keys for flocks reports the error.
            Err(KeyError::Read { .. }) => Ok(Trust::default()),
            keys => keys.map_err(Fatal::Keys),
        },
        keys => keys.map_err(Fatal::Keys),
    }
}

/// Opens the store's folder by `open`, which locks it. Waits for another updater that works on it, so that a second stick need not be put in again. A run on
/// the schedule ends instead, and comes later.
fn locked(order: &Order, stop: &AtomicBool, open: fn(&Path) -> io::Result<LocalDisk>) -> Result<LocalDisk, Fatal> {
    let path = &order.config.store;
    let mut is_told = false;
    let disk = loop {
        match open(path) {
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                if order.schedule.is_some() {
                    return Err(Fatal::Busy { store: path.clone() });
                }
                if stop.load(Ordering::Relaxed) {
                    return Err(Fatal::Stopped);
                }
                if !std::mem::replace(&mut is_told, true) {
                    info!("waiting for another update to end");
                }
                thread::park_timeout(PAUSE);
            }
            disk => break disk,
        }
    };
    Ok(disk.map_err(|source| StoreError::Disk { doing: "open", path: path.display().to_string(), source })?)
}

/// Refuses a source that has bundles for other units only.
fn is_for_nobody(order: &Order, place: &str, source: &Origin) -> Result<(), Fatal> {
    let units = source.units()?;
    if units.is_empty() {
        return Ok(());
    }
    Err(Fatal::ForOthers { place: place.to_owned(), units, unit: order.unit.clone() })
}

/// Installs the flock at `place` for this unit, if it is new.
fn take(order: &Order, store: &mut Store, place: &str, fetcher: &mut Fetcher<'_>) -> Result<Outcome, Fatal> {
    let unverified = match UnverifiedSeal::open(fetcher.source, &order.unit) {
        Ok(unverified) => unverified,
        Err(Refusal::Read { source: error, .. }) if error.kind() == ErrorKind::NotFound => {
            is_for_nobody(order, place, fetcher.source)?;
            return Ok(Outcome::NoBundle);
        }
        Err(refused) => return Err(Fatal::Refused(refused)),
    };
    if store.is_current(&unverified) {
        return Ok(Outcome::NoNews);
    }
    let verify = |store: &Store| unverified.clone().verify(store.trust());
    let seal = statements::heeded(store, fetcher.source, verify, Seal::expected_statements)?;
    match store.admit(&seal, &order.unit, order.consent).map_err(Fatal::Refused)? {
        Admission::New => {}
        Admission::Kept | Admission::OnTrial | Admission::Plays => return Ok(Outcome::NoNews),
    }
    let letter = seal.letter();
    info!(flock = letter.flock, sequence = letter.sequence.0, signer = %seal.signer(), "fetching a bundle");
    let bundle = seal.fetch(fetcher.source).map_err(Fatal::Refused)?;
    make_room(order, store, &bundle)?;
    let plan = store.plan(&bundle)?;
    fetcher.progress.begins(plan.bytes, plan.bytes - plan.to_fetch(), now());
    let (toml, clips): (Vec<&FetchItem>, Vec<&FetchItem>) =
        plan.wanted.iter().partition(|wanted| wanted.path.as_str() == flock::FILE_NAME);
    // What the flock says is looked at before anything large is fetched.
    toml.into_iter().try_for_each(|wanted| fetcher.fetch(store, wanted))?;
    store.flock(&bundle)?;
    clips.into_iter().try_for_each(|wanted| fetcher.fetch(store, wanted))?;
    let generation = store.install(&bundle)?;
    info!(
        flock = generation.flock,
        sequence = generation.sequence.0,
        generation = generation.number,
        "installed a flock"
    );
    Ok(Outcome::Installed)
}

/// Removes unused objects, and if that is not enough the reserve, until the bundle fits.
fn make_room(order: &Order, store: &mut Store, bundle: &VerifiedBundle) -> Result<(), Fatal> {
    let reserve = order.config.reserve_mib << 20;
    let shortfall =
        |store: &Store| -> Result<_, Fatal> { Ok(store.plan(bundle)?.shortfall(store.free_bytes()?, reserve)) };
    tidy(store, bundle);
    if shortfall(store)?.is_some() && store.state().before.is_some() {
        info!("removing the flock before the last good one to make room");
        store.drop_reserve()?;
        tidy(store, bundle);
    }
    shortfall(store)?.map_or(Ok(()), |shortfall| Err(Fatal::Room(shortfall)))
}

fn tidy(store: &Store, bundle: &VerifiedBundle) {
    if let Err(error) = store.collect(Some(bundle)) {
        warn!(error = chain(&error), "cannot remove unused objects from the store");
    }
}

/// Reads every byte that is kept, and has what is damaged fetched again.
fn scrub(store: &Store, stop: &AtomicBool) -> Result<(), Fatal> {
    let found = store.scrub(|_| !stop.load(Ordering::Relaxed))?;
    for damaged in &found.damaged {
        warn!(
            clip = damaged.path.as_str(),
            "a file of the flock is damaged and stays in use until it is fetched again"
        );
    }
    for UnreadableObject { wanted, why } in &found.unread {
        warn!(clip = wanted.path.as_str(), error = why, "cannot read a file, it stays");
    }
    for generation in &found.unlisted {
        warn!(generation = generation.number, "a generation is damaged, and its list of files is lost");
    }
    let (whole, damaged, unread) = (found.whole, found.damaged.len(), found.unread.len());
    if found.is_failing {
        return Err(StoreError::Failing { unread }.into());
    }
    info!(whole, damaged, unread, "read the whole store");
    if stop.load(Ordering::Relaxed) { Err(Fatal::Stopped) } else { Ok(()) }
}

/// Fetches what the kept flocks lack, as far as the source has it; returns how many objects it had, and had not.
fn mend(store: &Store, fetcher: &mut Fetcher<'_>) -> Result<(usize, usize), Fatal> {
    let lacking = match store.missing() {
        Ok(lacking) => lacking,
        Err(error) => {
            warn!(error = chain(&error), "cannot list what the store lacks");
            return Ok((0, 0));
        }
    };
    let (mut mended, mut missing, mut trouble) = (0, 0, None);
    for wanted in &lacking {
        let repair_with = |fetcher: &mut Fetcher<'_>| match store.restore(wanted) {
            Ok(true) => Ok(()),
            Ok(false) => fetcher.fetch(store, wanted),
            Err(error) => Err(error.into()),
        };
        match repair_with(fetcher) {
            Ok(()) => mended += 1,
            Err(Fatal::Read { source, .. }) if source.kind() == io::ErrorKind::NotFound => missing += 1,
            Err(fatal) => {
                trouble = Some(fatal);
                break;
            }
        }
    }
    // Also what an attempt before this one fetched, and was ended before it could put it back.
    store.repair()?;
    trouble.map_or(Ok((mended, missing)), Err)
}
