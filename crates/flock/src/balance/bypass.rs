//! A network in which visits may pass sheep by.
//!
//! Owns the ways past: for some sheep one from its row to its column, which carries what the sheep is not visited. So it
//! need not be visited as often as is said, only at most. How much may pass by is up to the caller.

use super::network::Network;

/// A network with bypasses.
pub(super) struct Bypassed {
    /// The network; sheep of which nothing is wanted are wanted as often as all others together.
    pub(super) network: Network,
    /// Its transitions by their numbers in the network before; behind those the bypasses by their numbers.
    order: Vec<usize>,
    /// How many transitions there were.
    arcs: usize,
    /// The sheep of each bypass.
    past: Vec<u32>,
}

impl Bypassed {
    /// `network` with bypasses for the sheep for which `has_one` is true.
    pub(super) fn of(network: &Network, has_one: impl Fn(usize) -> bool) -> Self {
        let past: Vec<u32> = (0..network.len() as u32).filter(|&sheep| has_one(sheep as usize)).collect();
        let mut arcs: Vec<(u32, u32, f64)> =
            (0..network.arcs()).map(|arc| (network.from[arc], network.to[arc], network.prior[arc])).collect();
        arcs.extend(past.iter().map(|&sheep| (sheep, sheep, 0.0)));
        let mut order: Vec<usize> = (0..arcs.len()).collect();
        order.sort_by_key(|&arc| arcs[arc].0);
        let mut wide = network.with_arcs(&order.iter().map(|&arc| arcs[arc]).collect::<Vec<_>>());
        for sheep in (0..network.len()).filter(|&sheep| network.is_free(sheep)) {
            wide.want[sheep] = 1.0;
        }
        Self { network: wide, order, arcs: network.arcs(), past }
    }

    /// `flow`, a circulation in `network` that was widened, in every transition of this one; past a sheep of which
    /// something is wanted goes the part `passes` of that.
    pub(super) fn widened(&self, network: &Network, flow: &[f64], passes: f64) -> Vec<f64> {
        let scale = network.scale_of(flow);
        let visits = |sheep: usize| scale * flow[network.exits(sheep)].iter().sum::<f64>();
        let past = |sheep: usize| {
            let most = self.network.want[sheep];
            if network.is_free(sheep) { (most - visits(sheep)).max(0.0) } else { passes * most }
        };
        self.each(|arc| scale * flow[arc], past)
    }

    /// A figure of every transition: `own` for those that were there, `bypass` for those past a sheep.
    pub(super) fn each<T>(&self, own: impl Fn(usize) -> T, bypass: impl Fn(usize) -> T) -> Vec<T> {
        let figure =
            |&arc: &usize| arc.checked_sub(self.arcs).map_or_else(|| own(arc), |at| bypass(self.past[at] as usize));
        self.order.iter().map(figure).collect()
    }

    /// Of figures of every transition those that were there.
    pub(super) fn own<T: Copy + Default>(&self, figures: &[T]) -> Vec<T> {
        let mut own = vec![T::default(); self.arcs];
        for (&arc, &figure) in self.order.iter().zip(figures).filter(|(arc, _)| **arc < self.arcs) {
            own[arc] = figure;
        }
        own
    }
}
