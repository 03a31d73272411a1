//! The sheep of the demo flock, their transitions, and the plans of their clips.
//!
//! Owns the table of the demo and its two [`Edition`]s. Never renders and never touches a disk.
//!
//! Start at [`SHEEP`], then [`Plan::new`]; `operations::render` makes files of its clips.

use std::error::Error;
use std::path::Path;

use ::species::RenderError;
use flame::Backend;
use flock::{ClipPath, SheepId};
use operations::render::plan::{CRF, ClipPlan, Look, PRESET, SEED, SheepMotion};
use operations::species;
use timing::{FrameCount, Rate};
use video::{Form, Quality, Tuning};

/// A sheep of the demo.
pub(crate) struct DemoSheep {
    /// Its id, and its genome's name.
    pub(crate) id: &'static str,
    /// The text of its genome.
    pub(crate) genome: &'static str,
    /// The ending of its file.
    pub(crate) ending: &'static str,
    /// Frames of one turn at pace 1: more for those that change a lot while they turn.
    turn: u32,
    /// The two sheep that it leads to.
    exits: [&'static str; 2],
}

macro_rules! sheep {
    ($id:literal . $ending:literal, $turn:literal -> $a:literal, $b:literal) => {
        DemoSheep {
            id: $id,
            genome: include_str!(concat!("../../../demo/genomes/", $id, ".", $ending)),
            ending: $ending,
            turn: $turn,
            exits: [$a, $b],
        }
    };
}

/// The flock: flames, expressions, agents' globes and a plant. Two transitions lead to each sheep and two away from it, chosen
/// so that the pictures half way are good; eight of them lead from flames to others or back.
pub(crate) const SHEEP: [DemoSheep; 16] = [
    sheep!("aurora"."expr", 132 -> "tigereye", "selene"),
    sheep!("bower"."flam3", 180 -> "kindle", "corona"),
    sheep!("clematis"."flam3", 192 -> "corona", "oracle"),
    sheep!("corona"."flam3", 160 -> "tempest", "snowglobe"),
    sheep!("dahlia"."expr", 132 -> "neon", "lagoon"),
    sheep!("kindle"."flam3", 160 -> "medusa", "dahlia"),
    sheep!("lagoon"."expr", 132 -> "vesper", "bower"),
    sheep!("linden"."plant", 132 -> "dahlia", "kindle"),
    sheep!("medusa"."flam3", 180 -> "tempest", "linden"),
    sheep!("neon"."agents", 132 -> "snowglobe", "vesper"),
    sheep!("oracle"."flam3", 160 -> "clematis", "bower"),
    sheep!("selene"."flam3", 160 -> "medusa", "neon"),
    sheep!("snowglobe"."agents", 132 -> "linden", "aurora"),
    sheep!("tempest"."flam3", 192 -> "selene", "clematis"),
    sheep!("tigereye"."expr", 132 -> "lagoon", "oracle"),
    sheep!("vesper"."expr", 132 -> "tigereye", "aurora"),
];

impl DemoSheep {
    /// The sheep `id` of the table.
    pub(crate) fn find(id: &str) -> &'static Self {
        SHEEP.iter().find(|sheep| sheep.id == id).expect("an exit leads to a sheep of the table")
    }

    /// The name of its genome's file.
    pub(crate) fn file(&self) -> String {
        format!("{}.{}", self.id, self.ending)
    }
}

/// The size, the quality and the pace of a copy of the demo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Edition {
    /// How its clips are made.
    pub(crate) look: Look,
    /// How many times slower than the table's frames, ≥ 1.
    pub(crate) pace: u32,
    /// Loops per visit.
    pub(crate) repeat: u32,
    /// The sheep whose loop is encoded as for a wall, if the others are coarser.
    pub(crate) finest: Option<&'static str>,
    /// The rate factor of clips without noise, which take few bits, if it is another.
    pub(crate) noiseless_crf: Option<f32>,
}

impl Edition {
    /// In high quality: a day or more on a strong machine.
    pub(crate) fn fine() -> Self {
        Self::new((400.0, 2), CRF, 4, 1)
    }

    /// The copy in the repository, under 48 MB with everything.
    pub(crate) fn small() -> Self {
        Self { finest: Some("selene"), noiseless_crf: Some(32.0), ..Self::new((60.0, 2), 35.0, 1, 2) }
    }

    fn new((spp, supersample): (f64, u32), crf: f32, pace: u32, repeat: u32) -> Self {
        let fps = Rate::new(30, 1).expect("whole numbers above 0 are rates");
        let look = Look {
            form: Form { size: (1280, 720), fps },
            spp: Some(spp),
            psnr: None,
            supersample: Some(supersample),
            temporal_samples: None,
            seed: SEED,
            gpu: None,
            quality: Quality { crf, preset: PRESET, tuning: Tuning::Gradients, max_bits_per_second: None },
        };
        Self { look, pace, repeat, finest: None, noiseless_crf: None }
    }

    /// How a clip of these sheep is made.
    fn look_of(&self, sheep: &[&SheepMotion]) -> Look {
        let mut look = self.look;
        if sheep.iter().all(|sheep| !sheep.is_noisy(&look)) {
            look.quality.crf = self.noiseless_crf.unwrap_or(look.quality.crf);
        }
        look
    }
}

/// The clips of the demo in an edition, loops first.
pub(crate) struct Plan {
    /// How it is made.
    pub(crate) edition: Edition,
    /// Its clips.
    pub(crate) clips: Vec<ClipPlan>,
}

