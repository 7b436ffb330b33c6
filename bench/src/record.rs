//! One line of the ledger: a run in physics, or the cost of an update of a synthetic automaton.
//!
//! Every field is a function of the protocol, the key and the code. Only the fields named `update_seconds` hold the
//! clock. [`Record::without_times`] sets those to 0, so that two ledgers can be compared byte for byte.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::{Deserialize, Serialize};
use situ::edit::Edit;
use situ::method::Method;
use situ::structure::Structure;
use situ::trace::Counters;
use situ_tasks::{NeededEdit, ORIGINAL, Setting};

use crate::calibration::BranchCalibration;
use crate::correction_record::CorrectionRecord;
use crate::grade::Grade;
use crate::held_out::HeldOut;
use crate::tally::{Rate, TotalEffort, count, is_zero};

/// The version of the ledger's lines.
pub const SCHEMA: u64 = 2;

/// A line of the ledger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
#[expect(clippy::large_enum_variant, reason = "nearly all records are runs: boxes would save no memory")]
pub enum Record {
    /// One run in physics.
    Run(RunRecord),
    /// One update of a synthetic automaton.
    Cost(CostRecord),
}

impl Record {
    /// The run, where it is one and stands alone: no stage of a sequence, whose model has seen other changes before.
    pub fn single_run(&self) -> Option<&RunRecord> {
        match self {
            Self::Run(run) if run.key.stage.is_none() => Some(run),
            _ => None,
        }
    }

    /// The name that no other record has; it gives the order of a canonical ledger.
    pub fn identity(&self) -> Identity {
        match self {
            Self::Run(run) => Identity::Run(run.key.clone()),
            Self::Cost(cost) => cost.identity(),
        }
    }

    /// Whether it says what it was made of, where that is no matter of names alone.
    pub fn has_content(&self) -> bool {
        matches!(self, Self::Cost(_)) || matches!(self, Self::Run(run) if !run.key.content.is_empty())
    }

    /// The same record without what it was made of.
    pub fn without_content(mut self) -> Self {
        if let Self::Run(run) = &mut self {
            run.key.content.clear();
        }
        self
    }

    /// The same record with its clock times set to 0. Two runs of one protocol must not differ in it.
    pub fn without_times(&self) -> Self {
        let mut record = self.clone();
        match &mut record {
            Self::Run(run) => run.corrections.iter_mut().for_each(|correction| correction.update_seconds = 0.0),
            Self::Cost(cost) => cost.update_seconds = 0.0,
        }
        record
    }
}

/// Names a run: the cell (task × edit × method × teacher) and the seed.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Key {
    /// The protocol.
    pub protocol: String,
    /// The task.
    pub task: String,
    /// How the task was changed; in a sequence it may be `original`, what was changed is undone.
    pub variation: String,
    /// The edit that the variation needs.
    pub edit: Edit,
    /// The teacher's profile.
    pub teacher: String,
    /// The method.
    pub method: String,
    /// The seed of the run.
    pub seed: u64,
    /// The stage, where the run is one of a sequence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stage: Option<Stage>,
    /// What these names stand for ([`crate::content`]); empty in ledgers that do not say.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub content: String,
}

impl Key {
    /// The name of a run of a method on a setting.
    pub fn of(protocol: &str, setting: &Setting, teacher: &str, method: &dyn Method, seed: u64) -> Self {
        Self {
            protocol: protocol.to_owned(),
            task: setting.task.clone(),
            variation: setting.variation.clone().unwrap_or_else(|| ORIGINAL.to_owned()),
            edit: needed(setting),
            teacher: teacher.to_owned(),
            method: method.name().to_owned(),
            seed,
            stage: None,
            content: String::new(),
        }
    }

    /// The same, made of this.
    #[must_use]
    pub fn made_of(self, content: &str) -> Self {
        Self { content: content.to_owned(), ..self }
    }

    /// The same in a sequence, at this index of it.
    #[must_use]
    pub fn at(self, sequence: &str, index: usize) -> Self {
        Self { stage: Some(Stage { sequence: sequence.to_owned(), number: index as u32 + 1 }), ..self }
    }
}

/// The edit that a setting says it needs, in the learner's words.
fn needed(setting: &Setting) -> Edit {
    match setting.edit {
        NeededEdit::NodeAddition => Edit::NodeAddition,
        NeededEdit::EdgeAddition => Edit::EdgeAddition,
        NeededEdit::NodeModification => Edit::NodeModification,
        NeededEdit::None => Edit::None,
    }
}

/// A stage of a sequence of variations. Each is met with the model that the one before left.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stage {
    /// The sequence.
    pub sequence: String,
    /// The place in it, from 1.
    pub number: u32,
}

/// Names a record among all records: no two records of a ledger share it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Identity {
    /// A run in physics.
    Run(Key),
    /// An update of a synthetic automaton.
    Cost {
        /// The protocol.
        protocol: String,
        /// The series of the protocol.
        series: String,
        /// The method.
        method: String,
        /// The edit that was planted.
        edit: Edit,
        /// Nodes of the automaton.
        nodes: u32,
        /// Its original demonstrations.
        originals: u32,
        /// The seed of the automaton.
        seed: u64,
        /// The number of the correction.
        correction: u32,
    },
}

