//! One run in physics.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use situ::edit::Edit;
use situ::structure::Structure;

use super::correction::CorrectionRecord;
use super::effort::TotalEffort;
use super::key::Key;
use super::outcome::Outcome;
use super::rate::Rate;

/// The corrected model against the pooled one: what `rebuild` makes of the same demonstrations at once.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pooled {
    /// Success of the corrected model on the changed task, from starts that did not decide about any correction.
    pub separate: Rate,
    /// Success of the pooled model, from the same starts.
    #[serde(rename = "joint")]
    pub pooled: Rate,
    /// Success of the pooled model on the original task, from the starts of [`RunRecord::retained`].
    pub retained: Rate,
    /// The structure of the pooled model.
    pub structure: Option<Structure>,
}

/// One run in physics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunRecord {
    /// Which run.
    pub key: Key,
    /// How it ended.
    pub outcome: Outcome,
    /// The effort of teaching the original task.
    pub original: TotalEffort,
    /// Success of the original model on the changed task.
    pub before: Option<Rate>,
    /// Success on the changed task at the end.
    pub after: Option<Rate>,
    /// Corrective (or from-scratch) demonstrations until the target was reached or the budget used up.
    pub effort: TotalEffort,
    /// The corrections in order.
    pub corrections: Vec<CorrectionRecord>,
    /// How the last evaluation's rollouts ended, by name.
    pub ended: BTreeMap<String, u32>,
    /// Success on the original task before the corrections.
    pub original_rate: Option<Rate>,
    /// Success on the original task after the corrections, from the same starts as before.
    pub retained: Option<Rate>,
    /// The structure of the corrected model, against what the teacher meant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub structure: Option<Structure>,
    /// The comparison with the pooled model, where the protocol asks for it and there was a correction.
    #[serde(default, rename = "joint", skip_serializing_if = "Option::is_none")]
    pub pooled: Option<Pooled>,
    /// In a sequence: success on the variations of the earlier stages, after this one.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub earlier: BTreeMap<String, Rate>,
}

impl RunRecord {
    /// Whether the target was reached.
    pub fn is_reached(&self) -> bool {
        self.outcome == Outcome::Reached
    }

    /// The edit that each correction made.
    pub fn edits_made(&self) -> impl Iterator<Item = Edit> {
        self.corrections.iter().map(|correction| correction.edit_made)
    }
}
