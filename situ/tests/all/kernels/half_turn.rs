//! A hand with a symmetry (decision D24): whichever way a hold was shown, the same is learned.

use core::f64::consts::PI;
use std::ops::Range;

use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::correction::Correction;
use situ::decisions::Decisions;
use situ::demonstration::{Demonstration, Gripper, Keyframe, Kind, Pose};
use situ::fold::fold;
use situ::keyframe::learner::KeyframeLearner;
use situ::keyframe::parameters::KeyframeParameters;
use situ::keyframe::pose::{Tangent, exp};
use situ::method::rebuild::rebuild;
use situ::place::Place;
use situ::placement::ByPolicy;
use situ::primitive::Learner;
use situ::random::standard_normal;
use situ::segmentation::by_reference_object;
use situ::state::{Axis, Feature, Schema, State};
use situ::task_model::{History, TaskModel};
use situ::trace::{Branch, Counters, Step};

use crate::kernels::sample::pose_of;

/// A model of keyframes.
type Taught = TaskModel<KeyframeLearner>;

/// Whether the hand is closed when each segment of the task begins and when it ends. Each is about its own object.
const HANDS: [(bool, bool); 6] =
    [(false, true), (true, false), (false, false), (false, true), (true, true), (true, false)];
/// The segments that turn together: a grasp with all that is done until the hand opens.
const HOLDS: [Range<usize>; 3] = [0..2, 2..3, 3..6];
const KEYFRAMES: usize = 3;
const ORIGINALS: usize = 4;
/// Rounding, through fits that end at a relative gain of 1e-6.
const TOLERANCE: f64 = 1e-6;

/// How a hand says what it does.
type Command = fn(bool) -> Gripper;

fn force(is_closed: bool) -> Gripper {
    if is_closed { Gripper::Close(20.0) } else { Gripper::Open(0.08) }
}

fn reading(is_closed: bool) -> Gripper {
    Gripper::Opening(if is_closed { 0.1 } else { 0.9 })
}

/// A task: one path for each segment.
struct Script {
    axis: Axis,
    command: Command,
    schema: Schema,
    paths: Vec<Vec<Pose>>,
}

impl Script {
    fn new(axis: Axis, command: Command, rng: &mut ChaCha8Rng) -> Self {
        let feature = Feature { name: "progress".to_owned(), scale: 1.0 };
        let schema = Schema::new(vec![feature]).unwrap().with_half_turn(Some(axis));
        let mut pose = || {
            let mut number = |range: f64| rng.random_range(-range..range);
            pose_of([(); 3].map(|()| number(0.2)), [(); 3].map(|()| number(0.6)))
        };
        let paths = HANDS.iter().map(|_| (0..KEYFRAMES).map(|_| pose()).collect()).collect();
        Self { axis, command, schema, paths }
    }

    /// Half a turn of the hand, in its own frame.
    fn half_turn(&self) -> UnitQuaternion<f64> {
        let axis = match self.axis {
            Axis::X => Vector3::x(),
            Axis::Y => Vector3::y(),
            Axis::Z => Vector3::z(),
        };
        UnitQuaternion::from_scaled_axis(axis * PI)
    }

    /// Some segments of the task, where the hand is turned in some holds. The noise is that of the seed.
    fn show(&self, kind: Kind, segments: Range<usize>, turned: &[bool; 3], seed: u64) -> Demonstration {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut keyframes = Vec::new();
        let state = |progress: usize| State::new([progress as f64]);
        for segment in segments.clone() {
            let hold = HOLDS.iter().position(|hold| hold.contains(&segment)).expect("each is in one");
            let (begins, ends) = HANDS[segment];
            for (index, pose) in self.paths[segment].iter().enumerate() {
                let noise = Tangent::from_fn(|axis, _| standard_normal(&mut rng) * if axis < 3 { 0.004 } else { 0.03 });
                let mut gripper_pose = exp(pose, &noise);
                if turned[hold] {
                    gripper_pose.rotation *= self.half_turn();
                }
                keyframes.push(Keyframe {
                    reference: format!("object-{segment}").into(),
                    reference_pose: Pose::identity(),
                    gripper_pose,
                    gripper: (self.command)(if index == 0 { begins } else { ends }),
                    hold: 0.0,
                    state: state(segment),
                    announced: false,
                    narration: None,
                });
            }
        }
        Demonstration::new("shown", kind, &self.schema, keyframes, state(segments.end), segments.end == HANDS.len())
            .unwrap()
    }

