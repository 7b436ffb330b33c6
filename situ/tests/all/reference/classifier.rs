//! An initiation classifier: a ridge logistic regression over the scaled features and their squares (decisions D2b,
//! D2c, D10b, D16).

use nalgebra::{DMatrix, DVector};
use situ::keyframe::parameters::{Activation, KeyframeParameters, Standardisation};
use situ::primitive::Initiation;
use situ::state::State;

use crate::reference::learner::percentile;

/// The regression ends when no component of the gradient is above this.
const REST: f64 = 1e-11;

/// A fitted classifier.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Classifier {
    scales: Vec<f64>,
    centre: Vec<f64>,
    units: Vec<f64>,
    /// How many units a feature counts at the most.
    most: f64,
    radius: f64,
    /// The intercept is last.
    weights: DVector<f64>,
}

impl Classifier {
    pub(crate) fn fit(positives: &[&State], negatives: &[&State], scales: &[f64], rule: &KeyframeParameters) -> Self {
        let (Standardisation::Within { prior, most }, Activation::Bounded { factor, least }) =
            (rule.standardisation, rule.activation)
        else {
            panic!("the reference knows the defaults alone")
        };
        let scaled = |states: &[&State]| states.iter().map(|state| scaled(state, scales)).collect::<Vec<_>>();
        let (own, others) = (scaled(positives), scaled(negatives));
        let centre = mean(&own, scales.len());
        let (points, about, count) = match own.len() {
            1 => (&others, mean(&others, scales.len()), 1 + others.len()),
            count => (&own, centre.clone(), count),
        };
        let unit = |f: usize| {
            let squares: f64 = points.iter().map(|point| (point[f] - about[f]).powi(2)).sum();
            ((prior + squares) / (prior + count as f64)).sqrt().min(1.0)
        };
        let units = (0..scales.len()).map(unit).collect();
        let radius = (factor * percentile(own.iter().map(|point| apart(point, &centre)).collect())).max(least);
        let mut classifier = Self { scales: scales.to_vec(), centre, units, most, radius, weights: DVector::zeros(0) };
        let classes = if others.is_empty() { 1.0 } else { 2.0 };
        let sample = |target: f64, count: usize| move |row: DVector<f64>| (row, target, 1.0 / classes / count as f64);
        let row = |point: &Vec<f64>| classifier.row(point);
        let own = own.iter().map(row).map(sample(rule.logistic.positive, own.len()));
        let others = others.iter().map(row).map(sample(rule.logistic.negative, others.len()));
        classifier.weights = regression(&own.chain(others).collect::<Vec<_>>(), rule.logistic.ridge);
        classifier
    }

    /// z and z² of each feature in its unit, divided by the root of their number; then 1 for the intercept.
    fn row(&self, scaled: &[f64]) -> DVector<f64> {
        let features = scaled.len();
        let z = |f: usize| ((scaled[f] - self.centre[f]) / self.units[f]).max(-self.most).min(self.most);
        let lifted = (0..features).map(z).chain((0..features).map(|f| z(f) * z(f)));
        let norm = ((2 * features) as f64).sqrt();
        DVector::from_iterator(2 * features + 1, lifted.map(|value| value / norm).chain([1.0]))
    }
}

impl Initiation for Classifier {
    fn probability(&self, state: &State) -> f64 {
        sigmoid(self.weights.dot(&self.row(&scaled(state, &self.scales))))
    }

    fn is_applicable(&self, state: &State) -> bool {
        self.probability(state) >= 0.5 && apart(&scaled(state, &self.scales), &self.centre) <= self.radius
    }
}

/// The minimum of Σ s ℓ(t, w·x) + ½ λ |w|² over samples (x, t, s), by Newton's method. The intercept is not penalised.
fn regression(samples: &[(DVector<f64>, f64, f64)], ridge: f64) -> DVector<f64> {
    let size = samples[0].0.len();
    let mut penalty = DMatrix::identity(size, size) * ridge;
    penalty[(size - 1, size - 1)] = 0.0;
    let gradient = |weights: &DVector<f64>| {
        let slope = |(x, target, share): &(DVector<f64>, f64, f64)| x * (share * (sigmoid(x.dot(weights)) - target));
        samples.iter().map(slope).fold(&penalty * weights, |sum, slope| sum + slope)
    };
    let mut weights = DVector::zeros(size);
    while gradient(&weights).amax() > REST {
        let mut curvature = penalty.clone();
        for (x, _, share) in samples {
            let p = sigmoid(x.dot(&weights));
            curvature.ger(share * p * (1.0 - p), x, x, 1.0);
        }
        let mut step = curvature.cholesky().expect("the ridge keeps it definite").solve(&gradient(&weights));
        // Far from the minimum a whole step can be too long.
        while gradient(&(&weights - &step)).norm() >= gradient(&weights).norm() {
            step *= 0.5;
        }
        weights -= step;
    }
    weights
}

fn sigmoid(z: f64) -> f64 {
    1.0 / (1.0 + (-z).exp())
}

fn scaled(state: &State, scales: &[f64]) -> Vec<f64> {
    state.values().iter().zip(scales).map(|(value, scale)| value / scale).collect()
}

fn mean(points: &[Vec<f64>], features: usize) -> Vec<f64> {
    (0..features).map(|f| points.iter().map(|point| point[f]).sum::<f64>() / points.len().max(1) as f64).collect()
}

/// The root mean square difference over the features.
fn apart(left: &[f64], right: &[f64]) -> f64 {
    (left.iter().zip(right).map(|(left, right)| (left - right).powi(2)).sum::<f64>() / left.len() as f64).sqrt()
}