impl Identity {
    /// The names alone, whatever they stood for.
    #[must_use]
    pub fn names(self) -> Self {
        match self {
            Self::Run(key) => Self::Run(Key { content: String::new(), ..key }),
            cost @ Self::Cost { .. } => cost,
        }
    }

    /// The method.
    pub fn method(&self) -> &str {
        match self {
            Self::Run(key) => &key.method,
            Self::Cost { method, .. } => method,
        }
    }
}

impl fmt::Display for Identity {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Run(Key { protocol, task, variation, teacher, method, seed, stage, edit: _, content: _ }) => {
                write!(formatter, "{protocol}, {task}/{variation}")?;
                if let Some(Stage { sequence, number }) = stage {
                    write!(formatter, " (stage {number} of {sequence})")?;
                }
                write!(formatter, ", {teacher}, {method}, seed {seed}")
            }
            Self::Cost { protocol, series, method, edit, nodes, originals, seed, correction } => {
                write!(
                    formatter,
                    "{protocol}, {series}, cost of {edit} at {nodes} nodes and {originals} originals, {method}, \
                     seed {seed}"
                )?;
                if *correction > 0 { write!(formatter, ", correction {correction}") } else { Ok(()) }
            }
        }
    }
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The target success rate was reached within the budget.
    Reached,
    /// The budget was used up first.
    Censored,
    /// The teacher gave up before: it counts as the budget.
    GaveUp {
        /// The reason.
        why: String,
    },
    /// The original task was never learned. Counted apart; it is the same for every method.
    Untaught {
        /// The reason.
        why: String,
    },
    /// Physics failed (a body quarantined, NaN). Counted apart, and never as a failure of the method.
    Spoilt {
        /// The reason.
        why: String,
    },
    /// The method has nothing to do in this cell.
    NotApplicable,
    /// The method refused what it was given. It counts as the budget, and as no success.
    MethodError {
        /// The method's words.
        why: String,
    },
    /// The run went on for too long. It counts as the budget, and as no success.
    TimedOut {
        /// What went on.
        why: String,
    },
    /// The program panicked. It counts as the budget, and as no success.
    Panicked {
        /// The message.
        why: String,
    },
}

impl Outcome {
    /// Whether the run says something about the method: it reached the target or did not.
    pub fn counts(&self) -> bool {
        matches!(self, Self::Reached | Self::Censored | Self::GaveUp { .. }) || self.is_failure()
    }

    /// Why it ended so, in words; `None` where nothing is to be said.
    pub fn why(&self) -> Option<&str> {
        match self {
            Self::GaveUp { why }
            | Self::Untaught { why }
            | Self::Spoilt { why }
            | Self::MethodError { why }
            | Self::TimedOut { why }
            | Self::Panicked { why } => Some(why),
            Self::Reached | Self::Censored | Self::NotApplicable => None,
        }
    }

    /// Whether the run was not done to its end, and the sweep went on.
    pub fn is_failure(&self) -> bool {
        matches!(self, Self::MethodError { .. } | Self::TimedOut { .. } | Self::Panicked { .. })
    }
}

/// The corrected model against the pooled one: what `rebuild` makes of the same demonstrations at once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pooled {
    /// Success of the pooled model on the changed task, from the starts of [`RunRecord::after`].
    #[serde(rename = "joint")]
    pub pooled: Rate,
    /// Success of the pooled model on the original task, from the starts of [`RunRecord::retained`].
    pub retained: Rate,
    /// The structure of the pooled model.
    pub structure: Option<Structure>,
    /// Its likelihood of the demonstration of [`RunRecord::held_out`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_out: Option<HeldOut>,
}

/// One run in physics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunRecord {
    /// Which run.
    pub key: Key,
    /// How it ended.
    pub outcome: Outcome,
    /// Whether the edge that is needed leads from a skill to itself: a retry.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub self_loop: bool,
    /// Its place in a series of graded changes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grade: Option<Grade>,
    /// Demonstrations at the most, corrective or from scratch.
    pub budget: u32,
    /// The success rate at which teaching ends, above 0 and at most 1.
    pub target: f64,
    /// The effort of teaching the original task.
    pub original: TotalEffort,
    /// Success of the original model on the changed task, from fresh starts: no rollout from them has decided anything.
    pub before: Option<Rate>,
    /// Success on the changed task at the end, from the same starts.
    pub after: Option<Rate>,
    /// Corrective (or from-scratch) demonstrations until the target was reached or the budget used up.
    pub effort: TotalEffort,
    /// The corrections in order.
    pub corrections: Vec<CorrectionRecord>,
    /// How the rollouts of `after` ended, by name.
    pub ended: BTreeMap<String, u32>,
    /// Success on the original task before the corrections, from fresh starts.
    pub original_rate: Option<Rate>,
    /// Success on the original task after the corrections, from the same starts.
    pub retained: Option<Rate>,
    /// The structure of the last model, against what the teacher meant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub structure: Option<Structure>,
    /// The comparison with the pooled model, where the protocol asks for it and there was a correction.
    #[serde(default, rename = "joint", skip_serializing_if = "Option::is_none")]
    pub pooled: Option<Pooled>,
    /// The calibration at the branches of the rollouts of `after`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<BranchCalibration>,
    /// The likelihood of a demonstration of the changed task that was given to nobody.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_out: Option<HeldOut>,
    /// In a sequence: success on each variation of the earlier stages, after this one. This stage's own is not among
    /// them, where it comes again: it is [`Self::after`].
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub earlier: BTreeMap<String, Rate>,
}

