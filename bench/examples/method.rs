//! A method of one's own: `first_only` learns from the first correction and from no later one.
//!
//! A method like this says what later corrections are worth. It stands in one file; below it is a check of what it
//! does. `cargo run --example method` runs that, and so does `cargo test`, for this file is part of
//! `situ_bench::extending`.

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;
use situ::correction::Correction;
use situ::demonstration::Demonstration;
use situ::edit::{Edit, difference};
use situ::error::SituError;
use situ::graph::Graph;
use situ::keyframe::policy::Execution;
use situ::method::{self, KEYFRAME_AUTOMATON, Learned, Method, Original, Role};
use situ::place::{NodeId, Place};
use situ::segment::RelativeKeyframe;
use situ::state::{Schema, State};
use situ::trace::Trace;
use situ_bench::cost::Subject;
use situ_bench::synthetic::Parameters;

/// Learns as `situ` does, and from the first correction alone.
struct FirstOnly;

impl Method for FirstOnly {
    fn name(&self) -> &str {
        "first_only"
    }

    fn summary(&self) -> &str {
        "situ with the first correction alone"
    }

    fn source(&self) -> &str {
        "a control of this benchmark"
    }

    fn role(&self) -> Role {
        Role::Correct
    }

    fn original(&self) -> &str {
        KEYFRAME_AUTOMATON
    }

    fn learn_original(&self, schema: &Schema, shown: &[Demonstration], seed: u64) -> Result<Original, SituError> {
        method::standard().learn_original(schema, shown, seed)
    }

    fn take_over(&self, original: &Original) -> Result<Box<dyn Learned>, SituError> {
        let situ = method::named("situ").expect("it is listed");
        Ok(Box::new(Task { model: situ.take_over(original)?, is_corrected: false }))
    }
}

/// The model of a task.
struct Task {
    model: Box<dyn Learned>,
    is_corrected: bool,
}

impl Learned for Task {
    fn correct(&mut self, correction: Correction<'_>) -> Result<Trace, SituError> {
        if self.is_corrected {
            return Ok(Trace::default());
        }
        self.is_corrected = true;
        self.model.correct(correction)
    }

    fn ranked(&self, last: Place, state: &State) -> Result<Vec<(Place, f64)>, SituError> {
        self.model.ranked(last, state)
    }

    fn ways(&self, node: NodeId, state: &State) -> Result<Vec<usize>, SituError> {
        self.model.ways(node, state)
    }

    fn keyframes(
        &self,
        node: NodeId,
        way: usize,
        state: &State,
        execution: Execution,
        rng: &mut ChaCha8Rng,
    ) -> Result<(Arc<str>, Vec<RelativeKeyframe>), SituError> {
        self.model.keyframes(node, way, state, execution, rng)
    }

    fn graph(&self) -> Result<Graph, SituError> {
        self.model.graph()
    }

    fn boxed(&self) -> Box<dyn Learned> {
        Box::new(Self { model: self.model.boxed(), is_corrected: self.is_corrected })
    }

    fn to_json(&self) -> serde_json::Value {
        serde_json::json!({ "model": self.model.to_json(), "is_corrected": self.is_corrected })
    }
}

fn main() {
    let subject = Subject::teach(&FirstOnly, Parameters::of(10, 1)).expect("it learns the automaton");
    let mut task = subject.learned().boxed();
    for (edit, made) in [(Edit::NodeAddition, Edit::NodeAddition), (Edit::EdgeAddition, Edit::None)] {
        let planted = subject.automaton().plant(edit, 1).expect("there is room for a correction");
        let before = task.graph().expect("it is held here");
        let last = planted.last(&before).expect("the first original visits every node");
        task.correct(Correction::after(last, &planted.demonstration)).expect("the correction is learned");
        assert_eq!(difference(&before, &task.graph().expect("it is held here")).edit(), made, "{edit} was needed");
    }
}
