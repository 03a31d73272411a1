//! `dreams-votes` with a pipe for its input device, beside a player on the virtual screen.
//!
//! Owns both processes, and what the player's flips say of showings. Time is measured in these flips.
//!
//! Start at [`Voting::begin`].

use crate::flocks::{Flock, Plan};
use crate::player_run::{PlayerRun, RunningPlayer};
use crate::programs::{output, votes};
use crate::trace::{End, Flip};
use crate::wait;
use rustix::fs::{CWD, FileType, Mode, mknodat};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::SystemTime;
use votes::{DAY_S, Ledger, LedgerId, Store, Visit};

/// What a press counts for was lit so long before it.
pub const SEEN_NS: u64 = 700_000_000;
/// Between a flip and the press that the claim makes then may be so much.
pub const UNSURE_NS: u64 = 150_000_000;
/// Flips of 30 a second in 150 ms.
pub const AT_ONCE: usize = 4;
/// Flips within which a mark comes, or never.
pub const PATIENCE: usize = 300;
/// The keys that the claims use.
pub const UP: u16 = 103;
pub const DOWN: u16 = 108;
/// Seconds of somebody near each sheep that were counted before.
pub const NEAR_BEFORE_S: u32 = 297;

/// A player, and `dreams-votes` beside it.
pub struct Voting {
    pub run: PlayerRun,
    player: RunningPlayer,
    /// Its flips so far.
    pub flips: Vec<Flip>,
    /// The far end of the device; `None` while it is unplugged.
    device: Option<File>,
    counting: Counting,
    pub flock: Flock,
}

/// A running `dreams-votes`. It is killed when dropped.
pub struct Counting(Child);

impl Voting {
    /// Plays the flock of `plan`, and counts the presses of its device.
    pub fn begin(plan: Plan) -> Self {
        Self::beside(plan.flock())
    }

    /// The same of any flock.
    pub fn beside(flock: Flock) -> Self {
        Self::reading("device", flock)
    }

    /// The same with the device that the config has for `key`.
    pub fn reading(key: &str, flock: Flock) -> Self {
        let run = PlayerRun::of(&flock.folder);
        let [page, mark, device, store] = ["page", "mark", "device", "votes"].map(|name| run.path(name));
        let status = format!("unix:{}", page.display());
        let options =
            ["--screen", "virtual", "--seed", "3", "--status", &status, "--acknowledge", mark.to_str().unwrap()];
        let run = run.with(&options);
        let config = format!(
            "{key} = '{}'\nup = {UP}\ndown = {DOWN}\nstore = '{}'\nstatus = '{status}'\nacknowledge = '{}'\n",
            device.display(),
            store.display(),
            mark.display()
        );
        fs::write(run.path("votes.toml"), config).unwrap();
        fs::create_dir(&store).unwrap();
        if key == "presence" {
            count_before(&store, &flock);
        }
        let mut player = run.start();
        player.await_line_with("\"flip\"");
        let counting = count(&run);
        let mut voting = Self { run, player, flips: Vec::new(), device: None, counting, flock };
        voting.plug_in();
        voting
    }

