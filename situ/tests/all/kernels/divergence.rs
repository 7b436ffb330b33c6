//! Divergences against the values of the reference. The code is generic, so it is the same for poses.

use nalgebra::{Matrix6, Translation3, Vector3};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use situ::demonstration::{Gripper, Pose};
use situ::keyframe::divergence::{CERTAIN, cross_likelihood, monte_carlo, monte_carlo_against, transient_bound};
use situ::keyframe::hmm::{Emission, EmissionDensity, Hmm, HmmParameters, Observation};
use situ::keyframe::pose::{Tangent, exp, log};

use crate::kernels::sample::{passes, pose, pose_of, slices, vector};
use crate::kernels::scalar::{Scalar, left_to_right};

const DEVIATION: f64 = 0.5;
const SAMPLES: usize = 20_000;

fn diagonal(deviations: [f64; 6]) -> Matrix6<f64> {
    Matrix6::from_diagonal(&deviations.into()).map(|value| value * value)
}

fn emission(mean: Pose, covariance: Matrix6<f64>) -> Emission {
    Emission::new(mean, covariance, Matrix6::zeros(), None).expect("definite")
}

/// The same chain with one axis of the pose as its scalar.
fn in_six_dimensions(hmm: &Hmm<Scalar>) -> Hmm {
    let emissions = hmm.emissions.iter().map(|scalar| {
        emission(Pose::translation(0.0, scalar.mean, 0.0), diagonal([1.0, scalar.deviation, 1.0, 0.1, 0.1, 0.1]))
    });
    Hmm {
        initial: hmm.initial.clone(),
        transition: hmm.transition.clone(),
        end: hmm.end.clone(),
        emissions: emissions.collect(),
    }
}

#[test]
fn two_normal_distributions() {
    const EXPECTED: f64 = 0.443_147_180_559_945_3;
    let (p, q) = (Scalar { mean: 0.0, deviation: 1.0 }, Scalar { mean: 1.0, deviation: 2.0 });
    assert!((p.kl(&q) - EXPECTED).abs() < 1e-15);
    for axis in 0..6 {
        let mut wide = [0.7; 6];
        let mut narrow = wide;
        (narrow[axis], wide[axis]) = (1.0, 2.0);
        let mut step = Tangent::zeros();
        step[axis] = 1.0;
        let there = emission(exp(&Pose::identity(), &step), diagonal(wide));
        assert!((emission(Pose::identity(), diagonal(narrow)).kl(&there) - EXPECTED).abs() < 1e-14, "axis {axis}");
    }
}

/// One row of the reference: the bound and the Monte Carlo estimate of a whole sequence, and E[length].
fn check(p: &Hmm<Scalar>, q: &Hmm<Scalar>, length: f64, bound: f64, sampled: f64, error: f64) {
    assert!((p.expected_length() - length).abs() < 1e-12);
    assert!((transient_bound(p, q) * length - bound).abs() < 1e-12);
    let (p6, q6) = (in_six_dimensions(p), in_six_dimensions(q));
    assert!((transient_bound(&p6, &q6) * length - bound).abs() < 1e-9);
    let found = monte_carlo(p, q, SAMPLES, 7);
    let (mean, own_error) = (found.mean * length, found.standard_error * length);
    // Both are estimates, so this allows five standard errors of their difference. That of the reference is from
    // 100,000 sequences.
    assert!((mean - sampled).abs() < 5.0 * own_error.hypot(error), "{mean} ± {own_error} is not {sampled}");
    assert!((own_error / error / (100_000.0 / SAMPLES as f64).sqrt() - 1.0).abs() < 0.15, "{own_error}");
    assert!(mean < bound + 5.0 * own_error);
}

