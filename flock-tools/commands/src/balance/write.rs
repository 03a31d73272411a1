//! Writes balanced weights into the manifest.
//!
//! Owns the edit of `--write`: only weights that differ are changed, and none if the flock would be further from its wants
//! with the new ones. A manifest without such is not written. The flock crate finds the weights.

use std::sync::Arc;

use flock::Draft;
use flock::{Balance, Flock, FlockShares, Manifest, Measure};
use operations::program::{Exit, Fatal};

/// Writes the weights of `balance` into `draft`, whose manifest is that of `flock`; returns how many were changed, and the
/// manifest with them. The flock goes first: as long as it is there, its manifest has to be copied to be changed.
/// Errors: If the manifest cannot be saved. It is then as it was.
pub(super) fn weights(mut draft: Draft, flock: Flock, balance: &Balance) -> Result<(usize, Arc<Manifest>), Fatal> {
    let places: Vec<u32> = places(&flock).collect();
    drop(flock);
    let mut changed = 0;
    for (at, weight) in places.into_iter().zip(&balance.weights) {
        let set = draft.edit.set_weight_at(at as usize, weight.weight);
        changed += usize::from(set.map_err(|error| Fatal::new(Exit::Malformed, error))?);
    }
    let manifest = draft.edit.shared_manifest();
    if changed > 0 {
        draft.save()?;
    }
    Ok((changed, manifest))
}

/// `flock` with the weights of `balance`.
pub(crate) fn with_weights(flock: &Flock, balance: &Balance) -> Flock {
    let mut manifest = flock.manifest().clone();
    for (at, weight) in places(flock).zip(&balance.weights) {
        manifest.transitions[at as usize].weight = weight.weight;
    }
    Flock::new(manifest)
}

/// The places in the manifest of `flock` of the transitions that a balance has weights for, in the order of these.
fn places(flock: &Flock) -> impl Iterator<Item = u32> {
    let whole = flock.whole();
    whole.sheep().flat_map(|sheep| whole.exits(sheep)).map(|exit| whole.transition_in_manifest(exit) as u32)
}

/// The worst ratio of `flock` as it stands, `by` a measure. `None` if it plays nothing, or not all that is wanted.
pub(super) fn worst_ratio(flock: &Flock, by: Measure) -> Option<f64> {
    FlockShares::of(flock)?.worst(by)
}

/// The worst ratio `was` and that with the weights of `balance`, in its measure, if the latter is worse. Nearness to the
/// wants is weighed against nearness to the weights as written, and the least played transitions get their floor: both may
/// take from the sheep that is furthest from its want.
pub(super) fn worse(was: f64, balance: &Balance) -> Option<[f64; 2]> {
    let is = balance.worst().unwrap_or(f64::INFINITY);
    (is > was).then_some([was, is])
}

/// What was written of `balance`, in one line; `was` is the worst ratio before, in its measure.
pub(super) fn summary(changed: usize, balance: &Balance, was: Option<f64>) -> String {
    let (all, by) = (balance.weights.len(), balance.by);
    if changed == 0 {
        return format!("note: nothing to write, all {all} weights stand already");
    }
    let was = was.map_or(String::new(), |ratio| format!("; the worst ratio of {by} and want was {ratio:.3}"));
    format!("note: wrote {changed} of {all} weights{was}")
}

/// Why nothing was written, in one line, by the two ratios of [`worse`]; the balance was `by` a measure.
pub(super) fn kept([was, is]: [f64; 2], by: Measure) -> String {
    format!(
        "note: nothing written, the weights stay: their worst ratio of {by} and want is {was:.3}, that of these is \
         {is:.3}; --suggest looks for transitions that would help"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use flock::{Manifest, Terms};
    use proptest::prelude::*;
    use std::fmt::Write as _;
    use std::path::Path;

    fn flock(wants: &[f64], weights: &[(usize, usize, f64)]) -> Flock {
        let mut text = "format = 1\nname = \"x\"\nsize = [64, 64]\nfps = [30, 1]\n".to_owned();
        for (at, want) in wants.iter().enumerate() {
            let frames = 768 * (1 + at % 3);
            write!(text, "[[sheep]]\nid = \"s{at}\"\nframes = {frames}\nclip = \"s{at}.mp4\"\nwant = {want:?}\n")
                .unwrap();
        }
        for (from, to, weight) in weights {
            let ends = format!("from = \"s{from}\"\nto = \"s{to}\"\nframes = 384\nclip = \"{from}={to}.mp4\"");
            write!(text, "[[transition]]\n{ends}\nweight = {weight:?}\n").unwrap();
        }
        Flock::new(Manifest::parse(&text, Path::new("flock.toml")).unwrap())
    }

    fn terms() -> impl Strategy<Value = Terms> {
        let fairness = prop_oneof![Just(3.0), Just(0.3), Just(30.0), Just(f64::INFINITY)];
        let floor = prop_oneof![Just(12.0), Just(0.0), Just(2000.0)];
        let by = prop_oneof![Just(Measure::Visits), Just(Measure::Time)];
        (fairness, floor, any::<bool>(), by).prop_map(|(fairness, floor, afresh, by)| Terms {
            fairness,
            floor,
            afresh,
            by,
        })
    }

    proptest! {
        /// A ring, so that all is played, with more transitions across it; weights and wants are far apart.
        #[test]
        fn what_is_written_is_never_further_from_the_wants(
            wants in prop::collection::vec((-3i32..3).prop_map(|power| 2f64.powi(power)), 2..9),
            ring in prop::collection::vec((-6i32..6).prop_map(|power| 2f64.powi(power)), 9),
            across in prop::collection::btree_map((0usize..9, 0usize..9), (-6i32..6).prop_map(|p| 2f64.powi(p)), 0..20),
            terms in terms(),
        ) {
            let n = wants.len();
            let mut weights: std::collections::BTreeMap<(usize, usize), f64> =
                across.into_iter().map(|((from, to), weight)| ((from % n, to % n), weight)).collect();
            weights.extend((0..n).map(|at| ((at, (at + 1) % n), ring[at])));
            let weights: Vec<_> = weights.into_iter().map(|((from, to), weight)| (from, to, weight)).collect();
            let before = flock(&wants, &weights);
            let balance = Balance::of(&before, terms).unwrap();
            let is_worse = worst_ratio(&before, terms.by).and_then(|was| worse(was, &balance)).is_some();
            let after = if is_worse { before.clone() } else { with_weights(&before, &balance) };
            let [was, is] = [&before, &after].map(|flock| FlockShares::of(flock).unwrap().worst(terms.by).unwrap());
            prop_assert!(is <= was * (1.0 + 1e-9), "{} was {}: {:?} {:?} {:?}", is, was, wants, weights, terms);
        }
    }
}