impl RunRecord {
    /// Whether the target was reached.
    pub fn is_reached(&self) -> bool {
        self.outcome == Outcome::Reached
    }

    /// Whether it says something about a method, and the task needs an edit.
    pub fn counts_for_an_edit(&self) -> bool {
        self.outcome.counts() && self.key.edit != Edit::None
    }

    /// Wall-clock seconds of an update, the mean; `None` where there was none.
    pub fn update_seconds(&self) -> Option<f64> {
        let seconds: f64 = self.corrections.iter().map(|correction| correction.update_seconds).sum();
        (!self.corrections.is_empty()).then(|| seconds / self.corrections.len() as f64)
    }

    /// Whether a success rate meets the target.
    fn is_met_by(&self, rate: Rate) -> bool {
        f64::from(rate.successes) >= self.target * f64::from(rate.rollouts)
    }

    /// Whether the rollouts that decided reached the target, and fewer did from fresh starts.
    pub fn is_reached_by_luck(&self) -> bool {
        self.is_reached() && self.after.is_some_and(|rate| !self.is_met_by(rate))
    }

    /// The first correction whose demonstration shows what changed.
    pub fn first_to_show(&self) -> Option<&CorrectionRecord> {
        self.corrections.iter().find(|correction| correction.shows_change)
    }

    /// The set of edits that all corrections made together; [`Edit::None`] where they made none. Empty where there was
    /// no correction.
    pub fn edits(&self) -> BTreeSet<Edit> {
        let mut edits: BTreeSet<Edit> = self.corrections.iter().flat_map(CorrectionRecord::edits).collect();
        if edits.len() > 1 {
            edits.remove(&Edit::None);
        }
        edits
    }

    /// In a sequence: success, after this stage, on what a stage before or this one had; `None` where it was no such.
    pub fn success_on(&self, variation: &str) -> Option<Rate> {
        match variation {
            own if own == self.key.variation => self.after,
            ORIGINAL => self.retained,
            earlier => self.earlier.get(earlier).copied(),
        }
    }

    /// In a sequence: how many of the tasks so far are kept, and of how many. They are the original, this stage's and
    /// those of the stages before, each once. One is kept where success on it, from fresh starts, meets the target.
    pub fn kept(&self) -> (u32, u32) {
        let own = (self.key.variation != ORIGINAL).then_some(self.after).flatten();
        let rates = self.earlier.values().copied().chain(self.retained).chain(own);
        let rates: Vec<Rate> = rates.collect();
        let kept = rates.iter().filter(|rate| rate.rollouts > 0 && self.is_met_by(**rate));
        (count(kept.count()), count(rates.len()))
    }

    /// What counts as the demonstrations that it took: the budget, where the target was not reached.
    pub fn charged(&self) -> u32 {
        if self.is_reached() { self.effort.demonstrations } else { self.budget }
    }
}

/// One update of a synthetic automaton.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CostRecord {
    /// The protocol.
    pub protocol: String,
    /// The series of the protocol.
    pub series: String,
    /// The method.
    pub method: String,
    /// Nodes of the automaton before the update.
    pub nodes: u32,
    /// Original demonstrations that taught it.
    pub originals: u32,
    /// The edit that was planted.
    pub edit: Edit,
    /// The seed of the automaton. Together with the number of the correction it is the seed of the correction.
    pub seed: u64,
    /// The number of the correction among those of the same edit; left out where it is 0, the first.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub correction: u32,
    /// |Z| at each step.
    pub applicable: Vec<u32>,
    /// |T| at each step.
    pub model_size: Vec<u32>,
    /// The exact work of the update.
    pub counters: Counters,
    /// The edit that the method made.
    pub edit_made: Edit,
    /// Wall-clock seconds of the update: the only clock.
    pub update_seconds: f64,
}

impl CostRecord {
    /// The name that no other record has.
    pub fn identity(&self) -> Identity {
        Identity::Cost {
            protocol: self.protocol.clone(),
            series: self.series.clone(),
            method: self.method.clone(),
            edit: self.edit,
            nodes: self.nodes,
            originals: self.originals,
            seed: self.seed,
            correction: self.correction,
        }
    }
}
