//! Updates that do not search for the primitive that a segment belongs to: they always add one (`append_only`), are
//! told (`oracle_edit`), or listen to the teacher (`narrated_hierarchy`). The rest is Algorithm 2 from line 5 on, as in
//! SITU.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::rebuild::assemble;
use crate::correction::Oracle;
use crate::decisions::Decisions;
use crate::demonstration::{Demonstration, Kind};
use crate::error::SituError;
use crate::keyframe::learner::KeyframeLearner;
use crate::keyframe::parameters::KeyframeParameters;
use crate::matching::{Match, Shows};
use crate::place::{NodeId, Place, SampleId, SegmentId};
use crate::placement::Placement;
use crate::primitive::Learner;
use crate::segment::Segment;
use crate::segmentation::by_narration;
use crate::state::Schema;
use crate::task_model::{History, TaskModel};
use crate::trace::Counters;
use crate::update::Update;

/// How a segment finds its primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// It never does: each segment is a new primitive. So the tables show what clustering saves.
    Append,
    /// By the teacher's name for it; an oracle says which skills the task wants done in another way (Kappler et al.
    /// 2015: a graph specified by hand). It is the upper bound of SITU's decisions about structure.
    Oracle,
    /// By the teacher's name for it (Mohseni-Kabir et al. 2015). What is shown again under a name replaces what was
    /// shown before.
    Narrated,
}

/// What a rule needs of a demonstration, in the words of an error.
const NARRATION: &str = "listens to the teacher, so every keyframe needs a narration";
/// The same for the rule that listens to an oracle.
const ORACLE: &str = "must be told which skills have changed";

/// Checks that a demonstration says what the rule has to hear.
///
/// # Errors
/// [`SituError::Silent`].
pub(super) fn check(
    rule: Rule,
    method: &str,
    demonstration: &Demonstration,
    oracle: Option<&Oracle>,
) -> Result<(), SituError> {
    let is_silent = demonstration.keyframes().iter().any(|keyframe| keyframe.narration.is_none());
    let missing = match rule {
        Rule::Oracle | Rule::Narrated if is_silent => NARRATION,
        Rule::Oracle if demonstration.kind() == Kind::Corrective && oracle.is_none() => ORACLE,
        _ => return Ok(()),
    };
    Err(SituError::Silent { demonstration: demonstration.name().to_string(), method: method.to_owned(), missing })
}

/// What a segment shows, as a rule knows it: its object, and the teacher's names for it.
type Name = (Arc<str>, Vec<Arc<str>>);

/// The name of a segment; `None` where it has none, or the rule does not listen.
fn name(rule: Rule, segment: &Segment) -> Option<Name> {
    let is_heard = rule != Rule::Append && !segment.narration.is_empty();
    is_heard.then(|| (segment.reference.clone(), segment.narration.clone()))
}

/// Where a segment belongs by a rule.
pub(super) struct Direct<'a> {
    rule: Rule,
    oracle: Option<&'a Oracle>,
    /// The primitive that each name means: the last that was called so.
    named: BTreeMap<Name, NodeId>,
}

impl<'a> Direct<'a> {
    /// What the histories of a model say about names.
    pub(super) fn new<L: Learner>(rule: Rule, oracle: Option<&'a Oracle>, model: &TaskModel<L>) -> Self {
        let mut named = BTreeMap::new();
        for history in model.histories() {
            let placed = history.segments.iter().zip(&history.nodes);
            named.extend(placed.filter_map(|(segment, node)| Some((name(rule, segment)?, *node))));
        }
        Self { rule, oracle, named }
    }

    /// Whether what is shown under a known name replaces what was shown before.
    fn replaces(&self, segment: &Segment) -> bool {
        let is_changed = |oracle: &Oracle| segment.narration.iter().any(|name| oracle.changed.contains(name));
        self.rule == Rule::Narrated || self.oracle.is_some_and(is_changed)
    }
}

impl<L: Learner> Placement<L> for Direct<'_> {
    fn applicable(&mut self, _: &mut Update<'_, L>, _: SampleId) -> Vec<NodeId> {
        Vec::new()
    }

    fn find_policy(
        &mut self,
        update: &mut Update<'_, L>,
        _: Place,
        segment: SegmentId,
        _: Option<NodeId>,
    ) -> Result<Option<Match>, SituError> {
        let segment = update.model.segment(segment);
        let Some(name) = name(self.rule, segment) else { return Ok(None) };
        let known = self.named.get(&name).copied();
        // What has no name yet will be the next node.
        self.named.entry(name).or_insert(update.model.next_id());
        let shows = if self.replaces(segment) { Shows::AnotherWay } else { Shows::Way(0) };
        Ok(known.map(|node| Match { node, shows }))
    }
}

/// An automaton with one primitive for each name that the teacher gave, on its object. The demonstrations were
/// [`check`]ed.
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
    // Labels in order of first appearance.
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
