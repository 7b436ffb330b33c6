//! The methods over keyframe task models: SITU, its literal reading and its ablations, full retraining, and the
//! controls.
//!
//! All share one representation and its kernels, so that a difference between two of them is the update's.

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;

use super::direct::{self, Direct, Rule};
use super::rebuild::rebuild;
use super::replay::{Later, replay};
use super::{Calibrated, KEYFRAME_AUTOMATON, KeyframeAutomaton, Learned, Method, Original, Role};
use crate::correction::{Correction, Oracle};
use crate::decisions::{Background, Candidates, Decisions, Limit, Modify, Ways};
use crate::demonstration::{Demonstration, Kind};
use crate::error::SituError;
use crate::fold::fold;
use crate::graph::Graph;
use crate::keyframe::learner::KeyframeLearner;
use crate::keyframe::parameters::{
    Activation, Compared, Divergence, KeyframeParameters, Lift, Spurious, Standardisation,
};
use crate::keyframe::policy::Execution;
use crate::keyframe::scatter::ScatterParameters;
use crate::place::{NodeId, Place};
use crate::placement::ByPolicy;
use crate::primitive::Learner;
use crate::segment::{RelativeKeyframe, Segment};
use crate::segmentation::{by_narration, by_reference_object};
use crate::state::{Schema, State};
use crate::task_model::TaskModel;
use crate::trace::Trace;

/// How a correction is folded in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Update {
    /// Algorithms 1 and 2.
    Situ,
    /// Everything anew, without a modification.
    Rebuild,
    /// Everything anew, corrections in their order.
    Replay(Later),
    /// Without a search for what a segment is.
    Direct(Rule),
    /// Not at all.
    Nothing,
}

