//! The true keyframes of a skill, told from the spurious ones as plainly as possible (decision D25).

use core::f64::consts::PI;

use situ::demonstration::Gripper;
use situ::keyframe::hmm::HmmParameters;

use crate::reference::commands::Commands;
use crate::reference::hmm::{Frame, Hmm};

/// The model of so many states of which each explains one keyframe of a segment, and one kind of command where that
/// can be.
pub(crate) fn true_keyframes(sequences: &[Vec<Frame>], states: usize, rule: &HmmParameters) -> Hmm {
    let even = Hmm::fit(sequences, states, rule);
    let paths: Vec<Vec<usize>> = sequences.iter().map(|sequence| even.path(sequence)).collect();
    let twice = |path: &Vec<usize>| (1..path.len()).any(|frame| path[frame] == path[frame - 1]);
    let commands = |state: usize| -> Vec<Gripper> {
        let frames = sequences.iter().flatten().zip(paths.iter().flatten());
        frames.filter(|(_, of)| **of == state).filter_map(|((_, command), _)| *command).collect()
    };
    let mixed = |of: Vec<Gripper>| of.iter().any(|command| of[0].is_moved_by(*command));
    if !paths.iter().any(twice) && !(0..states).any(|state| mixed(commands(state))) {
        return even;
    }
    let mut best = settled(even, sequences, rule);
    for template in sequences.iter().filter(|sequence| sequence.len() == states).take(5) {
        let other = settled(Hmm::fit(std::slice::from_ref(template), states, rule), sequences, rule);
        if other.1 > best.1 + 0.1 {
            best = other;
        }
    }
    best.0
}

/// Thins the sequences and fits again, until nothing changes. Returns how well the rest is explained.
fn settled(from: Hmm, sequences: &[Vec<Frame>], rule: &HmmParameters) -> (Hmm, f64) {
    let (mut hmm, mut kept) = (from, sequences.to_vec());
    loop {
        let paths: Vec<Vec<usize>> = kept.iter().map(|sequence| hmm.path(sequence)).collect();
        let fewer: Vec<Vec<Frame>> = (0..kept.len()).map(|index| thinned(&hmm, &kept, &paths, index)).collect();
        if fewer == kept {
            break;
        }
        hmm = hmm.refit(&fewer, rule);
        kept = fewer;
    }
    let floors: f64 = 3.0 * rule.position_floor.ln() + rule.rotation_floor.iter().map(|floor| floor.ln()).sum::<f64>();
    // χ² with 6 degrees of freedom is below this in 95 of 100 draws.
    let least = -(3.0 * (2.0 * PI).ln() + floors + 0.5 * 12.591_587_243_743_977);
    let score = kept.iter().map(|sequence| hmm.log_likelihood(sequence) - least * sequence.len() as f64).sum();
    (hmm, score)
}

/// A sequence with the best keyframe of each state alone.
fn thinned(hmm: &Hmm, sequences: &[Vec<Frame>], paths: &[Vec<usize>], index: usize) -> Vec<Frame> {
    let of = |sequence: usize, state: usize| -> Vec<usize> {
        (0..paths[sequence].len()).filter(|frame| paths[sequence][*frame] == state).collect()
    };
    let mut kept = Vec::new();
    for (state, emission) in hmm.emissions.iter().enumerate() {
        let own = emission.commands.as_ref().map(Commands::most_probable).expect("keyframes have commands");
        let centre = [0, 1, 2].map(|axis| {
            let mut votes: Vec<(f64, f64)> = Vec::new();
            for (sequence, frames) in sequences.iter().enumerate() {
                let shown = of(sequence, state);
                votes.extend(shown.iter().map(|at| (frames[*at].0.translation.vector[axis], 1.0 / shown.len() as f64)));
            }
            votes.sort_by(|one, other| one.0.total_cmp(&other.0));
            let all: f64 = votes.iter().map(|vote| vote.1).sum();
            (0..votes.len())
                .find(|at| votes[..=*at].iter().map(|vote| vote.1).sum::<f64>() >= 0.5 * all - 1e-9)
                .map_or(0.0, |at| votes[at].0)
        });
        let worse = |frame: usize| {
            let (pose, command) = &sequences[index][frame];
            let is_other = own.is_moved_by(command.expect("keyframes have commands"));
            let apart = (pose.translation.vector - nalgebra::Vector3::from(centre)).norm();
            apart + if is_other { 1e6 } else { 0.0 }
        };
        kept.extend(of(index, state).into_iter().min_by(|one, other| worse(*one).total_cmp(&worse(*other))));
    }
    kept.into_iter().map(|frame| sequences[index][frame]).collect()
}
