//! The learner of the crate beside the reference: two models of one task, and in what they must agree.

use std::collections::BTreeMap;
use std::fmt;
use std::mem::discriminant;

use situ::decisions::Decisions;
use situ::demonstration::{Demonstration, Pose};
use situ::fold::situ;
use situ::keyframe::learner::KeyframeLearner;
use situ::keyframe::parameters::KeyframeParameters;
use situ::method::rebuild::rebuild;
use situ::place::Place;
use situ::primitive::Learner;
use situ::state::State;
use situ::task_model::TaskModel;
use situ::trace::{Branch, Counters, MatchedIn, Step};

use crate::common::histories;
use crate::reference::learner::Reference;
use crate::reference::task::{Shown, Task};

/// How far apart two numbers may be: relative above 1, absolute below.
const TOLERANCE: f64 = 1e-6;

/// What was compared.
#[derive(Debug, Default)]
pub(crate) struct Summary {
    /// What is being compared; a failure names it.
    pub(crate) now: String,
    pub(crate) corrections: usize,
    /// The steps of the crate's learner. The reference took the same.
    steps: Vec<Step>,
    /// The greatest difference of each kind of number.
    differences: BTreeMap<&'static str, f64>,
}

impl Summary {
    fn count(&self, is_of_kind: impl Fn(&Step) -> bool) -> usize {
        self.steps.iter().filter(|step| is_of_kind(step)).count()
    }

    /// How many segments took this branch.
    pub(crate) fn branch(&self, branch: Branch) -> usize {
        self.count(|step| step.branch == branch)
    }

    /// # Panics
    /// If the numbers differ by more than rounding.
    fn near(&mut self, what: &'static str, own: f64, of_reference: f64) {
        // Equal infinities have no difference that is a number.
        let difference =
            if own == of_reference { 0.0 } else { (own - of_reference).abs() / of_reference.abs().max(1.0) };
        assert!(difference <= TOLERANCE, "{}: {what}: {own}, by the reference {of_reference}", self.now);
        let greatest = self.differences.entry(what).or_default();
        *greatest = greatest.max(difference);
    }

    /// # Panics
    /// If the paths differ by more than rounding: metres, radians.
    fn near_path(&mut self, what: &'static str, own: &[Pose], of_reference: &[Pose]) {
        assert_eq!(own.len(), of_reference.len(), "{}: {what}", self.now);
        for (own, of_reference) in own.iter().zip(of_reference) {
            self.near(what, (own.translation.vector - of_reference.translation.vector).norm(), 0.0);
            self.near(what, own.rotation.angle_to(&of_reference.rotation), 0.0);
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [new, existing, modify] = [Branch::New, Branch::Existing, Branch::Modify].map(|branch| self.branch(branch));
        let [index, object, nowhere] = [MatchedIn::Index, MatchedIn::Reference, MatchedIn::None]
            .map(|place| self.count(|step| step.matched_in == place));
        let (edges, merges) = (self.count(|step| step.edge_added), self.count(|step| !step.merged.is_empty()));
        writeln!(f, "{} corrections of {} segments: no decision differs", self.corrections, self.steps.len())?;
        writeln!(f, "{new} new, {existing} existing, {modify} modified; {edges} new edges, {merges} merges")?;
        writeln!(f, "matched: {index} in the index, {object} by reference object, {nowhere} nowhere")?;
        let differences = self.differences.iter().map(|(what, difference)| format!("{what} {difference:.1e}"));
        write!(f, "greatest differences: {}", differences.collect::<Vec<_>>().join(", "))
    }
}

/// Two models of one task.
pub(crate) struct Comparison {
    learner: KeyframeLearner,
    reference: Reference,
    fast: TaskModel<KeyframeLearner>,
    plain: TaskModel<Reference>,
}

impl Comparison {
    /// The models of the task's original demonstrations.
    pub(crate) fn taught(task: &mut Task, reference: Reference, summary: &mut Summary) -> Self {
        let learner = KeyframeLearner::new(&task.schema, KeyframeParameters::default());
        let originals = task.originals();
        let (fast, plain) = (taught(&originals, &learner), taught(&originals, &reference));
        let models = Self { learner, reference, fast, plain };
        models.agree(originals[0].final_state(), summary);
        models
    }

    /// Folds a correction into both models.
    pub(crate) fn correct(&mut self, shown: &Shown, summary: &mut Summary) {
        let fast = corrected(&mut self.fast, shown, &self.learner);
        let plain = corrected(&mut self.plain, shown, &self.reference);
        assert_eq!(fast, plain, "{}: steps", summary.now);
        summary.corrections += 1;
        summary.steps.extend(fast);
        self.agree(&shown.demonstration.keyframes()[0].state, summary);
    }

    /// Compares the two models. The classifiers are evaluated at `state`.
    ///
    /// # Panics
    /// Unless both are the same automaton over the same data, with the same numbers up to rounding.
    fn agree(&self, state: &State, summary: &mut Summary) {
        let (fast, plain) = (&self.fast, &self.plain);
        assert!(fast.edges().eq(plain.edges()), "{}: edges", summary.now);
        assert!(fast.nodes().map(|(id, _)| id).eq(plain.nodes().map(|(id, _)| id)), "{}: nodes", summary.now);
        summary.near("cut", fast.calibration().cut, *plain.calibration());
        let probabilities = |place| (fast.probability(place, state), plain.probability(place, state));
        for place in fast.nodes().map(|(id, _)| Place::Node(id)).chain([Place::End]) {
            let (own, of_reference) = probabilities(place);
            summary.near("probability", own, of_reference);
        }
        let nodes: Vec<_> = fast.nodes().zip(plain.nodes()).map(|((_, own), (_, plain))| (own, plain)).collect();
        for (index, (own, plain)) in nodes.iter().enumerate() {
            let data = (&own.segments, &own.policy_segments, &own.samples);
            assert_eq!(data, (&plain.segments, &plain.policy_segments, &plain.samples), "{}: data", summary.now);
            let keyframes = own.policy.mean_keyframes();
            let poses: Vec<Pose> = keyframes.iter().map(|keyframe| keyframe.pose).collect();
            summary.near_path("keyframe", &poses, &plain.policy.poses);
            for (own, of_reference) in keyframes.iter().zip(&plain.policy.commands) {
                assert_eq!(discriminant(&own.gripper), discriminant(of_reference), "{}: gripper", summary.now);
                summary.near("gripper", own.gripper.value(), of_reference.value());
            }
            summary.near_path("path", &self.learner.path(&own.policy), &self.reference.path(&plain.policy));
            for (other, of_reference) in &nodes[..index] {
                let counters = &mut Counters::default();
                let distance = self.learner.distance(&own.policy, &other.policy, None, counters);
                let of_reference = self.reference.distance(&plain.policy, &of_reference.policy, None, counters);
                summary.near("divergence", distance, of_reference);
            }
        }
    }
}

fn taught<L: Learner>(originals: &[Demonstration], learner: &L) -> TaskModel<L> {
    rebuild(histories(originals), None, learner, &Decisions::default()).expect("every segment can be learned").0
}

/// Folds a correction in, and returns what was decided.
fn corrected<L: Learner>(model: &mut TaskModel<L>, shown: &Shown, learner: &L) -> Vec<Step> {
    let correction = shown.of(model);
    let trace = situ(correction, model, learner, &Decisions::default()).expect("every segment can be learned");
    trace.steps.into_iter().map(|step| Step { counters: Counters::default(), ..step }).collect()
}
