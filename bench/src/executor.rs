//! What an executor does next: the paper's choice of the most probable child, or the next one where that failed.

use serde::Deserialize;
use situ::error::SituError;
use situ::method::Learned;
use situ::place::{NodeId, Place};
use situ::state::State;

/// What is done where a primitive fails: where it is aborted, has no plan or is out of reach, and where no child is
/// confident after it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Executor {
    /// The rollout ends: only the most probable child is tried, as the paper has it.
    #[default]
    Argmax,
    /// From where the world then is, the next way of the primitive is tried, and then the next probable child of what
    /// ran before it.
    Next,
}

impl Executor {
    /// Whether it is the paper's.
    pub fn is_argmax(self) -> bool {
        self == Self::Argmax
    }
}

/// A place that is to follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follows {
    /// The place.
    pub place: Place,
    /// Its probability.
    pub probability: f64,
    /// The way of a primitive; 0 for END.
    pub way: usize,
}

/// A place that was come to, and what was tried from it.
struct Step {
    place: Place,
    tried: Vec<(NodeId, usize)>,
}

impl Step {
    /// The most probable of what was not tried yet; `None` where all was.
    fn untried(&self, model: &dyn Learned, state: &State) -> Result<Option<Follows>, SituError> {
        for (place, probability) in model.ranked(self.place, state)? {
            let Place::Node(node) = place else { return Ok(Some(Follows { place, probability, way: 0 })) };
            let left = model.ways(node, state)?.into_iter().find(|way| !self.tried.contains(&(node, *way)));
            if let Some(way) = left {
                return Ok(Some(Follows { place, probability, way }));
            }
        }
        Ok(None)
    }
}

/// Where an execution stands in the automaton.
pub struct Pursuit {
    executor: Executor,
    confidence: f64,
    steps: Vec<Step>,
}

impl Pursuit {
    /// An execution that has done nothing yet. A child below this probability is not confident.
    pub fn new(executor: Executor, confidence: f64) -> Self {
        Self { executor, confidence, steps: vec![Step { place: Place::Start, tried: Vec::new() }] }
    }

    /// The primitive that ran last to its end; START where none did.
    pub fn last(&self) -> Place {
        self.steps.last().map_or(Place::Start, |step| step.place)
    }

    /// What is to follow. Where nothing is confident, the most probable is given all the same; `None` where nothing is
    /// left at all. An executor that tries the next one goes back first, as far as it must.
    ///
    /// # Errors
    /// Those of the model.
    pub fn next(&mut self, model: &dyn Learned, state: &State) -> Result<Option<Follows>, SituError> {
        if self.executor.is_argmax() {
            let Some((place, probability)) = model.next(self.last(), state)? else { return Ok(None) };
            let way = if let Place::Node(node) = place { model.ways(node, state)?.first().copied() } else { None };
            return Ok(Some(Follows { place, probability, way: way.unwrap_or_default() }));
        }
        loop {
            let Some(step) = self.steps.last() else { return Ok(None) };
            match step.untried(model, state)? {
                Some(found) if found.probability >= self.confidence || self.steps.len() == 1 => return Ok(Some(found)),
                _ => drop(self.steps.pop()),
            }
        }
    }

    /// A primitive is begun.
    pub fn begins(&mut self, node: NodeId, way: usize) {
        if let Some(step) = self.steps.last_mut() {
            step.tried.push((node, way));
        }
    }

    /// What was begun last has run to its end.
    pub fn finished(&mut self, node: NodeId) {
        self.steps.push(Step { place: Place::Node(node), tried: Vec::new() });
    }

    /// Whether something else is tried where a primitive failed.
    pub fn goes_on(&self) -> bool {
        !self.executor.is_argmax()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rand_chacha::ChaCha8Rng;
    use situ::correction::Correction;
    use situ::graph::Graph;
    use situ::keyframe::policy::Execution;
    use situ::segment::RelativeKeyframe;
    use situ::trace::Trace;

    use super::*;

    /// START leads to 0 (two ways) and 1; 0 leads to END, which is confident in a state above 0 alone; 1 to END.
    #[derive(Clone)]
    struct Known;

    impl Learned for Known {
        fn correct(&mut self, _: Correction<'_>) -> Result<Trace, SituError> {
            Ok(Trace::default())
        }

        fn ranked(&self, last: Place, state: &State) -> Result<Vec<(Place, f64)>, SituError> {
            Ok(match last {
                Place::Start => vec![(Place::Node(NodeId(0)), 0.9), (Place::Node(NodeId(1)), 0.5)],
                Place::Node(NodeId(0)) => vec![(Place::End, if state.values()[0] > 0.0 { 0.9 } else { 0.1 })],
                _ => vec![(Place::End, 0.8)],
            })
        }

        fn ways(&self, node: NodeId, _: &State) -> Result<Vec<usize>, SituError> {
            Ok(if node == NodeId(0) { vec![1, 0] } else { vec![0] })
        }

        fn keyframes(
            &self,
            _: NodeId,
            _: usize,
            _: &State,
            _: Execution,
            _: &mut ChaCha8Rng,
        ) -> Result<(Arc<str>, Vec<RelativeKeyframe>), SituError> {
            Ok(("cup".into(), Vec::new()))
        }

        fn graph(&self) -> Result<Graph, SituError> {
            Ok(Graph::default())
        }

        fn boxed(&self) -> Box<dyn Learned> {
            Box::new(self.clone())
        }

        fn to_json(&self) -> serde_json::Value {
            serde_json::Value::Null
        }
    }

    /// What is begun, in order, where each primitive ends as told; `END`, or what is not confident, comes last.
    fn walked(executor: Executor, ends: &[bool], state: f64) -> Vec<(Place, usize)> {
        let state = State::new([state]);
        let mut pursuit = Pursuit::new(executor, 0.3);
        let mut begun = Vec::new();
        let mut ends = ends.iter();
        let confident = |follows: &Follows| follows.probability >= 0.3;
        while let Some(follows) = pursuit.next(&Known, &state).unwrap().filter(confident) {
            begun.push((follows.place, follows.way));
            let Place::Node(node) = follows.place else { break };
            pursuit.begins(node, follows.way);
            match ends.next() {
                Some(true) => pursuit.finished(node),
                _ if pursuit.goes_on() => {}
                _ => break,
            }
        }
        begun
    }

    #[test]
    fn the_next_way_then_the_next_child_is_tried_where_one_fails() {
        let (zero, one, end) = (Place::Node(NodeId(0)), Place::Node(NodeId(1)), Place::End);
        assert_eq!(walked(Executor::Argmax, &[true], 1.0), [(zero, 1), (end, 0)]);
        assert_eq!(walked(Executor::Argmax, &[false], 1.0), [(zero, 1)], "it ends there");
        assert_eq!(walked(Executor::Next, &[true], 1.0), [(zero, 1), (end, 0)]);
        assert_eq!(walked(Executor::Next, &[false, false, true], 1.0), [(zero, 1), (zero, 0), (one, 0), (end, 0)]);
        assert_eq!(walked(Executor::Next, &[false, false, false], 1.0), [(zero, 1), (zero, 0), (one, 0)]);
        // No child is confident after the first primitive, whichever way it runs.
        assert_eq!(walked(Executor::Argmax, &[true], 0.0), [(zero, 1)]);
        assert_eq!(walked(Executor::Next, &[true, true, true], 0.0), [(zero, 1), (zero, 0), (one, 0), (end, 0)]);
    }
}
