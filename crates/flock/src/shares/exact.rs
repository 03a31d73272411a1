//! Shares against arithmetic that never rounds.
//!
//! Owns the flocks that are hard for numbers of 53 bits: with a beat, nearly fallen apart, with weights over nine orders
//! of magnitude. Their shares are solved for in fractions of whole numbers of any length.

use num_rational::BigRational;
use proptest::prelude::*;

use super::Shares;
use crate::graph::Graph;
use crate::graph::tests::manifest;

/// How near shares have to be, as a part of themselves.
const NEAR: f64 = 1e-9;

fn graph(n: usize, arcs: &[(usize, usize, f64)]) -> Graph {
    Graph::new(&manifest(n, arcs))
}

/// The shares of `graph` in fractions, by elimination of its balance equations.
fn exact(graph: &Graph) -> Vec<BigRational> {
    let n = graph.len();
    let zero = || BigRational::from_integer(0.into());
    let mut flow = vec![vec![zero(); n]; n];
    for from in graph.sheep() {
        for exit in graph.exits(from) {
            // From the weights as written: the chances that the graph holds are rounded already.
            let weight = BigRational::from_float(graph.weight(exit)).unwrap();
            flow[from.index()][graph.target(exit).index()] = weight;
        }
        let total: BigRational = flow[from.index()].iter().sum();
        flow[from.index()].iter_mut().for_each(|weight| *weight /= &total);
    }
    // pi (I - P) = 0 with the sum of pi in place of the last column.
    let mut rows: Vec<Vec<BigRational>> = (0..n)
        .map(|to| {
            (0..n).map(|from| &flow[from][to] - BigRational::from_integer(i32::from(from == to).into())).collect()
        })
        .collect();
    rows[n - 1] = vec![BigRational::from_integer(1.into()); n];
    let mut right = vec![zero(); n];
    right[n - 1] = BigRational::from_integer(1.into());
    for column in 0..n {
        let pivot = (column..n).find(|&row| rows[row][column] != zero()).expect("one class has one solution");
        rows.swap(column, pivot);
        right.swap(column, pivot);
        let (pivot, of_pivot) = (rows[column].clone(), right[column].clone());
        for row in (0..n).filter(|&row| row != column) {
            let factor = &rows[row][column] / &pivot[column];
            for (entry, of_pivot) in rows[row].iter_mut().zip(&pivot) {
                *entry -= &factor * of_pivot;
            }
            right[row] -= &factor * &of_pivot;
        }
    }
    (0..n).map(|at| &right[at] / &rows[at][at]).collect()
}

/// By what part of itself a share of `graph` is off, at most.
fn off(graph: &Graph) -> f64 {
    let shares = Shares::of(graph).unwrap();
    let told = graph.sheep().map(|sheep| BigRational::from_float(shares.visits(sheep)).unwrap());
    let part = |(told, exact): (BigRational, BigRational)| {
        let off = (told - &exact) / exact;
        // Beyond its first digits the difference does not matter, but a fraction may be longer than a number.
        let scale = BigRational::from_integer(10i64.pow(18).into());
        (off * &scale).to_integer().to_string().parse::<f64>().unwrap().abs() / 1e18
    };
    let worst = told.zip(exact(graph)).map(part).fold(0.0, f64::max);
    assert!(worst <= shares.off_by(), "off by {worst}, proved to within {}", shares.off_by());
    worst
}

#[test]
fn shares_of_nearly_split_flocks_are_exact() {
    for bridge in [1e-3, 1e-6, 1e-9, 1e-12, 1e-15] {
        // Three rings of 4 with a chord each; one bridge on, a second one back on the way.
        let mut arcs = Vec::new();
        for part in 0..3 {
            let at = |sheep: usize| 4 * part + sheep % 4;
            arcs.extend((0..4).map(|sheep| (at(sheep), at(sheep + 1), 1.0 + sheep as f64)));
            arcs.push((at(0), at(2), 0.7));
            arcs.push((at(3), (4 * part + 5) % 12, bridge * (1.0 + part as f64)));
        }
        arcs.push((6, 1, bridge / 3.0));
        let off = off(&graph(12, &arcs));
        assert!(off < 1e-14, "bridges of {bridge}: off by {off}");
    }
}

#[test]
fn shares_over_many_orders_of_magnitude_are_exact() {
    // A row of sheep, each left a thousand times as readly one way as the other: the last has 1e-27 of the first.
    let arcs = (1..10).flat_map(|at| [(at - 1, at, 1e-3), (at, at - 1, 1.0)]).chain([(0, 0, 1.0)]);
    let off = off(&graph(10, &arcs.collect::<Vec<_>>()));
    assert!(off < 1e-14, "off by {off}");
}

proptest! {
    #[test]
    fn shares_of_random_flocks_are_exact(
        n in 1usize..9,
        more in prop::collection::vec((0usize..9, 0usize..9, 0u32..10, 1.0f64..10.0), 0..24),
    ) {
        // A ring holds each together; the weights reach over nine orders of magnitude and more.
        let ring = (0..n).map(|at| (at, (at + 1) % n, 1.0));
        let weighted = more.into_iter().map(|(a, b, order, weight)| (a % n, b % n, weight / 10f64.powi(order as i32)));
        let arcs: Vec<_> = weighted.chain(ring).collect();
        let off = off(&graph(n, &arcs));
        prop_assert!(off < NEAR, "off by {}", off);
    }

    #[test]
    fn shares_of_random_flocks_with_a_beat_are_exact(
        beat in 2usize..4,
        groups in 1usize..4,
        more in prop::collection::vec((0usize..12, 0usize..12, 1.0f64..1e9), 0..16),
    ) {
        let n = beat * groups;
        // Every transition leads from one group of the beat to the next.
        let ring = (0..n).map(|at| (at, (at + 1) % n, 1.0));
        let on = |(a, b, weight): (usize, usize, f64)| {
            let from = a % n;
            (from, (b % groups) * beat + (from + 1) % beat, weight)
        };
        let arcs: Vec<_> = more.into_iter().map(on).chain(ring).collect();
        let off = off(&graph(n, &arcs));
        prop_assert!(off < NEAR, "off by {}", off);
    }
}
