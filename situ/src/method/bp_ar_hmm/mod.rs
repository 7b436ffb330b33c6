//! `bp_ar_hmm`: Niekum, Osentoski, Konidaris, Chitta, Marthi and Barto, "Learning grounded finite-state representations
//! from unstructured demonstrations" (IJRR 2015), as a baseline.
//!
//! 1. A demonstration becomes a recording at 10 Hz, interpolated between its keyframes at the planner's speed
//!    ([`recording`](self)).
//! 2. The beta-process autoregressive hidden Markov model cuts all recordings together into runs of recurring
//!    behaviours ([`sampler`]). Of the states of several chains, the most probable is kept.
//! 3. Each behaviour that ends at one place of one object is a node. It is a dynamic movement primitive ([`dmp::Dmp`])
//!    that its runs teach.
//! 4. Runs that followed each other give edges. If several nodes can follow, the nearest example by L1 distance
//!    decides.
//! 5. A correction is one more recording: everything is segmented and built anew. The correction begins after the node
//!    that has the last frames of the runs of what ran last. What was interrupted is not used, nor what the teacher
//!    says, nor what an oracle is told.
//!
//! What is a *reconstruction*:
//! - Frames are relative to the reference object that the demonstration names. The original segments in the robot's
//!   frame and finds coordinate frames by clustering the ends of runs. Of that only the clusters are left: a behaviour
//!   that ends at two places is two nodes.
//! - Runs shorter than 0.3 s join the run before.
//! - The classifier sees the benchmark's state features; the original's sees object poses.
//! - A primitive starts at the mean start of its runs; the original starts wherever the arm is.
//! - Between two keyframes, the state is that before the motion to the next.
//! - There are fewer and shorter chains than in the original, for cost: [`BpArHmmParameters`].
//!
//! Work: `segments_touched` counts the runs that taught primitives, `nodes_touched` the nodes built, `classifier_fits`
//! the places with several children. The work of the sampler, chains × sweeps over all frames, has no counter. Nothing
//! is fitted by expectation maximisation.

mod automaton;
pub mod dmp;
mod labelling;
pub mod parameters;
mod recording;
mod run;
pub mod sampler;
mod skill;

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;

use self::automaton::{Automaton, Recorded};
use self::labelling::{Labelling, label};
use self::parameters::BpArHmmParameters;
use self::recording::{Frame, record};
use super::{Learned, Method, Original, Role};
use crate::correction::Correction;
use crate::demonstration::Demonstration;
use crate::edit::Edit;
use crate::error::SituError;
use crate::graph::{Graph, GraphNode};
use crate::keyframe::policy::Execution;
use crate::place::{NodeId, Place};
use crate::random::stream;
use crate::segment::RelativeKeyframe;
use crate::segmentation::lengths;
use crate::state::{Schema, State};
use crate::trace::{Counters, Trace};

/// The method.
#[derive(Clone, Copy, Debug, Default)]
pub struct BpArHmm {
    /// How the sampler runs.
    pub parameters: BpArHmmParameters,
}

impl Method for BpArHmm {
    fn name(&self) -> &str {
        "bp_ar_hmm"
    }

    fn summary(&self) -> &str {
        "full retraining: all recordings segmented by a BP-AR-HMM, a movement primitive a behaviour, nearest-neighbour branches"
    }

    fn source(&self) -> &str {
        "Niekum, Osentoski, Konidaris, Chitta, Marthi and Barto 2015 (reconstruction)"
    }

    fn role(&self) -> Role {
        Role::Correct
    }

    /// All: everything is built anew, so a correction can add, join and move anything. Another way of doing something
    /// is averaged with what was shown before, or stands beside it. Nothing is ever replaced.
    fn edits(&self) -> &[Edit] {
        &Edit::ALL
    }