impl Plan {
    /// The demo in `edition`.
    /// Errors: None for the genomes in the repository: a test parses them.
    pub(crate) fn new(edition: Edition) -> Result<Self, Box<dyn Error>> {
        let turn = |sheep: &DemoSheep| FrameCount(sheep.turn * edition.pace);
        let motion = |sheep: &DemoSheep| {
            let genome = species::parse(Path::new(&sheep.file()), sheep.genome, &Backend::default())
                .map_err(|why| why.source)?;
            Ok::<_, Box<dyn Error>>(SheepMotion::new(genome, turn(sheep)))
        };
        let motions = SHEEP.iter().map(motion).collect::<Result<Vec<_>, _>>()?;
        let find =
            |id: &str| SHEEP.iter().position(|sheep| sheep.id == id).expect("an exit leads to a sheep of the table");
        let mut clips = Vec::new();
        for (sheep, motion) in SHEEP.iter().zip(&motions) {
            let path = clip_path(&format!("loops/{}.mp4", sheep.id));
            let mut look = edition.look_of(&[motion]);
            if edition.finest == Some(sheep.id) {
                look.quality.crf = CRF;
            }
            clips.push(ClipPlan::of_loop(id(sheep), motion, path, turn(sheep), &look));
        }
        for (from, sheep) in SHEEP.iter().enumerate() {
            for to in sheep.exits.map(find) {
                // Half a turn at the speed of its ends.
                let frames = FrameCount((sheep.turn + SHEEP[to].turn) / 4 * edition.pace);
                let path = clip_path(&format!("transitions/{}={}.mp4", sheep.id, SHEEP[to].id));
                let (ids, ends) = ([id(sheep), id(&SHEEP[to])], [&motions[from], &motions[to]]);
                let look = edition.look_of(&ends);
                clips.push(ClipPlan::of_transition(ids, ends, path, frames, &look));
            }
        }
        Ok(Self { edition, clips })
    }

    /// Most memory that a frame takes, in bytes.
    /// Errors: [`RenderError`] if one cannot be rendered: the edition asks for something odd.
    pub(crate) fn bytes(&self) -> Result<u64, RenderError> {
        let look = &self.edition.look;
        self.clips.iter().try_fold(0, |most, clip| Ok(clip.demand(look)?.bytes.max(most)))
    }
}

fn id(sheep: &DemoSheep) -> SheepId {
    SheepId::new(sheep.id).expect("ids in the table are plain")
}

fn clip_path(path: &str) -> ClipPath {
    ClipPath::new(path).expect("ids of sheep make plain paths")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::manifest;
    use ::species::{Settings, Threads};
    use flock::Manifest;
    use operations::render::plan::ClipRole;

    fn flock(edition: Edition) -> Manifest {
        let plan = Plan::new(edition).unwrap();
        let hashes: Vec<_> = plan.clips.iter().map(|clip| clip.recipe).collect();
        Manifest::parse(&manifest::text(&plan, &hashes), Path::new("flock.toml")).unwrap()
    }

    #[test]
    fn everyone_has_two_ways_in_and_two_ways_out_and_can_be_reached() {
        let flock = flock(Edition::small());
        assert_eq!((flock.sheep.len(), flock.transitions.len()), (16, 32));
        for sheep in &flock.sheep {
            let out = flock.transitions.iter().filter(|transition| transition.from == sheep.id).count();
            let into = flock.transitions.iter().filter(|transition| transition.to == sheep.id).count();
            assert_eq!((into, out), (2, 2), "{}", sheep.id);
        }
        assert_eq!(flock::Flock::new(flock).faults(), []);
    }

    #[test]
    fn the_fine_flock_is_slower_and_otherwise_the_same() {
        let (fine, small) = (flock(Edition::fine()), flock(Edition::small()));
        for (fine, small) in fine.clips().zip(small.clips()) {
            assert_eq!((&fine.path, fine.frames.0), (&small.path, 4 * small.frames.0));
        }
    }

    #[test]
    fn another_encoding_keeps_the_pictures_and_another_size_does_not() {
        let plan = |change: fn(&mut Edition)| {
            let mut edition = Edition { finest: None, noiseless_crf: None, ..Edition::small() };
            change(&mut edition);
            Plan::new(edition).unwrap()
        };
        let was = plan(|_| {});
        let coarser = plan(|edition| edition.look.quality.crf = 40.0);
        let larger = plan(|edition| edition.look.form.size = (1920, 1080));
        for (was, (coarser, larger)) in was.clips.iter().zip(coarser.clips.iter().zip(&larger.clips)) {
            assert_eq!(was.picture_recipe, coarser.picture_recipe);
            assert_ne!(was.recipe, coarser.recipe);
            assert_ne!(was.picture_recipe, larger.picture_recipe);
        }
    }

    #[test]
    fn transitions_start_and_end_as_the_loops_do() {
        let plan = Plan::new(Edition::small()).unwrap();
        let threads = Threads::new(0).unwrap();
        let settings = Settings { size: [48, 27], spp: Some(4.0), ..plan.edition.look.settings() };
        let picture =
            |clip: &ClipPlan, frame: u32| clip.motion.frame(f64::from(frame), &settings, &threads).unwrap().image;
        let turns = |id: &SheepId| plan.clips.iter().find(|clip| clip.role == ClipRole::Loop(id.clone())).unwrap();
        for clip in &plan.clips {
            if let ClipRole::Transition(from, to) = &clip.role {
                for (frame, sheep) in [(0, from), (clip.frames.0, to)] {
                    let same = picture(clip, frame) == picture(turns(sheep), 0);
                    assert!(same, "{from} to {to}: frame {frame} is not that of `{sheep}`");
                }
            }
        }
    }
}
