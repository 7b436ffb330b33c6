//! When two policies are the same primitive (decisions D6, D6b), and how far one is displaced from another (decision
//! D18).

use std::sync::Arc;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use situ::demonstration::Gripper;
use situ::keyframe::learner::{Calibration, KeyframeLearner};
use situ::keyframe::parameters::{Divergence, KeyframeParameters};
use situ::keyframe::policy::KeyframePolicy;
use situ::primitive::Learner;
use situ::random::standard_normal;
use situ::segment::{RelativeKeyframe, Segment};
use situ::state::{Feature, Schema, State};
use situ::trace::Counters;

use crate::kernels::sample::pose_of;

const OPEN: Gripper = Gripper::Open(0.08);
const CLOSE: Gripper = Gripper::Close(30.0);
/// A pick: over the thing, at it, and up again.
const PICK: [([f64; 3], Gripper); 3] =
    [([0.0, 0.0, 0.13], OPEN), ([0.0, 0.0, 0.012], CLOSE), ([0.0, 0.0, 0.15], CLOSE)];

fn learner(parameters: KeyframeParameters) -> KeyframeLearner {
    let schema = Schema::new(vec![Feature { name: "x".to_owned(), scale: 1.0 }]).unwrap();
    KeyframeLearner::new(&schema, parameters)
}

fn segment(reference: &str, keyframes: &[([f64; 3], Gripper)]) -> Segment {
    let keyframe =
        |&(at, gripper): &([f64; 3], Gripper)| RelativeKeyframe { pose: pose_of(at, [0.0; 3]), gripper, hold: 0.0 };
    let reference: Arc<str> = reference.into();
    let keyframes = keyframes.iter().map(keyframe).collect();
    Segment { reference, start: State::new([0.0]), keyframes, narration: Vec::new() }
}

/// Each keyframe is off by 1 cm on each axis, as novices give it in free space.
fn noisy(keyframes: &[([f64; 3], Gripper)], rng: &mut ChaCha8Rng) -> Vec<([f64; 3], Gripper)> {
    keyframes.iter().map(|(at, gripper)| (at.map(|axis| axis + 0.01 * standard_normal(rng)), *gripper)).collect()
}

/// What is believed of a teacher of whom nothing was seen: 2 cm.
fn untaught(learner: &KeyframeLearner) -> Calibration {
    learner.calibrate(&[], &mut Counters::default()).unwrap()
}

fn fitted(segments: &[Segment]) -> KeyframePolicy {
    let segments: Vec<&Segment> = segments.iter().collect();
    let learner = learner(KeyframeParameters::default());
    learner.fit_policy(&segments, &untaught(&learner), &mut Counters::default()).unwrap()
}

#[test]
fn a_keyframe_moved_is_told_from_noise_and_from_a_keyframe_more() {
    let learner = learner(KeyframeParameters::default());
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut noise, mut moved): (f64, f64) = (0.0, f64::INFINITY);
    for _ in 0..200 {
        let originals: Vec<Segment> = (0..3).map(|_| segment("cube", &noisy(&PICK, &mut rng))).collect();
        let policy = fitted(&originals);
        let displacement = |keyframes: &[([f64; 3], Gripper)]| {
            let other = fitted(&[segment("cube", keyframes)]);
            learner.displacement(&policy, &other, &untaught(&learner), false).metres
        };
        noise = noise.max(displacement(&noisy(&PICK, &mut rng)));
        let mut near = noisy(&PICK, &mut rng);
        near[1].0[0] += 0.10;
        moved = moved.min(displacement(&near));
        // A needless keyframe neither makes a displacement nor hides one.
        let needless = ([0.3, 0.1, 0.2], OPEN);
        let mut more = noisy(&PICK, &mut rng);
        more.insert(0, needless);
        noise = noise.max(displacement(&more));
        near.insert(0, needless);
        moved = moved.min(displacement(&near));
    }
    assert!(noise < 0.07 && moved > 0.065 && moved > noise, "noise {noise} m, moved {moved} m");
    // Without noise it is the distance itself.
    let mut exact = PICK;
    exact[2].0 = [0.0, 0.08, 0.15];
    let (pick, exact) = (fitted(&[segment("cube", &PICK)]), fitted(&[segment("cube", &exact)]));
    let displaced = learner.displacement(&pick, &exact, &untaught(&learner), false);
    assert!((displaced.metres - 0.08).abs() < 1e-9 && (displaced.scatters - 4.0).abs() < 1e-9, "{displaced:?}");
}

#[test]
fn neither_another_object_nor_another_grip_is_the_same_primitive() {
    // A place on the cube leads along much the same poses as a pick of it.
    let place = [([0.0, 0.0, 0.12], CLOSE), ([0.0, 0.0, 0.064], OPEN), ([0.0, 0.0, 0.18], OPEN)];
    let [pick, again, place, other] = [
        fitted(&[segment("cube", &PICK)]),
        fitted(&[segment("cube", &PICK)]),
        fitted(&[segment("cube", &place)]),
        fitted(&[segment("ball", &PICK)]),
    ];
    let distance = |parameters: KeyframeParameters, to: &KeyframePolicy| {
        learner(parameters).distance(&pick, to, None, &mut Counters::default())
    };
    let default = KeyframeParameters::default;
    assert!(distance(default(), &again) < 1e-9);
    assert_eq!(distance(default(), &place), f64::INFINITY);
    assert_eq!(distance(default(), &other), f64::INFINITY);
    let cut = 10.0;
    assert!(distance(KeyframeParameters { across_grips: true, ..default() }, &place) < cut, "they would be one");
    assert!(distance(KeyframeParameters { across_references: true, ..default() }, &other) < 1e-9);
}