    /// Plugs the device in, and waits until it is read.
    pub fn plug_in(&mut self) {
        let path = self.run.path("device");
        mknodat(CWD, &path, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        self.device = Some(OpenOptions::new().read(true).write(true).open(&path).unwrap());
        self.read_on();
    }

    /// Waits until `dreams-votes` has its device open. The player plays on.
    pub fn read_on(&mut self) {
        let (path, descriptors) = (self.run.path("device"), format!("/proc/{}/fd", self.counting.0.id()));
        wait::until("the input device is read", 60, || {
            let open = fs::read_dir(&descriptors).into_iter().flatten().flatten();
            open.filter_map(|entry| fs::read_link(entry.path()).ok()).any(|target| target == path)
        });
        // A press needs a look at the picture before it.
        self.watch(30);
    }

    /// Waits for so many flips.
    pub fn watch(&mut self, count: usize) {
        let end = self.flips.len() + count;
        while self.flips.len() < end {
            self.flips.extend(self.player.next_line().flips);
        }
    }

    /// The device is pulled out.
    pub fn unplug(&mut self) {
        self.device = None;
        fs::remove_file(self.run.path("device")).unwrap();
    }

    /// A key gets a value: 1 pressed, 0 released, 2 repeated.
    pub fn key(&mut self, code: u16, value: i32) {
        let event = [&[0; 16][..], &1u16.to_ne_bytes(), &code.to_ne_bytes(), &value.to_ne_bytes()].concat();
        self.device.as_mut().expect("it is plugged in").write_all(&event).unwrap();
    }

    /// A key is pressed and released.
    pub fn press(&mut self, code: u16) {
        self.key(code, 1);
        self.key(code, 0);
    }

    /// The same, later than a contact bounces.
    pub fn press_after_bounce(&mut self, code: u16) {
        self.watch(3);
        self.press(code);
    }

    /// Kills `dreams-votes`, and starts it again.
    pub fn kill(&mut self) {
        self.counting.0.kill().unwrap();
        wait::ended("`dreams-votes` is killed", 10, &mut self.counting.0);
        self.counting = count(&self.run);
        self.read_on();
    }

    /// Waits for mark `number`; returns after how many flips it was lit.
    pub fn await_mark(&mut self, number: u64) -> usize {
        for flips in 1..=PATIENCE {
            self.watch(1);
            if self.flips.last().is_some_and(|flip| flip.mark == Some(number)) {
                return flips;
            }
        }
        panic!("mark {number} was not lit within {PATIENCE} flips");
    }

    /// The number of the showing that is lit, and its sheep.
    pub fn showing(&self) -> (usize, String) {
        showings(&self.flock, &self.flips).pop().expect("something is lit")
    }

    /// Waits for the next showing, until what was seen is of it, too; returns its sheep.
    pub fn await_next(&mut self) -> String {
        let (now, _) = self.showing();
        while self.showing().0 == now {
            self.watch(1);
        }
        self.watch(10);
        self.showing().1
    }

    /// What `dreams-votes --show` prints.
    pub fn shown(&self) -> Value {
        let said = output(command(&self.run).arg("--show"));
        serde_json::from_slice(&said.stdout).unwrap_or_else(|_| json!({ "sheep": {} }))
    }

    /// Ends the player; returns its closing counts.
    pub fn end(self) -> End {
        self.player.signal(rustix::process::Signal::TERM);
        let (code, trace) = self.player.end_within(10);
        assert_eq!((code, trace.faults.len()), (Some(0), 0), "{:?}", trace.faults);
        trace.end.unwrap()
    }
}

impl Drop for Counting {
    fn drop(&mut self) {
        // Fails only if it has ended by itself.
        let _ended = self.0.kill();
        let _status = self.0.wait();
    }
}

/// Writes down that each sheep was shown once, and somebody was near for [`NEAR_BEFORE_S`]: since the day on which the folder
/// `store` was made.
fn count_before(store: &Path, flock: &Flock) {
    let made = fs::metadata(store).unwrap().modified().unwrap().duration_since(SystemTime::UNIX_EPOCH).unwrap();
    let mut ledger = Ledger::new(LedgerId(1), (made.as_secs() / DAY_S) as u32, false);
    let mut sheep: Vec<_> = flock.shows.keys().filter(|clip| !clip.contains('=')).collect();
    sheep.sort();
    // The showing that begins last stays open: that of the first sheep again.
    for (step, clip) in (0..).zip(sheep.iter().chain(sheep.first())) {
        let visit = Visit { seed: 1, step, sheep: clip.trim_end_matches(".mp4").to_owned() };
        // A showing is over a minute after the next one began.
        for ns in [0, 60_000_000_000] {
            ledger.show(&visit, step * 120_000_000_000 + ns, &mut || 0);
        }
        ledger.near(&visit, if step < sheep.len() as u64 { NEAR_BEFORE_S * 1_000 } else { 0 });
    }
    Store::open(store).unwrap().0.save(&ledger).unwrap();
}

pub fn command(run: &PlayerRun) -> Command {
    let mut command = Command::new(votes());
    command.arg("--config").arg(run.path("votes.toml"));
    command
}

pub fn count(run: &PlayerRun) -> Counting {
    Counting(command(run).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap())
}

/// The number of the showing that each flip belongs to, and its sheep: in a transition those of the nearer end.
pub fn showings(flock: &Flock, flips: &[Flip]) -> Vec<(usize, String)> {
    let nearest = |flip: &Flip| {
        let name = flip.clip.trim_end_matches(".mp4");
        let (from, to) = name.split_once('=').unwrap_or((name, name));
        if flip.frame * 2 < flock.shows[&flip.clip].len() as u64 { from } else { to }.to_owned()
    };
    let (mut number, mut before) = (0, None);
    let numbered = flips.iter().map(nearest).map(|sheep| {
        number += usize::from(before.replace(sheep.clone()).is_some_and(|before| before != sheep));
        (number, sheep)
    });
    numbered.collect()
}

/// The totals of `kind` of each sheep that has some.
pub fn totals(told: &Value, kind: &str) -> BTreeMap<String, u64> {
    let sheep = told["sheep"].as_object().unwrap().iter();
    sheep.map(|(id, totals)| (id.clone(), totals[kind].as_u64().unwrap())).filter(|(_, total)| *total > 0).collect()
}
