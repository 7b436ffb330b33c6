//! How many additions and multiplications of doubles this core does in a second at most.
//!
//! Chains that do not wait for one another, in the widest vectors that the processor has and all in registers. The
//! kernels of situ never fuse a multiplication with an addition, for then their bits would be the processor's. So the
//! peak that they could reach is that of as many multiplications as additions, each by itself; the fused one stands
//! beside it.

use std::hint::black_box;

use pulp::{Arch, Simd, WithSimd};

/// Vector instructions of a run: some milliseconds, as a fit takes, so that what disturbs the one disturbs the other.
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
        // As many chains as the registers hold beside the two constants: fewer would wait for themselves.
        match (self.fused, S::REGISTER_COUNT >= 32) {
            (false, false) => separate::<S, 6>(simd),
            (false, true) => separate::<S, 12>(simd),
            (true, false) => fused::<S, 12>(simd),
            (true, true) => fused::<S, 24>(simd),
        }
    }
}

/// Steps that N products and N sums go on by one factor and one term.
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

/// Steps that N chains go on by one factor and one term together.
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

/// 1 and 0, which the compiler must not know: no chain overflows, and none becomes a denormal number.
#[inline(always)]
fn constants<S: Simd>(simd: S) -> (S::f64s, S::f64s) {
    (simd.splat_f64s(black_box(1.0)), simd.splat_f64s(black_box(0.0)))
}
