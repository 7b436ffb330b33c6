//! The model of the original task that most methods start from.

use crate::decisions::Decisions;
use crate::demonstration::{Demonstration, Schema};
use crate::error::SituError;
use crate::keyframe::learner::KeyframeLearner;
use crate::keyframe::parameters::KeyframeParameters;
use crate::method::rebuild::rebuild;
use crate::segmentation::by_reference_object;
use crate::task_model::{History, TaskModel};

/// The name of that model: see [`super::Method::original`].
pub const KEYFRAME_AUTOMATON: &str = "keyframe automaton";

/// The automaton of keyframe policies that `rebuild` makes of the original demonstrations with the default kernels and the mended decisions,
/// whatever the method that takes it over at the first correction is set to.
///
/// # Errors
/// As [`super::Method::teach`].
pub(super) fn keyframe_automaton(
    schema: &Schema,
    demonstrations: &[Demonstration],
) -> Result<TaskModel<KeyframeLearner>, SituError> {
    demonstrations.iter().try_for_each(|demonstration| demonstration.check_features(schema.len()))?;
    let histories = demonstrations
        .iter()
        .map(|demonstration| History::new(demonstration, by_reference_object(demonstration), None))
        .collect();
    let learner = KeyframeLearner::new(schema, KeyframeParameters::default());
    Ok(rebuild(histories, None, &learner, &Decisions::mended())?.0)
}