#[test]
fn the_values_of_the_reference() {
    let p = left_to_right(&[0.0, 1.0, 2.0], DEVIATION, 0.5);
    let moved = left_to_right(&[0.0, 1.0, 3.0], DEVIATION, 0.5);
    let slow = left_to_right(&[0.0, 1.0, 2.0], DEVIATION, 0.8);
    check(&p, &moved, 6.0, 4.0, 2.981, 0.008);
    check(&moved, &p, 6.0, 4.0, 3.833, 0.013);
    check(&p, &slow, 6.0, 1.338_861_307_885_259, 1.336, 0.004);
    check(&slow, &p, 15.0, 2.891_171_355_326_363, 2.901, 0.012);
}

#[test]
fn sampling_is_its_seed() {
    let p = left_to_right(&[0.0, 1.0], DEVIATION, 0.5);
    let q = left_to_right(&[0.5, 1.0], DEVIATION, 0.6);
    assert_eq!(monte_carlo(&p, &q, 100, 3), monte_carlo(&p, &q, 100, 3));
    assert_ne!(monte_carlo(&p, &q, 100, 3), monte_carlo(&p, &q, 100, 4));
    assert_eq!(monte_carlo(&p, &p, 100, 3).mean, 0.0);
    assert_eq!(monte_carlo(&p, &q, 1, 3).standard_error, f64::INFINITY);
    // q cannot do what p does.
    let mut shut = q.clone();
    (shut.transition[0], shut.transition[1]) = (0.0, 1.0);
    assert_eq!(transient_bound(&p, &shut), f64::INFINITY);
    let short = left_to_right(&[0.0], DEVIATION, 0.0);
    assert_eq!(monte_carlo(&p, &short, 100, 3).mean, f64::INFINITY);
    assert_eq!(monte_carlo(&p, &short, 100, 3).standard_error, f64::INFINITY);
}

/// Sampling against a cut draws no more than needed, and finds the same side as all samples. If the side stays
/// uncertain, it draws all.
#[test]
fn sampling_stops_when_the_side_of_the_cut_is_certain() {
    let p = left_to_right(&[0.0, 1.0, 2.0], DEVIATION, 0.5);
    let q = left_to_right(&[0.0, 1.0, 3.0], DEVIATION, 0.5);
    const MOST: usize = 1000;
    let all = 0.5 * (monte_carlo(&p, &q, MOST, 3).mean + monte_carlo(&q, &p, MOST, 3).mean);
    let mut drawn_before = MOST;
    for apart in [0.0, 0.05, 0.2, 0.4] {
        for cut in [all - apart, all + apart] {
            let (found, drawn) = monte_carlo_against(&p, &q, MOST, 3, cut);
            if apart == 0.0 {
                assert_eq!((found.mean.to_bits(), drawn), (all.to_bits(), MOST));
            } else {
                assert_eq!(found.mean > cut, all > cut, "{cut}: {found:?} of {drawn}");
                assert!(drawn == MOST || (found.mean - cut).abs() > CERTAIN * found.standard_error);
                assert!(drawn <= drawn_before, "{drawn} samples at {apart}");
            }
        }
        drawn_before = monte_carlo_against(&p, &q, MOST, 3, all + apart)
            .1
            .max(monte_carlo_against(&p, &q, MOST, 3, all - apart).1);
    }
    assert!(drawn_before < MOST / 4, "{drawn_before} samples for what is far from the cut");
    let short = left_to_right(&[0.0], DEVIATION, 0.0);
    assert_eq!(monte_carlo_against(&p, &short, MOST, 3, 1e9).0.mean, f64::INFINITY);
}

/// The formula: ½ [(log p(X_p) − log q(X_p)) / |X_p| + (log q(X_q) − log p(X_q)) / |X_q|].
#[test]
fn cross_likelihood_is_its_formula() {
    let (first, second) = (passes(1, 2, 3, 0.01, 0.1), passes(2, 3, 3, 0.01, 0.1));
    let model = |data: &[Vec<Observation>], states| {
        Hmm::fit(&slices(data), states, &HmmParameters::default()).expect("fits").hmm
    };
    let (p, q) = (model(&first, 3), model(&second, 2));
    let frames = |data: &[Vec<Observation>]| data.iter().flatten().count() as f64;
    let total = |hmm: &Hmm, data: &[Vec<Observation>]| -> f64 { data.iter().map(|xs| hmm.log_likelihood(xs)).sum() };
    let expected = 0.5
        * ((total(&p, &first) - total(&q, &first)) / frames(&first)
            + (total(&q, &second) - total(&p, &second)) / frames(&second));
    let found = cross_likelihood(&p, &first, &q, &second);
    assert!((found - expected).abs() < 1e-12 * expected.abs());
    assert_eq!(found.to_bits(), cross_likelihood(&q, &second, &p, &first).to_bits());
    assert!(found > 0.0);
    assert_eq!(cross_likelihood(&p, &first, &p, &first), 0.0);
}

