//! A circulation that meets the wants exactly, in integers.
//!
//! Owns the last step with infinite fairness: the floating-point result is corrected to integers, so that sheep keep
//! their shares also in a nearly decomposable flock.
//!
//! Start at [`circulation`].

use super::bypass::Bypassed;
use super::network::Network;
use super::reach::{GIVE, Transport, units};

/// No visits move by more than this part so that silent transitions carry something.
const SILENT: f64 = 1e-7;

/// A circulation near `flow`, which is one nearly: every sheep is visited as often as it is wanted, to a billionth of
/// that, and every transition carries something, the silent ones hardly anything. `None` if there is none.
///
/// `network` is one strongly connected class. Rows and columns are equal to the last unit, and so the walk's shares
/// follow from the weights alone.
pub(super) fn circulation(network: &Network, flow: &[f64]) -> Option<Vec<f64>> {
    let mut carried = in_units(network, flow)?;
    activate_all(network, &mut carried);
    let whole = carried.iter().sum::<i128>() as f64;
    Some(carried.into_iter().map(|units| units as f64 / whole).collect())
}

/// Whether there is such a circulation, but for the silent transitions.
pub(super) fn is_there(network: &Network, flow: &[f64]) -> bool {
    in_units(network, flow).is_some()
}

/// What each transition carries in whole units, the silent ones nothing.
fn in_units(network: &Network, flow: &[f64]) -> Option<Vec<i128>> {
    // A sheep may be visited a little less than the most that it may, or any less if nothing is wanted of it.
    let wide = Bypassed::of(network, |_| true);
    let most = |sheep: usize| if network.is_free(sheep) { i128::MAX } else { 2 * (units(network.want[sheep]) / GIVE) };
    let hint = wide.widened(network, flow, 1.0 / GIVE as f64);
    let limits = wide.each(|_| i128::MAX, most);
    let wants = wide.network.want.iter().map(|&want| units(want) + units(want) / GIVE).collect();
    let mut transport = Transport::new(&wide.network, wants, Some(limits), &hint);
    if transport.fill() > 0 {
        return None;
    }
    Some(wide.own(&transport.flow))
}

/// Lets every transition of `network` carry something, by closed ways that lead through those that do not.
fn activate_all(network: &Network, carried: &mut [i128]) {
    let throughput = |flow: &[i128]| -> Vec<i128> {
        (0..network.len()).map(|sheep| flow[network.exits(sheep)].iter().sum()).collect()
    };
    let (visits, most) = (throughput(carried), throughput(&closed_ways(network, |_| true)));
    let bearable = |(visits, ways): (&i128, &i128)| (SILENT * *visits as f64) as i128 / ways;
    let amount = visits.iter().zip(&most).map(bearable).min().unwrap_or(1).max(1);
    let ways = closed_ways(network, |arc| carried[arc] < amount);
    for (carried, ways) in carried.iter_mut().zip(ways) {
        *carried += amount * ways;
    }
}

/// How often each transition lies on the closed ways from the first sheep through each of those `wanted`.
fn closed_ways(network: &Network, wanted: impl Fn(usize) -> bool) -> Vec<i128> {
    let n = network.len();
    let mut ways = vec![0; network.arcs()];
    let (mut there, mut back) = (vec![0; n], vec![0; n]);
    for arc in (0..network.arcs()).filter(|&arc| wanted(arc)) {
        let (from, to) = network.ends(arc);
        ways[arc] += 1;
        there[from] += 1;
        back[to] += 1;
    }
    let mut entries = vec![Vec::new(); n];
    (0..network.arcs()).for_each(|arc| entries[network.to[arc] as usize].push(arc));
    let exits = |sheep: usize| network.exits(sheep).collect::<Vec<_>>();
    for (arc, sheep, nearer) in tree(n, exits, |arc| network.to[arc] as usize).into_iter().rev() {
        ways[arc] += there[sheep];
        there[nearer] += there[sheep];
    }
    for (arc, sheep, nearer) in
        tree(n, |sheep| entries[sheep].clone(), |arc| network.from[arc] as usize).into_iter().rev()
    {
        ways[arc] += back[sheep];
        back[nearer] += back[sheep];
    }
    ways
}

/// The shortest ways between the first sheep and all others: for each sheep the transition on its way, the sheep itself
/// and the next nearer one, the nearest first.
fn tree(n: usize, arcs: impl Fn(usize) -> Vec<usize>, other: impl Fn(usize) -> usize) -> Vec<(usize, usize, usize)> {
    let (mut met, mut tree, mut open) = (vec![false; n], Vec::with_capacity(n), vec![0]);
    met[0] = true;
    let mut next = 0;
    while next < open.len() {
        let nearer = open[next];
        next += 1;
        for arc in arcs(nearer) {
            let sheep = other(arc);
            if !std::mem::replace(&mut met[sheep], true) {
                tree.push((arc, sheep, nearer));
                open.push(sheep);
            }
        }
    }
    tree
}
