//! Which edit explains a correction best.
//!
//! Every candidate is fitted to all data, original and corrective, and the smallest AICc wins. One edit explains most
//! corrections. Where none makes the whole of one possible, those that make the longest part of it possible, in
//! segments, are compared on that part; then the search goes on from there, so a correction can bring several edits.

use serde::Serialize;

use super::automaton::{Automaton, problem};
use super::candidate::{Candidate, all, apply};
use super::criterion::{akaike_weights, corrected_akaike};
use super::parameters::ItmcdParameters;
use super::starhmm::{Starhmm, StarhmmFit, StarhmmSequence, StarhmmStep};
use crate::error::SituError;
use crate::place::{NodeId, Place};
use crate::trace::Counters;

/// A candidate must be better than an earlier one by more than this: what differs by less differs by rounding.
const MARGIN: f64 = 1e-6;

/// What a candidate was found to be worth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CandidateEvaluation {
    /// The edit.
    pub candidate: Candidate,
    /// k, the free parameters of the whole model.
    pub parameters: usize,
    /// n, the scalar observations that it was compared on.
    pub observations: usize,
    /// log L, nats; `None` where it was not fitted, for it was refused.
    pub log_likelihood: Option<f64>,
    /// AICc; `None` where the candidate is refused, for n ≤ k + 1.
    pub criterion: Option<f64>,
    /// Its Akaike weight among the candidates of the round.
    pub weight: f64,
}

/// One round of the search.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Round {
    /// Segments of the correction that the winner makes possible; one more where END is.
    pub reach: usize,
    /// Candidates that do not make as much possible: they are not fitted.
    pub impossible: usize,
    /// The others, in order.
    pub evaluations: Vec<CandidateEvaluation>,
    /// The winner; `None` where every one is refused.
    pub chosen: Option<Candidate>,
}

/// A correction, as the search sees it.
pub(super) struct Shown {
    /// What had run before it.
    pub(super) last: Place,
    /// ψ of its first state.
    pub(super) entry_features: Vec<f64>,
    /// The steps of each segment.
    pub(super) segments: Vec<Vec<StarhmmStep>>,
    /// Whether it was carried on to the end.
    pub(super) ends: bool,
    /// Places that can come after a segment, the most plausible first, one list a segment.
    pub(super) order: Vec<Vec<Place>>,
}

/// The outcome.
pub(super) struct Plan {
    pub(super) rounds: Vec<Round>,
    /// The node of each segment; `None` where every candidate of a round was refused.
    pub(super) nodes: Option<Vec<NodeId>>,
}

impl Plan {
    pub(super) fn edits(&self) -> impl Iterator<Item = Candidate> {
        self.rounds.iter().filter_map(|round| round.chosen)
    }
}

