//! Key frames: flames that are moments of one animation.
//!
//! Owns how such a file is recognised, and what becomes of it. `flam3-genome` writes the moments of an animation as flames
//! of one file, whose names are their times, or one name for all. Never draws the animation: `dreams still --time` does.
//!
//! Start at [`is_animation`].

use flame::Genome;

/// What becomes of files of key frames, as the command line says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum KeyFrames {
    /// The first of them is a sheep
    First,
    /// Each of them is a sheep
    All,
}

/// Whether `flames` are the key frames of one animation: two or more, whose times grow, without names of their own.
pub(super) fn is_animation(flames: &[&Genome]) -> bool {
    let grow = flames.windows(2).all(|pair| pair[0].time < pair[1].time);
    let first = flames.first().and_then(|flame| own_name(flame));
    flames.len() > 1 && grow && flames.iter().all(|flame| own_name(flame) == first)
}

/// The name of a flame, if it is neither empty nor its time.
pub(super) fn own_name(flame: &Genome) -> Option<&str> {
    let name = flame.name.as_deref().map(str::trim)?;
    let is_time = name.parse::<f64>().is_ok_and(|time| (time - flame.time).abs() < 1e-6);
    (!name.is_empty() && !is_time).then_some(name)
}

/// Why `flames`, which are key frames, are left out unless an option decides.
pub(super) fn undecided(flames: &[&Genome]) -> String {
    let [first, last] = [flames.first(), flames.last()].map(|flame| flame.map_or(0.0, |flame| flame.time));
    format!(
        "its {} flames are the key frames of one animation, of times {first} to {last}: --key-frames first takes the \
         first as a sheep, --key-frames all takes each",
        flames.len()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flames_whose_times_grow_without_names_of_their_own_are_one_animation() {
        let is_one = |flames: &[(&str, f64)]| {
            let flame = |(name, time): &(&str, f64)| Genome {
                name: Some((*name).to_owned()),
                time: *time,
                ..Genome::default()
            };
            let flames: Vec<Genome> = flames.iter().map(flame).collect();
            is_animation(&flames.iter().collect::<Vec<_>>())
        };
        assert!(is_one(&[("0.000000", 0.0), ("1.000000", 1.0), ("2.500000", 2.5)]), "as flam3-genome writes them");
        assert!(is_one(&[("wave", 0.0), ("wave", 60.0)]) && is_one(&[("", -1.0), ("", 0.0)]));
        assert!(!is_one(&[("", 0.0), ("", 0.0)]) && !is_one(&[("", 1.0), ("", 0.0)]), "times that do not grow");
        assert!(!is_one(&[("a", 0.0), ("b", 1.0)]) && !is_one(&[("a", 0.0), ("", 1.0)]), "a collection");
        assert!(!is_one(&[("a", 3.0)]) && !is_one(&[]));
    }
}
