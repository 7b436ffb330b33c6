//! The methods over keyframe task models: SITU, its literal reading and its ablations, full retraining, and the controls.
//!
//! All share one representation and its kernels, so that a difference between two of them is the update's.

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;

use super::direct::{self, Rule};
use super::original::{KEYFRAME_AUTOMATON, keyframe_automaton};
use super::rebuild::rebuild;
use super::{Learned, Method, Role};
use crate::correction::{Correction, Told};
use crate::decisions::{Background, Candidates, Decisions};
use crate::demonstration::{Demonstration, RelativeKeyframe, Schema, Segment, State};
use crate::error::SituError;
use crate::graph::Graph;
use crate::keyframe::learner::KeyframeLearner;
use crate::keyframe::parameters::{Activation, Compared, Divergence, KeyframeParameters, Lift, Standardisation};
use crate::keyframe::policy::Execution;
use crate::place::{NodeId, Place};
use crate::segmentation::{by_narration, by_reference_object};
use crate::situ::situ;
use crate::task_model::{History, TaskModel};
use crate::trace::Trace;

/// How a correction is folded in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Update {
    /// Algorithms 1 and 2.
    Situ,
    /// Everything anew.
    Rebuild,
    /// Without a search for what a segment is.
    Direct(Rule),
    /// Not at all.
    Nothing,
}

impl Update {
    /// A demonstration cut as the method cuts it.
    fn segments(self, demonstration: &Demonstration) -> Vec<Segment> {
        match self {
            Self::Direct(Rule::Narrated) => by_narration(demonstration),
            _ => by_reference_object(demonstration),
        }
    }

    /// Checks that a demonstration says what the method has to hear.
    fn check(self, method: &'static str, demonstration: &Demonstration, told: Option<&Told>) -> Result<(), SituError> {
        let Self::Direct(rule) = self else { return Ok(()) };
        direct::check(rule, method, demonstration, told)
    }
}

/// A method over keyframe task models.
#[derive(Clone, Copy)]
pub struct KeyframeMethod {
    name: &'static str,
    summary: &'static str,
    source: &'static str,
    role: Role,
    update: Update,
    decisions: fn() -> Decisions,
    parameters: fn() -> KeyframeParameters,
}

const PAPER: &str = "Gutierrez, Short, Niekum and Thomaz 2018";
const OURS: &str = "this project";

/// The methods, in the order of the tables.
pub fn all() -> Vec<KeyframeMethod> {
    let situ = KeyframeMethod {
        name: "situ",
        summary: "state-indexed task updates, the open decisions mended",
        source: PAPER,
        role: Role::Correct,
        update: Update::Situ,
        decisions: Decisions::mended,
        parameters: KeyframeParameters::default,
    };
    let ablation = |name, summary| KeyframeMethod { name, summary, source: OURS, ..situ };
    let decided = |name, summary, decisions| KeyframeMethod { decisions, ..ablation(name, summary) };
    let kernel = |name, summary, parameters| KeyframeMethod { parameters, ..ablation(name, summary) };
    vec![
        situ,
        KeyframeMethod {
            name: "situ:literal",
            summary: "the listing as printed, every mending switched off",
            decisions: Decisions::literal,
            parameters: KeyframeParameters::literal,
            ..situ
        },
        KeyframeMethod {
            name: "rebuild",
            summary: "full retraining on all demonstrations, original and corrective, one global clustering",
            source: OURS,
            update: Update::Rebuild,
            ..situ
        },
        KeyframeMethod {
            name: "from_scratch",
            summary: "rebuild from full demonstrations of the changed task alone",
            source: PAPER,
            role: Role::FromScratch,
            update: Update::Rebuild,
            ..situ
        },
        KeyframeMethod {
            name: "no_update",
            summary: "the original model, never corrected",
            source: OURS,
            role: Role::Control,
            update: Update::Nothing,
            ..situ
        },
        KeyframeMethod {
            name: "append_only",
            summary: "each segment of a correction is a new primitive: nothing is clustered",
            source: OURS,
            update: Update::Direct(Rule::Append),
            ..situ
        },
        KeyframeMethod {
            name: "oracle_edit",
            summary: "told which primitive each segment is and which skills have changed: the upper bound of structure",
            source: "Kappler, Pastor, Kalakrishnan, Wüthrich and Schaal 2015 (reconstruction)",
            update: Update::Direct(Rule::Told),
            ..situ
        },
        KeyframeMethod {
            name: "narrated_hierarchy",
            summary: "steps are what the teacher calls them, and a step shown again replaces the one before",
            source: "Mohseni-Kabir, Rich, Chernova, Sidner and Miller 2015 (reconstruction)",
            update: Update::Direct(Rule::Narrated),
            ..situ
        },
        decided("situ:own_negatives", "D1 as printed: a primitive's positives stay among its negatives", || {
            Decisions { subtract_own_positives: false, ..Decisions::mended() }
        }),
        decided("situ:no_background", "D2 off: no background negatives", || Decisions {
            background: Background { neighbours: false, others: 0 },
            ..Decisions::mended()
        }),
        decided("situ:no_siblings", "D3 off: siblings are not told", || Decisions {
            push_to_siblings: false,
            ..Decisions::mended()
        }),
        decided("situ:no_merge", "D4: redundant candidates are left apart", || Decisions {
            merge_redundant: false,
            ..Decisions::mended()
        }),
        decided("situ:applicable", "D10 as printed: the applicable primitives alone are candidates", || Decisions {
            candidates: Candidates::Applicable,
            ..Decisions::mended()
        }),
        decided("situ:all_nodes", "D10: every primitive is a candidate", || Decisions {
            candidates: Candidates::All,
            ..Decisions::mended()
        }),
        decided("situ:no_modify", "D18 off: an unmatched segment always adds a node", || Decisions {
            modify: None,
            ..Decisions::mended()
        }),
        kernel("situ:fixed_scales", "D16 as designed: one scale a feature for every classifier", || {
            KeyframeParameters { standardisation: Standardisation::Fixed, ..KeyframeParameters::default() }
        }),
        kernel("situ:linear", "D2b: classifiers linear in the state", || KeyframeParameters {
            lift: Lift::Linear,
            ..KeyframeParameters::default()
        }),
        kernel("situ:distance", "D2b: classifiers by distance alone", || KeyframeParameters {
            lift: Lift::Distance,
            ..KeyframeParameters::default()
        }),
        kernel("situ:grips", "D6b off: a pick and a place on one object can be one primitive", || KeyframeParameters {
            across_grips: true,
            ..KeyframeParameters::default()
        }),
        kernel("situ:policy_signature", "D5 literal: policy against signature", || KeyframeParameters {
            compared: Compared::PolicyAgainstSignature,
            ..KeyframeParameters::default()
        }),
        kernel("situ:monte_carlo", "D7: divergence by Monte Carlo", || KeyframeParameters {
            divergence: Divergence::MonteCarlo(1000),
            ..KeyframeParameters::default()
        }),
        kernel("situ:bound", "D7: the transient bound for the divergence", || KeyframeParameters {
            divergence: Divergence::TransientBound,
            ..KeyframeParameters::default()
        }),
        kernel("situ:probability", "D10b as printed: activation is p ≥ 0.5 alone", || KeyframeParameters {
            activation: Activation::Probability,
            ..KeyframeParameters::default()
        }),
    ]
}

