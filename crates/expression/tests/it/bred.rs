//! Genomes by chance and by breeding.

use expression::Genome;
use species::Rng;

/// The genome numbered `seed`: random, then mutated and crossed up to six times.
pub(crate) fn genome(seed: u64) -> Genome {
    let mut rng = Rng::stream(seed, 0);
    let mut genome = Genome::random(&mut rng);
    for _ in 0..seed % 7 {
        let other = Genome::random(&mut rng);
        genome = genome.crossed(&other, &mut rng).map_or(other, |(child, _)| child);
        genome = genome.mutated(1.0, &mut rng).0;
    }
    genome
}
