//! Random tasks: chains of primitives over several objects, demonstrations of them, and corrections of every edit type.

use std::ops::Range;

use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::correction::Correction;
use situ::demonstration::{Demonstration, Gripper, Keyframe, Kind, Pose};
use situ::place::{Place, SegmentId};
use situ::primitive::Learner;
use situ::random::{standard_normal, stream};
use situ::segment::RelativeKeyframe;
use situ::state::{Feature, Schema, State};
use situ::task_model::TaskModel;
use situ::trail::{StepEnd, TrailStep};

use crate::common::{CAREFUL, Noise};

/// A teacher who gives needless keyframes and forgets some.
const CARELESS: Noise = Noise { position: 0.012, rotation: 0.07, state: 0.03 };
const NEEDLESS: f64 = 0.15;
const FORGOTTEN: f64 = 0.07;

/// A primitive as it is meant.
#[derive(Clone)]
struct Primitive {
    object: usize,
    keyframes: Vec<RelativeKeyframe>,
    /// The state in which it begins, in units of the features' scales.
    begins: Vec<f64>,
    /// Where it was shown first.
    shown: SegmentId,
}

/// A task, and all that has been shown of it.
pub(crate) struct Task {
    pub(crate) schema: Schema,
    objects: usize,
    /// The chain, and after it what corrections have added.
    primitives: Vec<Primitive>,
    chain: usize,
    /// The state in which the task is over.
    over: Vec<f64>,
    demonstrations: u32,
    rng: ChaCha8Rng,
}

/// A correction, and when it is given.
pub(crate) struct Shown {
    pub(crate) demonstration: Demonstration,
    after: Option<SegmentId>,
    interrupted: Option<SegmentId>,
    /// In which state the robot chose what, by a segment of it, and how it ended.
    trail: Vec<(State, SegmentId, StepEnd)>,
}

impl Shown {
    /// The trail that led to the correction, as this model knows it.
    pub(crate) fn trail<L: Learner>(&self, model: &TaskModel<L>) -> Vec<TrailStep> {
        let step = |(state, of, end): &(State, SegmentId, StepEnd)| TrailStep {
            state: state.clone(),
            node: model.node_of(*of).expect("it was shown"),
            end: *end,
        };
        self.trail.iter().map(step).collect()
    }

    /// The correction as this model receives it, with its trail.
    pub(crate) fn of<'a, L: Learner>(&'a self, model: &TaskModel<L>, trail: &'a [TrailStep]) -> Correction<'a> {
        let node = |segment| model.node_of(segment).expect("it was shown");
        Correction {
            interrupted: self.interrupted.map(node),
            trail,
            ..Correction::after(
                self.after.map_or(Place::Start, |segment| Place::Node(node(segment))),
                &self.demonstration,
            )
        }
    }
}

impl Task {
    pub(crate) fn new(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(stream(seed, "chain"));
        let scale = |rng: &mut ChaCha8Rng| [0.2, 0.3, 0.5][rng.random_range(0..3)];
        let features = (0..rng.random_range(2..=5)).map(|f| Feature { name: format!("f{f}"), scale: scale(&mut rng) });
        let schema = Schema::new(features.collect()).expect("names and scales are valid");
        let (objects, chain) = (rng.random_range(2..=4), rng.random_range(2..=6));
        let mut task =
            Self { schema, objects, primitives: Vec::new(), chain, over: Vec::new(), demonstrations: 0, rng };
        while task.primitives.len() < chain {
            let object = task.rng.random_range(0..objects);
            if task.primitives.last().is_none_or(|before| before.object != object) {
                let begins = task.state();
                let primitive = task.primitive(object, begins);
                task.primitives.push(primitive);
            }
        }
        task.over = task.state();
        task
    }

    /// The whole chain, three to six times.
    pub(crate) fn originals(&mut self) -> Vec<Demonstration> {
        let chain = self.primitives.clone();
        let over = self.over.clone();
        let noise = self.noise();
        (0..[3, 3, 3, 4, 5, 6][self.rng.random_range(0..6)])
            .map(|_| self.show(Kind::Original, &chain, &over, noise, true))
            .collect()
    }

