//! What the dissolve between pictures is, on every processor.

use species::{Demand, Dissolve, Drawn, Image, Motion, RenderError, Settings, Threads};

const SETTINGS: Settings = Settings {
    size: [131, 70],
    spp: None,
    psnr: None,
    supersample: None,
    temporal_samples: None,
    smooths: false,
    seed: 0,
};

/// A bright disc on a dark slope, which moves: of sums and products alone, which are the same everywhere.
struct Disc {
    middle: [f32; 2],
    light: [f32; 3],
}

impl Motion for Disc {
    fn demand(&self, _frame: f64, settings: &Settings) -> Result<Demand, RenderError> {
        let pixels: u64 = settings.size.map(u64::from).iter().product();
        Ok(Demand { samples: pixels, bytes: 12 * pixels, bytes_per_thread: 0 })
    }

    fn frame(&self, frame: f64, settings: &Settings, _threads: &Threads) -> Result<Drawn, RenderError> {
        let [width, height] = settings.size.map(|side| side as usize);
        let pixel = |at: usize| {
            let place = [(at % width) as f32 / height as f32, (at / width) as f32 / height as f32];
            let off = [place[0] - self.middle[0] - frame as f32 / 64.0, place[1] - self.middle[1]];
            let near = (1.0 - 9.0 * (off[0] * off[0] + off[1] * off[1])).clamp(0.0, 1.0);
            self.light.map(|light| light * near + 0.1 * place[0] * (1.0 - near))
        };
        let image = Image { width, height, pixels: (0..width * height).map(pixel).collect() };
        Ok(Drawn { samples: (width * height) as u64, image, psnr: None })
    }
}

/// FNV-1a over the bits of all channels.
fn checksum(image: &Image) -> u64 {
    let bytes = image.pixels.as_flattened().iter().flat_map(|light| light.to_bits().to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |sum, byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Checksums of pictures early, half way and late.
const ON_THE_WAY: [u64; 3] = [6_993_906_580_854_949_512, 7_128_880_041_194_156_207, 373_338_719_853_608_608];

#[test]
fn pictures_between_two_others_are_those_that_were_there_for_any_number_of_threads() {
    let disc = |middle, light| -> Box<dyn Motion> { Box::new(Disc { middle, light }) };
    let dissolve = Dissolve::new([disc([0.4, 0.4], [0.9, 0.6, 0.2]), disc([1.2, 0.6], [0.2, 0.5, 0.95])], 32.0);
    for count in [1, 2, 7] {
        let threads = Threads::new(count).unwrap();
        let sum = |frame| checksum(&dissolve.frame(frame, &SETTINGS, &threads).unwrap().image);
        assert_eq!([5.0, 16.0, 26.5].map(sum), ON_THE_WAY, "{count} threads");
    }
}
