//! What follows a place that more than one thing can follow: the nearest example decides.

use std::collections::BTreeSet;

use serde::Serialize;

use crate::demonstration::State;
use crate::keyframe::classifier::scaled;
use crate::place::Place;

/// A distance that counts for both sides of the probability, in scales of the schema, so that no example decides alone.
const DOUBT: f64 = 1.0;

/// What followed a place: each time, and in which state. Distances are L1, each feature in its scale of the schema.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct Branch {
    examples: Vec<(Place, Vec<f64>)>,
}

impl Branch {
    /// One example.
    pub(super) fn add(&mut self, next: Place, state: &State, scales: &[f64]) {
        self.examples.push((next, scaled(state, scales)));
    }

    /// What can follow, in order.
    pub(super) fn children(&self) -> BTreeSet<Place> {
        self.examples.iter().map(|(place, _)| *place).collect()
    }

    /// What follows in this state. The only child is certain; of several, the nearest example's, the first of equals,
    /// is as probable as the nearest of another is far: (1 + b) / (2 + a + b) at distances a and b, from ½ to 1. The
    /// original's classifier says no probability.
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
