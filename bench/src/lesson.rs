//! The demonstrations of a robot in order, and where it had stopped before each: to score its model, and to teach
//! another the same.

use std::collections::BTreeMap;
use std::sync::Arc;

use situ::demonstration::Demonstration;
use situ::graph::Graph;
use situ::method::Learned;
use situ::place::NodeId;
use situ::structure::{Structure, Truth};

use crate::demonstration_file::Before;
use crate::error::BenchError;
use crate::stop::{Nameless, StopPoint, Stopped};

/// A correction that was given.
struct Given {
    demonstration: Demonstration,
    stop: Result<StopPoint, Nameless>,
}

/// All that a robot was shown.
pub struct Lesson {
    originals: Vec<Demonstration>,
    corrections: Vec<Given>,
    truth: Truth,
}

impl Lesson {
    /// The demonstrations of the original task.
    pub fn new(originals: &[Demonstration]) -> Self {
        let mut truth = Truth::default();
        originals.iter().for_each(|shown| truth.original(shown));
        Self { originals: originals.to_vec(), corrections: Vec::new(), truth }
    }

    /// One more correction. `model` is the robot's model before it.
    pub fn corrected(&mut self, model: &Graph, stop: &Stopped, demonstration: Demonstration) {
        self.truth.correction(&demonstration, stop.last, model);
        self.corrections.push(Given { demonstration, stop: StopPoint::of(model, stop) });
    }

    /// A stop in the words of the demonstration file of the next correction, `name`.
    ///
    /// # Errors
    /// [`BenchError::Nameless`].
    pub fn before(&self, name: &str, stop: Result<StopPoint, Nameless>) -> Result<Before, BenchError> {
        let corrections = self.corrections.iter().map(|given| &given.demonstration);
        let shown: Vec<&str> = self.originals.iter().chain(corrections).map(|shown| &**shown.name()).collect();
        stop.map(|stop| Before::of(&stop, &shown)).map_err(|nameless| BenchError::nameless(name, nameless))
    }

    /// The score of the structure that the lesson led to; `None` where a keyframe has no narration.
    pub fn score(&self, model: &Graph) -> Option<Structure> {
        self.truth.score(model)
    }

    /// The skill that each node of a model of the lesson holds in the main.
    pub fn skills(&self, model: &Graph) -> BTreeMap<NodeId, Arc<str>> {
        self.truth.skills(model)
    }

    /// What another method makes of the corrections. `learned` is its model of the originals, and its graphs must name
    /// the same segments. A correction begins after the primitive that holds what it began after.
    ///
    /// # Errors
    /// Where that method refuses a correction; [`BenchError::Nameless`], [`BenchError::Unheld`] where a correction's
    /// stop is no place of its model.
    pub fn taught_to(&self, method: &str, mut learned: Box<dyn Learned>) -> Result<Box<dyn Learned>, BenchError> {
        for Given { demonstration, stop } in &self.corrections {
            let name = demonstration.name();
            let stop = stop.as_ref().map_err(|nameless| BenchError::nameless(name, *nameless))?;
            let place = stop.in_model(&learned.graph()?);
            let stop = place.map_err(|unheld| BenchError::unheld(name, method, unheld))?;
            learned.correct(stop.correction(demonstration))?;
        }
        Ok(learned)
    }
}
