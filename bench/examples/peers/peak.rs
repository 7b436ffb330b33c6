//! How many additions and multiplications of doubles this core does in a second at most.
//!
//! A run consists of chains that do not wait for one another, in the widest vectors that the processor has and all in
//! registers. The kernels of situ never fuse a multiplication with an addition, because their bits would then depend on
//! the processor. So the peak that they could reach is that of as many multiplications as additions, each by itself.
//! The fused peak stands beside it.

use std::hint::black_box;

use pulp::{Arch, Simd, WithSimd};

/// Vector instructions of a run. It takes some milliseconds, as a fit does, so that both meet the same disturbances.
const INSTRUCTIONS: usize = 48 << 20;

/// A run of nothing but additions and multiplications.
#[derive(Clone, Copy)]
pub(crate) struct Peak {
    /// Whether a multiplication and the addition to its product are one instruction, where the processor has it.
    pub(crate) fused: bool,
}

impl Peak {
    /// Makes a run; returns its additions and multiplications.
    pub(crate) fn run(self) -> f64 {
        Arch::new().dispatch(self)
    }
}

impl WithSimd for Peak {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        // As many chains as the registers hold beside the two constants. With fewer, a chain would wait for its own
        // last result.
        match (self.fused, S::REGISTER_COUNT >= 32) {
            (false, false) => separate::<S, 6>(simd),
            (false, true) => separate::<S, 12>(simd),
            (true, false) => fused::<S, 12>(simd),
            (true, true) => fused::<S, 24>(simd),
        }
    }
}

/// Makes the steps of N products and N sums; each step of a product is a factor, and each step of a sum is a term.
#[inline(always)]
fn separate<S: Simd, const N: usize>(simd: S) -> f64 {
    let (factor, term) = constants(simd);
    let (mut products, mut sums) = black_box(([factor; N], [factor; N]));
    for _ in 0..INSTRUCTIONS / (2 * N) {
        for (product, sum) in products.iter_mut().zip(&mut sums) {
            *product = simd.mul_f64s(*product, factor);
            *sum = simd.add_f64s(*sum, term);
        }
    }
    black_box((products, sums));
    (INSTRUCTIONS * S::F64_LANES) as f64
}

/// Makes the steps of N chains; each step is a factor and a term together.
#[inline(always)]
fn fused<S: Simd, const N: usize>(simd: S) -> f64 {
    let (factor, term) = constants(simd);
    let mut chains = black_box([factor; N]);
    for _ in 0..INSTRUCTIONS / N {
        for chain in &mut chains {
            *chain = simd.mul_add_e_f64s(*chain, factor, term);
        }
    }
    black_box(chains);
    (2 * INSTRUCTIONS * S::F64_LANES) as f64
}

/// 1 and 0, so that no chain overflows or becomes a denormal number. The compiler must not know them.
#[inline(always)]
fn constants<S: Simd>(simd: S) -> (S::f64s, S::f64s) {
    (simd.splat_f64s(black_box(1.0)), simd.splat_f64s(black_box(0.0)))
}