    fn learn_original(
        &self,
        schema: &Schema,
        demonstrations: &[Demonstration],
        seed: u64,
    ) -> Result<Original, SituError> {
        demonstrations.iter().try_for_each(|demonstration| demonstration.check_features(schema.len()))?;
        if demonstrations.is_empty() {
            return Err(SituError::NoDemonstration);
        }
        let rules = [(f64::from(self.parameters.chains), "chains"), (f64::from(self.parameters.sweeps), "sweeps")];
        for (value, parameter) in rules {
            if value < 1.0 {
                return Err(SituError::Parameter { parameter, value, rule: "must be at least 1" });
            }
        }
        let shown = demonstrations.iter().map(|demonstration| Recorded {
            frames: record(demonstration),
            demonstration: demonstration.clone(),
            after: None,
        });
        let scales = schema.features().iter().map(|feature| feature.scale).collect();
        let (task, _) = Task::built(shown.collect(), scales, self.parameters, seed)?;
        Ok(Original::of(task))
    }
}

/// A task model of this method.
#[derive(Clone)]
struct Task {
    shown: Vec<Recorded>,
    scales: Vec<f64>,
    parameters: BpArHmmParameters,
    seed: u64,
    labelling: Labelling,
    automaton: Automaton,
}

impl Task {
    /// The task model of all demonstrations. The chains of each correction have their own random streams.
    fn built(
        shown: Vec<Recorded>,
        scales: Vec<f64>,
        parameters: BpArHmmParameters,
        seed: u64,
    ) -> Result<(Self, Trace), SituError> {
        let recordings: Vec<Vec<Frame>> = shown.iter().map(|one| one.frames.clone()).collect();
        let labelling =
            label(&recordings, &parameters, stream(seed, &format!("bp_ar_hmm of {} demonstrations", shown.len())))?;
        let labels: Vec<Vec<usize>> = (0..shown.len()).map(|recording| labelling.labels(recording)).collect();
        let mut counters = Counters::default();
        let automaton = Automaton::of(&shown, &labels, scales.clone(), &mut counters);
        Ok((Self { shown, scales, parameters, seed, labelling, automaton }, Trace { counters, ..Trace::default() }))
    }

    fn node(&self, id: NodeId) -> Result<&automaton::Node, SituError> {
        self.automaton.node(id).ok_or(SituError::UnknownNode(id))
    }
}

impl Learned for Task {
    fn correct(&mut self, correction: Correction<'_>) -> Result<Trace, SituError> {
        let Correction { last, interrupted, demonstration, .. } = correction;
        demonstration.check_features(self.scales.len())?;
        let after = match last {
            Place::Start => None,
            Place::Node(id) => Some(self.node(id)?.runs.iter().map(|run| run.stretch).collect()),
            Place::End => return Err(SituError::NotExecutable(last)),
        };
        interrupted.map(|id| self.node(id)).transpose()?;
        let mut shown = self.shown.clone();
        shown.push(Recorded { frames: record(demonstration), demonstration: demonstration.clone(), after });
        let (task, trace) = Self::built(shown, self.scales.clone(), self.parameters, self.seed)?;
        *self = task;
        Ok(trace)
    }

    fn ranked(&self, last: Place, state: &State) -> Result<Vec<(Place, f64)>, SituError> {
        Ok(self.automaton.next(last, state).into_iter().collect())
    }

    fn keyframes(
        &self,
        node: NodeId,
        _: usize,
        _: &State,
        execution: Execution,
        rng: &mut ChaCha8Rng,
    ) -> Result<(Arc<str>, Vec<RelativeKeyframe>), SituError> {
        let skill = &self.node(node)?.skill;
        Ok((skill.reference.clone(), skill.keyframes(execution, rng)))
    }

    fn graph(&self) -> Result<Graph, SituError> {
        let node = |(id, node): (u32, &automaton::Node)| GraphNode {
            id: NodeId(id),
            reference: node.skill.reference.clone(),
            segments: node.segments.clone(),
            paths: vec![node.skill.mean_path()],
        };
        Ok(Graph {
            nodes: (0..).zip(&self.automaton.nodes).map(node).collect(),
            edges: self.automaton.edges(),
            lengths: self.shown.iter().map(|shown| lengths(&shown.demonstration)).collect(),
        })
    }

    fn boxed(&self) -> Box<dyn Learned> {
        Box::new(self.clone())
    }

    fn to_json(&self) -> serde_json::Value {
        serde_json::json!({ "labelling": self.labelling, "automaton": self.automaton })
    }
}
