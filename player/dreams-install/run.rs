//! The installer on a machine.
//!
//! Owns the loop: disks, keys and the work on the disk go to the state machine, and what it says is done. The work is a thread
//! of its own, so that the display shows how far it is.
//!
//! Start at [`run`].

use crate::conversation::{Action, Input, Key, State, Trouble};
use crate::copying::{Failure, Phase, Sum, install};
use crate::disks::{Disk, Machine};
use crate::fatal::Fatal;
use crate::options::Options;
use crate::page::Page;
use crate::pages::Pages;
use crate::plan::{self, Plan};
use crate::table::Table;
use diagnostics::chain;
use player::input_devices::{FOLDER, InputDevices};
use player::{input_devices, now, threads};
use rustix::io::Errno;
use rustix::mm::{MlockAllFlags, mlockall};
use rustix::system::{RebootCommand, reboot};
use std::fs::File;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use timing::Nanos;
use tracing::{info, warn};

/// The time between two looks for disks.
const LOOK_NS: u64 = 1_000_000_000;
/// Codes of keys, after `linux/input-event-codes.h`: Enter and that of the number pad, `OK` and `Select` of remote controls;
/// Delete and that of the number pad; 1 to 9, and those of the number pad.
const ENTER: [u16; 4] = [28, 96, 352, 353];
const DELETE: [u16; 2] = [111, 83];
const DIGITS: [[u16; 2]; 9] = [[2, 79], [3, 80], [4, 81], [5, 75], [6, 76], [7, 77], [8, 71], [9, 72], [10, 73]];

/// Shows the pages until the unit is installed and the stick is removed.
/// Errors: [`Fatal`].
pub(crate) fn run(options: &Options) -> Result<(), Fatal> {
    let mut session = Session::open(options)?;
    // From the removal of the stick on, no page of this program can be read from it.
    if let Err(error) = mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE) {
        info!(%error, "cannot lock the memory");
    }
    while session.step()? != Action::Restart {}
    info!("installed, and the stick is removed");
    if options.restart {
        // All that was written is on the disk. The programs that would stop the system are on the stick.
        reboot(RebootCommand::Restart).map_err(|error| Fatal::Restart(error.into()))?;
    }
    Ok(())
}

/// A run.
struct Session {
    machine: Arc<Machine>,
    stick: Arc<(File, Table)>,
    sum: Sum,
    needed: u64,
    state: State,
    pages: Pages,
    keys: InputDevices,
    work: (Sender<Input>, Receiver<Input>),
    /// When the next look for disks is due.
    next: Nanos,
}

impl Session {
    fn open(options: &Options) -> Result<Self, Fatal> {
        let machine = Machine { root: options.root.clone(), stick: options.stick.clone() };
        let path = machine.device(&machine.stick);
        let unread = |source| Fatal::Read { path: path.clone(), source };
        let table = machine.table(&machine.stick).map_err(unread)?;
        let none = || Fatal::NoStick { path: path.clone() };
        let table = table.ok_or_else(none)?;
        let needed = plan::needed(&table).ok_or_else(none)?;
        let file = File::open(&path).map_err(unread)?;
        Ok(Self {
            keys: InputDevices::all_of(&machine.root.join(FOLDER.trim_start_matches('/'))),
            machine: Arc::new(machine),
            stick: Arc::new((file, table)),
            sum: options.sum,
            needed,
            state: State::Looking,
            pages: Pages::new(options.screen),
            work: channel(),
            next: Nanos(0),
        })
    }

    /// Gives the state machine what there is, does what it says, and shows its page.
    fn step(&mut self) -> Result<Action, Fatal> {
        for input in self.inputs() {
            let input = match input {
                // A key before it may have changed the page.
                Input::Key { key, .. } => Input::Key { key, visible_ms: self.pages.visible_ms() },
                Input::Disks(_) | Input::Progress { .. } | Input::Ended(_) | Input::StickGone => input,
            };
            let (state, action) = std::mem::replace(&mut self.state, State::Looking).on(input);
            self.state = state;
            match action {
                Action::Wait => {}
                Action::Install { stay } => self.begin(stay)?,
                Action::Restart => return Ok(Action::Restart),
            }
            self.pages.show(Page::of(&self.state, self.needed));
        }
        self.pages.wait();
        Ok(Action::Wait)
    }

    /// What has happened since the last step.
    fn inputs(&mut self) -> Vec<Input> {
        let mut inputs: Vec<Input> = self.work.1.try_iter().collect();
        self.keys.open(now());
        let pressed = self.keys.read().into_iter().filter_map(|input| key(&input));
        inputs.extend(pressed.map(|key| Input::Key { key, visible_ms: None }));
        if now() >= self.next {
            self.next = now().after(LOOK_NS);
            inputs.push(Input::Disks(self.machine.disks(&self.stick.1)));
        }
        if !self.machine.has_stick() {
            inputs.push(Input::StickGone);
        }
        inputs
    }

    /// Begins the work on the disk of the state.
    fn begin(&self, stay: bool) -> Result<(), Fatal> {
        let State::Working { disk, .. } = &self.state else { return Ok(()) };
        info!(disk = disk.name, stay, "installing");
        let (machine, stick, sum, disk) = (Arc::clone(&self.machine), Arc::clone(&self.stick), self.sum, disk.clone());
        let out = self.work.0.clone();
        let work = move || {
            let report = |phase, thousandths| drop(out.send(Input::Progress { phase, thousandths }));
            let done = written(&machine, &stick, &sum, &disk, stay, &report);
            let ended = done.map_err(|failure| {
                warn!(error = chain(&failure), disk = disk.name, "cannot install");
                trouble(&failure)
            });
            // The session may have ended.
            let _ = out.send(Input::Ended(ended));
        };
        Ok(threads::start("install", work).map(drop)?)
    }
}

/// Opens the disk, and installs the unit on it, if it still is as the page had it.
fn written(
    machine: &Machine,
    (stick, table): &(File, Table),
    sum: &Sum,
    disk: &Disk,
    stay: bool,
    report: &dyn Fn(Phase, u16),
) -> Result<(), Failure> {
    let file = machine.open(&disk.name).map_err(Failure::Open)?;
    if !machine.disks(table).contains(disk) {
        return Err(Failure::Changed);
    }
    let earlier = machine.table(&disk.name).map_err(Failure::Open)?.filter(|_| stay);
    let plan = Plan::new(table, disk.bytes, earlier.as_ref()).ok_or(Failure::Stick)?;
    install(stick, &file, &plan, sum, report)
}

fn trouble(failure: &Failure) -> Trouble {
    match failure {
        Failure::Changed => Trouble::Busy,
        Failure::Differs => Trouble::Differs,
        Failure::Open(error) if Errno::from_io_error(error) == Some(Errno::BUSY) => Trouble::Busy,
        Failure::Open(_) | Failure::Write(_) => Trouble::Disk,
        Failure::Read(_) | Failure::Stick => Trouble::Stick,
    }
}

/// The key that was pressed, if it means something. One that is held means nothing more.
fn key(input: &input_devices::Input) -> Option<Key> {
    let code = match input {
        input_devices::Input::Key { code, value: 1, .. } => *code,
        input_devices::Input::Key { .. } | input_devices::Input::Lost => return None,
    };
    let digit = DIGITS.iter().position(|codes| codes.contains(&code)).map(|at| Key::Digit(at as u8 + 1));
    digit.or(ENTER.contains(&code).then_some(Key::Enter)).or(DELETE.contains(&code).then_some(Key::Delete))
}
