//! Kernels on the widest vectors of the processor, with the same bits on any processor.
//!
//! The vectors of a processor are only known at run time. `widest` runs a `Kernel` that was compiled for each kind of
//! vectors. The result is the same on all: no product is fused with a sum, and a sum has a fixed number of running
//! sums, which are joined in a fixed order. There are two ways to write a kernel: with its numbers in fours (`Four`),
//! or as plain loops over eights, which the compiler turns into vector instructions (`loops!`).

mod exponential;
mod four;
mod logarithm;

pub(crate) use exponential::exp;
pub(crate) use four::{Four, LANES, Wide, polynomial};
pub(crate) use logarithm::log_1p;

#[cfg(target_arch = "x86_64")]
use std::sync::LazyLock;

use pulp::Scalar256b;
#[cfg(target_arch = "x86_64")]
use pulp::{NullaryFnOnce, x86::V3};

/// The numbers that plain loops process at once.
pub(crate) const EIGHT: usize = 8;

/// Loops to be run, and their data.
pub(crate) trait Kernel {
    type Output;

    /// Runs the loops. Mark it `#[inline(always)]`, and everything that it calls: a function that is not inlined has
    /// narrow vectors.
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

#[cfg(target_arch = "x86_64")]
static AVX2: LazyLock<Option<V3>> = LazyLock::new(V3::try_new);

/// The vectors that the kernels run on here: `avx2`, or `baseline` for what every processor of the target has. No
/// result depends on it, only the number of instructions.
pub fn kind() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    if AVX2.is_some() {
        return "avx2";
    }
    "baseline"
}

#[cfg(test)]
thread_local! {
    /// Whether kernels do without the processor's vectors.
    pub(crate) static PLAINLY: core::cell::Cell<bool> = const { core::cell::Cell::new(false) };
}

/// Runs a kernel on the widest vectors of the processor.
#[inline]
pub(crate) fn widest<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(test)]
    if PLAINLY.get() {
        return kernel.run(Scalar256b);
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = *AVX2 {
        return simd.vectorize(Call(kernel, simd));
    }
    kernel.run(Scalar256b)
}

/// A kernel of plain loops, and its arguments.
pub(crate) struct Plain<K, A>(pub(crate) K, pub(crate) A);

impl<A, R, K: Fn(A) -> R> Kernel for Plain<K, A> {
    type Output = R;

    #[inline(always)]
    fn run<S: Wide>(self, _: S) -> R {
        (self.0)(self.1)
    }
}

/// [`widest`] of a function of plain loops, which is marked `#[inline(always)]`. It is a macro, because a function that
/// is passed as a value would be called through a shim that is compiled for any processor.
macro_rules! loops {
    ($kernel:path, $arguments:expr) => {
        $crate::vector::widest($crate::vector::Plain(
            #[inline(always)]
            |arguments| $kernel(arguments),
            $arguments,
        ))
    };
}
pub(crate) use loops;

/// The fours of a column that is padded to whole fours.
#[inline(always)]
pub(crate) fn fours(column: &[f64]) -> &[[f64; LANES]] {
    column.as_chunks().0
}

/// The same fours, to be written.
#[inline(always)]
pub(crate) fn fours_mut(column: &mut [f64]) -> &mut [[f64; LANES]] {
    column.as_chunks_mut().0
}

/// The sum of eight running sums.
#[inline(always)]
pub(crate) fn joined(sums: [f64; EIGHT]) -> f64 {
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// The sum of a column that is padded to whole fours.
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

/// Σ l_i r_i in four running sums, which are joined in a fixed order. So it has the same bits on every machine, and the
/// compiler can use vectors.
pub(crate) fn dot(left: &[f64], right: &[f64]) -> f64 {
    let mut lanes = [0.0; 4];
    let (left_lanes, right_lanes) = (left.chunks_exact(4), right.chunks_exact(4));
    let rest: f64 = left_lanes.remainder().iter().zip(right_lanes.remainder()).map(|(l, r)| l * r).sum();
    for (left, right) in left_lanes.zip(right_lanes) {
        for lane in 0..4 {
            lanes[lane] += left[lane] * right[lane];
        }
    }
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]) + rest
}
