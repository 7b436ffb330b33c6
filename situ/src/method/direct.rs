//! Updates that do not search for what a segment is: they add it always (`append_only`), are told (`oracle_edit`), or listen to the
//! teacher (`narrated_hierarchy`). What follows from it is Algorithm 2 from line 5 on, as in SITU.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::rebuild::assemble;
use crate::correction::{Correction, Told};
use crate::decisions::Decisions;
use crate::demonstration::{Demonstration, Kind, SEVERAL, Schema, Segment};
use crate::error::SituError;
use crate::keyframe::learner::KeyframeLearner;
use crate::keyframe::parameters::KeyframeParameters;
use crate::place::Place;
use crate::primitive::Learner;
use crate::segmentation::by_narration;
use crate::situ::{Target, commit, end};
use crate::task_model::{History, TaskModel};
use crate::trace::{Counters, MatchedIn, Step, Trace};

/// How a segment finds its primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// It never does: each segment is a new primitive. What clustering saves, made visible.
    Append,
    /// By the teacher's name for it, and by being told which skills the task wants done in another way (Kappler et al. 2015: a graph
    /// specified by hand): the upper bound of SITU's decisions about structure.
    Told,
    /// By the teacher's name for it (Mohseni-Kabir et al. 2015). Whatever is shown again under a name replaces what was shown before.
    Narrated,
}

/// What a rule needs of a demonstration, in the words of an error.
const NARRATION: &str = "listens to the teacher, so every keyframe needs a narration";
/// See [`NARRATION`].
const TOLD: &str = "must be told which skills have changed";

/// Checks that a demonstration says what the rule has to hear.
///
/// # Errors
/// [`SituError::Untold`].
pub(super) fn check(
    rule: Rule,
    method: &'static str,
    demonstration: &Demonstration,
    told: Option<&Told>,
) -> Result<(), SituError> {
    let is_silent = demonstration.keyframes().iter().any(|keyframe| keyframe.narration.is_none());
    let missing = match rule {
        Rule::Told | Rule::Narrated if is_silent => NARRATION,
        Rule::Told if demonstration.kind() == Kind::Corrective && told.is_none() => TOLD,
        _ => return Ok(()),
    };
    Err(SituError::Untold { demonstration: demonstration.name().to_string(), method, missing })
}

/// What a segment shows, as the rule knows it: its object, and the teacher's name for it; nothing where the rule does not listen.
type Name = (Arc<str>, Arc<str>);

/// See [`Name`].
fn name(rule: Rule, segment: &Segment) -> Option<Name> {
    let narration = segment.narration.as_ref().filter(|_| rule != Rule::Append);
    narration.map(|narration| (segment.reference.clone(), narration.clone()))
}

/// Folds a correction in, which was [`check`]ed; `segments` are those of its demonstration.
///
/// # Errors
/// Where the last primitive cannot have run, or the learner refuses a segment: the model is lost then.
pub(super) fn fold<L: Learner>(
    rule: Rule,
    correction: Correction<'_>,
    segments: Vec<Segment>,
    mut model: TaskModel<L>,
    learner: &L,
    decisions: &Decisions,
) -> Result<(TaskModel<L>, Trace), SituError> {
    let Correction { last, demonstration, told, .. } = correction;
    let mut trace = Trace::default();
    let mut named = BTreeMap::new();
    for history in model.histories() {
        // The last that was called so is what the name means.
        let placed = history.segments.iter().zip(&history.nodes);
        named.extend(placed.filter_map(|(segment, node)| Some((name(rule, segment)?, *node))));
    }
    let origin = model.origin(last)?;
    let mut a = last;
    for d in model.begin(History::new(demonstration, segments, origin)) {
        let segment = model.segment(d).clone();
        let mut counters = Counters::default();
        let model_size = model.len();
        let name = name(rule, &segment);
        let mut own = || learner.fit_policy(&[&segment], &mut counters);
        let target = match name.as_ref().and_then(|name| named.get(name).copied()) {
            None => Target::New(own()?),
            Some(z) if rule == Rule::Narrated || told.is_some_and(|told| changes(told, &segment)) => {
                Target::Modify(z, own()?)
            }
            Some(z) => Target::Existing(z),
        };
        let branch = target.branch();
        let (z, edge_added) = commit(a, d, target, &mut model, learner, decisions, &mut counters)?;
        named.extend(name.map(|name| (name, z)));
        trace.counters += counters;
        trace.steps.push(Step {
            reference: segment.reference.to_string(),
            applicable: 0,
            model_size,
            candidates: 0,
            matched_in: MatchedIn::None,
            branch,
            node: z,
            after: a,
            edge_added,
            merged: Vec::new(),
            counters,
        });
        a = Place::Node(z);
    }
    if demonstration.carried_to_end() {
        let index = model.histories().len() as u32 - 1;
        end(a, index, &mut model, learner, decisions, &mut trace.counters)?;
    }
    Ok((model, trace))
}

/// Whether one of the skills that a segment shows is among those that have changed.
fn changes(told: &Told, segment: &Segment) -> bool {
    segment.narration.iter().flat_map(|names| names.split(SEVERAL)).any(|name| told.changed.contains(name))
}

/// An automaton whose primitives are the names that the teacher gave, each on its object; the demonstrations were [`check`]ed.
///
/// # Errors
/// [`SituError::NoDemonstration`], or where the learner refuses a segment.
pub(super) fn named_automaton(
    schema: &Schema,
    demonstrations: &[Demonstration],
) -> Result<TaskModel<KeyframeLearner>, SituError> {
    if demonstrations.is_empty() {
        return Err(SituError::NoDemonstration);
    }
    let histories: Vec<History> =
        demonstrations.iter().map(|shown| History::new(shown, by_narration(shown), None)).collect();
    // In order of first appearance.
    let mut known = BTreeMap::new();
    let segments = histories.iter().flat_map(|history| &history.segments);
    let labels: Vec<usize> = segments
        .map(|segment| {
            let next = known.len();
            *known.entry(name(Rule::Narrated, segment)).or_insert(next)
        })
        .collect();
    let learner = KeyframeLearner::new(schema, KeyframeParameters::default());
    // No segment is ever compared with another, so the cut is never asked for.
    let calibration = learner.calibrate(&[], &mut Counters::default())?;
    Ok(assemble(histories, &labels, calibration, &learner, &Decisions::mended(), Counters::default())?.0)
}
