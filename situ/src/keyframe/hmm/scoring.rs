//! The same sequences under one model after another.

use super::emission::Observation;
use super::frames::Frames;
use super::inference::Recursion;
use super::model::Hmm;
use crate::demonstration::Gripper;

/// Sets of sequences, prepared once for many models.
pub(crate) struct Scoring {
    frames: Frames,
    grippers: Vec<Option<Gripper>>,
    /// The number of sequences of each set.
    sets: Vec<usize>,
    recursion: Recursion,
}

impl Scoring {
    /// Sets of sequences for models of so many states. A sequence without a frame does not count.
    pub(crate) fn new(sets: &[&[Vec<Observation>]], states: usize) -> Self {
        let all = || sets.iter().flat_map(|set| set.iter()).filter(|sequence| !sequence.is_empty());
        let (mut starts, mut frames) = (vec![0], Vec::<&Observation>::new());
        for sequence in all() {
            frames.extend(sequence);
            starts.push(frames.len());
        }
        let has_frames = |sequence: &&Vec<Observation>| !sequence.is_empty();
        Self {
            frames: Frames::new(frames.iter().map(|frame| &frame.pose)),
            grippers: frames.iter().map(|frame| frame.gripper).collect(),
            sets: sets.iter().map(|set| set.iter().filter(has_frames).count()).collect(),
            recursion: Recursion::new(starts, states),
        }
    }

    /// The log likelihood of each set under a model of that many states: what [`Hmm::total_log_likelihood`] gives, bit
    /// for bit.
    pub(crate) fn log_likelihoods(&mut self, hmm: &Hmm) -> Vec<f64> {
        for (state, emission) in hmm.emissions.iter().enumerate() {
            let column = self.recursion.log_densities_mut().column_mut(state);
            self.frames.log_densities(&emission.mean, emission.gaussian(), column);
            emission.add_log_densities_of_commands(self.grippers.iter().copied(), column);
        }
        let mut sequences = self.recursion.forward(hmm).iter();
        self.sets.iter().map(|count| sequences.by_ref().take(*count).sum()).collect()
    }
}
