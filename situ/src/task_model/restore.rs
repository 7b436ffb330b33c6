//! A task model that was written and read, made whole: what is not written follows from the rest. What is read was
//! written by anybody, so nothing is believed.

use std::collections::BTreeSet;

use super::TaskModel;
use super::history::History;
use super::node::Node;
use crate::error::SituError;
use crate::keyframe::pose::is_unit;
use crate::place::{NodeId, Place, SampleId, Samples, SegmentId};
use crate::primitive::Restore;
use crate::segment::Segment;
use crate::state::State;

fn refuse<T>(place: impl Into<String>, problem: impl Into<String>) -> Result<T, SituError> {
    Err(SituError::Model { place: place.into(), problem: problem.into() })
}

impl<L: Restore> TaskModel<L> {
    /// The model that was written, whole: it does and says what it did before.
    ///
    /// # Errors
    /// [`SituError::Model`] with the first part that cannot be one of a model.
    pub fn restored(mut self, learner: &L) -> Result<Self, SituError> {
        let width = learner.features();
        if !learner.is_calibration(&self.calibration) {
            return refuse("model.calibration", "expected finite numbers, and scatters above 0");
        }
        for (index, history) in self.histories.iter().enumerate() {
            self.check_history(index, history, width)?;
        }
        self.check_places()?;
        self.check_samples("model.end.samples", &self.end.samples)?;
        let whole = |place: String, read: L::Classifier| {
            learner.restored_classifier(read).or_else(|problem| refuse(place, problem))
        };
        if let Some(classifier) = self.end.classifier.take() {
            self.end.classifier = Some(whole("model.end.classifier".to_owned(), classifier)?);
        }
        for (id, node) in std::mem::take(&mut self.nodes) {
            let key = format!("model.nodes.{}", id.0);
            self.check_node(&key, id, &node)?;
            let Node { reference, segments, ways, samples, classifier } = node;
            let classifier = whole(format!("{key}.classifier"), classifier)?;
            let mut restored = Vec::with_capacity(ways.len());
            for (index, mut way) in ways.into_iter().enumerate() {
                let own: Vec<&Segment> = way.segments.iter().map(|segment| &**self.segment(*segment)).collect();
                way.policy = learner
                    .restored_policy(way.policy, &own)
                    .or_else(|problem| refuse(format!("{key}.ways[{index}].policy"), problem))?;
                restored.push(way);
            }
            self.put_in(id, Node { reference, segments, ways: restored, samples, classifier });
        }
        for (demonstration, history) in (0..).zip(&self.histories) {
            if let Some(after) = history.after {
                self.followers.entry(after).or_default().push(demonstration);
            }
        }
        Ok(self)
    }

    fn check_history(&self, index: usize, history: &History, width: usize) -> Result<(), SituError> {
        let key = format!("model.histories[{index}]");
        let is_state = |state: &State| state.values().len() == width && state.values().iter().all(|v| v.is_finite());
        let is_earlier = |id: &SegmentId| (id.demonstration as usize) < index && self.has(*id);
        let is_segment = |segment: &Segment| {
            let keyframes = &segment.keyframes;
            let is_fine = |value: f64| value.is_finite();
            let is_keyframe = keyframes.iter().all(|keyframe| {
                is_unit(&keyframe.pose)
                    && is_fine(keyframe.gripper.value())
                    && keyframe.hold >= 0.0
                    && is_fine(keyframe.hold)
            });
            !segment.reference.is_empty() && !keyframes.is_empty() && is_keyframe && is_state(&segment.start)
        };
        if history.segments.is_empty() || history.segments.len() != history.nodes.len() {
            return refuse(key, "expected at least one segment, and a node for each");
        }
        if let Some(segment) = history.segments.iter().position(|segment| !is_segment(segment)) {
            return refuse(
                format!("{key}.segments[{segment}]"),
                format!("expected a state of {width} finite numbers, and keyframes with unit rotations"),
            );
        }
        if !history.after.iter().chain(&history.interrupted).all(is_earlier) {
            return refuse(key, "expected `after` and `interrupted` to be segments of earlier demonstrations");
        }
        if let Some(step) = history.trail.iter().position(|step| !is_earlier(&step.of) || !is_state(&step.state)) {
            let problem = format!("expected a segment of an earlier demonstration, and a state of {width} numbers");
            return refuse(format!("{key}.trail[{step}]"), problem);
        }
        if !is_state(&history.final_state) {
            return refuse(format!("{key}.final_state"), format!("expected {width} finite numbers"));
        }
        Ok(())
    }

    /// Whether there is such a segment.
    fn has(&self, id: SegmentId) -> bool {
        let history = self.histories.get(id.demonstration as usize);
        history.is_some_and(|history| (id.index as usize) < history.segments.len())
    }

    fn check_places(&self) -> Result<(), SituError> {
        let ids: BTreeSet<NodeId> = self.nodes.keys().copied().collect();
        if ids.last().is_some_and(|last| last.0 >= self.next) {
            return refuse("model.next", format!("{}, expected more than the greatest node", self.next));
        }
        let held: usize = self.nodes.values().map(|node| node.segments.len()).sum();
        let shown: usize = self.histories.iter().map(|history| history.segments.len()).sum();
        if held != shown {
            return refuse("model.nodes", format!("they hold {held} segments, expected each of {shown} once"));
        }
        let is_there = |place: Place| place.node().is_none_or(|id| ids.contains(&id));
        let is_edge =
            |(from, to): (Place, Place)| is_there(from) && is_there(to) && from != Place::End && to != Place::Start;
        match self.edges().position(|edge| !is_edge(edge)) {
            None => Ok(()),
            Some(edge) => refuse(format!("model.edges[{edge}]"), "expected two places of the model, not out of END"),
        }
    }

    fn check_samples(&self, key: &str, samples: &Samples) -> Result<(), SituError> {
        let is_there = |sample: &SampleId| match *sample {
            SampleId::Start(id) => self.has(id),
            SampleId::Final(index) => (index as usize) < self.histories.len(),
            SampleId::Chosen { demonstration, index } => {
                let history = self.histories.get(demonstration as usize);
                history.is_some_and(|history| (index as usize) < history.trail.len())
            }
        };
        if samples.positives.iter().chain(&samples.negatives).all(is_there) {
            return Ok(());
        }
        refuse(key, "expected states of the model's demonstrations")
    }

    fn check_node(&self, key: &str, id: NodeId, node: &Node<L>) -> Result<(), SituError> {
        let is_own = |segment: &SegmentId| {
            self.has(*segment)
                && self.node_of(*segment) == Some(id)
                && self.segment(*segment).reference == node.reference
        };
        if node.segments.is_empty() || !node.segments.iter().all(is_own) {
            return refuse(format!("{key}.segments"), "expected segments that are placed at this node, on its object");
        }
        if node.ways.is_empty() {
            return refuse(format!("{key}.ways"), "expected at least one");
        }
        for (index, way) in node.ways.iter().enumerate() {
            if way.segments.is_empty() || !way.segments.is_subset(&node.segments) {
                return refuse(format!("{key}.ways[{index}].segments"), "expected some of the node's segments");
            }
            let wanted = Samples { positives: way.wanted.clone(), negatives: BTreeSet::new() };
            self.check_samples(&format!("{key}.ways[{index}].wanted"), &wanted)?;
        }
        self.check_samples(&format!("{key}.samples"), &node.samples)
    }
}
