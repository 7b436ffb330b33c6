//! The state samples that the classifiers of a task model are fitted to.

use std::collections::BTreeSet;

use super::TaskModel;
use crate::decisions::Background;
use crate::error::SituError;
use crate::place::{NodeId, Place, SampleId, Samples, SegmentId};
use crate::primitive::Learner;

impl<L: Learner> TaskModel<L> {
    pub(super) fn samples(&self, place: Place) -> Option<&Samples> {
        match place {
            Place::Start => None,
            Place::Node(id) => self.nodes.get(&id).map(|node| &node.samples),
            Place::End => Some(&self.end.samples),
        }
    }

    fn samples_mut(&mut self, place: Place) -> Option<&mut Samples> {
        match place {
            Place::Start => None,
            Place::Node(id) => self.node_mut(id).ok().map(|node| &mut node.samples),
            Place::End => Some(&mut self.end_mut().samples),
        }
    }

    /// `S(places)`: the samples in which these places begin.
    pub fn starts(&self, places: impl Iterator<Item = Place>) -> BTreeSet<SampleId> {
        places.filter_map(|place| self.samples(place)).flat_map(|samples| &samples.positives).copied().collect()
    }

    /// Adds positive samples to a node.
    ///
    /// # Errors
    /// [`SituError::UnknownNode`].
    pub fn add_positives(&mut self, id: NodeId, samples: &BTreeSet<SampleId>) -> Result<(), SituError> {
        self.node_mut(id)?.samples.positives.extend(samples);
        Ok(())
    }

    /// Takes a positive away from a place that has others, and says whether it did. The history keeps it (decision
    /// D22).
    pub fn retire(&mut self, place: Place, sample: SampleId) -> bool {
        self.samples_mut(place).is_some_and(|samples| samples.positives.len() > 1 && samples.positives.remove(&sample))
    }

    /// Gives a positive back that was retired.
    pub fn reinstate(&mut self, place: Place, sample: SampleId) {
        if let Some(samples) = self.samples_mut(place) {
            samples.positives.insert(sample);
        }
    }

    /// The place that a robot came from to the state of a sample.
    pub fn before(&self, sample: SampleId) -> Option<Place> {
        let node = |segment: SegmentId| self.node_of(segment).map(Place::Node);
        let origin = |demonstration: u32| self.histories[demonstration as usize].after.map_or(Some(Place::Start), node);
        match sample {
            SampleId::Start(SegmentId { demonstration, index: 0 }) => origin(demonstration),
            SampleId::Start(SegmentId { demonstration, index }) => node(SegmentId { demonstration, index: index - 1 }),
            SampleId::Final(demonstration) => {
                self.histories[demonstration as usize].nodes.last().map(|node| Place::Node(*node))
            }
            SampleId::Chosen { index: 0, .. } => Some(Place::Start),
            SampleId::Chosen { demonstration, index } => {
                node(self.histories[demonstration as usize].trail[index as usize - 1].of)
            }
        }
    }

    /// Adds a positive sample to END.
    pub fn add_final(&mut self, demonstration: u32) {
        self.end_mut().samples.positives.insert(SampleId::Final(demonstration));
    }

    /// Adds negatives to a place's samples. Returns whether one of them was new.
    pub fn add_negatives(&mut self, place: Place, negatives: &BTreeSet<SampleId>) -> bool {
        let Some(samples) = self.samples_mut(place) else { return false };
        let before = samples.negatives.len();
        samples.negatives.extend(negatives);
        samples.negatives.len() > before
    }

    /// Forgets the negatives of all places, before they are made anew.
    pub(crate) fn forget_negatives(&mut self) {
        let places: Vec<Place> = self.nodes().map(|(id, _)| Place::Node(id)).chain([Place::End]).collect();
        for place in places {
            if let Some(samples) = self.samples_mut(place) {
                samples.negatives.clear();
            }
        }
    }

    /// Background negatives (decision D2) of a primitive that stands between these places: a bounded number of start
    /// states, spread over the demonstrations by a fixed sequence of low discrepancy, its own `positives` left out.
    pub fn background(
        &self,
        rule: Background,
        neighbours: impl Iterator<Item = Place>,
        positives: &BTreeSet<SampleId>,
    ) -> BTreeSet<SampleId> {
        let mut samples = if rule.neighbours { self.starts(neighbours) } else { BTreeSet::new() };
        // Only the demonstration that is being learned can have no segment placed yet.
        let placed =
            self.histories.len() - usize::from(self.histories.last().is_some_and(|last| last.nodes.is_empty()));
        for draw in 0..if placed == 0 { 0 } else { rule.others } {
            // The golden ratio and the plastic number: points that spread evenly however many are drawn.
            let spread = |step: f64, size: usize| ((draw as f64 + 0.5) * step % 1.0 * size as f64) as usize;
            let history = spread(0.618_033_988_749_894_9, placed);
            let segment = spread(0.754_877_666_246_692_8, self.histories[history].nodes.len());
            samples.insert(SampleId::Start(SegmentId { demonstration: history as u32, index: segment as u32 }));
        }
        samples.retain(|sample| !positives.contains(sample));
        samples
    }
}