/// Exhaustive: every assignment that never goes back.
fn brute_force_alignment(p: &Hmm<Scalar>, q: &Hmm<Scalar>) -> f64 {
    fn go(p: &Hmm<Scalar>, q: &Hmm<Scalar>, visits: &[f64], state: usize, from: usize) -> f64 {
        if state == p.states() {
            return 0.0;
        }
        let bernoulli = |a: f64, b: f64| a * (a / b).ln() + (1.0 - a) * ((1.0 - a) / (1.0 - b)).ln();
        (from..q.states())
            .map(|other| {
                let stay = bernoulli(p.transition[state * (p.states() + 1)], q.transition[other * (q.states() + 1)]);
                visits[state] * (p.emissions[state].kl(&q.emissions[other]) + stay) + go(p, q, visits, state + 1, other)
            })
            .fold(f64::INFINITY, f64::min)
    }
    go(p, q, &p.expected_visits(), 0, 0) / p.expected_length()
}

proptest! {
    #[test]
    fn different_numbers_of_states_are_aligned(
        (left, right) in (prop::collection::vec(-2.0..2.0, 1..5), prop::collection::vec(-2.0..2.0, 1..5))
            .prop_filter("as many states", |(left, right)| left.len() != right.len()),
        stay in (0.1..0.9, 0.1..0.9),
    ) {
        let (p, q) = (left_to_right(&left, DEVIATION, stay.0), left_to_right(&right, DEVIATION, stay.1));
        let expected = brute_force_alignment(&p, &q);
        prop_assert!((transient_bound(&p, &q) - expected).abs() < 1e-11 * expected.max(1.0));
    }

    /// KL does not depend on the orientation from which both are seen. It is 0 between equals and above 0 otherwise.
    #[test]
    fn the_divergence_of_poses_is_geometric(
        means in (pose(), pose()),
        turn in vector(1.5),
        entries in prop::collection::vec(-1.0..1.0, 72),
    ) {
        // The angle stays below half a turn, where the logarithm is smooth.
        prop_assume!(log(&means.0, &means.1).fixed_rows::<3>(3).norm() < 3.0);
        let covariance = |entries: &[f64]| {
            let root = Matrix6::from_row_slice(entries);
            0.01 * root * root.transpose() + Matrix6::identity() * 1e-3
        };
        let (p, q) = (emission(means.0, covariance(&entries[..36])), emission(means.1, covariance(&entries[36..])));
        let turn = pose_of([0.0; 3], turn).rotation;
        let turned = |e: &Emission| {
            emission(Pose::from_parts(e.mean.translation, turn * e.mean.rotation), e.covariance)
        };
        let found = p.kl(&q);
        prop_assert!(found > 0.0);
        prop_assert!((turned(&p).kl(&turned(&q)) - found).abs() < 1e-9 * found.max(1.0));
        prop_assert!(p.kl(&p).abs() < 1e-11);
    }

    /// A covariance is carried along the geodesic by reflection at its middle (one rung of a pole ladder, exact in a
    /// symmetric space). There it is the same covariance, so only the distance of the means is left.
    #[test]
    fn a_covariance_is_carried_along_the_geodesic(
        base in pose(),
        step in (vector(0.2), vector(1.2)),
        entries in prop::collection::vec(-1.0..1.0, 36),
    ) {
        let root = Matrix6::from_row_slice(&entries);
        let covariance: Matrix6<f64> = 0.01 * root * root.transpose() + Matrix6::identity() * 1e-3;
        let tangent = Tangent::from_fn(|axis, _| if axis < 3 { step.0[axis] } else { step.1[axis - 3] });
        let (there, middle) = (exp(&base, &tangent), exp(&base, &(tangent * 0.5)).rotation);
        let reflected = |vector: Vector3<f64>| {
            let back = exp(&base, &Tangent::new(0.0, 0.0, 0.0, -vector.x, -vector.y, -vector.z)).rotation;
            let image = Pose::from_parts(Translation3::identity(), middle * back.inverse() * middle);
            log(&Pose::from_parts(Translation3::identity(), there.rotation), &image).fixed_rows::<3>(3).into_owned()
        };
        let mut transport = Matrix6::identity();
        for axis in 0..3 {
            transport.fixed_view_mut::<3, 1>(3, 3 + axis).copy_from(&reflected(Vector3::ith(axis, 1.0)));
        }
        let carried = transport * covariance * transport.transpose();
        let inverse = covariance.try_inverse().expect("definite");
        let expected = 0.5 * (tangent.transpose() * inverse * tangent)[0];
        let found = emission(base, covariance).kl(&emission(there, (carried + carried.transpose()) * 0.5));
        prop_assert!((found - expected).abs() < 1e-9 * expected.max(1.0), "{found} is not {expected}");
    }
}