    fn learner(&self) -> KeyframeLearner {
        KeyframeLearner::new(&self.schema, KeyframeParameters::default())
    }

    /// The model of originals that were turned like that.
    fn taught(&self, turned: &[[bool; 3]]) -> Taught {
        let show = |(seed, turned)| self.show(Kind::Original, 0..HANDS.len(), turned, seed);
        let shown: Vec<Demonstration> = (0..).zip(turned).map(show).collect();
        let segments = self.learner().one_representative(shown.iter().map(by_reference_object).collect());
        let histories = shown.iter().zip(segments).map(|(shown, segments)| History::new(shown, segments, None));
        rebuild(histories.collect(), None, &self.learner(), &Decisions::default()).unwrap().0
    }

    /// The model with a correction that begins with a hold, and what was decided.
    fn corrected(&self, mut model: Taught, segments: Range<usize>, turned: &[bool; 3]) -> (Taught, Vec<Step>) {
        let learner = self.learner();
        let last = segments.start.checked_sub(1);
        let shown = self.show(Kind::Corrective, segments, turned, 77);
        let last = last.map_or(Place::Start, |last| Place::Node(model.histories()[0].nodes[last]));
        let correction = Correction::after(last, &shown);
        let segments = learner.as_the_model_has_it(by_reference_object(&shown), &model);
        let history = model.history(&correction, segments).unwrap();
        let trace = fold(correction, history, &mut model, &learner, &Decisions::default(), &mut ByPolicy).unwrap();
        let uncounted = |step| Step { counters: Counters::default(), ..step };
        (model, trace.steps.into_iter().map(uncounted).collect())
    }

    /// # Panics
    /// Unless the models are one but for rounding, and but for half a turn of the hand in these holds.
    fn are_one(&self, left: &Taught, right: &Taught, turned: &[bool; 3]) {
        assert!(left.edges().eq(right.edges()) && left.len() == right.len());
        assert!((left.calibration().cut - right.calibration().cut).abs() < TOLERANCE);
        for ((_, left), (_, right)) in left.nodes().zip(right.nodes()) {
            let (data, same) = ((&left.segments, &left.samples), (&right.segments, &right.samples));
            assert_eq!(data, same);
            assert_eq!(left.ways.len(), right.ways.len());
            let segment: usize = left.reference.strip_prefix("object-").unwrap().parse().unwrap();
            let hold = HOLDS.iter().position(|hold| hold.contains(&segment)).expect("each is in one");
            for (left, right) in left.ways.iter().zip(&right.ways) {
                let [left, right] = [&left.policy, &right.policy].map(|policy| self.learner().path(policy));
                for (one, other) in left.iter().zip(&right) {
                    let turn = if turned[hold] { self.half_turn() } else { UnitQuaternion::identity() };
                    let metres = (one.translation.vector - other.translation.vector).norm();
                    let radians = one.rotation.angle_to(&(other.rotation * turn));
                    assert!(metres < TOLERANCE && radians < TOLERANCE, "{segment}: {metres} m, {radians} rad");
                }
            }
        }
    }
}

/// Each hold of each demonstration turned or not, at random.
fn random_turns(rng: &mut ChaCha8Rng) -> Vec<[bool; 3]> {
    (0..ORIGINALS).map(|_| [(); 3].map(|()| rng.random())).collect()
}

