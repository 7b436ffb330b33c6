//! The learner of the crate beside the reference: two models of one task, and in what they must agree.

use std::collections::BTreeMap;
use std::fmt;
use std::mem::discriminant;

use situ::decisions::Decisions;
use situ::demonstration::{Demonstration, Pose};
use situ::fold::situ;
use situ::keyframe::learner::KeyframeLearner;
use situ::keyframe::parameters::KeyframeParameters;
use situ::keyframe::policy::KeyframePolicy;
use situ::method::rebuild::rebuild;
use situ::place::Place;
use situ::primitive::Learner;
use situ::state::State;
use situ::task_model::TaskModel;
use situ::trace::{Branch, Counters, MatchedIn, Obedience, Step};

use crate::common::histories;
use crate::reference::learner::{Policy, Reference};
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
    /// Positives that were retired so that the model obeys.
    pub(crate) retired: u32,
    /// How often a node was compared that has one way, two, or more.
    pub(crate) ways: [usize; 3],
    /// How often an older way than the newest was the right one.
    pub(crate) older: usize,
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
        let [one, two, more] = self.ways;
        writeln!(f, "nodes of one way {one}, of two {two}, of more {more}; an older way is right in {}", self.older)?;
        writeln!(f, "{} positives retired", self.retired)?;
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
        summary.steps.extend(fast.0);
        summary.retired += fast.1.retired;
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
        self.agree_on_the_teacher(summary);
        let probabilities = |place| (fast.probability(place, state), plain.probability(place, state));
        for place in fast.nodes().map(|(id, _)| Place::Node(id)).chain([Place::End]) {
            let (own, of_reference) = probabilities(place);
            summary.near("probability", own, of_reference);
        }
        let nodes: Vec<_> = fast.nodes().zip(plain.nodes()).map(|((id, own), (_, plain))| (id, own, plain)).collect();
        for (index, (id, own, plain)) in nodes.iter().enumerate() {
            let data = (&own.segments, &own.samples);
            assert_eq!(data, (&plain.segments, &plain.samples), "{}: data", summary.now);
            let right = (
                fast.way_in(*id, state, self.learner.scales()).expect("it is a node"),
                self.plain.way_in(*id, state, self.reference.scales()).expect("it is a node"),
            );
            assert_eq!(right.0, right.1, "{}: the way that is right", summary.now);
            summary.ways[own.ways.len().min(3) - 1] += 1;
            summary.older += usize::from(right.0 + 1 < own.ways.len());
            assert_eq!(own.ways.len(), plain.ways.len(), "{}: ways", summary.now);
            for (own, plain) in own.ways.iter().zip(&plain.ways) {
                let data = (&own.segments, &own.wanted, own.is_corrective);
                assert_eq!(data, (&plain.segments, &plain.wanted, plain.is_corrective), "{}: a way", summary.now);
                self.agree_on(&own.policy, &plain.policy, summary);
            }
            for (_, other, of_reference) in &nodes[..index] {
                for (one, plain_one) in own.ways.iter().zip(&plain.ways) {
                    for (other, plain_other) in other.ways.iter().zip(&of_reference.ways) {
                        let pair = [&one.policy, &other.policy];
                        self.agree_how_far(pair, [&plain_one.policy, &plain_other.policy], summary);
                    }
                }
            }
        }
    }

    fn agree_how_far(&self, own: [&KeyframePolicy; 2], plain: [&Policy; 2], summary: &mut Summary) {
        let counters = &mut Counters::default();
        let distance = self.learner.distance(own[0], own[1], None, counters);
        summary.near("divergence", distance, self.reference.distance(plain[0], plain[1], None, counters));
        for beside in [false, true] {
            let displaced = self.learner.displacement(own[0], own[1], self.fast.calibration(), beside);
            let of_reference = self.reference.displacement(plain[0], plain[1], self.plain.calibration(), beside);
            summary.near("metres", displaced.metres, of_reference.metres);
            summary.near("scatters", displaced.scatters, of_reference.scatters);
        }
    }

    /// The cut, and the scatter about each axis.
    fn agree_on_the_teacher(&self, summary: &mut Summary) {
        let (fast, plain) = (self.fast.calibration(), self.plain.calibration());
        summary.near("cut", fast.cut, plain.cut);
        assert_eq!(fast.scatter.is_clamped, plain.scatter.is_clamped, "{}: clamped", summary.now);
        for (own, plain) in [(fast.scatter.contact, plain.scatter.contact), (fast.scatter.free, plain.scatter.free)] {
            summary.near("scatter", own.position, plain.0);
            own.rotation.iter().zip(plain.1).for_each(|(own, plain)| summary.near("scatter", *own, plain));
        }
    }

    fn agree_on(&self, own: &KeyframePolicy, plain: &Policy, summary: &mut Summary) {
        let keyframes = own.mean_keyframes();
        let poses: Vec<Pose> = keyframes.iter().map(|keyframe| keyframe.pose).collect();
        summary.near_path("keyframe", &poses, &plain.poses);
        for (own, of_reference) in keyframes.iter().zip(&plain.commands) {
            assert_eq!(discriminant(&own.gripper), discriminant(of_reference), "{}: gripper", summary.now);
            summary.near("gripper", own.gripper.value(), of_reference.value());
        }
        summary.near_path("path", &self.learner.path(own), &self.reference.path(plain));
    }
}

fn taught<L: Learner>(originals: &[Demonstration], learner: &L) -> TaskModel<L> {
    rebuild(histories(originals), None, learner, &Decisions::default()).expect("every segment can be learned").0
}

/// Folds a correction in, and returns what was decided, and where the model had to be made to obey.
fn corrected<L: Learner>(model: &mut TaskModel<L>, shown: &Shown, learner: &L) -> (Vec<Step>, Obedience) {
    let trail = shown.trail(model);
    let correction = shown.of(model, &trail);
    let trace = situ(correction, model, learner, &Decisions::default()).expect("every segment can be learned");
    let uncounted = |step| Step { counters: Counters::default(), ..step };
    (trace.steps.into_iter().map(uncounted).collect(), trace.obedience)
}
