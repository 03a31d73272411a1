//! The transitions of an edition.
//!
//! Owns which sheep are linked: those whose figures are near, where relatives count as four times nearer, since close
//! genomes make good middles. In a flock that is new every sheep gets two transitions to it and two from it, and every
//! sheep can be reached from every other. In a flock that is there, newcomers get as many, and so do sheep that lose one
//! because another leaves; what the artist has linked otherwise stays. Pure: never touches a file.
//!
//! Start at [`links`].

use std::collections::BTreeSet;

use ::breeding::{Born, Point};
use flock::SheepId;

/// How much nearer relatives are than their figures tell.
const RELATIVE: f64 = 0.25;
/// How much further sheep of different species are: their pictures are dissolved.
const OTHER_SPECIES: f64 = 2.0;
/// How far a sheep is of which no figures are known.
const UNKNOWN: f64 = 4.0;
/// How much further a sheep seems for each transition that it has already.
const CROWD: f64 = 0.5;
/// Transitions to a newcomer, and from it.
const WAYS: usize = 2;

/// A sheep that is to be linked.
pub(super) struct Member<'a> {
    /// Its id in the flock.
    pub(super) id: SheepId,
    /// What the pool knows of it; `None` for a sheep that the artist put in from elsewhere.
    pub(super) bred: Option<Bred<'a>>,
    /// Whether the flock has it already.
    pub(super) is_there: bool,
}

/// What a pool knows of a sheep.
pub(super) struct Bred<'a> {
    /// Its birth.
    pub(super) born: &'a Born,
    /// Its figures.
    pub(super) point: Point,
}

/// The end of a transition at which a sheep is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    From,
    To,
}

/// The transitions that are missing between these sheep, from the first to the second of a pair. Of `there`, those that are
/// there, each one that does not join two of these sheep goes.
pub(super) fn links(members: &[Member], there: &BTreeSet<(SheepId, SheepId)>) -> Vec<(SheepId, SheepId)> {
    let at = |id: &SheepId| members.iter().position(|member| member.id == *id);
    let kept: BTreeSet<(usize, usize)> = there.iter().filter_map(|(from, to)| at(from).zip(at(to))).collect();
    let new = if kept.is_empty() { rings(members) } else { mended(members, there, &kept) };
    new.into_iter().map(|(from, to)| (members[from].id.clone(), members[to].id.clone())).collect()
}

/// What a flock lacks of which `kept` stays.
fn mended(
    members: &[Member],
    there: &BTreeSet<(SheepId, SheepId)>,
    kept: &BTreeSet<(usize, usize)>,
) -> BTreeSet<(usize, usize)> {
    let mut pairs = kept.clone();
    let is_member = |id: &SheepId| members.iter().any(|member| member.id == *id);
    let loses = |id: &SheepId, end: End| {
        there.iter().any(|(from, to)| match end {
            End::From => from == id && !is_member(to),
            End::To => to == id && !is_member(from),
        })
    };
    let (known, newcomers): (Vec<usize>, Vec<usize>) = (0..members.len()).partition(|at| members[*at].is_there);
    let mut connected = known.clone();
    for one in newcomers {
        for end in [End::From, End::To] {
            link(members, &mut pairs, one, end, &connected);
        }
        connected.push(one);
    }
    for one in known {
        for end in [End::From, End::To] {
            if loses(&members[one].id, end) {
                link(members, &mut pairs, one, end, &connected);
            }
        }
    }
    connect(members, &mut pairs);
    pairs.difference(kept).copied().collect()
}

/// Gives a sheep as many transitions as it should have, to or from the best `among` the others.
fn link(members: &[Member], pairs: &mut BTreeSet<(usize, usize)>, one: usize, end: End, among: &[usize]) {
    let ways = |at: usize, end: End, pairs: &BTreeSet<(usize, usize)>| {
        pairs.iter().filter(|(from, to)| at == if end == End::From { *from } else { *to }).count()
    };
    let pair = |one: usize, other: usize| if end == End::From { (one, other) } else { (other, one) };
    let far = if end == End::From { End::To } else { End::From };
    while ways(one, end, pairs) < WAYS {
        let free = among.iter().copied().filter(|other| *other != one && !pairs.contains(&pair(one, *other)));
        let cost =
            |other: usize| distance(&members[one], &members[other]) * (1.0 + CROWD * ways(other, far, pairs) as f64);
        let Some(other) = free.min_by(|a, b| cost(*a).total_cmp(&cost(*b))) else { return };
        pairs.insert(pair(one, other));
    }
}

/// Joins what cannot be reached from the first sheep, or cannot reach it, by the nearest pair.
fn connect(members: &[Member], pairs: &mut BTreeSet<(usize, usize)>) {
    for end in [End::From, End::To] {
        loop {
            let seen = reached(pairs, end);
            let (inside, outside): (Vec<usize>, Vec<usize>) = (0..members.len()).partition(|at| seen.contains(at));
            let all = inside.iter().flat_map(|one| outside.iter().map(|other| (*one, *other)));
            let cost = |(a, b): &(usize, usize)| distance(&members[*a], &members[*b]);
            let Some((one, other)) = all.min_by(|a, b| cost(a).total_cmp(&cost(b))) else { break };
            pairs.insert(if end == End::From { (one, other) } else { (other, one) });
        }
    }
}

