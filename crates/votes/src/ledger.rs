//! The ledger of a unit: the showings that are open, and the totals of those that are over.
//!
//! Owns that at most one vote counts per showing, and that totals only grow: a vote may change as long as its showing is
//! open, and is added when that is over. The totals are the same for any order and time of the same votes.
//! Never reads a clock or a random source; `store.rs` keeps it.
//!
//! Start at [`Ledger::show`].

use crate::buttons::STUCK_NS;
use crate::noise::Noise;
use crate::showing::{Visit, Vote};
use crate::totals::{LedgerId, MOST_SHEEP, SheepTotals, Totals, is_id};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How long a showing stays open after the next one began: a press may be on its way, and its key turn out to be stuck.
const OPEN_NS: u64 = STUCK_NS + 1_000_000_000;
/// Showings that are open at once, at most.
const MOST_OPEN: usize = 4;
/// A walk that is resumed after a power cut repeats visits of at most so many steps before.
const REPEATED: u64 = 2;

/// Showings and totals of a unit.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ledger {
    totals: Totals,
    /// The noise of each sheep; `None` where the exact totals are sent.
    noise: Option<BTreeMap<String, Noise>>,
    /// In the order in which they began.
    open: Vec<Showing>,
    /// The newest visit that is over.
    over: Option<Visit>,
}

/// A showing that is not over.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Showing {
    visit: Visit,
    vote: Option<Vote>,
    near_ms: u32,
    /// When the next one was seen to be lit; nothing in a ledger that was read.
    #[serde(skip)]
    ended_ns: Option<u64>,
}

/// What a press has done: enough to take it back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Credit {
    visit: Visit,
    /// The vote before.
    before: Option<Vote>,
    now: Vote,
}

impl Credit {
    /// Whether the showing has another vote than before.
    pub fn is_change(&self) -> bool {
        self.before != Some(self.now)
    }

    /// The sheep.
    pub fn sheep(&self) -> &str {
        &self.visit.sheep
    }
}

impl Ledger {
    /// An empty ledger that begins on the day `since_day`.
    pub fn new(id: LedgerId, since_day: u32, is_noisy: bool) -> Self {
        let totals = Totals { ledger: id, since_day, sheep: BTreeMap::new() };
        Self { totals, noise: is_noisy.then(BTreeMap::new), open: Vec::new(), over: None }
    }

    /// A new ledger that goes on with the open showings of this one.
    #[must_use]
    pub fn renewed(self, id: LedgerId, since_day: u32, is_noisy: bool) -> Self {
        let Self { open, over, .. } = self;
        Self { open, over, ..Self::new(id, since_day, is_noisy) }
    }

    /// Whether what is sent has noise.
    pub fn is_noisy(&self) -> bool {
        self.noise.is_some()
    }

    /// Whether it has no room for another sheep: it is time for a new ledger.
    pub fn is_full(&self) -> bool {
        self.totals.sheep.len() >= MOST_SHEEP
    }

    /// `visit` is what is lit at `now_ns`, in the sense of [`crate::seen`]. Showings before it are over six seconds after it
    /// began. Returns whether the totals have changed, or which showings are open.
    pub fn show(&mut self, visit: &Visit, now_ns: u64, random: &mut dyn FnMut() -> u64) -> bool {
        let is_new = self.opened(visit);
        let newest = self.open.iter().position(|showing| showing.visit == *visit).unwrap_or(0);
        let is_settled =
            |showing: &mut Showing| now_ns.saturating_sub(*showing.ended_ns.get_or_insert(now_ns)) >= OPEN_NS;
        let settled = self.open[..newest].iter_mut().map(is_settled).filter(|is_settled| *is_settled).count();
        let over = settled.max(self.open.len().saturating_sub(MOST_OPEN));
        let showings: Vec<_> = self.open.drain(..over).collect();
        for showing in showings {
            self.close(showing, random);
        }
        is_new || over > 0
    }

    /// Counts `vote` for the showing of `visit`; `None` if that is over.
    pub fn vote(&mut self, visit: &Visit, vote: Vote) -> Option<Credit> {
        self.opened(visit);
        let showing = self.open.iter_mut().find(|showing| showing.visit == *visit)?;
        let before = showing.vote.replace(vote);
        Some(Credit { visit: visit.clone(), before, now: vote })
    }