impl Method for KeyframeMethod {
    fn name(&self) -> &'static str {
        self.name
    }

    fn summary(&self) -> &'static str {
        self.summary
    }

    fn source(&self) -> &'static str {
        self.source
    }

    fn role(&self) -> Role {
        self.role
    }

    fn original(&self) -> &'static str {
        match self.update {
            Update::Direct(Rule::Narrated) => self.name,
            _ => KEYFRAME_AUTOMATON,
        }
    }

    fn segments(&self, demonstration: &Demonstration) -> Vec<Segment> {
        self.update.segments(demonstration)
    }

    fn teach(
        &self,
        schema: &Schema,
        demonstrations: &[Demonstration],
        seed: u64,
    ) -> Result<Box<dyn Learned>, SituError> {
        demonstrations.iter().try_for_each(|demonstration| demonstration.check_features(schema.len()))?;
        demonstrations.iter().try_for_each(|demonstration| self.update.check(self.name, demonstration, None))?;
        let model = match self.update {
            Update::Direct(Rule::Narrated) => direct::named_automaton(schema, demonstrations)?,
            _ => keyframe_automaton(schema, demonstrations)?,
        };
        Ok(Box::new(KeyframeTask {
            method: self.name,
            model,
            learner: KeyframeLearner::new(schema, KeyframeParameters { seed, ..(self.parameters)() }),
            decisions: (self.decisions)(),
            update: self.update,
        }))
    }
}

/// A keyframe task model and the way it is updated.
#[derive(Clone)]
struct KeyframeTask {
    method: &'static str,
    model: TaskModel<KeyframeLearner>,
    learner: KeyframeLearner,
    decisions: Decisions,
    update: Update,
}

impl Learned for KeyframeTask {
    fn correct(&mut self, correction: Correction<'_>) -> Result<Trace, SituError> {
        let Correction { last, interrupted, demonstration, told } = correction;
        demonstration.check_features(self.learner.features())?;
        let after = self.model.origin(last)?;
        interrupted.map(|id| self.model.node(id)).transpose()?;
        let segments = self.update.segments(demonstration);
        self.update.check(self.method, demonstration, told)?;
        let (learner, decisions) = (&self.learner, &self.decisions);
        // Taken, not copied: a copy would cost with the size of the model.
        let nothing = TaskModel::new(*self.model.calibration());
        let take = || std::mem::replace(&mut self.model, nothing);
        let (model, trace) = match self.update {
            Update::Nothing => return Ok(Trace::default()),
            Update::Situ => situ(correction, take(), learner, decisions)?,
            Update::Direct(rule) => direct::fold(rule, correction, segments, take(), learner, decisions)?,
            Update::Rebuild => {
                let mut histories = self.model.histories().to_vec();
                histories.push(History::new(demonstration, segments, after));
                rebuild(histories, Some(*self.model.calibration()), learner, decisions)?
            }
        };
        self.model = model;
        Ok(trace)
    }

    fn next(&self, last: Place, state: &State) -> Option<(Place, f64)> {
        self.model.most_probable_child(last, state)
    }

    fn keyframes(
        &self,
        node: NodeId,
        execution: Execution,
        rng: &mut ChaCha8Rng,
    ) -> Result<(Arc<str>, Vec<RelativeKeyframe>), SituError> {
        let policy = &self.model.node(node)?.policy;
        Ok((policy.reference().clone(), policy.keyframes(execution, rng)))
    }

    fn graph(&self) -> Graph {
        Graph::of(&self.model, &self.learner)
    }

    fn boxed(&self) -> Box<dyn Learned> {
        Box::new(self.clone())
    }

    fn to_json(&self) -> serde_json::Value {
        serde_json::to_value(&self.model).expect("a model's keys are strings and its numbers finite")
    }
}
