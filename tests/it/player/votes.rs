//! Votes before the wall: `dreams-votes` with a pipe for its input device, beside a player on the virtual screen.
//!
//! Owns the claims on a press, from the key to the mark on the picture and to the totals. Time is measured in the player's
//! own flips. What a press counts for is tried in virtual time by `crates/votes`.
//!
//! Start at [`Voting::begin`].

use crate::flocks::{Flock, Plan};
use crate::player::status_page::{ask, pixels};
use crate::player_run::{PlayerRun, RunningPlayer};
use crate::programs::{dreams, output, succeed, votes};
use crate::trace::{End, Flip};
use claims::wait;
use rustix::fs::{CWD, FileType, Mode, mknodat};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::SystemTime;
use votes::{DAY_S, Ledger, LedgerId, Store, Visit};

/// Clips of some two seconds: a showing takes four.
const QUICK: Plan = Plan { name: "votes", size: (640, 480), fps: (30, 1), sheep: 4, frames: 60 };
/// Clips of some six seconds.
const SLOW: Plan = Plan { name: "votes-slow", size: (320, 240), fps: (10, 1), sheep: 3, frames: 60 };

/// What a press counts for was lit so long before it.
const SEEN_NS: u64 = 700_000_000;
/// Between a flip and the press that the claim makes then may be so much.
const UNSURE_NS: u64 = 150_000_000;
/// Flips of 30 a second in 150 ms.
const AT_ONCE: usize = 4;
/// Flips within which a mark comes, or never.
const PATIENCE: usize = 300;
/// The keys that the claims use.
pub(crate) const UP: u16 = 103;
pub(crate) const DOWN: u16 = 108;
/// Seconds of somebody near each sheep that were counted before.
const NEAR_BEFORE_S: u32 = 297;

/// A player, and `dreams-votes` beside it.
pub(crate) struct Voting {
    run: PlayerRun,
    player: RunningPlayer,
    /// Its flips so far.
    flips: Vec<Flip>,
    /// The far end of the device; `None` while it is unplugged.
    device: Option<File>,
    counting: Counting,
    flock: Flock,
}

/// A running `dreams-votes`. It is killed when dropped.
struct Counting(Child);

impl Voting {
    /// Plays the flock of `plan`, and counts the presses of its device.
    fn begin(plan: Plan) -> Self {
        Self::beside(plan.flock())
    }

    /// The same of any flock.
    pub(crate) fn beside(flock: Flock) -> Self {
        Self::reading("device", flock)
    }

