//! What a robot was shown, in order, and what it had done before: to name it, to score the model by it, and to teach another the same.

use situ::correction::Correction;
use situ::demonstration::{Demonstration, Schema};
use situ::error::SituError;
use situ::graph::Graph;
use situ::method::{Learned, Method};
use situ::place::{NodeId, Place, SegmentId};
use situ::structure::{Structure, Truth};

use crate::demonstration_file::{Before, Instance};

/// A correction that was given. Primitives are named by the first segment that they held then: that outlives their nodes.
struct Given {
    demonstration: Demonstration,
    /// What had run; `None` for START.
    last: Option<SegmentId>,
    interrupted: Option<SegmentId>,
}

/// All that a robot was shown.
pub struct Lesson {
    originals: Vec<Demonstration>,
    corrections: Vec<Given>,
    truth: Truth,
}

impl Lesson {
    /// The demonstrations of the original task.
    pub fn new(method: &dyn Method, originals: &[Demonstration]) -> Self {
        let mut truth = Truth::default();
        originals.iter().for_each(|shown| truth.original(shown, &method.segments(shown)));
        Self { originals: originals.to_vec(), corrections: Vec::new(), truth }
    }

    /// A correction more, given when the model was this.
    pub fn corrected(
        &mut self,
        method: &dyn Method,
        model: &Graph,
        last: Place,
        interrupted: Option<NodeId>,
        demonstration: Demonstration,
    ) {
        self.truth.correction(&demonstration, &method.segments(&demonstration), last, model);
        let last = if let Place::Node(id) = last { held(model, id) } else { None };
        let interrupted = interrupted.and_then(|id| held(model, id));
        self.corrections.push(Given { demonstration, last, interrupted });
    }

    /// What the robot did before a correction, in the words of a demonstration file.
    pub fn before(&self, model: &Graph, last: Place, interrupted: Option<NodeId>) -> Before {
        let instance = |id| {
            let segment = held(model, id)?;
            let corrections = self.corrections.iter().map(|given| &given.demonstration);
            let shown = self.originals.iter().chain(corrections).nth(segment.demonstration as usize)?;
            Some(Instance { demonstration: shown.name().to_string(), segment: segment.index })
        };
        let after = if let Place::Node(id) = last { instance(id) } else { None };
        Before { after, interrupted: interrupted.and_then(instance) }
    }

    /// The score of the structure that the lesson led to; `None` where the teacher was silent.
    pub fn score(&self, model: &Graph) -> Option<Structure> {
        self.truth.score(model)
    }

    /// What another method makes of the lesson, one whose graphs name the same segments. A correction begins after the primitive that holds
    /// what it began after.
    ///
    /// # Errors
    /// Where that method refuses a demonstration.
    pub fn taught_to(&self, method: &dyn Method, schema: &Schema, seed: u64) -> Result<Box<dyn Learned>, SituError> {
        let mut learned = method.teach(schema, &self.originals, seed)?;
        for Given { demonstration, last, interrupted } in &self.corrections {
            let graph = learned.graph();
            let holders = graph.holders();
            let holder = |segment: &Option<SegmentId>| segment.and_then(|id| holders.get(&id)).map(|node| node.id);
            let last = holder(last).map_or(Place::Start, Place::Node);
            let interrupted = holder(interrupted);
            learned.correct(Correction { interrupted, ..Correction::after(last, demonstration) })?;
        }
        Ok(learned)
    }
}

/// The first segment that a node holds.
fn held(model: &Graph, id: NodeId) -> Option<SegmentId> {
    model.nodes.iter().find(|node| node.id == id)?.segments.first().copied()
}
