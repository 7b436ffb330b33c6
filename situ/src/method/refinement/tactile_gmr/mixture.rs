//! Gaussian mixtures: a fit by expectation maximisation, and regression (Ghahramani and Jordan 1994).

use serde::{Serialize, Serializer};

use crate::error::SituError;
use crate::method::gaussian::{Square, backward, cholesky, forward, log_density, log_determinant};

/// The greatest number of re-estimations.
const MOST_ITERATIONS: usize = 50;
/// The fit ends when the relative change of the objective is below this.
const TOLERANCE: f64 = 1e-7;
/// A Gaussian with less weight than this, in points, keeps its mean.
const NEGLIGIBLE: f64 = 1e-9;

/// A Gaussian of a mixture.
#[derive(Clone, Debug, PartialEq)]
pub struct Component<const D: usize> {
    /// Its share of the mixture, 0 to 1.
    pub weight: f64,
    /// Mean, shape (D).
    pub mean: [f64; D],
    /// Covariance, shape (D, D).
    pub covariance: Square<D>,
}

/// A mixture of Gaussians over D numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mixture<const D: usize>(pub Vec<Component<D>>);

impl<const D: usize> Serialize for Mixture<D> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let written = |component: &Component<D>| {
            let covariance: Vec<f64> = component.covariance.iter().flatten().copied().collect();
            (component.weight, component.mean.to_vec(), covariance)
        };
        serializer.collect_seq(self.0.iter().map(written))
    }
}

/// The prior of each covariance: as if so many points had these standard deviations, independently.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CovariancePrior<const D: usize> {
    /// The standard deviations, one per dimension, above 0.
    pub deviations: [f64; D],
    /// The weight in points, above 0.
    pub weight: f64,
}

/// The result of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct MixtureFit<const D: usize> {
    /// The mixture.
    pub mixture: Mixture<D>,
    /// The objective `Σ w_n log p(x_n) − ½ ν Σ_k (log |Σ_k| + tr Σ_k⁻¹ S₀)`, before each re-estimation and after the
    /// last. It never falls.
    pub objective: Vec<f64>,
}

fn refused(problem: &str) -> SituError {
    SituError::Policy { reference: "a Gaussian mixture".to_owned(), problem: problem.to_owned() }
}

/// The maximum a posteriori of `components` Gaussians from weighted points. Each Gaussian starts from the points of its
/// label.
///
/// # Errors
/// If the slices differ in length, a label is out of range, no point has weight, a weight is negative, or a number is
/// not finite.
pub fn fit<const D: usize>(
    points: &[[f64; D]],
    weights: &[f64],
    labels: &[usize],
    components: usize,
    prior: &CovariancePrior<D>,
) -> Result<MixtureFit<D>, SituError> {
    let total: f64 = weights.iter().sum();
    let alike = points.len() == weights.len() && points.len() == labels.len();
    let finite = points.iter().flatten().chain([&total]).all(|value| value.is_finite());
    let possible = weights.iter().all(|weight| *weight >= 0.0);
    if !(alike && finite && possible && total > NEGLIGIBLE && labels.iter().all(|label| *label < components)) {
        return Err(refused("points, weights and labels that fit together are needed, and finite numbers"));
    }
    // `shares[k][n]`: the weight of point n, times the probability that it belongs to Gaussian k.
    let mut shares: Vec<Vec<f64>> = (0..components)
        .map(|k| weights.iter().zip(labels).map(|(weight, label)| if *label == k { *weight } else { 0.0 }).collect())
        .collect();
    let mut mixture = Mixture(Vec::new());
    let mut objective: Vec<f64> = Vec::new();
    loop {
        mixture = maximise(points, &shares, total, prior, &mixture);
        let value = expect(points, weights, &mixture, prior, &mut shares)?;
        let before = objective.last().copied();
        objective.push(value);
        let done = before.is_some_and(|before| value - before <= TOLERANCE * value.abs());
        if done || objective.len() > MOST_ITERATIONS {
            return Ok(MixtureFit { mixture, objective });
        }
    }
}

/// The M step.
fn maximise<const D: usize>(
    points: &[[f64; D]],
    shares: &[Vec<f64>],
    total: f64,
    prior: &CovariancePrior<D>,
    before: &Mixture<D>,
) -> Mixture<D> {
    let component = |(k, shares): (usize, &Vec<f64>)| {
        let count: f64 = shares.iter().sum();
        let mut mean = before.0.get(k).map_or([0.0; D], |component| component.mean);
        if count > NEGLIGIBLE {
            mean = [0.0; D];
            for (share, point) in shares.iter().zip(points) {
                for axis in 0..D {
                    mean[axis] += share / count * point[axis];
                }
            }
        }
        let mut covariance = [[0.0; D]; D];
        for (axis, deviation) in prior.deviations.iter().enumerate() {
            covariance[axis][axis] = prior.weight * deviation * deviation;
        }
        for (share, point) in shares.iter().zip(points) {
            for row in 0..D {
                for column in 0..D {
                    covariance[row][column] += share * (point[row] - mean[row]) * (point[column] - mean[column]);
                }
            }
        }
        let covariance = covariance.map(|row| row.map(|value| value / (count + prior.weight)));
        Component { weight: count / total, mean, covariance }
    };
    Mixture(shares.iter().enumerate().map(component).collect())
}