/// Decision D8: if two originals of one role end with different grips, no cut joins them, and they do not move the cut.
#[test]
fn another_grip_among_the_originals_does_not_move_the_cut() {
    let learner = learner(KeyframeParameters::default());
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut cut = |last: Gripper| {
        let originals: Vec<Vec<Arc<Segment>>> = (0..4)
            .map(|original| {
                let mut lift = noisy(&PICK, &mut rng);
                if original == 3 {
                    lift[2].1 = last;
                }
                vec![segment("ball", &noisy(&PICK, &mut rng)).into(), segment("cube", &lift).into()]
            })
            .collect();
        let originals: Vec<&[Arc<Segment>]> = originals.iter().map(Vec::as_slice).collect();
        learner.calibrate(&originals, &mut Counters::default()).unwrap().cut
    };
    let (same, other) = (cut(CLOSE), cut(OPEN));
    assert!((2.0..10.0).contains(&same) && (2.0..10.0).contains(&other), "{same}, {other} nats");
}

/// What is calibrated and clustered together is what is calibrated and then clustered, and each distance of a pair is
/// that of the two alone, bit for bit. Together each segment is fitted once, and so is each pair compared.
#[test]
fn together_is_one_after_the_other() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut moved = PICK;
    moved[1].0[0] += 0.3;
    let originals: Vec<Vec<Arc<Segment>>> = (0..40)
        .map(|original| {
            let second = noisy(if original % 3 == 0 { &moved } else { &PICK }, &mut rng);
            vec![segment("ball", &noisy(&PICK, &mut rng)).into(), segment("cube", &second).into()]
        })
        .collect();
    let originals: Vec<&[Arc<Segment>]> = originals.iter().map(Vec::as_slice).collect();
    let pooled: Vec<&Segment> = originals.iter().copied().flatten().map(|segment| &**segment).collect();
    for divergence in [Divergence::CrossLikelihood, Divergence::TransientBound, Divergence::MonteCarlo(60)] {
        let learner = learner(KeyframeParameters { divergence, ..KeyframeParameters::default() });
        let (mut apart, mut together) = (Counters::default(), Counters::default());
        let calibration = learner.calibrate(&originals, &mut apart).unwrap();
        let labels = learner.cluster(&pooled, &calibration, &mut apart).unwrap();
        let found = learner.calibrate_and_cluster(&originals, &mut together).unwrap();
        assert_eq!(found, (calibration, labels));
        assert!(found.1.iter().max() > Some(&1), "the cubes are of two kinds");
        if !matches!(divergence, Divergence::MonteCarlo(_)) {
            // A segment has a model of its keyframes and one of its interpolation.
            assert_eq!((together.hmm_fits, together.divergences), (2 * 80, 2 * 40 * 39 / 2));
        }
    }
    let learner = learner(KeyframeParameters::default());
    let policies: Vec<KeyframePolicy> = pooled.iter().map(|segment| fitted(&[(*segment).clone()])).collect();
    let mut pairs: Vec<f64> = vec![5.0; 3];
    for object in [0, 1] {
        let own: Vec<&KeyframePolicy> = policies.iter().skip(object).step_by(2).collect();
        for (index, left) in own.iter().enumerate() {
            let distance = |right: &&KeyframePolicy| learner.distance(left, right, None, &mut Counters::default());
            pairs.extend(own[index + 1..].iter().map(distance));
        }
    }
    pairs.sort_by(f64::total_cmp);
    let rank = 0.95 * (pairs.len() - 1) as f64;
    let below = pairs[rank as usize];
    let cut = 1.5 * (below + (rank - rank.floor()) * (pairs[rank as usize + 1] - below));
    let parameters = KeyframeParameters::default().cut;
    let found = learner.calibrate(&originals, &mut Counters::default()).unwrap().cut;
    assert_eq!(found.to_bits(), cut.clamp(parameters.least, parameters.greatest).to_bits());
    assert_eq!(parameters.prior_copies, 3);
}

/// The bound is above what sampling finds, and no more than a few times that where two policies are near.
#[test]
fn the_bound_is_above_what_sampling_finds() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let by = |divergence| learner(KeyframeParameters { divergence, ..KeyframeParameters::default() });
    let (bound, sampled) = (by(Divergence::TransientBound), by(Divergence::MonteCarlo(500)));
    for moved in [0.02, 0.04, 0.06] {
        let mut policy = |moved: f64| {
            let mut keyframes = PICK;
            keyframes[1].0[0] += moved;
            fitted(&(0..3).map(|_| segment("cube", &noisy(&keyframes, &mut rng))).collect::<Vec<_>>())
        };
        let (left, right) = (policy(0.0), policy(moved));
        let [bound, sampled] =
            [&bound, &sampled].map(|learner| learner.distance(&left, &right, None, &mut Counters::default()));
        assert!(bound > 0.95 * sampled && bound < 3.0 * sampled, "{moved}: {bound} above {sampled}");
    }
}
