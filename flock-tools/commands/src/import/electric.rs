//! What names of Electric Sheep's files tell.
//!
//! Owns their forms, for clips and genomes alike, and what its site says of the licences: sheep that people designed are
//! under CC BY 3.0, those that its program has bred under CC BY-NC 3.0, and sheep of the generations from 10000 on were sold
//! and are under neither. Where a file does not tell which it is, it counts as bred.
//!
//! Start at [`ElectricName::of_file`].

use flame::genome::Origin;
use flock::SheepId;
use operations::credits::Licence;

/// The beginning of the names of genomes.
const PREFIX: &str = "electricsheep.";
/// What its licences ask everybody to say who shows a sheep.
pub(crate) const ATTRIBUTION: &str = "artwork by Scott Draves and the Electric Sheep";
/// The first generation that was sold.
const GOLD: u64 = 10_000;
/// The licence of sheep that people designed.
const DESIGNED: &str = "CC-BY-3.0-US";
/// The licence of all others: SPDX lists no version of it for a single country but Germany.
const BRED: &str = "CC-BY-NC-3.0";
/// Of sheep that were sold.
const SOLD: &str = "LicenseRef-Electric-Sheep-Gold";

/// A sheep, or a transition between two, as Electric Sheep calls it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ElectricName {
    generation: u64,
    number: u64,
    /// The sheep where it starts and where it ends, if the name has them.
    ends: Option<(u64, u64)>,
}

impl ElectricName {
    /// The name of a flame: `electricsheep.247.00505`.
    pub(crate) fn of_flame(name: &str) -> Option<Self> {
        Self::dotted(name).filter(|name| name.ends.is_none())
    }

    /// The name of a file without its ending: that of a flame, with or without the sheep where it starts and where it ends,
    /// or `00247=00505=00505=00505`.
    pub(crate) fn of_file(stem: &str) -> Option<Self> {
        let equals: Option<Vec<u64>> = stem.split('=').map(number).collect();
        match equals.as_deref() {
            Some(&[generation, number, first, last]) => Some(Self { generation, number, ends: Some((first, last)) }),
            Some(_) | None => Self::dotted(stem),
        }
    }

    fn dotted(name: &str) -> Option<Self> {
        let parts: Option<Vec<u64>> = name.strip_prefix(PREFIX)?.split('.').map(number).collect();
        match parts?[..] {
            [generation, number] => Some(Self { generation, number, ends: None }),
            [generation, number, first, last] => Some(Self { generation, number, ends: Some((first, last)) }),
            _ => None,
        }
    }

    /// The sheep of this number.
    pub(crate) fn sheep(&self) -> SheepId {
        sheep(self.generation, self.number)
    }

    /// The sheep where it starts and where it ends, if the name has them.
    pub(crate) fn ends(&self) -> Option<(SheepId, SheepId)> {
        self.ends.map(|(first, last)| (sheep(self.generation, first), sheep(self.generation, last)))
    }

    /// The name by which it is credited.
    pub(crate) fn source(&self) -> String {
        format!("{PREFIX}{}.{:05}", self.generation, self.number)
    }

    /// What it calls the sheep where it starts and the one where it ends, if the name has them.
    pub(crate) fn end_names(&self) -> Option<[Self; 2]> {
        let (first, last) = self.ends?;
        Some([first, last].map(|number| Self { generation: self.generation, number, ends: None }))
    }

    /// Its licence by generation, and by the origin that its genome tells, if there is one.
    pub(crate) fn licence(&self, origin: Option<&Origin>) -> Option<Licence> {
        let designed = origin.is_some_and(|origin| origin.designed && !origin.bred);
        Licence::read(match self.generation {
            GOLD.. => SOLD,
            _ if designed => DESIGNED,
            _ => BRED,
        })
    }
}

/// The id that the sheep `number` of `generation` gets in a flock.
fn sheep(generation: u64, number: u64) -> SheepId {
    SheepId::new(&format!("{generation}.{number}")).expect("two numbers and a point are an id")
}

/// A number with any zeros before it.
fn number(digits: &str) -> Option<u64> {
    let plain = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
    digits.parse().ok().filter(|_| plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_tells_generation_number_and_ends() {
        let told = |stem| {
            let name = ElectricName::of_file(stem)?;
            let ends = name.ends().map(|(from, to)| format!("{}={}", from.as_str(), to.as_str()));
            Some((name.source(), name.sheep().as_str().to_owned(), ends.unwrap_or_default()))
        };
        let wanted = |source: &str, id: &str, ends: &str| Some((source.to_owned(), id.to_owned(), ends.to_owned()));
        assert_eq!(told("electricsheep.247.00505"), wanted("electricsheep.247.00505", "247.505", ""));
        assert_eq!(told("electricsheep.242.172.76.99"), wanted("electricsheep.242.00172", "242.172", "242.76=242.99"));
        assert_eq!(told("00202=70000=67501=00033"), wanted("electricsheep.202.70000", "202.70000", "202.67501=202.33"));
        for odd in ["electricsheep.247", "electricsheep.a.b", "247.505", "1=2=3", "electricsheep.1.2.3", "1=2=3=+4"] {
            assert_eq!(told(odd), None, "{odd}");
        }
        assert_eq!(ElectricName::of_flame("electricsheep.242.172.76.99"), None);
    }

    #[test]
    fn a_licence_follows_generation_and_origin_and_bred_is_assumed() {
        let name = |generation: u64| ElectricName { generation, number: 1, ends: None };
        let licence = |generation, origin: Option<&Origin>| name(generation).licence(origin).unwrap().to_string();
        let designed = Origin { designed: true, ..Origin::default() };
        assert_eq!(licence(247, Some(&designed)), "CC-BY-3.0-US");
        assert_eq!(licence(247, Some(&Origin { bred: true, ..designed.clone() })), "CC-BY-NC-3.0");
        assert_eq!((licence(247, Some(&Origin::default())), licence(247, None)), (BRED.into(), BRED.into()));
        assert_eq!(licence(10_247, Some(&designed)), "LicenseRef-Electric-Sheep-Gold");
    }
}