/// The E step. Fills `shares` and returns the objective.
fn expect<const D: usize>(
    points: &[[f64; D]],
    weights: &[f64],
    mixture: &Mixture<D>,
    prior: &CovariancePrior<D>,
    shares: &mut [Vec<f64>],
) -> Result<f64, SituError> {
    let factors = factors(mixture)?;
    let mut objective = 0.0;
    for (n, point) in points.iter().enumerate() {
        let logs: Vec<f64> = mixture
            .0
            .iter()
            .zip(&factors)
            .map(|(component, factor)| libm::log(component.weight) + log_density(&component.mean, factor, point))
            .collect();
        let (density, probabilities) = normalised(&logs);
        objective += weights[n] * density;
        for (shares, probability) in shares.iter_mut().zip(probabilities) {
            shares[n] = weights[n] * probability;
        }
    }
    for factor in &factors {
        let mut trace = 0.0;
        for (axis, deviation) in prior.deviations.iter().enumerate() {
            let mut unit = [0.0; D];
            unit[axis] = *deviation;
            trace += forward(factor, &unit).iter().map(|value| value * value).sum::<f64>();
        }
        objective -= 0.5 * prior.weight * (log_determinant(factor) + trace);
    }
    Ok(objective)
}

fn factors<const D: usize>(mixture: &Mixture<D>) -> Result<Vec<Square<D>>, SituError> {
    let factor = |component: &Component<D>| cholesky(&component.covariance);
    mixture.0.iter().map(factor).collect::<Option<_>>().ok_or_else(|| refused("a covariance is not positive definite"))
}

/// log Σ exp, and the exponentials over their sum. If all are −∞, each gets the same share.
fn normalised(logs: &[f64]) -> (f64, Vec<f64>) {
    let greatest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if greatest == f64::NEG_INFINITY {
        return (greatest, vec![1.0 / logs.len() as f64; logs.len()]);
    }
    let terms: Vec<f64> = logs.iter().map(|log| libm::exp(log - greatest)).collect();
    let sum: f64 = terms.iter().sum();
    (greatest + libm::log(sum), terms.into_iter().map(|term| term / sum).collect())
}

/// Regression: the mean, shape (O), and the covariance, shape (O, O), of the last O numbers given the first I. I + O =
/// D.
///
/// Each Gaussian predicts `μ_o + Σ_oi Σ_ii⁻¹ (x − μ_i)` with covariance `Σ_oo − Σ_oi Σ_ii⁻¹ Σ_io`. Its weight is its
/// probability given the input. The covariance is that of the whole conditional, so it includes the scatter of the
/// predictions. A Gaussian is left out if its covariance is not positive definite in the input, which no fit gives. If
/// no Gaussian is left, mean and covariance are 0.
pub fn regress<const I: usize, const O: usize, const D: usize>(
    mixture: &Mixture<D>,
    input: &[f64; I],
) -> ([f64; O], Square<O>) {
    const { assert!(I + O == D, "inputs and outputs are all the numbers there are") };
    let mut logs = Vec::new();
    let mut predictions: Vec<([f64; O], Square<O>)> = Vec::new();
    for component in &mixture.0 {
        let (mean, covariance) = (&component.mean, &component.covariance);
        let mut own = [[0.0; I]; I];
        let mut centre = [0.0; I];
        let mut error = [0.0; I];
        for row in 0..I {
            own[row].copy_from_slice(&covariance[row][..I]);
            centre[row] = mean[row];
            error[row] = input[row] - mean[row];
        }
        let Some(factor) = cholesky(&own) else { continue };
        logs.push(libm::log(component.weight) + log_density(&centre, &factor, input));
        let mut predicted = [0.0; O];
        let mut rest = [[0.0; O]; O];
        for row in 0..O {
            let mut cross = [0.0; I];
            cross.copy_from_slice(&covariance[I + row][..I]);
            let gain = backward(&factor, &forward(&factor, &cross));
            predicted[row] = mean[I + row] + (0..I).map(|k| gain[k] * error[k]).sum::<f64>();
            for column in 0..O {
                let explained: f64 = (0..I).map(|k| gain[k] * covariance[k][I + column]).sum();
                rest[row][column] = covariance[I + row][I + column] - explained;
            }
        }
        predictions.push((predicted, rest));
    }
    let mut mean = [0.0; O];
    let mut covariance = [[0.0; O]; O];
    if predictions.is_empty() {
        return (mean, covariance);
    }
    let (_, probabilities) = normalised(&logs);
    for (probability, (predicted, _)) in probabilities.iter().zip(&predictions) {
        for row in 0..O {
            mean[row] += probability * predicted[row];
        }
    }
    for (probability, (predicted, rest)) in probabilities.iter().zip(&predictions) {
        for row in 0..O {
            for column in 0..O {
                let apart = (predicted[row] - mean[row]) * (predicted[column] - mean[column]);
                covariance[row][column] += probability * (rest[row][column] + apart);
            }
        }
    }
    (mean, covariance)
}
