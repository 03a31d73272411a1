//! Who the demo flock's sheep are, where they lead, and the clips that make them visible.
//!
//! Owns the one table of the demo and the two ready-made [`Look`]s. Never renders and never touches a disk.
//!
//! Start at [`SHEEP`], then [`Plan::new`]; `make.rs` turns a plan into files.

use flame::{Genome, GenomeError, Loop, Motion, Transition};
use flock::{ClipHash, ClipPath, SheepId};
use timing::{FrameCount, Rate};

/// A sheep of the demo.
pub(crate) struct Seed {
    /// Its id, and its genome's name.
    pub(crate) id: &'static str,
    /// Its genome, flam3 XML.
    pub(crate) genome: &'static str,
    /// Frames of one turn at pace 1: more for those that change a lot while they turn.
    turn: u32,
    /// The two sheep that it leads to.
    exits: [&'static str; 2],
}

macro_rules! seed {
    ($id:literal, $turn:literal -> $a:literal, $b:literal) => {
        Seed {
            id: $id,
            genome: include_str!(concat!("../../demo/genomes/", $id, ".flam3")),
            turn: $turn,
            exits: [$a, $b],
        }
    };
}

/// The flock. Everyone has two ways in and two ways out, chosen so that the pictures half way are good ones.
pub(crate) const SHEEP: [Seed; 7] = [
    seed!("blossom", 107 -> "orchid", "nautilus"),
    seed!("caldera", 100 -> "nocturne", "orchid"),
    seed!("nautilus", 113 -> "blossom", "caldera"),
    seed!("nocturne", 113 -> "undertow", "blossom"),
    seed!("orchid", 127 -> "rosette", "undertow"),
    seed!("rosette", 100 -> "nautilus", "nocturne"),
    seed!("undertow", 127 -> "caldera", "rosette"),
];

/// How a flock is made from the table: how large, how fine, how slow.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Look {
    /// Width and height in pixels.
    pub(crate) size: (u32, u32),
    /// Frames per second.
    pub(crate) fps: Rate,
    /// Samples per pixel.
    pub(crate) spp: f64,
    /// Histogram cells per pixel in each direction.
    pub(crate) supersample: u32,
    /// How many times slower than the table's frames, ≥ 1.
    pub(crate) pace: u32,
    /// Loops per visit.
    pub(crate) repeat: u32,
    /// x264's constant rate factor.
    pub(crate) crf: f32,
    /// x264's preset.
    pub(crate) preset: &'static str,
}

impl Look {
    /// As good pictures are made: a day or more on a strong machine.
    pub(crate) fn fine() -> Self {
        let fps = Rate::new(30, 1).expect("30/1 is a rate");
        Self { fps, spp: 400.0, supersample: 2, pace: 6, repeat: 1, crf: 17.0, ..Self::small() }
    }

    /// The copy in the repository, under 16 MB with everything.
    pub(crate) fn small() -> Self {
        let fps = Rate::new(20, 1).expect("20/1 is a rate");
        Self { size: (1280, 720), fps, spp: 12.0, supersample: 1, pace: 1, repeat: 2, crf: 34.0, preset: "slower" }
    }

    /// What the pictures depend on, besides genomes and motion.
    fn of_pictures(&self) -> String {
        let Self { size: (width, height), spp, supersample, .. } = self;
        format!("{width}x{height} {spp} samples per pixel, {supersample}x{supersample} cells")
    }

    /// What the clips depend on, besides the pictures.
    fn of_encoding(&self) -> String {
        format!("{} fps, crf {}, {}", self.fps, self.crf, self.preset)
    }
}

/// Which part of the graph a clip shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Shows {
    /// A sheep's loop.
    Loop(SheepId),
    /// The way from the first sheep to the second.
    Transition(SheepId, SheepId),
}

/// A clip to be made.
pub(crate) struct ClipPlan {
    /// What it shows.
    pub(crate) shows: Shows,
    /// Where it goes, in the flock's folder.
    pub(crate) path: ClipPath,
    /// How long it is.
    pub(crate) frames: FrameCount,
    /// How its pictures change over its frames.
    pub(crate) motion: Box<dyn Motion + Send>,
    /// Equal for equal pictures.
    pub(crate) pictures: ClipHash,
    /// Equal for equal pictures and encoding.
    pub(crate) made_as: ClipHash,
}

/// The clips of the demo in a given look, loops first.
pub(crate) struct Plan {
    /// How it is made.
    pub(crate) look: Look,
    /// What is made.
    pub(crate) clips: Vec<ClipPlan>,
}

