//! The "true" keyframes of a skill (paper, "Primitive Specification"), and the keyframes of a demonstration that are
//! none (decision D25).
//!
//! People give keyframes that nobody needs: half way, or on a detour. Expectation maximisation gives such a keyframe to
//! the hidden state that is nearest, and the mean of that state moves towards it. Where the gripper closes or opens,
//! the command keeps it out; where the hand only pushes, nothing does, and the hand stops short of what it pushes. Two
//! rules mend that, and change nothing where no state explains two keyframes of one segment:
//!
//! - *One segment shows a true keyframe once.* Of several keyframes of one segment in one state the one nearest to the
//!   median is true, where each segment has one vote. The others are left out, and the fit goes on from there.
//! - *Nor has a true keyframe two gripper commands.* Where some state has, or explains two keyframes of one segment,
//!   the even cut may have been a bad start: one segment with many tries at one thing has more keyframes than all
//!   others together. Then the keyframes of single segments are starts too, and the one counts which explains best
//!   what it leaves. A keyframe is better left out where it is less likely than at the 95th percentile of the floor
//!   (decision D12).
//!
//! The limit: where most segments have a needless keyframe, each at another place, there are as many hidden states as
//! that makes (decision D14). One of them may then hold the contacts of some segments together with the needless
//! keyframes of others, if these are within two or three standard deviations of the floor (decision D12).

use core::f64::consts::TAU;
use std::borrow::Cow;

use super::hmm::{Hmm, HmmError, HmmFit, HmmParameters, Observation};
use super::policy::CHI_SQUARED_6_95;
use crate::demonstration::Gripper;
use crate::error::SituError;
use crate::trace::Counters;

/// Segments from whose keyframes a fit starts, at the most.
const TEMPLATES: usize = 5;
/// What is better by less than this, in nats, is the same up to the tolerance of the fit.
const BETTER: f64 = 0.1;
/// Two sums of votes that differ by less than this are the same up to rounding.
const ROUNDING: f64 = 1e-9;

/// The likeliest state of every frame of every sequence.
pub(super) type Paths = Vec<Vec<usize>>;

/// Fits models to what was shown about one reference object, and counts the work.
pub(super) struct Fitting<'a> {
    /// The reference object, for errors.
    pub(super) reference: &'a str,
    pub(super) parameters: &'a HmmParameters,
    pub(super) counters: &'a mut Counters,
}

impl Fitting<'_> {
    /// See [`Hmm::fit`].
    pub(super) fn fit(&mut self, sequences: &[Vec<Observation>], states: usize) -> Result<HmmFit, SituError> {
        let sequences: Vec<&[Observation]> = sequences.iter().map(Vec::as_slice).collect();
        self.counted(Hmm::fit(&sequences, states, self.parameters))
    }

    /// See [`Hmm::refit`].
    fn refit(&mut self, from: &Hmm, sequences: &[Vec<Observation>]) -> Result<HmmFit, SituError> {
        let sequences: Vec<&[Observation]> = sequences.iter().map(Vec::as_slice).collect();
        self.counted(from.refit(&sequences, self.parameters))
    }

    fn counted(&mut self, fit: Result<HmmFit, HmmError>) -> Result<HmmFit, SituError> {
        let of =
            |error: HmmError| SituError::Policy { reference: self.reference.to_owned(), problem: error.to_string() };
        let fit = fit.map_err(of)?;
        self.counters.hmm_fits += 1;
        self.counters.em_iterations += fit.iterations as u64;
        Ok(fit)
    }

    /// The model whose hidden states are the true keyframes, so many, and the likeliest state of every frame. Every
    /// frame has a gripper command.
    pub(super) fn true_keyframes(
        &mut self,
        sequences: &[Vec<Observation>],
        states: usize,
    ) -> Result<(Hmm, Paths), SituError> {
        let even = self.fit(sequences, states)?.hmm;
        let taken = paths(&even, sequences);
        if !is_ambiguous(&taken, sequences, states) {
            return Ok((even, taken));
        }
        let mut best = self.without_spurious(even, sequences)?;
        for template in sequences.iter().filter(|sequence| sequence.len() == states).take(TEMPLATES) {
            let start = self.fit(std::slice::from_ref(template), states)?.hmm;
            let other = self.without_spurious(start, sequences)?;
            if other.1 > best.1 + BETTER {
                best = other;
            }
        }
        let taken = paths(&best.0, sequences);
        Ok((best.0, taken))
    }

    /// Leaves spurious keyframes out and fits again, until there is none. Returns how well the model explains the
    /// others, beside it, in nats.
    fn without_spurious(&mut self, from: Hmm, sequences: &[Vec<Observation>]) -> Result<(Hmm, f64), SituError> {
        let (mut hmm, mut kept) = (from, Cow::Borrowed(sequences));
        while let Some(fewer) = without_second(&hmm, &kept) {
            hmm = self.refit(&hmm, &fewer)?.hmm;
            kept = Cow::Owned(fewer);
        }
        let frames: usize = kept.iter().map(Vec::len).sum();
        let score = hmm.total_log_likelihood(&kept) - frames as f64 * self.least_log_density();
        Ok((hmm, score))
    }

    /// The log density of a pose at the 95th percentile of the floor.
    fn least_log_density(&self) -> f64 {
        let normaliser: f64 = (0..6).map(|axis| 0.5 * libm::log(TAU) + libm::log(self.parameters.floor(axis))).sum();
        -normaliser - 0.5 * CHI_SQUARED_6_95
    }
}