    /// The same with the device that the config has for `key`.
    fn reading(key: &str, flock: Flock) -> Self {
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
    fn plug_in(&mut self) {
        let path = self.run.path("device");
        mknodat(CWD, &path, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        self.device = Some(OpenOptions::new().read(true).write(true).open(&path).unwrap());
        self.read_on();
    }

    /// Waits until `dreams-votes` has its device open. The player plays on.
    fn read_on(&mut self) {
        let (path, descriptors) = (self.run.path("device"), format!("/proc/{}/fd", self.counting.0.id()));
        wait::until("the input device is read", 60, || {
            let open = fs::read_dir(&descriptors).into_iter().flatten().flatten();
            open.filter_map(|entry| fs::read_link(entry.path()).ok()).any(|target| target == path)
        });
        // A press needs a look at the picture before it.
        self.watch(30);
    }

    /// Waits for so many flips.
    pub(crate) fn watch(&mut self, count: usize) {
        let end = self.flips.len() + count;
        while self.flips.len() < end {
            self.flips.extend(self.player.next_line().flips);
        }
    }

    /// The device is pulled out.
    fn unplug(&mut self) {
        self.device = None;
        fs::remove_file(self.run.path("device")).unwrap();
    }

    /// A key gets a value: 1 pressed, 0 released, 2 repeated.
    fn key(&mut self, code: u16, value: i32) {
        let event = [&[0; 16][..], &1u16.to_ne_bytes(), &code.to_ne_bytes(), &value.to_ne_bytes()].concat();
        self.device.as_mut().expect("it is plugged in").write_all(&event).unwrap();
    }

    /// A key is pressed and released.
    pub(crate) fn press(&mut self, code: u16) {
        self.key(code, 1);
        self.key(code, 0);
    }

    /// The same, later than a contact bounces.
    fn press_after_bounce(&mut self, code: u16) {
        self.watch(3);
        self.press(code);
    }

    /// Kills `dreams-votes`, and starts it again.
    fn kill(&mut self) {
        self.counting.0.kill().unwrap();
        wait::ended("`dreams-votes` is killed", 10, &mut self.counting.0);
        self.counting = count(&self.run);
        self.read_on();
    }

    /// Waits for mark `number`; returns after how many flips it was lit.
    fn await_mark(&mut self, number: u64) -> usize {
        for flips in 1..=PATIENCE {
            self.watch(1);
            if self.flips.last().is_some_and(|flip| flip.mark == Some(number)) {
                return flips;
            }
        }
        panic!("mark {number} was not lit within {PATIENCE} flips");
    }

    /// The number of the showing that is lit, and its sheep.
    fn showing(&self) -> (usize, String) {
        showings(&self.flock, &self.flips).pop().expect("something is lit")
    }

    /// Waits for the next showing, until what was seen is of it, too; returns its sheep.
    fn await_next(&mut self) -> String {
        let (now, _) = self.showing();
        while self.showing().0 == now {
            self.watch(1);
        }
        self.watch(10);
        self.showing().1
    }

    /// What `dreams-votes --show` prints.
    pub(crate) fn shown(&self) -> Value {
        let said = output(command(&self.run).arg("--show"));
        serde_json::from_slice(&said.stdout).unwrap_or_else(|_| json!({ "sheep": {} }))
    }

    /// Ends the player; returns its closing counts.
    pub(crate) fn end(self) -> End {
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

fn command(run: &PlayerRun) -> Command {
    let mut command = Command::new(votes());
    command.arg("--config").arg(run.path("votes.toml"));
    command
}

fn count(run: &PlayerRun) -> Counting {
    Counting(command(run).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap())
}

/// The number of the showing that each flip belongs to, and its sheep: in a transition those of the nearer end.
pub(crate) fn showings(flock: &Flock, flips: &[Flip]) -> Vec<(usize, String)> {
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

/// The showing that was seen before the last of `flips`, if it is the same a moment earlier and later.
fn seen(flips: &[Flip], showings: &[(usize, String)]) -> Option<usize> {
    let newest_ns = flips.last()?.t_ns;
    let at = |ns: u64| flips.iter().rposition(|flip| flip.t_ns + ns <= newest_ns).map(|place| showings[place].0);
    let around = [SEEN_NS - UNSURE_NS, SEEN_NS, SEEN_NS + UNSURE_NS].map(at);
    around[1].filter(|showing| around == [Some(*showing); 3])
}

/// The totals of `kind` of each sheep that has some.
pub(crate) fn totals(told: &Value, kind: &str) -> BTreeMap<String, u64> {
    let sheep = told["sheep"].as_object().unwrap().iter();
    sheep.map(|(id, totals)| (id.clone(), totals[kind].as_u64().unwrap())).filter(|(_, total)| *total > 0).collect()
}

#[test]
fn a_press_counts_for_what_was_seen_and_is_answered_at_once() {
    let mut voting = Voting::begin(QUICK);
    // The showing of each press, and after how many flips its mark was lit. Only every other showing is voted for: what counted
    // for the wrong one would be seen.
    let (mut voted, mut waited) = (Vec::new(), Vec::new());
    while waited.len() < 100 {
        voting.watch(1);
        let seen = seen(&voting.flips, &showings(&voting.flock, &voting.flips));
        if let Some(showing) = seen.filter(|showing| showing % 2 == 1) {
            // A vote that changes is stored, too.
            voting.press(if waited.len() % 3 == 0 { DOWN } else { UP });
            voted.push((showing, waited.len() % 3 == 0));
            waited.push(voting.await_mark(waited.len() as u64 + 1));
        }
    }
    // Until the last showing that was voted for is over.
    voting.watch(400);
    let told = voting.shown();
    let numbered = showings(&voting.flock, &voting.flips);
    let (mut ups, mut downs) = (BTreeMap::new(), BTreeMap::new());
    let last_votes: BTreeMap<usize, bool> = voted.into_iter().collect();
    for (showing, is_down) in last_votes {
        let (_, sheep) = numbered.iter().find(|(number, _)| *number == showing).unwrap();
        *if is_down { &mut downs } else { &mut ups }.entry(sheep.clone()).or_default() += 1;
    }
    assert_eq!((totals(&told, "up"), totals(&told, "down")), (ups, downs), "{told:#}");
    let slow = waited.iter().filter(|flips| **flips > AT_ONCE).count();
    assert!(slow <= 1, "{slow} of 100 marks came later than {AT_ONCE} flips after the press: {waited:?}");
    let end = voting.end();
    assert_eq!((end.skipped, end.repeated), (0, 0), "the picture went on");
}

#[test]
fn a_vote_that_was_acknowledged_survives_a_kill_and_a_key_that_is_stuck_gives_none() {
    let mut voting = Voting::begin(SLOW);
    let voted = voting.await_next();
    voting.press(DOWN);
    voting.press_after_bounce(UP);
    voting.await_mark(2);
    voting.kill();
    // Nothing is lost with the device, either.
    voting.unplug();
    let stuck = voting.await_next();
    voting.plug_in();
    voting.key(UP, 1);
    voting.await_mark(3);
    for _ in 0..60 {
        voting.key(UP, 2);
        voting.watch(1);
    }
    voting.key(UP, 0);
    voting.await_next();
    voting.watch(90);
    let told = voting.shown();
    assert_eq!(totals(&told, "up"), BTreeMap::from([(voted, 1)]), "{told:#}");
    assert_eq!((totals(&told, "down").len(), told["sheep"][&stuck]["shown"].as_u64()), (0, Some(1)), "{told:#}");
    voting.end();
}

/// Votes for that the pool `pool` takes in from what `dreams-votes` told.
fn taken_in(pool: &Path, told: &Value) -> u64 {
    let file = pool.with_extension("json");
    fs::write(&file, told.to_string()).unwrap();
    let mut take = Command::new(dreams());
    let said = output(take.arg("votes").args([pool, &file]).args(["--unit", "lobby", "--json"]));
    assert_eq!(said.status.code(), Some(0), "{said:?}");
    let answer: Value = serde_json::from_slice(&said.stdout).unwrap();
    answer["units"]["lobby"]["up"].as_u64().unwrap()
}

#[test]
fn seconds_of_somebody_near_count_for_what_is_seen_and_become_a_vote_of_the_pool() {
    let mut voting = Voting::reading("presence", SLOW.flock());
    let pool = voting.run.path("pool");
    succeed(Command::new(dreams()).args(["pool", "new"]).arg(&pool));
    let before = voting.shown();
    assert_eq!(taken_in(&pool, &before), 0, "less than what counts as a vote: {before:#}");
    // In one showing somebody stands there for most of it, in the next one nobody; in a third the sensor is pulled out.
    let mut seconds: BTreeMap<String, f64> = BTreeMap::new();
    for (is_near, flips) in [(true, 80), (false, 80), (true, 20)] {
        let sheep = voting.await_next();
        let begun_ns = voting.flips.last().unwrap().t_ns;
        voting.key(UP, i32::from(is_near));
        voting.watch(flips);
        let lasted_s = (voting.flips.last().unwrap().t_ns - begun_ns) as f64 / 1e9;
        *seconds.entry(sheep).or_default() += if is_near { lasted_s } else { 0.0 };
        if flips == 80 { voting.key(UP, 0) } else { voting.unplug() }
    }
    voting.await_next();
    voting.watch(90);
    let told = voting.shown();
    let near_s = totals(&told, "near_s");
    for (sheep, before_s) in totals(&before, "near_s") {
        // A look is every half second, and a showing counts whole seconds.
        let (counted_s, was_s) = ((near_s[&sheep] - before_s) as f64, seconds.get(&sheep).copied().unwrap_or_default());
        let is_right = if was_s > 0.0 { counted_s < was_s + 1.0 && counted_s > was_s - 3.0 } else { counted_s == 0.0 };
        assert!(is_right, "`{sheep}`: {counted_s} s were counted, somebody was near for {was_s} s: {told:#}");
    }
    assert!(totals(&told, "up").is_empty(), "nobody has pressed anything: {told:#}");
    let reached = near_s.values().filter(|seconds| **seconds >= 300).count();
    assert_eq!((taken_in(&pool, &told), reached > 0), (reached as u64, true), "{told:#}");
    voting.end();
}

#[test]
fn the_mark_is_a_dot_in_the_corner_of_the_picture() {
    let mut voting = Voting::begin(QUICK);
    let page = voting.run.path("page");
    let light = |rgb: &[u8]| {
        rgb.chunks(3).map(|pixel| pixel.iter().all(|sample| (195..235).contains(sample))).collect::<Vec<_>>()
    };
    voting.press(UP);
    voting.await_mark(1);
    let lit = light(&pixels(&ask(&page, "GET /screen.jpg").body, "jpg"));
    let corner = |at: &usize| at % 640 > 600 - 20 && at / 640 > 440 - 20;
    let dots = (0..lit.len()).filter(corner).filter(|at| lit[*at]).count();
    assert!((40..768).contains(&dots), "{dots} light pixels in the corner");
    voting.end();
}
