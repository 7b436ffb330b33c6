//! Random tasks: chains of primitives over several objects, demonstrations of them, and corrections of every edit type.

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
}

impl Shown {
    /// The correction as this model receives it.
    pub(crate) fn of<L: Learner>(&self, model: &TaskModel<L>) -> Correction<'_> {
        let node = |segment| model.node_of(segment).expect("it was shown");
        Correction {
            interrupted: self.interrupted.map(node),
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

    /// A correction after any primitive: something new, something known out of order, what comes next in another way,
    /// or what comes next as it was.
    pub(crate) fn correction(&mut self) -> Shown {
        let ran = self.rng.random_range(0..=self.primitives.len());
        let next = if ran < self.chain { ran } else { self.rng.random_range(0..self.chain) };
        let mut first = self.primitives[next].clone();
        let mut interrupted = None;
        match self.rng.random_range(0..4) {
            0 => {
                // Often this is an object that the task does not know.
                let object = self.rng.random_range(0..self.objects + 2);
                let begins = self.surprising(&first.begins);
                first = self.primitive(object, begins);
                self.primitives.push(first.clone());
            }
            1 => {
                let begins = self.surprising(&first.begins);
                let other = self.rng.random_range(0..self.primitives.len());
                first = Primitive { begins, ..self.primitives[other].clone() };
            }
            2 => {
                let way = Vector3::from_fn(|_, _| standard_normal(&mut self.rng)).normalize();
                let moved = way * self.rng.random_range(0.06..0.12);
                first.keyframes.iter_mut().for_each(|keyframe| keyframe.pose.translation.vector += moved);
                self.primitives[next] = first.clone();
                interrupted = self.rng.random::<bool>().then_some(first.shown);
            }
            _ => {}
        }
        let mut acts = vec![first];
        // Back to the chain, and perhaps to its end.
        let mut after = next;
        while after + 1 < self.chain && self.rng.random_range(0..3) == 0 {
            after += 1;
            if acts[acts.len() - 1].object != self.primitives[after].object {
                acts.push(self.primitives[after].clone());
            }
        }
        let carried_to_end = after + 1 == self.chain;
        let last = if carried_to_end { self.over.clone() } else { acts[acts.len() - 1].begins.clone() };
        let after = ran.checked_sub(1).map(|ran| self.primitives[ran].shown);
        let noise = self.noise();
        let demonstration = self.show(Kind::Corrective, &acts, &last, noise, carried_to_end);
        Shown { demonstration, after, interrupted }
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
            let mut push = |pose: Pose, command: &RelativeKeyframe| {
                keyframes.push(Keyframe {
                    reference: format!("object-{}", act.object).into(),
                    reference_pose,
                    gripper_pose: reference_pose * pose,
                    gripper: command.gripper,
                    hold: command.hold,
                    state: state.clone(),
                    announced: false,
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
