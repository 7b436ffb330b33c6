//! Corrections folded in: SITU, and the one driver of every method whose corrections end in Algorithm 2.

use crate::correction::Correction;
use crate::decisions::Decisions;
use crate::error::SituError;
use crate::place::{Place, SegmentId};
use crate::placement::{ByPolicy, Placement};
use crate::primitive::Learner;
use crate::segmentation::by_reference_object;
use crate::task_model::{History, TaskModel};
use crate::trace::Trace;
use crate::trail::StepEnd;
use crate::update::Update;

/// SITU: folds a correction into a task model, all of it or nothing.
///
/// The cost depends on the applicable primitives and their neighbours, and with decision D10 on the primitives of one
/// object. Only the scan of A1.6 grows with the rest of the model.
///
/// # Errors
/// Where the last primitive is END or not in the model, the interrupted one is not in the model, or the learner refuses
/// a segment. The model is then as it was before.
pub fn situ<L: Learner>(
    correction: Correction<'_>,
    model: &mut TaskModel<L>,
    learner: &L,
    decisions: &Decisions,
) -> Result<Trace, SituError> {
    let history = model.history(&correction, by_reference_object(correction.demonstration))?;
    fold(correction, history, model, learner, decisions, &mut ByPolicy)
}

/// Folds a correction in by Algorithms 1 and 2, all of it or nothing. `history` is the correction as the model writes
/// it down ([`TaskModel::history`]); `placement` decides where its segments belong.
///
/// # Errors
/// Where the learner refuses a segment. The model is then as it was before.
pub fn fold<L: Learner, P: Placement<L>>(
    correction: Correction<'_>,
    history: History,
    model: &mut TaskModel<L>,
    learner: &L,
    decisions: &Decisions,
    placement: &mut P,
) -> Result<Trace, SituError> {
    model.all_or_nothing(|model| {
        let mut update = Update::new(model, learner, decisions);
        update.fold(correction.last, history, placement)?;
        Ok(update.into_trace())
    })
}

impl<L: Learner> Update<'_, L> {
    /// Folds a demonstration in that was given after `last`.
    ///
    /// # Errors
    /// Where the learner refuses a segment. The model is then half-way.
    pub(crate) fn fold<P: Placement<L>>(
        &mut self,
        last: Place,
        history: History,
        placement: &mut P,
    ) -> Result<(), SituError> {
        let demonstration = self.model.histories().len() as u32;
        let carried_to_end = history.carried_to_end;
        let trail = if self.decisions.trail { history.trail } else { Vec::new() };
        let node = |segment: SegmentId| self.model.node_of(segment);
        self.last = last;
        self.interrupted = history.interrupted.and_then(node);
        let prevented = trail.last().filter(|step| step.end == StepEnd::Prevented);
        self.prevented = prevented.and_then(|step| node(step.of));
        let segments = self.model.begin(History { trail, ..history });
        let a = self.situ(last, &segments, placement)?;
        if carried_to_end {
            self.end(a, demonstration)?; // D11
        }
        if self.decisions.obey {
            self.obey(demonstration)?; // D22
        }
        Ok(())
    }
}
