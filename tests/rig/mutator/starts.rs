//! Changes the start file or the root of a system.
//!
//! Owns changes with the old papers and with papers that name the changed file. Those that the artist has signed are
//! detected by the unit only, when it installs them.
//!
//! Start at [`change`].

use super::fields::{Signing, dressed};
use super::keys::KeyHolder;
use super::{Detection, Dice, Good, Material, Stick};
use crate::mutator::bytes;
use bundle::ObjectId;

/// Changes one half of the system; returns what was done.
pub(super) fn change(stick: &mut Stick, good: &Good, material: Material<'_>, dice: &mut Dice) -> (String, Detection) {
    let release = good.release();
    let name = *dice.of_these(&["start", "root"]);
    let line = release.lines().find(|line| line.starts_with(name)).expect("each system has both");
    let before = line.rsplit(' ').next().unwrap_or_default();
    let path = ObjectId::parse(before).unwrap().path();
    let whole = stick.bytes(&path).to_vec();
    let (mut half, mut done) = (whole.clone(), Vec::new());
    while half == whole {
        done.push(bytes::varied(&mut half, dice));
    }
    let done = done.join(", ");
    if dice.chance(40) {
        stick.put(&path, half);
        return (format!("the {name} of the system: {done}"), Detection::ByAllOrHarmless);
    }
    let id = ObjectId::of(&half);
    let text = release.replace(line, &format!("{name} {} {id}", half.len()));
    stick.put_object(&half);
    // A root that the artist has signed is not examined further: it is started, and given up if it fails.
    let by_artist = name == "start" && dice.chance(50);
    let dresses = [Signing::Kept, Signing::By(KeyHolder::Stranger), Signing::By(KeyHolder::Lost), Signing::Claimed];
    let signing = if by_artist { Signing::By(KeyHolder::Artist) } else { *dice.of_these(&dresses) };
    let seal = dressed(material.keys(), signing, stick.bytes("systems/all.seal"), KeyHolder::Artist, text.as_bytes());
    stick.put("systems/all.seal", seal);
    (
        format!("the {name} of the system, {signing:?}: {done}"),
        if by_artist { Detection::ByUnits } else { Detection::ByAll },
    )
}
