//! A place that several places can follow: the nearest example decides.

use std::collections::BTreeSet;

use serde::Serialize;

use crate::keyframe::classifier::scaled;
use crate::place::Place;
use crate::state::State;

/// A distance that is added on both sides of the probability, in scales of the schema, so that no example decides
/// alone.
const DOUBT: f64 = 1.0;

/// What followed a place, each time, and in which state. Distances are L1, with each feature in its scale of the
/// schema.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct Branch {
    examples: Vec<(Place, Vec<f64>)>,
}

impl Branch {
    /// Adds one example.
    pub(super) fn add(&mut self, next: Place, state: &State, scales: &[f64]) {
        self.examples.push((next, scaled(state, scales)));
    }

    /// The places that can follow, in order.
    pub(super) fn children(&self) -> BTreeSet<Place> {
        self.examples.iter().map(|(place, _)| *place).collect()
    }

    /// What follows in this state, and how probable that is. An only child is certain. Of several children, that of the
    /// nearest example is taken, the first of equals. Its probability is (1 + b) / (2 + a + b), from ½ to 1, where a is
    /// the distance of the nearest example and b that of the nearest example of another child. The original's
    /// classifier gives no probability.
    pub(super) fn next(&self, state: &State, scales: &[f64]) -> Option<(Place, f64)> {
        let state = scaled(state, scales);
        let distance = |example: &[f64]| example.iter().zip(&state).map(|(left, right)| (left - right).abs()).sum();
        let nearest = |among: &dyn Fn(Place) -> bool| {
            let examples = self.examples.iter().filter(|(place, _)| among(*place));
            let far: Vec<(Place, f64)> = examples.map(|(place, example)| (*place, distance(example))).collect();
            far.into_iter().reduce(|best, other| if other.1 < best.1 { other } else { best })
        };
        let (place, own) = nearest(&|_| true)?;
        let probability = match nearest(&|other| other != place) {
            None => 1.0,
            Some((_, other)) => (DOUBT + other) / (2.0 * DOUBT + own + other),
        };
        Some((place, probability))
    }
}
