//! What is half way is judged before it is rendered.
//!
//! Owns claims about exposure and scores of motions that are made up for them; the demo's own are tested beside it.

use flame::{Exposed, Exposure, Genome, Loop, Motion, Renderer};
use species::{Drawn, Middle, MiddleFault, Threads};

const FRAMES: f64 = 100.0;

/// A still flame that is changed in the middle, by how far it has come from either end: 0 to 1.
struct Changed<F>(Genome, F);

impl<F: Fn(&mut Genome, f64, f64) + Sync> Motion for Changed<F> {
    fn at(&self, frame: f64) -> Genome {
        let mut genome = self.0.clone();
        let part = (frame / FRAMES).clamp(0.0, 1.0);
        (self.1)(&mut genome, 16.0 * (part * (1.0 - part)).powi(2), frame);
        genome
    }
}

fn sheep() -> Genome {
    let genome = Genome::parse(include_str!("../../../../flock-tools/demo/genomes/nautilus.flam3")).unwrap();
    Loop::new(&genome, FRAMES).at(0.0)
}

/// A motion with its exposure, as the contract of a species has it.
struct Drawable<'a, M>(Exposed<'a, M>);

impl<M: Motion + Send> species::Motion for Drawable<'_, M> {
    fn demand(&self, _: f64, _: &species::Settings) -> Result<species::Demand, species::RenderError> {
        Ok(species::Demand { samples: 0, bytes: 0, bytes_per_thread: 0 })
    }

    fn frame(&self, frame: f64, settings: &species::Settings, _: &Threads) -> Result<Drawn, species::RenderError> {
        let drawn = Renderer::new(0).unwrap().render_measured(&self.0, frame, &settings.into())?;
        Ok(Drawn { image: drawn.image, samples: drawn.samples, psnr: drawn.psnr })
    }
}

/// The middle of a changed flame, with the exposure that is measured for it.
fn middle(change: impl Fn(&mut Genome, f64, f64) + Send + Sync) -> (Middle, Exposure) {
    let (motion, threads) = (Changed(sheep(), change), Threads::new(0).unwrap());
    let exposure = Exposure::measure(&motion, FRAMES, &threads).unwrap();
    let exposed = Drawable(Exposed { motion: &motion, exposure: &exposure });
    (Middle::of(&exposed, FRAMES, [640, 360], &threads).unwrap(), exposure)
}

#[test]
fn what_is_wrong_half_way_is_named() {
    let (fine, exposure) = middle(|_, _, _| ());
    assert_eq!(fine.faults, []);
    assert!(fine.score > 0.9 && (0.8..1.25).contains(&exposure.gain(50.0)), "{fine:?}");
    let faults = |change: fn(&mut Genome, f64, f64)| middle(change).0.faults;
    assert_eq!(
        faults(|genome, part, _| genome.camera.center[0] += 500.0 * part),
        [MiddleFault::Dead, MiddleFault::Empty]
    );
    assert!(faults(|genome, part, _| genome.tone.background = [part; 3]).contains(&MiddleFault::BlownOut));
    // A point of light.
    let shrunk = faults(|genome, part, _| genome.camera.scale *= 1.0 - 0.95 * part);
    assert!(shrunk.contains(&MiddleFault::Empty), "{shrunk:?}");
    let shaken = faults(|genome, part, frame| genome.camera.center[0] += part * (frame.floor() % 2.0));
    assert_eq!(shaken, [MiddleFault::Flickering]);
}

#[test]
fn what_is_too_dark_or_too_bright_half_way_is_exposed_as_its_ends_are() {
    for gain in [0.05, 0.4, 3.0, 12.0] {
        let (found, exposure) = middle(|genome, part, _| genome.tone.brightness *= 1.0 + (gain - 1.0) * part);
        assert!(found.score > 0.75 && found.faults.is_empty(), "{gain}: {found:?}");
        assert!((exposure.gain(50.0) * gain).ln().abs() < 0.3, "{gain} is met by {}", exposure.gain(50.0));
    }
}

#[test]
fn where_light_makes_a_picture_darker_the_gain_does_not_run_away() {
    let xforms = [(0.0, 0.0), (0.5, 0.0), (0.25, 0.5)]
        .map(|(x, y)| format!("<xform weight=\"1\" coefs=\"0.5 0 0 0.5 {x} {y}\" spherical=\"0.1\" linear=\"1\"/>"));
    let text = format!(
        "<flame size=\"640 360\" center=\"0.5 0.4\" scale=\"450\" background=\"1 1 1\" brightness=\"0.2\">{}<color index=\"0\" rgb=\"10 0 25\"/></flame>",
        xforms.concat()
    );
    let dark = Genome::parse(&text).unwrap();
    for change in [0.3, 3.0] {
        let motion = Changed(dark.clone(), |genome: &mut Genome, part, _| {
            genome.tone.brightness *= 1.0 + (change - 1.0) * part;
        });
        let exposure = Exposure::measure(&motion, FRAMES, &Threads::new(0).unwrap()).unwrap();
        assert!((0.1..10.0).contains(&exposure.gain(50.0)), "{change} is met by {}", exposure.gain(50.0));
    }
}

#[test]
fn an_exposure_is_the_same_on_any_number_of_threads() {
    let motion = Changed(sheep(), |genome: &mut Genome, part, _| genome.camera.scale *= 1.0 + part);
    let measured =
        [1, 2, 7].map(|threads| Exposure::measure(&motion, FRAMES, &Threads::new(threads).unwrap()).unwrap());
    assert!(measured[0] == measured[1] && measured[1] == measured[2]);
    let exposed = Exposed { motion: &motion, exposure: &measured[0] };
    for end in [-1.0, 0.0, FRAMES, FRAMES + 1.0] {
        assert_eq!(exposed.at(end), motion.at(end));
    }
    assert_ne!(exposed.at(50.0), motion.at(50.0));
}
