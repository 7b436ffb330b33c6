//! Dynamic movement primitives (Ijspeert et al. 2013, in the form of Pastor et al. 2009 that the original uses).
//!
//! ```text
//! s = exp(−(a/τ) t),  a = −ln 0.01
//! v̇ = (K (g − x) − K (g − x₀) s + K f(s) − D v) / τ,   ẋ = v / τ,   D = 2 √K
//! f(s) = s Σ w_i ψ_i(s) / Σ ψ_i(s)
//! ```

use nalgebra::SVector;
use serde::Serialize;

/// The number of kernels ψ, which are evenly spaced in time.
const KERNELS: usize = 60;
/// K. With τ = 1 the system responds within a tenth of the movement.
const STIFFNESS: f64 = 100.0;
/// s at the end of the movement.
const LAST_PHASE: f64 = 0.01;
/// The steps of a movement of length τ, in learning and in execution.
pub(super) const STEPS: usize = 200;
/// The steps after that, in which the system settles at its goal: s falls to 0.001.
const SETTLING: usize = STEPS / 2;
/// The width of a kernel, in distances between kernels: at the next kernel's centre ψ = exp(−½).
const WIDTH: f64 = 1.0;

/// A primitive over trajectories of N numbers: metres or radians, relative to a frame that the caller chooses.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dmp<const N: usize> {
    /// w, one per kernel.
    weights: Vec<SVector<f64, N>>,
}

/// s at a share of τ.
fn phase(share: f64) -> f64 {
    libm::exp(libm::log(LAST_PHASE) * share)
}

/// ψ at a share of τ: Gaussian in time, which is log s. The centres of the kernels are at even shares.
fn kernels(share: f64) -> [f64; KERNELS] {
    core::array::from_fn(|index| {
        let apart = (share * (KERNELS - 1) as f64 - index as f64) / WIDTH;
        libm::exp(-0.5 * apart * apart)
    })
}

/// A trajectory at `count` + 1 even times, straight between its points. Without a point, all are zero.
pub(super) fn at_even_times<const N: usize>(points: &[SVector<f64, N>], count: usize) -> Vec<SVector<f64, N>> {
    let last = points.len().saturating_sub(1);
    let at = |step: usize| {
        let place = step as f64 * last as f64 / count as f64;
        let before = (place as usize).min(last);
        let share = place - before as f64;
        match (points.get(before), points.get(before + 1)) {
            (Some(left), Some(right)) => left + (right - left) * share,
            (Some(only), None) => *only,
            _ => SVector::zeros(),
        }
    };
    (0..=count).map(at).collect()
}

impl<const N: usize> Dmp<N> {
    /// Fits the primitive to these trajectories. The points of each are at even times, and each is stretched to the
    /// same τ. f is what the equation lacks, and w is its weighted least squares, kernel by kernel.
    pub fn fit(trajectories: &[Vec<SVector<f64, N>>]) -> Self {
        let mut tops = vec![SVector::<f64, N>::zeros(); KERNELS];
        let mut bottoms = [0.0; KERNELS];
        let pace = STEPS as f64;
        for points in trajectories {
            let x = at_even_times(points, STEPS);
            let (start, goal) = (x[0], x[STEPS]);
            // The integration below turns these differences back into the same points. The movement rests before and
            // after.
            for step in 0..STEPS {
                let velocity = if step == 0 { SVector::zeros() } else { (x[step] - x[step - 1]) * pace };
                let next = (x[step + 1] - x[step]) * pace;
                let s = phase(step as f64 / pace);
                let damping = 2.0 * libm::sqrt(STIFFNESS);
                let force =
                    ((next - velocity) * pace + velocity * damping) / STIFFNESS - (goal - x[step]) + (goal - start) * s;
                for (index, weight) in kernels(step as f64 / pace).into_iter().enumerate() {
                    tops[index] += force * (weight * s);
                    bottoms[index] += weight * s * s;
                }
            }
        }
        let weights = tops.into_iter().zip(bottoms).map(|(top, bottom)| if bottom > 0.0 { top / bottom } else { top });
        Self { weights: weights.collect() }
    }

    /// The trajectory from `start` to `goal`, from rest: the points at 201 even times of τ, from the start on, and then
    /// the point where the movement settles.
    pub fn rollout(&self, start: &SVector<f64, N>, goal: &SVector<f64, N>) -> Vec<SVector<f64, N>> {
        let pace = STEPS as f64;
        let damping = 2.0 * libm::sqrt(STIFFNESS);
        let (mut x, mut v) = (*start, SVector::<f64, N>::zeros());
        let mut points = vec![x];
        for step in 0..STEPS + SETTLING {
            let share = step as f64 / pace;
            let s = phase(share);
            let mut force = SVector::<f64, N>::zeros();
            if step < STEPS {
                let mut sum = 0.0;
                for (weight, psi) in self.weights.iter().zip(kernels(share)) {
                    force += weight * psi;
                    sum += psi;
                }
                force *= s / sum;
            } else if let Some(last) = self.weights.last() {
                force = last * s;
            }
            v += ((goal - x) * STIFFNESS - (goal - start) * (STIFFNESS * s) + force * STIFFNESS - v * damping) / pace;
            x += v / pace;
            if step < STEPS {
                points.push(x);
            }
        }
        points.push(x);
        points
    }
}
