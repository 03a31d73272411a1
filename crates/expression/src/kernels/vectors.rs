//! Which vector instructions are used.
//!
//! Owns the choice, at run time: AVX-512, AVX2, or those that every processor of the architecture has. Results are the same
//! bits with all of them, since the compiler may neither fuse nor reorder what is calculated.

#[cfg(target_arch = "x86_64")]
use fearless_simd::{Level, Simd};

/// Does `work`, and whatever is inlined there, with the widest vectors of this processor.
#[cfg(target_arch = "x86_64")]
pub(crate) fn vectorized<T>(work: impl FnOnce() -> T) -> T {
    let level = Level::new();
    match (level.as_avx512(), level.as_avx2()) {
        (Some(avx512), _) => avx512.vectorize(work),
        (_, Some(avx2)) => avx2.vectorize(work),
        _ => work(),
    }
}

/// Does `work`: elsewhere, all processors have the vectors that are used.
#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn vectorized<T>(work: impl FnOnce() -> T) -> T {
    work()
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;
    use crate::kernels::{Kernel, MOST_ARGUMENTS, Slice};
    use crate::math::settled;
    use species::Rng;

    /// Each kernel, and how many arguments it takes.
    fn kernels() -> Vec<(Kernel, usize)> {
        let of_one = [Kernel::Abs, Kernel::Cos, Kernel::Invert, Kernel::Sin, Kernel::Sqrt, Kernel::Chance(3)];
        let of_two = [
            [Kernel::Add, Kernel::And, Kernel::Atan, Kernel::Divide, Kernel::Log, Kernel::Max, Kernel::Min],
            [Kernel::Modulo, Kernel::Multiply, Kernel::Or, Kernel::Power, Kernel::Round, Kernel::Subtract, Kernel::Xor],
        ];
        let of_three = [Kernel::Dissolve, Kernel::If, Kernel::Hue(0), Kernel::Hue(2)];
        let slice = Slice::at(0.37);
        let of_four = [Kernel::Cell(slice), Kernel::Escape, Kernel::Noise(0, slice), Kernel::Noise(2, slice)];
        let counted =
            |kernels: &[Kernel], count: usize| kernels.iter().map(|kernel| (*kernel, count)).collect::<Vec<_>>();
        let many = [(Kernel::Ifs, MOST_ARGUMENTS)];
        [&of_one[..], of_two.as_flattened(), &of_three, &of_four]
            .into_iter()
            .zip(1..)
            .flat_map(|(kernels, count)| counted(kernels, count))
            .chain(many)
            .collect()
    }

    #[inline(always)]
    fn bits(kernel: Kernel, arguments: &[&[f32]]) -> Vec<u32> {
        let mut out = vec![0.0; arguments[0].len()];
        kernel.run(arguments, &mut out);
        out.into_iter().map(f32::to_bits).collect()
    }

    #[test]
    fn every_kernel_gives_the_same_bits_by_every_vector() {
        // No multiple of a vector's length.
        const SAMPLES: usize = 1003;
        let mut random = Rng::stream(42, 1);
        let mut tried = 0;
        for (kernel, count) in kernels() {
            let mut number = || {
                let size = [1e-3, 1.0, 30.0, 1e5, 1e9][(random.unit() * 5.0) as usize];
                if random.unit() < 0.05 { 0.0 } else { settled(((random.unit() - 0.5) * size) as f32) }
            };
            let arguments: Vec<Vec<f32>> = (0..count).map(|_| (0..SAMPLES).map(|_| number()).collect()).collect();
            let arguments: Vec<&[f32]> = arguments.iter().map(Vec::as_slice).collect();
            let run = || bits(kernel, &arguments);
            let (plain, level) = (run(), Level::new());
            let wide = [level.as_avx2().map(|it| it.vectorize(run)), level.as_avx512().map(|it| it.vectorize(run))];
            for found in wide.into_iter().flatten().chain([vectorized(run)]) {
                assert_eq!(found, plain, "{kernel:?}");
                tried += 1;
            }
        }
        assert!(tried >= kernels().len());
    }
}