/// The closed form against the mean log ratio of draws. The rotations are close, so the space is nearly flat.
#[test]
fn the_divergence_of_poses_is_what_sampling_finds() {
    let full = Hmm::fit(&slices(&passes(5, 4, 2, 0.01, 0.05)), 2, &HmmParameters::default()).expect("fits").hmm;
    let p = &full.emissions[0];
    let near = exp(&p.mean, &Tangent::new(0.02, -0.01, 0.03, 0.05, -0.1, 0.08));
    let gripper = full.emissions[1].gripper;
    let q = Emission::new(near, p.covariance * 1.5, p.scatter, gripper).expect("definite");
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let draws: Vec<f64> = (0..SAMPLES)
        .map(|_| {
            let frame = p.sample(&mut rng);
            assert!(matches!(frame.gripper, Some(Gripper::Opening(_) | Gripper::Open(_) | Gripper::Close(_))));
            p.log_density(&frame) - q.log_density(&frame)
        })
        .collect();
    let mean = draws.iter().sum::<f64>() / SAMPLES as f64;
    let variance = draws.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / SAMPLES as f64;
    assert!((mean - p.kl(&q)).abs() < 5.0 * (variance / SAMPLES as f64).sqrt() + 0.01 * mean, "{mean} {}", p.kl(&q));
}

/// Draws have the mean and the whole covariance of the emission, with its correlations.
#[test]
fn draws_have_the_covariance_of_the_emission() {
    let mut root =
        Matrix6::from_fn(|row, column| if row == column { 0.1 } else { 0.02 * (row as f64 - column as f64) });
    root[(4, 1)] = -0.1;
    let p = emission(pose_of([0.1, 0.2, 0.3], [1.0, 0.5, -2.0]), root * root.transpose());
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let draws: Vec<Tangent> = (0..SAMPLES).map(|_| log(&p.mean, &p.sample(&mut rng).pose)).collect();
    let found = draws.iter().map(|draw| draw * draw.transpose()).sum::<Matrix6<f64>>() / SAMPLES as f64;
    let mean = draws.iter().sum::<Tangent>() / SAMPLES as f64;
    assert!(p.mahalanobis_squared(&mean) < 22.5 / SAMPLES as f64, "beyond the 99.9th percentile of χ²₆");
    for row in 0..6 {
        for column in 0..6 {
            let scale = (p.covariance[(row, row)] * p.covariance[(column, column)]).sqrt();
            let error = (found - p.covariance)[(row, column)] / scale;
            assert!(error.abs() < 5.0 * (2.0 / SAMPLES as f64).sqrt(), "{row}, {column}: {error}");
        }
    }
}