/// Searches. `next` is the id of the first node that is added; `sequences` are those of the histories.
pub(super) fn select(
    mut automaton: Automaton,
    mut sequences: Vec<StarhmmSequence>,
    shown: &Shown,
    mut next: NodeId,
    parameters: &ItmcdParameters,
    counters: &mut Counters,
) -> Result<Plan, SituError> {
    let own = sequences.len();
    automaton.model = fitted(automaton.model, &sequences, parameters, counters)?.model;
    counters.nodes_touched += automaton.versions.len() as u64;

    let contexts: Vec<usize> = shown.segments.iter().map(|steps| steps[0].context).collect();
    let goal = contexts.len() + usize::from(shown.ends);
    let origin = match shown.last {
        Place::Node(id) => Some(automaton.current(id).ok_or(SituError::UnknownNode(id))?),
        _ => None,
    };
    let (mut explained, mut at, mut rounds) = (0, shown.last, Vec::new());
    loop {
        let order = shown.order.get(explained).map_or(&[][..], Vec::as_slice);
        let mut built = Vec::new();
        for candidate in all(&automaton, &contexts, (at, explained), next, order) {
            let edited = apply(&automaton, candidate, shown.last, own, &shown.segments, parameters)?;
            // A new version takes the place of the old one as what had run, too: their children are the same.
            let reach = edited.reach(origin, own, &contexts).min(goal);
            built.push((candidate, edited, reach));
        }
        let count = built.len();
        let reach = built.iter().map(|(.., reach)| *reach).max().unwrap_or(0);
        if reach <= explained {
            return Err(problem("no edit makes the next segment of the correction possible"));
        }
        built.retain(|(.., own)| *own == reach);
        sequences.truncate(own);
        sequences.push(StarhmmSequence {
            origin,
            entry_features: shown.entry_features.clone(),
            steps: shown.segments[..reach.min(contexts.len())].concat(),
            ends: reach > contexts.len(),
        });
        let mut round = Round { reach, impossible: count - built.len(), evaluations: Vec::new(), chosen: None };
        let mut best: Option<(f64, Automaton)> = None;
        for (candidate, mut edited, _) in built {
            let evaluation = evaluate(candidate, &mut edited, &sequences, parameters, counters)?;
            if let Some(criterion) = evaluation.criterion
                && best.as_ref().is_none_or(|(least, _)| criterion < least - MARGIN)
            {
                best = Some((criterion, edited));
                round.chosen = Some(candidate);
            }
            round.evaluations.push(evaluation);
        }
        let criteria: Vec<Option<f64>> = round.evaluations.iter().map(|evaluation| evaluation.criterion).collect();
        for (evaluation, weight) in round.evaluations.iter_mut().zip(akaike_weights(&criteria)) {
            evaluation.weight = weight;
        }
        if let Some(Candidate::Node { .. }) = round.chosen {
            next = NodeId(next.0 + 1);
        }
        rounds.push(round);
        let Some((_, winner)) = best else { return Ok(Plan { rounds, nodes: None }) };
        automaton = winner;
        let nodes = placed(&automaton, own, &sequences[own], &shown.segments)?;
        (explained, at) = (reach, nodes.last().map_or(at, |id| Place::Node(*id)));
        if reach == goal {
            return Ok(Plan { rounds, nodes: Some(nodes) });
        }
    }
}

/// A model fitted to these sequences, the work counted.
fn fitted(
    model: Starhmm,
    sequences: &[StarhmmSequence],
    parameters: &ItmcdParameters,
    counters: &mut Counters,
) -> Result<StarhmmFit, SituError> {
    let fit = model.fit(sequences, &parameters.fit).map_err(problem)?;
    let steps: usize = sequences.iter().map(|sequence| sequence.steps.len()).sum();
    counters.hmm_fits += 1;
    counters.em_iterations += fit.iterations() as u64;
    counters.logistic_steps += fit.logistic_steps as u64;
    counters.segments_touched += (steps / parameters.points) as u64;
    Ok(fit)
}

/// Fits a candidate, where it is not too large for the data.
fn evaluate(
    candidate: Candidate,
    edited: &mut Automaton,
    sequences: &[StarhmmSequence],
    parameters: &ItmcdParameters,
    counters: &mut Counters,
) -> Result<CandidateEvaluation, SituError> {
    let k = edited.model.free_parameters();
    let n = sequences.iter().flat_map(|sequence| &sequence.steps).map(|step| step.target.len()).sum();
    let mut evaluation = CandidateEvaluation {
        candidate,
        parameters: k,
        observations: n,
        log_likelihood: None,
        criterion: None,
        weight: 0.0,
    };
    if corrected_akaike(0.0, k, n).is_some() {
        let fit = fitted(edited.model.clone(), sequences, parameters, counters)?;
        evaluation.log_likelihood = Some(fit.log_likelihood());
        evaluation.criterion = corrected_akaike(fit.log_likelihood(), k, n);
        edited.model = fit.model;
    }
    Ok(evaluation)
}

/// The node of each segment on the most probable path, whose phases end with a segment or not at all.
fn placed(
    automaton: &Automaton,
    index: usize,
    sequence: &StarhmmSequence,
    segments: &[Vec<StarhmmStep>],
) -> Result<Vec<NodeId>, SituError> {
    let path = automaton.model.most_probable_path(index, sequence).map_err(problem)?;
    let mut firsts = segments.iter().scan(0, |next, steps| Some(std::mem::replace(next, *next + steps.len())));
    let phases = std::iter::from_fn(|| path.get(firsts.next()?));
    phases.map(|phase| automaton.node_of(*phase).ok_or_else(|| problem("a phase without a node"))).collect()
}