    /// Takes a vote back, if its showing is still open and has no other vote since. Returns whether it did.
    pub fn take_back(&mut self, credit: &Credit) -> bool {
        let same = |showing: &&mut Showing| showing.visit == credit.visit && showing.vote == Some(credit.now);
        let showing = self.open.iter_mut().find(same).filter(|_| credit.is_change());
        showing.map(|showing| showing.vote = credit.before).is_some()
    }

    /// Somebody was near for `ms` while `visit` was lit.
    pub fn near(&mut self, visit: &Visit, ms: u32) {
        if let Some(showing) = self.open.iter_mut().find(|showing| showing.visit == *visit) {
            showing.near_ms = showing.near_ms.saturating_add(ms);
        }
    }

    /// The document that is sent: the totals of the showings that are over, with the noise if it has some.
    pub fn sent(&self) -> Totals {
        let mut totals = self.totals.clone();
        for (id, noise) in self.noise.iter().flatten() {
            totals.sheep.entry(id.clone()).and_modify(|sheep| *sheep = noise.on(*sheep));
        }
        totals
    }

    /// Opens the showing of `visit`, unless it is open or over; returns whether it did.
    fn opened(&mut self, visit: &Visit) -> bool {
        let is_over = self.over.as_ref().is_some_and(|over| {
            over.seed == visit.seed && (visit.step..=visit.step.saturating_add(REPEATED)).contains(&over.step)
        });
        let is_known = is_over || self.open.iter().any(|showing| showing.visit == *visit);
        let is_new = !is_known && is_id(&visit.sheep);
        if is_new {
            self.open.push(Showing { visit: visit.clone(), vote: None, near_ms: 0, ended_ns: None });
        }
        is_new
    }

    /// Adds a showing that is over to the totals. A ledger that is full takes no other sheep.
    fn close(&mut self, showing: Showing, random: &mut dyn FnMut() -> u64) {
        let Showing { visit, vote, near_ms, .. } = showing;
        let id = visit.sheep.clone();
        self.over = Some(visit);
        if self.is_full() && !self.totals.sheep.contains_key(&id) {
            return;
        }
        let (up, down) = (u32::from(vote == Some(Vote::Up)), u32::from(vote == Some(Vote::Down)));
        let one = SheepTotals { shown: 1, up, down, near_s: near_ms / 1_000 };
        if let Some(noise) = &mut self.noise {
            noise.entry(id.clone()).or_insert_with(|| Noise::draw(random));
        }
        let totals = self.totals.sheep.entry(id).or_default();
        *totals = totals.plus(one);
    }
}

#[cfg(test)]
mod tests {
    use super::{Ledger, OPEN_NS};
    use crate::showing::{Visit, Vote};
    use crate::totals::tests_random::random;
    use crate::totals::{LedgerId, SheepTotals};
    use proptest::collection::vec;
    use proptest::prelude::{any, prop_assert_eq, proptest};

    fn visit(step: u64) -> Visit {
        Visit { seed: 7, step, sheep: format!("s{}", step % 3) }
    }

    fn ledger(is_noisy: bool) -> Ledger {
        Ledger::new(LedgerId(5), 20_412, is_noisy)
    }

    /// Shows `visit` until all before it is over.
    fn show_out(ledger: &mut Ledger, visit: &Visit, now_ns: u64) {
        ledger.show(visit, now_ns, &mut random(1));
        ledger.show(visit, now_ns + OPEN_NS, &mut random(1));
    }

    #[test]
    fn at_most_one_vote_counts_per_showing_and_another_key_changes_it() {
        let mut ledger = ledger(false);
        assert!(ledger.show(&visit(0), 0, &mut random(1)), "a showing has begun");
        assert!(!ledger.show(&visit(0), 10 * OPEN_NS, &mut random(1)));
        let changes = [Vote::Up, Vote::Up, Vote::Down, Vote::Up].map(|vote| ledger.vote(&visit(0), vote).unwrap());
        assert_eq!(changes.map(|credit| credit.is_change()), [true, false, true, true]);
        assert_eq!(ledger.sent().sheep.len(), 0, "it may still change");
        ledger.show(&visit(1), 11 * OPEN_NS, &mut random(1));
        assert!(ledger.vote(&visit(0), Vote::Down).is_some(), "a press that was on its way");
        assert!(ledger.show(&visit(1), 12 * OPEN_NS, &mut random(1)));
        assert_eq!(ledger.vote(&visit(0), Vote::Up), None, "too late");
        assert!(!ledger.show(&visit(0), 13 * OPEN_NS, &mut random(1)), "a walk that was resumed repeats no showing");
        let totals = SheepTotals { shown: 1, up: 0, down: 1, near_s: 0 };
        assert_eq!(ledger.sent().sheep.into_iter().collect::<Vec<_>>(), [("s0".to_owned(), totals)]);
    }