impl Update {
    /// Checks that a demonstration says what the method has to hear.
    fn check(self, method: &str, demonstration: &Demonstration, oracle: Option<&Oracle>) -> Result<(), SituError> {
        let Self::Direct(rule) = self else { return Ok(()) };
        direct::check(rule, method, demonstration, oracle)
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
    /// Whether its parameters change what the originals are.
    has_own_original: bool,
}

const PAPER: &str = "Gutierrez, Short, Niekum and Thomaz 2018";
const OURS: &str = "this project";

const SITU: KeyframeMethod = KeyframeMethod {
    name: "situ",
    summary: "state-indexed task updates, the open decisions mended",
    source: PAPER,
    role: Role::Correct,
    update: Update::Situ,
    decisions: Decisions::mended,
    parameters: KeyframeParameters::default,
    has_own_original: false,
};

const REBUILD: KeyframeMethod = KeyframeMethod {
    name: "rebuild",
    summary: "full retraining on all demonstrations, clustered at once, corrections replayed in order, modified as by situ",
    source: OURS,
    update: Update::Replay(Later::AsSitu),
    ..SITU
};

/// The paper's model of all demonstrations at once: it knows no order, so nothing modifies.
pub(super) const JOINT: KeyframeMethod = KeyframeMethod {
    name: "rebuild:no_modify",
    summary: "full retraining on all demonstrations as one set: no order, no modification (the joint model)",
    source: PAPER,
    update: Update::Rebuild,
    ..SITU
};

pub(super) const NO_UPDATE: KeyframeMethod = KeyframeMethod {
    name: "no_update",
    summary: "the original model, never corrected",
    source: OURS,
    role: Role::Control,
    update: Update::Nothing,
    ..SITU
};

/// The methods, in the order of the tables.
pub fn all() -> Vec<KeyframeMethod> {
    let systems = [
        SITU,
        KeyframeMethod {
            name: "situ:literal",
            summary: "the listing as printed, every mending switched off",
            decisions: Decisions::literal,
            parameters: KeyframeParameters::literal,
            ..SITU
        },
        REBUILD,
        KeyframeMethod {
            name: "rebuild:recency",
            summary: "full retraining on all demonstrations; within a cluster the newest of two ways that differ is the one",
            source: OURS,
            update: Update::Replay(Later::Replaces),
            ..SITU
        },
        JOINT,
        KeyframeMethod {
            name: "from_scratch",
            summary: "rebuild from full demonstrations of the changed task alone",
            source: PAPER,
            role: Role::FromScratch,
            update: Update::Rebuild,
            ..SITU
        },
        NO_UPDATE,
        KeyframeMethod {
            name: "append_only",
            summary: "each segment of a correction is a new primitive: nothing is clustered",
            source: OURS,
            update: Update::Direct(Rule::Append),
            ..SITU
        },
        KeyframeMethod {
            name: "oracle_edit",
            summary: "told which primitive each segment is and which skills have changed: the upper bound of structure",
            source: "Kappler, Pastor, Kalakrishnan, Wüthrich and Schaal 2015 (reconstruction)",
            update: Update::Direct(Rule::Oracle),
            ..SITU
        },
        KeyframeMethod {
            name: "narrated_hierarchy",
            summary: "steps are what the teacher calls them, and a step shown again replaces the one before",
            source: "Mohseni-Kabir, Rich, Chernova, Sidner and Miller 2015 (reconstruction)",
            update: Update::Direct(Rule::Narrated),
            decisions: Decisions::replacing,
            ..SITU
        },
    ];
    systems.into_iter().chain(decided()).chain(own_originals()).chain(kernels()).collect()
}

/// SITU with one decision about structure changed at a time.
fn decided() -> Vec<KeyframeMethod> {
    let decided = |name, summary, decisions| KeyframeMethod { name, summary, source: OURS, decisions, ..SITU };
    vec![
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
        decided("situ:no_follow", "D19 off: addition or modification is decided by distance alone", || Decisions {
            follow: false,
            ..Decisions::mended()
        }),
        decided("situ:replace", "D20 off: a new way replaces the old one", || Decisions {
            ways: Ways::Replace,
            ..Decisions::mended()
        }),
        decided("situ:no_obedience", "D22 off: the model may choose something else where it was corrected", || {
            Decisions { obey: false, ..Decisions::mended() }
        }),
        decided("situ:no_trail", "D23 off: what the robot had chosen before the correction is not heeded", || {
            Decisions { trail: false, ..Decisions::mended() }
        }),
    ]
}

/// SITU with a decision changed that the originals depend on as well: each is taught its own from the same
/// demonstrations.
fn own_originals() -> Vec<KeyframeMethod> {
    let own = |name, summary, parameters| KeyframeMethod {
        name,
        summary,
        source: OURS,
        parameters,
        has_own_original: true,
        ..SITU
    };
    vec![
        KeyframeMethod {
            decisions: || {
                let limit = |metres| Limit { metres, scatters: 0.0 };
                let modify = Decisions::mended().modify;
                let fixed = |rule| Modify { near: limit(0.03), far: limit(0.07), ..rule };
                Decisions { modify: modify.map(fixed), ..Decisions::mended() }
            },
            ..own("situ:fixed_scatter", "D21 off: displaced is 3 cm and 7 cm, and one floor for all teachers", || {
                KeyframeParameters { scatter: ScatterParameters::fixed(), ..KeyframeParameters::default() }
            })
        },
        own("situ:no_symmetry", "D24 off: half a turn of the hand is another grasp", || KeyframeParameters {
            symmetry: false,
            ..KeyframeParameters::default()
        }),
        own("situ:keep_spurious", "D25 off: a keyframe that nobody needs is averaged with the others", || {
            KeyframeParameters { spurious: Spurious::Averaged, ..KeyframeParameters::default() }
        }),
    ]
}

/// SITU with one decision about its kernels changed at a time.
fn kernels() -> Vec<KeyframeMethod> {
    let kernel = |name, summary, parameters| KeyframeMethod { name, summary, source: OURS, parameters, ..SITU };
    vec![
        kernel("situ:fixed_scales", "D16 as designed: one scale a feature for every classifier", || {
            KeyframeParameters { standardisation: Standardisation::Fixed, ..KeyframeParameters::default() }
        }),
        kernel("situ:unbounded", "D16: a feature counts as many units as it is off", || KeyframeParameters {
            standardisation: Standardisation::Within { prior: 0.1, most: f64::INFINITY },
            ..KeyframeParameters::default()
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
    fn name(&self) -> &str {
        self.name
    }

    fn summary(&self) -> &str {
        self.summary
    }

    fn source(&self) -> &str {
        self.source
    }

    fn role(&self) -> Role {
        self.role
    }

    fn original(&self) -> &str {
        match self.update {
            Update::Direct(Rule::Narrated) => self.name,
            _ if self.has_own_original => self.name,
            _ => KEYFRAME_AUTOMATON,
        }
    }

    fn learn_original(
        &self,
        schema: &Schema,
        demonstrations: &[Demonstration],
        seed: u64,
    ) -> Result<Original, SituError> {
        demonstrations.iter().try_for_each(|demonstration| demonstration.check_features(schema.len()))?;
        demonstrations.iter().try_for_each(|demonstration| self.update.check(self.name, demonstration, None))?;
        if self.update != Update::Direct(Rule::Narrated) {
            let parameters = if self.has_own_original { (self.parameters)() } else { KeyframeParameters::default() };
            return KeyframeAutomaton::learn_by(parameters, schema, demonstrations, seed).map(Original::Keyframe);
        }
        let model = Arc::new(direct::named_automaton(schema, demonstrations)?);
        Ok(Original::of(self.task(&KeyframeAutomaton { schema: schema.clone(), model, seed })))
    }

    fn take_over(&self, original: &Original) -> Result<Box<dyn Learned>, SituError> {
        if self.update == Update::Direct(Rule::Narrated) {
            return original.own(self.name);
        }
        Ok(Box::new(self.task(original.keyframe(self.name)?)))
    }

    fn read(&self, schema: &Schema, model: serde_json::Value, seed: u64) -> Result<Box<dyn Learned>, SituError> {
        let refuse = |problem: String| SituError::Model { place: "model".to_owned(), problem };
        let read: TaskModel<KeyframeLearner> =
            serde_json::from_value(model).map_err(|error| refuse(error.to_string()))?;
        let task = self.task(&KeyframeAutomaton { schema: schema.clone(), model: Arc::new(read), seed });
        let model = task.model.clone().restored(&task.learner)?;
        Ok(Box::new(KeyframeTask { model, ..task }))
    }
}

impl KeyframeMethod {
    fn task(&self, original: &KeyframeAutomaton) -> KeyframeTask {
        let parameters = KeyframeParameters { seed: original.seed, ..(self.parameters)() };
        KeyframeTask {
            method: self.name,
            model: TaskModel::clone(&original.model),
            learner: KeyframeLearner::new(&original.schema, parameters),
            decisions: (self.decisions)(),
            update: self.update,
        }
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

impl KeyframeTask {
    /// A demonstration, cut as the method cuts it.
    fn segments(&self, demonstration: &Demonstration) -> Vec<Segment> {
        match self.update {
            Update::Direct(Rule::Narrated) => by_narration(demonstration),
            _ => by_reference_object(demonstration),
        }
    }
}

impl Learned for KeyframeTask {
    fn correct(&mut self, correction: Correction<'_>) -> Result<Trace, SituError> {
        let Correction { demonstration, oracle, .. } = correction;
        demonstration.check_features(self.learner.features())?;
        let segments = self.learner.as_the_model_has_it(self.segments(demonstration), &self.model);
        let history = self.model.history(&correction, segments)?;
        self.update.check(self.method, demonstration, oracle)?;
        let Self { model, learner, decisions, .. } = self;
        match self.update {
            Update::Nothing => Ok(Trace::default()),
            Update::Situ => fold(correction, history, model, learner, decisions, &mut ByPolicy),
            Update::Direct(rule) => {
                let mut direct = Direct::new(rule, oracle, model);
                fold(correction, history, model, learner, decisions, &mut direct)
            }
            Update::Rebuild => {
                let histories = model.histories().iter().cloned().chain([history]).collect();
                let (rebuilt, trace) = rebuild(histories, Some(*model.calibration()), learner, decisions)?;
                *model = rebuilt;
                Ok(trace)
            }
            Update::Replay(later) => {
                let histories = model.histories().iter().cloned().chain([history]).collect();
                let (rebuilt, trace) = replay(histories, *model.calibration(), learner, decisions, later)?;
                *model = rebuilt;
                Ok(trace)
            }
        }
    }

    fn ranked(&self, last: Place, state: &State) -> Result<Vec<(Place, f64)>, SituError> {
        Ok(self.model.ranked_children(last, state))
    }

    fn next(&self, last: Place, state: &State) -> Result<Option<(Place, f64)>, SituError> {
        Ok(self.model.most_probable_child(last, state))
    }

    fn ways(&self, node: NodeId, state: &State) -> Result<Vec<usize>, SituError> {
        let right = self.model.way_in(node, state, self.learner.scales())?;
        let ways = self.model.node(node)?.ways.len();
        let others = (0..ways).rev().filter(|way| *way != right);
        Ok(std::iter::once(right).chain(others).collect())
    }

    fn keyframes(
        &self,
        node: NodeId,
        way: usize,
        _: &State,
        execution: Execution,
        rng: &mut ChaCha8Rng,
    ) -> Result<(Arc<str>, Vec<RelativeKeyframe>), SituError> {
        let node = self.model.node(node)?;
        let policy = &node.ways.get(way).unwrap_or_else(|| node.newest()).policy;
        Ok((policy.reference().clone(), policy.keyframes(execution, rng)))
    }

    fn calibrated(&self) -> Option<Calibrated> {
        let cut = self.learner.parameters().cut;
        let originals = self.model.histories().iter().filter(|history| history.kind == Kind::Original).count();
        Some(Calibrated {
            calibration: *self.model.calibration(),
            bounds: [cut.least, cut.greatest],
            is_of_one: originals < 2,
        })
    }

    fn held_out(&self, demonstration: &Demonstration) -> Vec<(usize, Option<f64>)> {
        let explained = |segment: &Segment| {
            let nodes = self.model.nodes_of(&segment.reference).filter_map(|id| self.model.node(id).ok());
            let policies = nodes.flat_map(|node| node.policies());
            let values = policies.map(|policy| policy.log_likelihood_of(segment));
            values.filter(|value| value.is_finite()).reduce(f64::max)
        };
        let segments = self.learner.as_the_model_has_it(self.segments(demonstration), &self.model);
        segments.iter().map(|segment| (segment.keyframes.len(), explained(segment))).collect()
    }

    fn graph(&self) -> Result<Graph, SituError> {
        Ok(Graph::of(&self.model, &self.learner))
    }

    fn boxed(&self) -> Box<dyn Learned> {
        Box::new(self.clone())
    }

    fn to_json(&self) -> serde_json::Value {
        serde_json::to_value(&self.model).expect("a model's keys are strings and its numbers finite")
    }
}
