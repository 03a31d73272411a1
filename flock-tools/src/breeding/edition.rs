//! The transitions of an edition.
//!
//! Owns which sheep are linked: relatives first, since close genomes make good middles, then sheep whose figures are near.
//! In a flock that is new every sheep gets two transitions to it and two from it, and every sheep can be reached from every
//! other. In a flock that is there, newcomers get as many. Pure: never touches a file.
//!
//! Start at [`links`].

use std::collections::BTreeSet;

use ::breeding::{Born, Id, Point};

/// How much nearer relatives are than their figures tell.
const RELATIVE: f64 = 0.25;
/// How much further sheep of different species are: their pictures are dissolved.
const OTHER_SPECIES: f64 = 2.0;
/// How much further a sheep seems for each transition that it has already.
const CROWD: f64 = 0.5;
/// Transitions to a newcomer, and from it.
const WAYS: usize = 2;

/// A sheep that is to be linked.
pub(super) struct Member<'a> {
    /// Its birth.
    pub(super) born: &'a Born,
    /// Its figures.
    pub(super) point: Point,
    /// Whether the flock has it already.
    pub(super) is_there: bool,
}

/// The transitions that are missing between these sheep, from the first to the second of a pair.
pub(super) fn links(members: &[Member], there: &BTreeSet<(Id, Id)>) -> Vec<(Id, Id)> {
    let mut found: BTreeSet<(usize, usize)> = BTreeSet::new();
    let at = |id: &Id| members.iter().position(|member| member.born.id == *id);
    let mut pairs: BTreeSet<(usize, usize)> = there.iter().filter_map(|(from, to)| at(from).zip(at(to))).collect();
    let known: Vec<usize> = (0..members.len()).filter(|at| members[*at].is_there).collect();
    if known.is_empty() {
        found.extend(rings(members));
    } else {
        let mut connected = known;
        for new in (0..members.len()).filter(|at| !members[*at].is_there) {
            for is_exit in [true, false] {
                let count = |other: usize, pairs: &BTreeSet<(usize, usize)>| {
                    pairs.iter().filter(|(from, to)| if is_exit { *to == other } else { *from == other }).count()
                };
                for _ in 0..WAYS.min(connected.len()) {
                    let pair = |other: usize| if is_exit { (new, other) } else { (other, new) };
                    let free = connected.iter().copied().filter(|other| !pairs.contains(&pair(*other)));
                    let cost = |other: usize| {
                        distance(&members[new], &members[other]) * (1.0 + CROWD * count(other, &pairs) as f64)
                    };
                    let Some(other) = free.min_by(|a, b| cost(*a).total_cmp(&cost(*b))) else { break };
                    pairs.insert(pair(other));
                    found.insert(pair(other));
                }
            }
            connected.push(new);
        }
    }
    found.into_iter().map(|(from, to)| (members[from].born.id, members[to].born.id)).collect()
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
    let is_parent = a.born.parents.contains(&b.born.id) || b.born.parents.contains(&a.born.id);
    let is_sibling = a.born.parents.iter().any(|parent| b.born.parents.contains(parent));
    let kin = if is_parent || is_sibling { RELATIVE } else { 1.0 };
    let species = if a.born.species == b.born.species { 1.0 } else { OTHER_SPECIES };
    a.point.distance(&b.point) * kin * species
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::breeding::{Origin, Scale, Traits};

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
        };
        (0..count).map(born).collect()
    }

    fn members<'a>(births: &'a [Born], there: usize) -> Vec<Member<'a>> {
        let scale = Scale::of(&births.iter().map(|born| &born.figures));
        let member =
            |(at, born): (usize, &'a Born)| Member { born, point: scale.point(&born.figures), is_there: at < there };
        births.iter().enumerate().map(member).collect()
    }

    /// Those that can be reached from the first, along the transitions or against them.
    fn reached(births: &[Born], pairs: &BTreeSet<(Id, Id)>, along: bool) -> usize {
        let mut seen = BTreeSet::from([births[0].id]);
        loop {
            let ways = pairs.iter().map(|(from, to)| if along { (from, to) } else { (to, from) });
            let new: Vec<Id> =
                ways.filter(|(from, to)| seen.contains(from) && !seen.contains(to)).map(|(_, to)| *to).collect();
            if new.is_empty() {
                return seen.len();
            }
            seen.extend(new);
        }
    }

    #[test]
    fn every_sheep_of_a_new_edition_has_two_ways_in_and_two_out_and_can_be_reached() {
        for count in 1..60 {
            let births = births(count);
            let pairs: BTreeSet<(Id, Id)> = links(&members(&births, 0), &BTreeSet::new()).into_iter().collect();
            assert!(pairs.iter().all(|(from, to)| from != to));
            let wanted = [0, 0, 1].get(count as usize).copied().unwrap_or(WAYS);
            for born in &births {
                let out = pairs.iter().filter(|(from, _)| *from == born.id).count();
                let into = pairs.iter().filter(|(_, to)| *to == born.id).count();
                assert_eq!((into, out), (wanted, wanted), "{} of {count}", born.id);
            }
            assert_eq!([true, false].map(|along| reached(&births, &pairs, along)), [count as usize; 2]);
        }
    }

    #[test]
    fn newcomers_are_linked_to_those_that_are_there_and_nobody_else_is() {
        let births = births(20);
        let old: BTreeSet<(Id, Id)> = links(&members(&births[..15], 0), &BTreeSet::new()).into_iter().collect();
        let new = links(&members(&births, 15), &old);
        let is_new = |id: &Id| id.serial >= 15;
        assert!(new.iter().all(|(from, to)| is_new(from) || is_new(to)), "{new:?}");
        let all: BTreeSet<(Id, Id)> = old.iter().chain(&new).copied().collect();
        assert_eq!(all.len(), old.len() + new.len(), "none twice");
        for born in &births[15..] {
            assert!(new.iter().filter(|(from, _)| *from == born.id).count() >= WAYS);
            assert!(new.iter().filter(|(_, to)| *to == born.id).count() >= WAYS);
        }
        assert_eq!([true, false].map(|along| reached(&births, &all, along)), [20; 2]);
    }
}