    #[test]
    fn the_vote_of_a_stuck_key_is_taken_back_and_only_that() {
        let mut ledger = ledger(false);
        ledger.show(&visit(0), 0, &mut random(1));
        let first = ledger.vote(&visit(0), Vote::Down).unwrap();
        let again = ledger.vote(&visit(0), Vote::Down).unwrap();
        assert!(!ledger.take_back(&again), "the first press stays");
        let other = ledger.vote(&visit(0), Vote::Up).unwrap();
        assert!(!ledger.take_back(&first), "there is another vote since");
        assert!(ledger.take_back(&other));
        show_out(&mut ledger, &visit(1), OPEN_NS);
        assert!(!ledger.take_back(&first), "it is over");
        assert_eq!(ledger.sent().sheep["s0"], SheepTotals { shown: 1, up: 0, down: 1, near_s: 0 });
    }

    #[test]
    fn noise_is_drawn_once_and_kept() {
        let mut ledger = ledger(true);
        let mut random = random(9);
        for step in 0..40 {
            ledger.show(&visit(step), step * 2 * OPEN_NS, &mut random);
            ledger.show(&visit(step), (step * 2 + 1) * OPEN_NS, &mut random);
        }
        let kept: Ledger = serde_json::from_str(&serde_json::to_string(&ledger).unwrap()).unwrap();
        assert_eq!(kept.sent(), ledger.sent());
        assert_eq!(kept.sent(), kept.sent());
        assert_ne!(kept.sent(), kept.totals, "there is some noise on nine numbers");
    }

    #[test]
    fn a_full_ledger_says_so_and_takes_no_other_sheep() {
        let mut ledger = ledger(false);
        for step in 0..5_000 {
            let visit = Visit { seed: 1, step, sheep: step.to_string() };
            show_out(&mut ledger, &visit, step * 2 * OPEN_NS);
        }
        assert!(ledger.is_full() && ledger.sent().sheep.len() == super::MOST_SHEEP);
        let renewed = ledger.renewed(LedgerId(6), 20_500, false);
        assert!(!renewed.is_full() && renewed.open.len() == 1, "the open showing goes on");
    }

    proptest! {
        /// The bytes that are sent are the same for any order and time of the same votes: the shows of a walk are permuted as
        /// a whole, and within each the presses come at any time, also several of them.
        #[test]
        fn what_is_sent_is_the_same_for_any_order_and_time(
            votes in vec(any::<Option<bool>>(), 1..40),
            order in any::<u64>(),
            spread_ns in 1..OPEN_NS,
        ) {
            let vote = |up: bool| if up { Vote::Up } else { Vote::Down };
            let told = |order: &[usize], spread_ns: u64, presses: usize| {
                let mut ledger = ledger(false);
                let mut now_ns = 0;
                for (step, place) in order.iter().enumerate() {
                    let visit = Visit { seed: 7, step: step as u64, sheep: format!("s{}", place % 3) };
                    ledger.show(&visit, now_ns, &mut random(1));
                    for _ in 0..presses {
                        now_ns += spread_ns;
                        if let Some(up) = votes[*place] {
                            ledger.vote(&visit, vote(up));
                        }
                    }
                    now_ns += OPEN_NS;
                    ledger.show(&visit, now_ns, &mut random(1));
                }
                show_out(&mut ledger, &Visit { seed: 7, step: 1_000, sheep: "end".to_owned() }, now_ns + OPEN_NS);
                ledger.sent().to_json()
            };
            let straight: Vec<usize> = (0..votes.len()).collect();
            let mut shuffled = straight.clone();
            let mut random = random(order);
            shuffled.sort_by_cached_key(|_| random());
            prop_assert_eq!(told(&straight, 1, 1), told(&shuffled, spread_ns, 3));
        }
    }
}