/// The likeliest state of every frame of every sequence.
pub(super) fn paths(hmm: &Hmm, sequences: &[Vec<Observation>]) -> Paths {
    sequences.iter().map(|sequence| hmm.viterbi(sequence).0).collect()
}

/// Whether a state explains two keyframes of one sequence, or two kinds of gripper command.
fn is_ambiguous(paths: &Paths, sequences: &[Vec<Observation>], states: usize) -> bool {
    let mut commands: Vec<Option<Gripper>> = vec![None; states];
    sequences.iter().zip(paths).any(|(sequence, path)| {
        path.windows(2).any(|states| states[0] == states[1])
            || sequence.iter().zip(path).any(|(observation, state)| {
                let before = *commands[*state].get_or_insert(command(observation));
                before.is_moved_by(command(observation))
            })
    })
}

fn command(observation: &Observation) -> Gripper {
    observation.gripper.expect("a policy is fitted to gripper commands")
}

/// The sequences with one keyframe for each state, or `None` if no state explains two keyframes of one sequence.
fn without_second(hmm: &Hmm, sequences: &[Vec<Observation>]) -> Option<Vec<Vec<Observation>>> {
    // The frames of each state in each sequence, shape (K, sequences).
    let mut explained = vec![vec![Vec::new(); sequences.len()]; hmm.states()];
    for (index, path) in paths(hmm, sequences).into_iter().enumerate() {
        for (frame, state) in path.into_iter().enumerate() {
            explained[state][index].push(frame);
        }
    }
    if explained.iter().flatten().all(|frames| frames.len() < 2) {
        return None;
    }
    let mut is_true: Vec<Vec<bool>> = sequences.iter().map(|sequence| vec![false; sequence.len()]).collect();
    for (frames, emission) in explained.iter().zip(&hmm.emissions) {
        let own = emission.gripper_command().expect("a policy is fitted to gripper commands");
        let centre = [0, 1, 2].map(|axis| median(sequences, frames, axis));
        for ((frames, sequence), is_true) in frames.iter().zip(sequences).zip(&mut is_true) {
            // The command of the state counts first.
            let rank = |frame: &usize| {
                let position = sequence[*frame].pose.translation.vector;
                let squared = (0..3).map(|axis| (position[axis] - centre[axis]) * (position[axis] - centre[axis]));
                (own.is_moved_by(command(&sequence[*frame])), squared.sum::<f64>())
            };
            let nearest = frames.iter().min_by(|left, right| {
                let (left, right) = (rank(left), rank(right));
                left.0.cmp(&right.0).then(left.1.total_cmp(&right.1))
            });
            if let Some(frame) = nearest {
                is_true[*frame] = true;
            }
        }
    }
    let kept = |(sequence, is_true): (&Vec<Observation>, Vec<bool>)| {
        sequence.iter().zip(is_true).filter_map(|(observation, is_true)| is_true.then_some(*observation)).collect()
    };
    Some(sequences.iter().zip(is_true).map(kept).collect())
}

/// The median of a coordinate over the frames of a state, of which those of each sequence have one vote together.
fn median(sequences: &[Vec<Observation>], frames: &[Vec<usize>], axis: usize) -> f64 {
    let mut votes: Vec<(f64, f64)> = Vec::new();
    for (sequence, frames) in sequences.iter().zip(frames) {
        let vote = 1.0 / frames.len() as f64;
        votes.extend(frames.iter().map(|frame| (sequence[*frame].pose.translation.vector[axis], vote)));
    }
    votes.sort_by(|left, right| left.0.total_cmp(&right.0));
    let half = 0.5 * votes.iter().map(|(_, vote)| vote).sum::<f64>();
    let mut below = 0.0;
    let reaches = |(_, vote): &&(f64, f64)| {
        below += vote;
        below >= half - ROUNDING
    };
    votes.iter().find(reaches).map_or(0.0, |(value, _)| *value)
}
