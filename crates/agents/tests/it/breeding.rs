//! What is bred may be shown.

use crate::bred::{self, SMALL, globe, luma, many, picture, read};
use agents::{Agents, Globe};
use species::{Breed, Genome, Rng, Threads};

/// Mean, contrast, mean change from frame to frame, and mean change of that change in parts of it.
fn figures(globe: &dyn Genome, frames: f64, threads: &Threads) -> [f64; 4] {
    let settings = bred::settings([160, 90]);
    let turning = globe.turning(settings.size, frames);
    let [mut first, mut second] = [0.0, 0.0];
    let (mut mean, mut contrast) = (0.0, f64::MAX);
    let moments = 4;
    for moment in 0..moments {
        let at = f64::from(moment) * frames / f64::from(moments);
        let lumas = [-1.0, 0.0, 1.0].map(|step| luma(&picture(turning.as_ref(), at + step, &settings, threads)));
        let many = lumas[0].len() as f64;
        let average = lumas[1].iter().sum::<f64>() / many;
        let square = lumas[1].iter().map(|luma| (luma - average) * (luma - average)).sum::<f64>() / many;
        mean += average / f64::from(moments);
        contrast = contrast.min(square.sqrt());
        for ((before, at), after) in lumas[0].iter().zip(&lumas[1]).zip(&lumas[2]) {
            first += (after - at).abs() / many / f64::from(moments);
            second += (after - 2.0 * at + before).abs() / many / f64::from(moments);
        }
    }
    [mean, contrast, first, second / first]
}

#[test]
fn what_is_bred_is_neither_black_nor_flat_nor_still_nor_strobing() {
    let threads = Threads::new(2).unwrap();
    let mut worst = [f64::MAX, f64::MAX, f64::MAX, 0.0];
    for seed in 0..many("GENOMES", 30) {
        let frames = [180.0, 360.0, 768.0][seed as usize % 3];
        let globe = globe(seed);
        let [mean, contrast, activity, flicker] = figures(globe.as_ref(), frames, &threads);
        worst = [worst[0].min(mean), worst[1].min(contrast), worst[2].min(activity), worst[3].max(flicker)];
        let is_good = (0.08..0.75).contains(&mean) && contrast >= 0.05 && activity >= 0.0005 && flicker <= 0.6;
        assert!(is_good, "globe {seed}: {mean:.3} {contrast:.3} {activity:.5} {flicker:.3}: {}", globe.text());
    }
    println!("worst: {worst:.5?}");
}

#[test]
fn no_agent_is_invisible_or_a_twin() {
    for seed in 0..many("GENOMES", 60) {
        let globe = globe(seed);
        // Reading refuses the invisible and twins.
        let again = Globe::parse(&globe.text()).unwrap();
        assert!((8..=20).contains(&again.flock().len()), "globe {seed} has {} agents", again.flock().len());
    }
}

#[test]
fn the_same_random_numbers_breed_the_same_globe() {
    let breed = |stream: u64| {
        let mut rng = Rng::stream(3, stream);
        let parents = [(); 2].map(|()| Agents.random(&mut rng));
        let child = Agents.cross([parents[0].as_ref(), parents[1].as_ref()], &mut rng).unwrap().0;
        let mutant = Agents.mutate(child.as_ref(), 1.0, &mut rng).unwrap().0;
        [parents[0].text(), child.text(), mutant.text()]
    };
    assert_eq!(breed(1), breed(1));
    let [parent, child, mutant] = breed(1);
    assert!(parent != child && child != mutant && breed(2)[0] != parent);
}

#[test]
fn a_mutation_of_no_strength_changes_nothing_and_a_strong_one_much() {
    let mut rng = Rng::stream(9, 0);
    let parent = Agents.random(&mut rng);
    assert_eq!(Agents.mutate(parent.as_ref(), 0.0, &mut rng).unwrap().0.text(), parent.text());
    let flock = |globe: &dyn Genome| Globe::parse(&globe.text()).unwrap().flock().to_vec();
    let parents = flock(parent.as_ref());
    let mut kept = |strength: f64| {
        let children = (0..20).map(|_| Agents.mutate(parent.as_ref(), strength, &mut rng).unwrap().0);
        children
            .map(|child| flock(child.as_ref()).iter().filter(|agent| parents.contains(agent)).count())
            .sum::<usize>()
    };
    let [weak, usual, strong] = [0.2, 1.0, 4.0].map(&mut kept);
    assert!(weak > usual && usual > strong, "{weak} {usual} {strong}");
}

#[test]
fn a_child_has_strings_of_both_parents_or_between_them() {
    let mut rng = Rng::stream(4, 0);
    let parents = [read(SMALL), Agents.random(&mut rng)];
    let flocks = [0, 1].map(|side| Globe::parse(&parents[side].text()).unwrap().flock().to_vec());
    let mut seen = [0; 3];
    for _ in 0..20 {
        let (child, _) = Agents.cross([parents[0].as_ref(), parents[1].as_ref()], &mut rng).unwrap();
        for agent in Globe::parse(&child.text()).unwrap().flock() {
            seen[flocks.iter().position(|flock| flock.contains(agent)).unwrap_or(2)] += 1;
        }
    }
    assert!(seen.iter().all(|count| *count >= 10), "{seen:?}");
}
