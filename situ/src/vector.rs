//! Kernels on the widest vectors of the processor, with the same bits on any.
//!
//! A processor's vectors are known at run time alone. `widest` runs a `Kernel` that was compiled for each kind, and
//! what it computes is the same on all: nothing here fuses a product with a sum, and a sum has a fixed number of
//! running sums, joined in a fixed order. A kernel has its numbers in fours (`Four`); or it is of plain loops over
//! eights, which the compiler turns into vector instructions (`loops!`).

mod exponential;
mod four;
mod logarithm;

pub(crate) use exponential::exp;
pub(crate) use four::{Four, Wide, polynomial};
pub(crate) use logarithm::log_1p;

#[cfg(target_arch = "x86_64")]
use std::sync::LazyLock;

use pulp::Scalar256b;
#[cfg(target_arch = "x86_64")]
use pulp::{NullaryFnOnce, x86::V3};

/// Numbers of a [`Four`].
pub(crate) const LANES: usize = 4;
/// Numbers that plain loops go through at once.
pub(crate) const EIGHT: usize = 8;

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

#[cfg(target_arch = "x86_64")]
static AVX2: LazyLock<Option<V3>> = LazyLock::new(V3::try_new);

/// What the kernels run on here: `avx2`, or `baseline` for what every processor of the target has. No result depends on
/// it, but the number of instructions does.
pub fn kind() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    if AVX2.is_some() {
        return "avx2";
    }
    "baseline"
}

/// Runs a kernel on the widest vectors of the processor.
#[inline]
pub(crate) fn widest<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(test)]
    if tests::PLAINLY.get() {
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

/// [`widest`] of a function of plain loops, marked `#[inline(always)]`. A function handed over as a value would be
/// called through a shim that was compiled for any processor: hence a macro.
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

/// The fours of a column that is filled up to them.
#[inline(always)]
pub(crate) fn fours(column: &[f64]) -> &[[f64; LANES]] {
    column.as_chunks().0
}

/// [`fours`], to be written.
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

/// The sum of a column in fours.
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

#[cfg(test)]
mod tests {
    use core::cell::Cell;
    use core::fmt::Debug;

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use crate::demonstration::{Gripper, Pose, State};
    use crate::keyframe::hmm::{Hmm, HmmParameters, Observation};
    use crate::keyframe::logistic::{self, LogisticParameters, Path};
    use crate::keyframe::pose::{Tangent, exp};
    use crate::place::NodeId;
    use crate::primitive::Ball;
    use crate::task_model::screen::Screen;

    thread_local! {
        /// Whether kernels do without the processor's vectors.
        pub(super) static PLAINLY: Cell<bool> = const { Cell::new(false) };
    }

    /// What something computes with the processor's vectors, and that it computes the same bits without.
    fn either_way<T: Debug + PartialEq>(compute: impl Fn() -> T) -> T {
        let found = compute();
        PLAINLY.set(true);
        let plain = compute();
        PLAINLY.set(false);
        assert_eq!(found, plain, "not the same bits without the processor's vectors");
        found
    }

    #[test]
    fn no_result_depends_on_the_vectors() {
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let mut draw = move |spread: f64| spread * (rng.random::<f64>() - 0.5);
        for case in 0..40 {
            // Rotations near one another, and as far as they can be.
            let spread = [0.2, 1.0, 3.0, 6.0][case % 4];
            let sequences: Vec<Vec<Observation>> = (0..1 + case % 6)
                .map(|sequence| {
                    let observe = |frame| {
                        let pose = exp(&Pose::identity(), &Tangent::from_fn(|_, _| draw(spread)));
                        let gripper = (case % 2 == 0).then(|| Gripper::Open(0.01 * f64::from(frame)));
                        Observation { pose, gripper }
                    };
                    (0..5 + 3 * sequence as u32).map(observe).collect()
                })
                .collect();
            let slices: Vec<&[Observation]> = sequences.iter().map(Vec::as_slice).collect();
            let parameters = HmmParameters::default();
            let fit = either_way(|| Hmm::fit(&slices, 1 + case % 7, &parameters).unwrap());
            assert!(fit.log_likelihood().is_finite());
            either_way(|| fit.hmm.total_log_likelihood(&sequences).to_bits());
            let rows: Vec<Vec<f64>> = (0..12 + 5 * case).map(|_| (0..1 + case).map(|_| draw(4.0)).collect()).collect();
            let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
            let labels: Vec<bool> = rows.iter().map(|row| row[0] + draw(1.0) > 0.5).collect();
            for path in [Path::Primal, Path::Dual] {
                let parameters = LogisticParameters { path, ..LogisticParameters::default() };
                assert!(either_way(|| logistic::fit(&rows, &labels, &parameters, None).unwrap()).converged);
            }
            let mut screen = Screen::default();
            let scales = vec![0.3; 1 + case];
            for (node, centre) in rows.iter().enumerate() {
                screen.set(NodeId(node as u32), Some(Ball { scales: &scales, centre, greatest: 20.0 * case as f64 }));
            }
            either_way(|| screen.passing(&State::new(rows[0].iter().map(|value| 0.2 * value).collect::<Vec<f64>>())));
        }
    }
}