    /// A correction after any primitive. What comes next in the chain may have been stopped, under way or before it
    /// began, and the robot may have written down what it did.
    pub(crate) fn correction(&mut self) -> Shown {
        let ran = self.rng.random_range(0..=self.primitives.len());
        let next = if ran < self.chain { ran } else { self.rng.random_range(0..self.chain) };
        let (expected, is_careful) = (self.primitives[next].clone(), self.rng.random());
        let noise = if is_careful { CAREFUL } else { CARELESS };
        let stopped = [None, Some(StepEnd::Interrupted), Some(StepEnd::Prevented)][self.rng.random_range(0..3)];
        let (mut first, is_inserted) = self.first(ran, next);
        let trail = if self.rng.random_range(0..3) == 0 {
            Vec::new()
        } else {
            // The robot chose in the world in which it has to choose rightly; somebody stepped in later.
            let trail = self.trail(ran, stopped.map(|end| (first.begins.clone(), expected.shown, end)), noise);
            if self.rng.random() {
                first.begins = self.surprising(&first.begins);
            }
            trail
        };
        let mut acts = vec![first];
        // Back to the chain, and perhaps to its end.
        let mut resumed = next + usize::from(!is_inserted);
        while resumed < self.chain && self.rng.random() {
            acts.push(self.primitives[resumed].clone());
            resumed += 1;
        }
        let carried_to_end = resumed == self.chain;
        let last = if carried_to_end { self.over.clone() } else { acts[acts.len() - 1].begins.clone() };
        let after = ran.checked_sub(1).map(|ran| self.primitives[ran].shown);
        let interrupted = stopped.filter(|end| *end == StepEnd::Interrupted).map(|_| expected.shown);
        let demonstration = self.show(Kind::Corrective, &acts, &last, noise, carried_to_end);
        Shown { demonstration, after, interrupted, trail }
    }

    /// What a correction begins with, and whether it stands before what comes next rather than in its place: something
    /// new, something known out of order, what comes next or what has just run in another way, or what comes next as it
    /// was.
    fn first(&mut self, ran: usize, next: usize) -> (Primitive, bool) {
        let expected = self.primitives[next].clone();
        match self.rng.random_range(0..5) {
            0 => {
                // Often this is an object that the task does not know, and often it is the expected one.
                let object =
                    if self.rng.random() { expected.object } else { self.rng.random_range(0..self.objects + 2) };
                let begins = self.surprising(&expected.begins);
                let new = self.primitive(object, begins);
                self.primitives.push(new.clone());
                (new, self.rng.random())
            }
            1 => {
                let begins = self.surprising(&expected.begins);
                let other = self.rng.random_range(0..self.primitives.len());
                (Primitive { begins, ..self.primitives[other].clone() }, self.rng.random())
            }
            2 => (self.moved(next, 0.06..0.12), false),
            3 if ran > 0 => (self.moved(ran - 1, 0.01..0.12), true),
            _ => (expected, false),
        }
    }

    /// A primitive in another way, by so many metres: in a world of its own or in any. Both ways, or the new one alone,
    /// will be shown from now on.
    fn moved(&mut self, index: usize, metres: Range<f64>) -> Primitive {
        let mut moved = self.primitives[index].clone();
        let way = Vector3::from_fn(|_, _| standard_normal(&mut self.rng)).normalize();
        let far = way * self.rng.random_range(metres);
        moved.keyframes.iter_mut().for_each(|keyframe| keyframe.pose.translation.vector += far);
        if self.rng.random() {
            moved.begins = self.surprising(&moved.begins);
        }
        if self.rng.random() {
            self.primitives[index] = moved.clone()
        } else {
            self.primitives.push(moved.clone())
        }
        moved
    }

    /// The chain up to what ran last, and what was stopped after it.
    fn trail(
        &mut self,
        ran: usize,
        stopped: Option<(Vec<f64>, SegmentId, StepEnd)>,
        noise: Noise,
    ) -> Vec<(State, SegmentId, StepEnd)> {
        let finished = (0..ran).filter(|index| *index < self.chain || index + 1 == ran);
        let finished = finished.map(|index| &self.primitives[index]);
        let finished = finished.map(|primitive| (primitive.begins.clone(), primitive.shown, StepEnd::Finished));
        let steps: Vec<_> = finished.chain(stopped).collect();
        steps.into_iter().map(|(begins, of, end)| (self.seen(&begins, noise), of, end)).collect()
    }

