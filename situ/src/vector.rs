//! Loops on the widest vectors of the processor, with the same bits on any.
//!
//! A processor's widest vectors are known at run time alone. [`widest`] runs a kernel that was compiled for each kind. What it computes is
//! the same on all: nothing here fuses a product with a sum, and sums have a fixed number of running sums, [`LANES`], joined in a fixed
//! order. A kernel is a plain function over slices, marked `#[inline(always)]`, whose loops the compiler turns into vector instructions.

mod exponential;

pub(crate) use exponential::exp;

use pulp::{Arch, Simd, WithSimd};

/// Running sums, and what columns are padded to: the widest vectors hold as many numbers, or a part of them.
pub(crate) const LANES: usize = 8;

/// A call that is not made yet.
struct Call<K, A>(K, A);

impl<A, R, K: FnOnce(A) -> R> WithSimd for Call<K, A> {
    type Output = R;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> R {
        (self.0)(self.1)
    }
}

/// Calls a kernel with its arguments, on the widest vectors of the processor.
#[inline]
pub(crate) fn widest<A, R>(kernel: impl FnOnce(A) -> R, arguments: A) -> R {
    Arch::new().dispatch(Call(kernel, arguments))
}

/// The length of a column of so many numbers, padded.
pub(crate) const fn padded(length: usize) -> usize {
    length.next_multiple_of(LANES)
}

/// The sum of running sums.
#[inline(always)]
pub(crate) fn joined(sums: [f64; LANES]) -> f64 {
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}