/// Of originals the first says how the hand is held; a correction is held as the model has it.
#[test]
fn half_a_turn_of_any_hold_changes_nothing() {
    for seed in 0..18_u64 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let axis = [Axis::X, Axis::Y, Axis::Z][seed as usize % 3];
        let command: Command = if seed % 2 == 0 { force } else { reading };
        let script = Script::new(axis, command, &mut rng);
        let plain = script.taught(&[[false; 3]; ORIGINALS]);
        assert_eq!(plain.len(), HANDS.len(), "{seed}: one primitive for each segment");
        let turns = random_turns(&mut rng);
        let model = script.taught(&turns);
        script.are_one(&plain, &model, &turns[0]);
        // It may stop before the hand opens.
        let begins = HOLDS[rng.random_range(0..HOLDS.len())].start;
        let segments = begins..rng.random_range(begins + 1..=HANDS.len());
        let (corrected, steps) = script.corrected(plain, segments.clone(), &[false; 3]);
        assert!(steps.iter().all(|step| step.branch == Branch::Existing), "{seed}: it shows nothing new");
        let turned = [(); 3].map(|()| rng.random());
        let (found, same) = script.corrected(model, segments, &turned);
        assert_eq!(steps, same, "{seed}");
        script.are_one(&corrected, &found, &turns[0]);
    }
}

/// Without the symmetry the two ways to hold a thing are averaged or become two primitives.
#[test]
fn a_hand_without_the_symmetry_is_taken_as_shown() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let script = Script::new(Axis::Z, force, &mut rng);
    let parameters = KeyframeParameters { symmetry: false, ..KeyframeParameters::default() };
    let learner = KeyframeLearner::new(&script.schema, parameters);
    let shown = [false, true].map(|turned| script.show(Kind::Original, 0..HANDS.len(), &[turned; 3], 1));
    let segments: Vec<_> = shown.iter().map(by_reference_object).collect();
    assert_eq!(learner.one_representative(segments.clone()), segments);
    let one = script.learner().one_representative(segments.clone());
    assert_eq!(one[0], segments[0]);
    assert_ne!(one[1], segments[1]);
}

/// What is held turns with the hand, however it is held on the way: one by one, the pour in the middle of a hold, which
/// this teacher turns by more than a right angle, would be taken for half a turn.
#[test]
fn a_hold_turns_as_a_whole_or_not_at_all() {
    for (seed, axis) in [(1, Axis::X), (2, Axis::Y), (3, Axis::Z)] {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let script = Script::new(axis, force, &mut rng);
        let learner = script.learner();
        let [first, plain, turned] = [(0, false), (1, false), (1, true)].map(|(seed, is_turned)| {
            let mut segments = by_reference_object(&script.show(Kind::Original, 3..6, &[is_turned; 3], seed));
            let aside = UnitQuaternion::identity().slerp(&script.half_turn(), if seed == 0 { 0.0 } else { 0.6 });
            segments[1].keyframes.iter_mut().for_each(|keyframe| keyframe.pose.rotation *= aside);
            segments
        });
        let originals = |second: &Vec<_>| learner.one_representative(vec![first.clone(), second.clone()]);
        let shown = script.show(Kind::Original, 3..6, &[false; 3], 0);
        let history = History::new(&shown, first.clone(), None);
        let model = rebuild(vec![history], None, &learner, &Decisions::default()).unwrap().0;
        assert_eq!(originals(&plain)[1], plain);
        assert_eq!(learner.as_the_model_has_it(plain.clone(), &model), plain);
        for found in [originals(&turned).remove(1), learner.as_the_model_has_it(turned.clone(), &model)] {
            let keyframes =
                found.iter().zip(&plain).flat_map(|(found, plain)| found.keyframes.iter().zip(&plain.keyframes));
            for (found, plain) in keyframes {
                assert!(found.pose.rotation.angle_to(&plain.pose.rotation) < 1e-9);
            }
        }
    }
}