/// Those that can be reached from the first sheep, or that can reach it.
fn reached(pairs: &BTreeSet<(usize, usize)>, end: End) -> BTreeSet<usize> {
    let mut seen = BTreeSet::from([0]);
    loop {
        let ways = pairs.iter().map(|(from, to)| if end == End::From { (from, to) } else { (to, from) });
        let new: Vec<usize> = ways
            .filter(|(one, other)| seen.contains(*one) && !seen.contains(*other))
            .map(|(_, other)| *other)
            .collect();
        if new.is_empty() {
            return seen;
        }
        seen.extend(new);
    }
}

/// A ring of all, each followed by the nearest that is not in it; and for each one more that is near.
fn rings(members: &[Member]) -> BTreeSet<(usize, usize)> {
    let mut pairs = BTreeSet::new();
    let mut left: Vec<usize> = (1..members.len()).collect();
    let mut last = 0;
    while let Some(next) = nearest(members, last, left.iter().copied()) {
        pairs.insert((last, next));
        left.retain(|other| *other != next);
        last = next;
    }
    if members.len() > 1 {
        pairs.insert((last, 0));
    }
    if members.len() > WAYS {
        second(members, &mut pairs);
    }
    pairs
}

/// One transition more from each sheep and to each.
fn second(members: &[Member], pairs: &mut BTreeSet<(usize, usize)>) {
    let fits = |from: usize, to: usize, pairs: &BTreeSet<(usize, usize)>| from != to && !pairs.contains(&(from, to));
    let mut left: Vec<usize> = (0..members.len()).collect();
    let mut chosen: Vec<(usize, usize)> = Vec::new();
    for from in 0..members.len() {
        let free = left.iter().copied().filter(|to| fits(from, *to, pairs));
        if let Some(to) = nearest(members, from, free) {
            left.retain(|other| *other != to);
            chosen.push((from, to));
            continue;
        }
        // Whoever is left does not fit: one chosen before takes it and gives its own.
        let Some(to) = left.pop() else { return };
        let swap = |(other, own): &(usize, usize)| fits(from, *own, pairs) && fits(*other, to, pairs);
        if let Some(at) = chosen.iter().position(swap) {
            let own = chosen[at].1;
            chosen[at].1 = to;
            chosen.push((from, own));
        }
    }
    pairs.extend(chosen);
}

fn nearest(members: &[Member], from: usize, among: impl Iterator<Item = usize>) -> Option<usize> {
    let cost = |to: usize| distance(&members[from], &members[to]);
    among.min_by(|a, b| cost(*a).total_cmp(&cost(*b)))
}

