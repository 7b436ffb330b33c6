//! Kernels on the widest vectors of the processor, with the same bits on any.
//!
//! A processor's vectors are known at run time alone. [`widest`] runs a [`Kernel`] that was compiled for each kind, and what it computes is
//! the same on all: numbers come in fours ([`Four`]), nothing here fuses a product with a sum, and a sum is of four running sums, joined in a
//! fixed order.

mod exponential;
mod four;

pub(crate) use exponential::exp;
pub(crate) use four::{Four, Wide, polynomial};

#[cfg(target_arch = "x86_64")]
use std::sync::LazyLock;

use pulp::Scalar256b;
#[cfg(target_arch = "x86_64")]
use pulp::{NullaryFnOnce, x86::V3};

/// Numbers that are gone through at once, and what columns are padded to.
pub(crate) const LANES: usize = 4;

/// Loops to be run, with what they run over.
pub(crate) trait Kernel {
    type Output;

    /// To be marked `#[inline(always)]`, as everything that it calls: what is a function of its own has narrow vectors.
    fn run<S: Wide>(self, simd: S) -> Self::Output;
}

#[cfg(target_arch = "x86_64")]
struct Call<K>(K, V3);

#[cfg(target_arch = "x86_64")]
impl<K: Kernel> NullaryFnOnce for Call<K> {
    type Output = K::Output;

    #[inline(always)]
    fn call(self) -> K::Output {
        self.0.run(self.1)
    }
}

/// Runs a kernel on the widest vectors of the processor.
#[inline]
pub(crate) fn widest<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        static AVX2: LazyLock<Option<V3>> = LazyLock::new(V3::try_new);
        if let Some(simd) = *AVX2 {
            return simd.vectorize(Call(kernel, simd));
        }
    }
    kernel.run(Scalar256b)
}

/// Numbers in fours: those of a padded column.
#[inline(always)]
pub(crate) fn fours(column: &[f64]) -> &[[f64; LANES]] {
    column.as_chunks().0
}

/// [`fours`], to be written.
#[inline(always)]
pub(crate) fn fours_mut(column: &mut [f64]) -> &mut [[f64; LANES]] {
    column.as_chunks_mut().0
}

/// The length of a column of so many numbers, padded.
pub(crate) const fn padded(length: usize) -> usize {
    length.next_multiple_of(LANES)
}

/// The sum of a padded column.
pub(crate) fn sum(column: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    for four in fours(column) {
        for lane in 0..LANES {
            sums[lane] += four[lane];
        }
    }
    let [a, b, c, d] = sums;
    (a + c) + (b + d)
}
