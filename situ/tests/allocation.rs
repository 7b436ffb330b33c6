//! A re-estimation allocates nothing: a fit of many iterations allocates as often as a fit of few. A clustering of many
//! segments allocates in proportion to them: the comparison of a pair allocates nothing.

use allocation_counter::measure;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::demonstration::{Gripper, Pose};
use situ::keyframe::hmm::{Hmm, HmmParameters, Observation};
use situ::keyframe::learner::{Calibration, KeyframeLearner};
use situ::keyframe::parameters::KeyframeParameters;
use situ::primitive::Learner;
use situ::segment::{RelativeKeyframe, Segment};
use situ::state::{Feature, Schema, State};
use situ::trace::Counters;

/// Noisy sequences of one path, with a turn and gripper commands.
fn sequences() -> Vec<Vec<Observation>> {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut noise = move || 0.02 * (rng.random::<f64>() - 0.5);
    let mut observation = |frame: usize| {
        let share = frame as f64 / 20.0;
        let position = Translation3::new(share + noise(), 0.1 * share * share + noise(), noise());
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(noise(), noise(), 1.5 * share + noise()));
        let gripper = if frame < 10 { Gripper::Open(0.05 + noise()) } else { Gripper::Close(20.0 + noise()) };
        Observation { pose: Pose::from_parts(position, turn), gripper: Some(gripper) }
    };
    (0..6).map(|_| (0..20).map(&mut observation).collect()).collect()
}

#[test]
fn re_estimation_allocates_nothing() {
    let sequences = sequences();
    let sequences: Vec<&[Observation]> = sequences.iter().map(Vec::as_slice).collect();
    let fit = |max_iterations: usize| {
        // With a tolerance of 0 the fit goes on to the last iteration.
        let parameters = HmmParameters { max_iterations, tolerance: 0.0, ..HmmParameters::default() };
        let mut iterations = 0;
        let counted = measure(|| iterations = Hmm::fit(&sequences, 6, &parameters).unwrap().iterations);
        assert_eq!(iterations, max_iterations);
        counted.count_total
    };
    let (none, few, many) = (fit(0), fit(2), fit(80));
    println!("allocations of a fit with 0, 2 and 80 re-estimations: {none}, {few}, {many}");
    assert!(none > 0, "the count counts");
    assert_eq!((few, many), (none, none));
}

/// When each pair was compared by itself, each comparison allocated some forty times.
#[test]
fn a_comparison_allocates_nothing() {
    let schema = Schema::new(vec![Feature { name: "x".to_owned(), scale: 1.0 }]).unwrap();
    let learner = KeyframeLearner::new(&schema, KeyframeParameters::default());
    let keyframe = |frame: &Observation| RelativeKeyframe {
        pose: frame.pose,
        gripper: frame.gripper.expect("every frame has a command"),
        hold: 0.0,
    };
    let segment = |frames: &Vec<Observation>| Segment {
        reference: "cube".into(),
        start: State::new(vec![0.0]),
        keyframes: frames.iter().step_by(5).map(keyframe).collect(),
        narration: Vec::new(),
    };
    let segments: Vec<Segment> = (0..20).flat_map(|_| sequences()).map(|frames| segment(&frames)).collect();
    let allocations = |count: usize| {
        let some: Vec<&Segment> = segments[..count].iter().collect();
        let calibration = learner.calibrate(&[], &mut Counters::default()).unwrap();
        let calibration = Calibration { cut: 5.0, ..calibration };
        let cluster = || drop(learner.cluster(&some, &calibration, &mut Counters::default()).unwrap());
        measure(cluster).count_total
    };
    let (few, many) = (allocations(30), allocations(120));
    println!("allocations of a clustering of 30 and of 120 segments: {few}, {many}");
    assert!(few > 0 && many <= 5 * few, "{few} and {many}");
}