/// How far two sheep are apart, as what is between them is likely to look.
fn distance(a: &Member, b: &Member) -> f64 {
    let (Some(a), Some(b)) = (&a.bred, &b.bred) else { return UNKNOWN };
    let is_parent = a.born.parents.contains(&b.born.id) || b.born.parents.contains(&a.born.id);
    let is_sibling = a.born.parents.iter().any(|parent| b.born.parents.contains(parent));
    let kin = if is_parent || is_sibling { RELATIVE } else { 1.0 };
    let species = if a.born.species == b.born.species { 1.0 } else { OTHER_SPECIES };
    a.point.distance(&b.point) * kin * species
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::breeding::{Id, Origin, Scale, Traits};

    type Pairs = BTreeSet<(SheepId, SheepId)>;

    fn births(count: u32) -> Vec<Born> {
        let origin = Origin::of_bits(7);
        let born = |serial: u32| Born {
            id: Id { brood: 0, serial, origin },
            parents: if serial > 2 { vec![Id { brood: 0, serial: serial - 3, origin }] } else { Vec::new() },
            operator: "random".into(),
            seed: 0,
            species: if serial.is_multiple_of(4) { "expr" } else { "flam3" }.into(),
            figures: Traits::new(&[f64::from(serial * serial % 11), f64::from(serial % 3)]),
            licence: String::new(),
            strength: 1.0,
            waited: None,
        };
        (0..count).map(born).collect()
    }

    fn name(born: &Born) -> SheepId {
        SheepId::new(&born.id.to_string()).unwrap()
    }

    fn members<'a>(births: &'a [Born], there: usize) -> Vec<Member<'a>> {
        let scale = Scale::of(&births.iter().map(|born| &born.figures));
        let member = |(at, born): (usize, &'a Born)| Member {
            id: name(born),
            bred: Some(Bred { born, point: scale.point(&born.figures) }),
            is_there: at < there,
        };
        births.iter().enumerate().map(member).collect()
    }

    /// How many transitions there are to a sheep, and from it.
    fn ways(pairs: &Pairs, id: &SheepId) -> [usize; 2] {
        [pairs.iter().filter(|(_, to)| to == id).count(), pairs.iter().filter(|(from, _)| from == id).count()]
    }

    /// Whether every member can be reached from every other.
    fn hangs_together(members: &[Member], pairs: &Pairs) -> bool {
        let at = |id: &SheepId| members.iter().position(|member| member.id == *id).unwrap();
        let pairs = pairs.iter().map(|(from, to)| (at(from), at(to))).collect();
        [End::From, End::To].into_iter().all(|end| reached(&pairs, end).len() == members.len())
    }

    #[test]
    fn every_sheep_of_a_new_edition_has_two_ways_in_and_two_out_and_can_be_reached() {
        for count in 1..60 {
            let births = births(count);
            let members = members(&births, 0);
            let pairs: Pairs = links(&members, &BTreeSet::new()).into_iter().collect();
            assert!(pairs.iter().all(|(from, to)| from != to));
            let wanted = [0, 0, 1].get(count as usize).copied().unwrap_or(WAYS);
            assert!(members.iter().all(|member| ways(&pairs, &member.id) == [wanted; 2]), "{count}");
            assert!(hangs_together(&members, &pairs), "{count}");
        }
    }

    #[test]
    fn newcomers_are_linked_to_those_that_are_there_and_nobody_else_is() {
        let births = births(20);
        let old: Pairs = links(&members(&births[..15], 0), &BTreeSet::new()).into_iter().collect();
        let members = members(&births, 15);
        let new = links(&members, &old);
        let is_new = |id: &SheepId| births[15..].iter().any(|born| name(born) == *id);
        assert!(new.iter().all(|(from, to)| is_new(from) || is_new(to)), "{new:?}");
        let all: Pairs = old.iter().chain(&new).cloned().collect();
        assert_eq!(all.len(), old.len() + new.len(), "none twice");
        assert!(members[15..].iter().all(|member| ways(&all, &member.id).iter().all(|count| *count >= WAYS)));
        assert!(hangs_together(&members, &all));
    }

    #[test]
    fn whoever_loses_transitions_gets_others_and_what_the_artist_linked_stays() {
        let births = births(24);
        let old: Pairs = links(&members(&births, 0), &BTreeSet::new()).into_iter().collect();
        // The artist has taken out one transition between two that stay.
        let stays = |id: &SheepId| births.iter().step_by(2).any(|born| name(born) == *id);
        let taken_out = old.iter().find(|(from, to)| stays(from) && stays(to)).cloned();
        let old: Pairs = old.into_iter().filter(|pair| Some(pair) != taken_out.as_ref()).collect();
        // Every second sheep leaves; one of another origin stays among them.
        let own = SheepId::new("own").unwrap();
        let mut there = old.clone();
        there.insert((name(&births[1]), own.clone()));
        there.insert((own.clone(), name(&births[3])));
        let kept: Vec<Born> = births.iter().step_by(2).cloned().collect();
        let mut members = members(&kept, kept.len());
        members.push(Member { id: own.clone(), bred: None, is_there: true });
        let new = links(&members, &there);
        let is_member = |id: &SheepId| members.iter().any(|member| member.id == *id);
        let mut all: Pairs = there.iter().filter(|(from, to)| is_member(from) && is_member(to)).cloned().collect();
        all.extend(new);
        assert!(hangs_together(&members, &all), "{all:?}");
        for member in &members {
            let before = ways(&there, &member.id);
            assert!(ways(&all, &member.id).iter().zip(before).all(|(now, before)| *now >= before.min(WAYS)));
        }
    }

    #[test]
    fn a_newcomer_is_linked_to_its_parent_unless_others_look_four_times_as_near() {
        let births = births(24);
        // The last is a child of the first, which is so far from it; two others are at a distance of 1.
        let linked = |far: f64| {
            let mut births = births.clone();
            for (born, at) in births.iter_mut().zip(0..) {
                born.parents.clear();
                (born.species, born.figures) = ("flam3".into(), Traits::new(&[f64::from(at) * 100.0, 0.0]));
            }
            for (at, place) in [(23, 0.0), (0, far), (1, 1.0), (2, -1.0)] {
                births[at].figures = Traits::new(&[1_150.0 + place, 0.0]);
            }
            births[23].parents = vec![births[0].id];
            let scale = Scale::of(&births.iter().map(|born| &born.figures));
            let member = |(at, born)| Member {
                id: name(born),
                bred: Some(Bred { born, point: scale.point(&born.figures) }),
                is_there: at < 23,
            };
            let members: Vec<Member> = births.iter().enumerate().map(member).collect();
            let there: Pairs = (0..23).map(|at| (name(&births[at]), name(&births[(at + 1) % 23]))).collect();
            let new = links(&members, &there);
            new.contains(&(name(&births[23]), name(&births[0]))) && new.contains(&(name(&births[0]), name(&births[23])))
        };
        assert_eq!([2.0, 8.0].map(linked), [true, false]);
    }
}
