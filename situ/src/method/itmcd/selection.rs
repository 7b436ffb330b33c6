//! The search for the edit that explains a correction best.
//!
//! Every candidate is fitted to all data, original and corrective, and the smallest AICc wins. One edit explains most
//! corrections. If no edit makes the whole correction possible, those that make the longest part of it possible, in
//! segments, are compared on that part. Then the search continues from there, so a correction can bring several edits.

use serde::Serialize;

use super::automaton::{Automaton, problem};
use super::candidate::{Candidate, all, apply};
use super::parameters::ItmcdParameters;
use super::starhmm::{Starhmm, StarhmmFit, StarhmmSequence, StarhmmStep};
use crate::error::SituError;
use crate::place::{NodeId, Place};
use crate::trace::Counters;

/// A candidate must be better than an earlier one by more than this. A smaller difference is rounding.
const MARGIN: f64 = 1e-6;

/// The result for one candidate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CandidateEvaluation {
    /// The edit.
    pub candidate: Candidate,
    /// k, the free parameters of the whole model.
    pub parameters: usize,
    /// n, the scalar observations that it was compared on.
    pub observations: usize,
    /// log L, nats. `None` if the candidate was refused, as it was not fitted.
    pub log_likelihood: Option<f64>,
    /// AICc. `None` if the candidate is refused, because n ≤ k + 1.
    pub criterion: Option<f64>,
    /// Its Akaike weight among the candidates of the round.
    pub weight: f64,
}

/// One round of the search.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Round {
    /// The segments of the correction that the winner makes possible. END counts as one more.
    pub reach: usize,
    /// The number of candidates that make less possible. They are not fitted.
    pub impossible: usize,
    /// The other candidates, in order.
    pub evaluations: Vec<CandidateEvaluation>,
    /// The winner. `None` if every candidate is refused.
    pub chosen: Option<Candidate>,
}

impl Round {
    /// Fits and weighs these candidates, which reach equally far. Returns the winner's automaton.
    fn compare(
        &mut self,
        built: Vec<(Candidate, Automaton, usize)>,
        sequences: &[StarhmmSequence],
        parameters: &ItmcdParameters,
        counters: &mut Counters,
    ) -> Result<Option<Automaton>, SituError> {
        let mut best: Option<(f64, Automaton)> = None;
        for (candidate, mut edited, _) in built {
            let evaluation = evaluate(candidate, &mut edited, sequences, parameters, counters)?;
            if let Some(criterion) = evaluation.criterion
                && best.as_ref().is_none_or(|(least, _)| criterion < least - MARGIN)
            {
                best = Some((criterion, edited));
                self.chosen = Some(candidate);
            }
            self.evaluations.push(evaluation);
        }
        let criteria: Vec<Option<f64>> = self.evaluations.iter().map(|evaluation| evaluation.criterion).collect();
        for (evaluation, weight) in self.evaluations.iter_mut().zip(akaike_weights(&criteria)) {
            evaluation.weight = weight;
        }
        Ok(best.map(|(_, automaton)| automaton))
    }
}

/// A correction as the search sees it.
pub(super) struct Shown {
    /// What ran before it.
    pub(super) last: Place,
    /// ψ of its first state.
    pub(super) entry_features: Vec<f64>,
    /// The steps of each segment.
    pub(super) segments: Vec<Vec<StarhmmStep>>,
    /// Whether it was carried on to the end.
    pub(super) ends: bool,
    /// For each segment, the places that can come after it, the most plausible first.
    pub(super) order: Vec<Vec<Place>>,
}

/// The result of the search.
pub(super) struct Plan {
    pub(super) rounds: Vec<Round>,
    /// The node of each segment. `None` if every candidate of a round was refused.
    pub(super) nodes: Option<Vec<NodeId>>,
}

impl Plan {
    pub(super) fn edits(&self) -> impl Iterator<Item = Candidate> {
        self.rounds.iter().filter_map(|round| round.chosen)
    }
}

/// Searches for the edits. `sequences` are those of the histories; `next` is the id for the first node that is added.
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
            // If what ran last gets a new version, that version has the same children, so `origin` still holds.
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
        let winner = round.compare(built, &sequences, parameters, counters)?;
        if let Some(Candidate::Node { .. }) = round.chosen {
            next = NodeId(next.0 + 1);
        }
        rounds.push(round);
        let Some(winner) = winner else { return Ok(Plan { rounds, nodes: None }) };
        automaton = winner;
        let nodes = placed(&automaton, own, &sequences[own], &shown.segments)?;
        (explained, at) = (reach, nodes.last().map_or(at, |id| Place::Node(*id)));
        if reach == goal {
            return Ok(Plan { rounds, nodes: Some(nodes) });
        }
    }
}

/// Fits a model to these sequences and counts the work.
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

/// Fits a candidate if it is not too large for the data.
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

/// The node of each segment on the most probable path. A phase on it ends only where a segment ends.
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

/// AICc = 2k − 2 log L + 2k(k + 1)/(n − k − 1), for k free parameters and n scalar observations. The smaller, the
/// better.
///
/// `None` if n ≤ k + 1: there the correction has no value, and the model cannot be chosen. Infinite if the data are
/// impossible.
pub fn corrected_akaike(log_likelihood: f64, parameters: usize, observations: usize) -> Option<f64> {
    let rest = observations.checked_sub(parameters + 1).filter(|rest| *rest > 0)?;
    let k = parameters as f64;
    Some(2.0 * k - 2.0 * log_likelihood + 2.0 * k * (k + 1.0) / rest as f64)
}

/// exp(−½ Δ) of each criterion over their sum, where Δ is the difference to the smallest: how much support each
/// candidate has. It is 0 for a candidate that is refused or impossible. If that is so for every candidate, all are 0.
pub fn akaike_weights(criteria: &[Option<f64>]) -> Vec<f64> {
    let least = criteria.iter().flatten().copied().filter(|value| value.is_finite()).reduce(f64::min);
    let Some(least) = least else { return vec![0.0; criteria.len()] };
    let support = |value: &Option<f64>| value.map_or(0.0, |value| libm::exp(-0.5 * (value - least)));
    let supports: Vec<f64> = criteria.iter().map(support).collect();
    let total: f64 = supports.iter().sum();
    supports.into_iter().map(|support| support / total).collect()
}
