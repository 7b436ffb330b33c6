//! A scalar Gaussian emission. The published values are for this one, and the code under test is generic.

use std::f64::consts::PI;

use rand::Rng;
use situ::keyframe::hmm::{EmissionDensity, Hmm};
use situ::random::standard_normal;

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scalar {
    pub(crate) mean: f64,
    pub(crate) deviation: f64,
}

impl EmissionDensity for Scalar {
    type Frame = f64;

    fn log_density(&self, frame: &f64) -> f64 {
        let error = (frame - self.mean) / self.deviation;
        -0.5 * error * error - self.deviation.ln() - 0.5 * (2.0 * PI).ln()
    }

    fn kl(&self, other: &Self) -> f64 {
        let (ratio, error) = (self.deviation / other.deviation, (self.mean - other.mean) / other.deviation);
        0.5 * (ratio * ratio + error * error - 1.0) - ratio.ln()
    }

    fn sample(&self, rng: &mut impl Rng) -> f64 {
        self.mean + self.deviation * standard_normal(rng)
    }
}

/// A left-to-right model: each state stays or goes on, and only the last ends.
pub(crate) fn left_to_right(means: &[f64], deviation: f64, stay: f64) -> Hmm<Scalar> {
    let k = means.len();
    let mut hmm = Hmm {
        initial: vec![0.0; k],
        transition: vec![0.0; k * k],
        end: vec![0.0; k],
        emissions: means.iter().map(|mean| Scalar { mean: *mean, deviation }).collect(),
    };
    hmm.initial[0] = 1.0;
    for state in 0..k {
        hmm.transition[state * k + state] = stay;
        match hmm.transition.get_mut(state * k + state + 1).filter(|_| state + 1 < k) {
            Some(next) => *next = 1.0 - stay,
            None => hmm.end[state] = 1.0 - stay,
        }
    }
    hmm
}