impl Plan {
    /// The demo in `look`.
    ///
    /// # Errors
    /// None for the genomes in the repository: a test parses them.
    pub(crate) fn new(look: Look) -> Result<Self, GenomeError> {
        let turning = |seed: &Seed| Ok(Loop::new(&Genome::parse(seed.genome)?, f64::from(seed.turn * look.pace)));
        let loops = SHEEP.iter().map(turning).collect::<Result<Vec<_>, _>>()?;
        let find =
            |id: &str| SHEEP.iter().position(|seed| seed.id == id).expect("an exit leads to a sheep of the table");
        let mut clips = Vec::new();
        for (seed, motion) in SHEEP.iter().zip(&loops) {
            let motion = Box::new(motion.clone());
            clips.push(ClipPlan::new(&look, Shows::Loop(id(seed)), seed.turn * look.pace, motion, &[seed]));
        }
        for (from, seed) in SHEEP.iter().enumerate() {
            for to in seed.exits.map(find) {
                // Half a turn at the speed of its ends.
                let frames = (seed.turn + SHEEP[to].turn) / 4 * look.pace;
                let motion = Transition::new(&loops[from], &loops[to], f64::from(frames));
                let shows = Shows::Transition(id(seed), id(&SHEEP[to]));
                clips.push(ClipPlan::new(&look, shows, frames, Box::new(motion), &[seed, &SHEEP[to]]));
            }
        }
        Ok(Self { look, clips })
    }
}

impl ClipPlan {
    fn new(look: &Look, shows: Shows, frames: u32, motion: Box<dyn Motion + Send>, seeds: &[&Seed]) -> Self {
        let path = match &shows {
            Shows::Loop(id) => format!("loops/{id}.mp4"),
            Shows::Transition(from, to) => format!("transitions/{from}={to}.mp4"),
        };
        let turns: Vec<_> = seeds.iter().map(|seed| (seed.turn * look.pace, seed.genome)).collect();
        let pictures = format!("{RENDERING}\n{path}\n{frames}\n{}\n{turns:?}", look.of_pictures());
        let made_as = format!("{pictures}\n{}", look.of_encoding());
        let hash = |text: &str| ClipHash::of(text.as_bytes()).expect("reading memory does not fail");
        Self {
            path: ClipPath::new(&path).expect("ids of sheep make plain paths"),
            frames: FrameCount(frames),
            motion,
            pictures: hash(&pictures),
            made_as: hash(&made_as),
            shows,
        }
    }
}

/// The version of everything that turns a genome into pixels: another one means other pictures.
const RENDERING: &str = concat!("dreams demo ", env!("CARGO_PKG_VERSION"));

fn id(seed: &Seed) -> SheepId {
    SheepId::new(seed.id).expect("ids in the table are plain")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::manifest;
    use flock::Manifest;
    use std::path::Path;

    fn flock(look: Look) -> Manifest {
        let plan = Plan::new(look).unwrap();
        let hashes: Vec<_> = plan.clips.iter().map(|clip| clip.made_as).collect();
        Manifest::parse(&manifest::text(&plan, &hashes), Path::new("flock.toml")).unwrap()
    }

    #[test]
    fn everyone_has_two_ways_in_and_two_ways_out_and_can_be_reached() {
        let flock = flock(Look::small());
        assert_eq!((flock.sheep.len(), flock.transitions.len()), (7, 14));
        for sheep in &flock.sheep {
            let out = flock.transitions.iter().filter(|transition| transition.from == sheep.id).count();
            let into = flock.transitions.iter().filter(|transition| transition.to == sheep.id).count();
            assert_eq!((into, out), (2, 2), "{}", sheep.id);
        }
        assert_eq!(flock::faults(&flock), []);
    }

    #[test]
    fn the_fine_flock_is_slower_and_otherwise_the_same() {
        let (fine, small) = (flock(Look::fine()), flock(Look::small()));
        for (fine, small) in fine.clips().zip(small.clips()) {
            assert_eq!((&fine.path, fine.frames.0), (&small.path, 6 * small.frames.0));
        }
    }

    #[test]
    fn another_encoding_keeps_the_pictures_and_another_size_does_not() {
        let plan = |look| Plan::new(look).unwrap();
        let was = plan(Look::small());
        let coarser = plan(Look { crf: 40.0, ..Look::small() });
        let larger = plan(Look { size: (1920, 1080), ..Look::small() });
        for (was, (coarser, larger)) in was.clips.iter().zip(coarser.clips.iter().zip(&larger.clips)) {
            assert_eq!(was.pictures, coarser.pictures);
            assert_ne!(was.made_as, coarser.made_as);
            assert_ne!(was.pictures, larger.pictures);
        }
    }

    #[test]
    fn transitions_start_and_end_as_the_loops_do() {
        let plan = Plan::new(Look::small()).unwrap();
        let turns = |id: &SheepId| plan.clips.iter().find(|clip| clip.shows == Shows::Loop(id.clone())).unwrap();
        for clip in &plan.clips {
            if let Shows::Transition(from, to) = &clip.shows {
                let end = f64::from(clip.frames.0);
                for (frame, sheep) in [(0.0, from), (end, to)] {
                    let (ours, theirs) = (clip.motion.at(frame), turns(sheep).motion.at(0.0));
                    assert!((ours.camera.scale - theirs.camera.scale).abs() < 1e-9, "{from} to {to} at {frame}");
                    assert!((ours.tone.brightness - theirs.tone.brightness).abs() < 1e-9, "{from} to {to} at {frame}");
                }
            }
        }
    }
}