    fn noise(&mut self) -> Noise {
        if self.rng.random() { CAREFUL } else { CARELESS }
    }

    fn normal(&mut self, deviation: f64) -> f64 {
        deviation * standard_normal(&mut self.rng)
    }

    fn vector(&mut self, deviation: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.normal(deviation))
    }

    /// A state. Its features have few values, as counts and contacts do.
    fn state(&mut self) -> Vec<f64> {
        (0..self.schema.len()).map(|_| f64::from(self.rng.random_range(0..4_u8))).collect()
    }

    /// A state in which one feature has a value that it never had.
    fn surprising(&mut self, state: &[f64]) -> Vec<f64> {
        let mut state = state.to_vec();
        let feature = self.rng.random_range(0..state.len());
        state[feature] += self.rng.random_range(1.0..4.0);
        state
    }

    /// One to five keyframes on a random walk about an object.
    fn primitive(&mut self, object: usize, begins: Vec<f64>) -> Primitive {
        let mut pose =
            Pose::from_parts(Translation3::from(self.vector(0.15)), UnitQuaternion::from_scaled_axis(self.vector(0.5)));
        let mut gripper = self.command();
        let mut keyframes = Vec::new();
        for _ in 0..self.rng.random_range(1..=5) {
            keyframes.push(RelativeKeyframe { pose, gripper, hold: self.rng.random_range(0.0..1.0) });
            pose = self.near(&pose, 0.08, 0.25);
            if self.rng.random_range(0..3) == 0 {
                gripper = self.command();
            }
        }
        let shown = SegmentId {
            demonstration: self.demonstrations,
            index: if self.demonstrations == 0 { self.primitives.len() as u32 } else { 0 },
        };
        Primitive { object, keyframes, begins, shown }
    }

    fn command(&mut self) -> Gripper {
        match self.rng.random_range(0..5) {
            0 => Gripper::Opening(self.rng.random_range(0.0..1.0)),
            1 | 2 => Gripper::Open(self.rng.random_range(0.02..0.08)),
            _ => Gripper::Close(self.rng.random_range(5.0..30.0)),
        }
    }

    fn near(&mut self, pose: &Pose, metres: f64, radians: f64) -> Pose {
        Pose::from_parts(
            Translation3::from(pose.translation.vector + self.vector(metres)),
            pose.rotation * UnitQuaternion::from_scaled_axis(self.vector(radians)),
        )
    }

    fn show(
        &mut self,
        kind: Kind,
        acts: &[Primitive],
        last: &[f64],
        noise: Noise,
        carried_to_end: bool,
    ) -> Demonstration {
        let is_careless = noise.position >= CARELESS.position;
        let mut keyframes = Vec::new();
        for act in acts {
            let state = self.seen(&act.begins, noise);
            let reference_pose = self.near(&Pose::identity(), 0.3, 0.5);
            let begun = keyframes.len();
            let mut push = |pose: Pose, command: &RelativeKeyframe| {
                keyframes.push(Keyframe {
                    reference: format!("object-{}", act.object).into(),
                    reference_pose,
                    gripper_pose: reference_pose * pose,
                    gripper: command.gripper,
                    hold: command.hold,
                    state: state.clone(),
                    announced: keyframes.len() == begun,
                    narration: None,
                });
            };
            for (index, keyframe) in act.keyframes.iter().enumerate() {
                let is_last = index + 1 == act.keyframes.len();
                if is_careless && !is_last && self.rng.random_bool(FORGOTTEN) {
                    continue;
                }
                push(self.near(&keyframe.pose, noise.position, noise.rotation), keyframe);
                if is_careless && self.rng.random_bool(NEEDLESS) {
                    push(self.near(&keyframe.pose, 0.04, 0.2), keyframe);
                }
            }
        }
        self.demonstrations += 1;
        let last = self.seen(last, noise);
        let name = format!("demonstration-{}", self.demonstrations);
        Demonstration::new(name, kind, &self.schema, keyframes, last, carried_to_end).expect("it is finite")
    }

    fn seen(&mut self, state: &[f64], noise: Noise) -> State {
        let scales: Vec<f64> = self.schema.features().iter().map(|feature| feature.scale).collect();
        let values = state.iter().zip(scales).map(|(value, scale)| value * scale + self.normal(noise.state));
        State::new(values.collect::<Vec<f64>>())
    }
}
