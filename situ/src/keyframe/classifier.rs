//! The initiation classifier: a ridge logistic regression over the scaled state (decisions D2b, D2c, D10b, D16).

use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serialize};

use super::logistic::LogisticFit;
use super::parameters::Lift;
use crate::primitive::{Ball, Initiation};
use crate::state::State;

/// A fitted initiation classifier.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyframeClassifier {
    pub(super) lift: Lift,
    pub(super) fit: LogisticFit,
    /// The mean of the scaled positives, shape (d).
    pub(super) centre: Vec<f64>,
    /// The origin and the unit of each feature in the regression, both in scaled units (decision D16), shape (d).
    pub(super) units: Vec<(f64, f64)>,
    /// The greatest number of units that a feature counts (decision D16). Infinite without a bound.
    #[serde(deserialize_with = "bounded")]
    pub(super) most: f64,
    /// The classifier is activated only up to this root mean square scaled distance from the centre. Infinite without a
    /// bound.
    #[serde(deserialize_with = "bounded")]
    pub(super) radius: f64,
    #[serde(skip)]
    pub(super) scales: Arc<[f64]>,
}

/// A number, or nothing where it is infinite, as JSON writes it.
fn bounded<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
}

/// The state, each feature divided by its scale (decision D16).
pub(crate) fn scaled(state: &State, scales: &[f64]) -> Vec<f64> {
    state.values().iter().zip(scales).map(|(value, scale)| value / scale).collect()
}

/// The mean over the features of the squared difference.
pub(super) fn squared_distance(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(left, right)| (left - right) * (left - right)).sum::<f64>() / left.len() as f64
}

/// The row that the regression is linear in. All is divided by √dimension, so the ridge means the same for any schema.
pub(super) fn lifted(lift: Lift, scaled: &[f64], centre: &[f64]) -> Vec<f64> {
    let row = match lift {
        Lift::QuadraticDiagonal => scaled.iter().copied().chain(scaled.iter().map(|value| value * value)).collect(),
        Lift::Linear => scaled.to_vec(),
        Lift::Distance => vec![squared_distance(scaled, centre)],
    };
    let norm = libm::sqrt(row.len() as f64);
    row.into_iter().map(|value: f64| value / norm).collect()
}

/// Scaled values in the classifier's own units, at most so many of them.
pub(super) fn standardised(scaled: &[f64], units: &[(f64, f64)], most: f64) -> Vec<f64> {
    scaled.iter().zip(units).map(|(value, (origin, unit))| ((value - origin) / unit).clamp(-most, most)).collect()
}

impl KeyframeClassifier {
    fn confidence(&self, scaled: &[f64]) -> f64 {
        let centre = standardised(&self.centre, &self.units, self.most);
        self.fit.probability(&lifted(self.lift, &standardised(scaled, &self.units, self.most), &centre))
    }
}

impl Initiation for KeyframeClassifier {
    fn probability(&self, state: &State) -> f64 {
        self.confidence(&scaled(state, &self.scales))
    }

    fn is_applicable(&self, state: &State) -> bool {
        let scaled = scaled(state, &self.scales);
        squared_distance(&scaled, &self.centre) <= self.radius * self.radius && self.confidence(&scaled) >= 0.5
    }

    fn ball(&self) -> Option<Ball<'_>> {
        // This is slightly wider than what `is_applicable` accepts; that test has the last word.
        let greatest = self.radius * self.radius * self.centre.len() as f64 * (1.0 + 1e-9);
        self.radius.is_finite().then_some(Ball { scales: &self.scales, centre: &self.centre, greatest })
    }
}
