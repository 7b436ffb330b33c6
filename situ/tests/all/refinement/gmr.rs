//! Gaussian mixture regression.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::keyframe::pose::{Tangent, exp, log};
use situ::method::refinement::Refine;
use situ::method::refinement::tactile_gmr::mixture::{Component, CovariancePrior, Mixture, fit, regress};
use situ::method::refinement::tactile_gmr::{MixturePrimitive, TactileGmr};
use situ::random::{standard_normal, stream};
use situ::segment::{RelativeKeyframe, Segment};

use super::fixture::{apart, keyframe, moved, pick, policy, segment};

/// A random covariance: A Aᵀ, and a little more on the diagonal.
fn covariance(rng: &mut ChaCha8Rng) -> [[f64; 3]; 3] {
    let a: [[f64; 3]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| 0.5 * standard_normal(rng)));
    std::array::from_fn(|row| {
        std::array::from_fn(|column| {
            (0..3).map(|k| a[row][k] * a[column][k]).sum::<f64>() + if row == column { 0.05 } else { 0.0 }
        })
    })
}

fn mixture(seed: u64) -> Mixture<3> {
    let mut rng = ChaCha8Rng::seed_from_u64(stream(seed, "mixture"));
    let mut components: Vec<Component<3>> = (0..3)
        .map(|_| Component {
            weight: 0.2 + rng.random::<f64>(),
            mean: std::array::from_fn(|_| standard_normal(&mut rng)),
            covariance: covariance(&mut rng),
        })
        .collect();
    let sum: f64 = components.iter().map(|component| component.weight).sum();
    components.iter_mut().for_each(|component| component.weight /= sum);
    Mixture(components)
}

/// The density of a Gaussian of three numbers, by nalgebra's inverse and determinant.
fn density(component: &Component<3>, x: [f64; 3]) -> f64 {
    let covariance = nalgebra::Matrix3::from_fn(|row, column| component.covariance[row][column]);
    let error = nalgebra::Vector3::from(x) - nalgebra::Vector3::from(component.mean);
    let squared = (error.transpose() * covariance.try_inverse().unwrap() * error)[0];
    (-0.5 * squared).exp() / ((2.0 * std::f64::consts::PI).powi(3) * covariance.determinant()).sqrt()
}

/// The mean and the variance of the third number given the first two, by sums of the density over a fine grid.
#[test]
fn regression_is_the_conditional() {
    const STEP: f64 = 0.005;
    for seed in 0..20 {
        let mixture = mixture(seed);
        let mut rng = ChaCha8Rng::seed_from_u64(stream(seed, "input"));
        let input = [standard_normal(&mut rng), standard_normal(&mut rng)];
        let (mut mass, mut first, mut second) = (0.0, 0.0, 0.0);
        for index in -4000..=4000 {
            let y = f64::from(index) * STEP;
            let p: f64 = mixture.0.iter().map(|one| one.weight * density(one, [input[0], input[1], y])).sum();
            mass += p;
            first += p * y;
            second += p * y * y;
        }
        let (mean, variance) = (first / mass, second / mass - (first / mass).powi(2));
        let ([found], [[spread]]) = regress::<2, 1, 3>(&mixture, &input);
        assert!((found - mean).abs() < 1e-6, "{seed}: {found} instead of {mean}");
        assert!((spread - variance).abs() < 1e-6, "{seed}: {spread} instead of {variance}");
    }
}

/// The objective never falls, for any first labels, weights and number of Gaussians.
#[test]
fn the_objective_never_falls() {
    let mut iterations = 0;
    for seed in 0..50 {
        let truth = mixture(seed);
        let mut rng = ChaCha8Rng::seed_from_u64(stream(seed, "points"));
        let components = rng.random_range(1..6);
        let points: Vec<[f64; 3]> = (0..60)
            .map(|_| {
                let one = &truth.0[rng.random_range(0..3)];
                std::array::from_fn(|axis| one.mean[axis] + 0.3 * standard_normal(&mut rng))
            })
            .collect();
        let weights: Vec<f64> = points.iter().map(|_| 9.0 * rng.random::<f64>()).collect();
        let labels: Vec<usize> = points.iter().map(|_| rng.random_range(0..components)).collect();
        let prior = CovariancePrior { deviations: [0.05, 0.1, 0.2], weight: 1.0 };
        let objective = fit(&points, &weights, &labels, components, &prior).unwrap().objective;
        for pair in objective.windows(2) {
            assert!(pair[1] >= pair[0] - 1e-8 * pair[0].abs(), "{seed}: {objective:?}");
        }
        iterations += objective.len();
    }
    assert!(iterations > 500, "the fits take steps: {iterations}");
    let refused = fit(&[[f64::NAN; 3]], &[1.0], &[0], 1, &CovariancePrior { deviations: [0.1; 3], weight: 1.0 });
    assert!(refused.is_err());
}

fn noisy(keyframes: &[RelativeKeyframe], seed: u64) -> Segment {
    let mut rng = ChaCha8Rng::seed_from_u64(stream(seed, "noise"));
    let shake = |keyframe: &RelativeKeyframe| {
        let error = Tangent::from_fn(|axis, _| standard_normal(&mut rng) * if axis < 3 { 0.005 } else { 0.03 });
        RelativeKeyframe { pose: exp(&keyframe.pose, &error), ..*keyframe }
    };
    segment(keyframes.iter().map(shake).collect())
}

/// The distance of each keyframe of the regression from `expected`, after these corrections of the pick.
fn errors(corrections: &[Segment], expected: &[RelativeKeyframe]) -> Vec<f64> {
    let originals: Vec<Segment> = (0..3).map(|seed| noisy(&pick(), seed)).collect();
    let originals: Vec<&Segment> = originals.iter().collect();
    let mut primitive = TactileGmr.fit(&policy(&originals), &originals, &mut Default::default()).unwrap();
    for correction in corrections {
        TactileGmr.correct(&mut primitive, correction, &mut Default::default()).unwrap();
    }
    let found = TactileGmr.keyframes(&primitive);
    assert_eq!(found.len(), expected.len());
    found.iter().zip(expected).map(|(found, expected)| apart(&found.mean.pose, &expected.pose)).collect()
}

/// A corrected keyframe pulls the regression towards it by nine tenths of the way, and the others stay.
#[test]
fn a_corrected_keyframe_pulls_the_regression_there() {
    let before = errors(&[], &pick());
    println!("tactile_gmr: metres from the original keyframes, uncorrected: {before:.4?}");
    assert!(before.iter().all(|error| *error < 0.015), "{before:?}");
    for index in 0..pick().len() {
        let mut shown = pick();
        shown[index] = moved(&shown[index], [0.07, 0.0, 0.0975]);
        let after = errors(&[noisy(&shown, 10)], &shown);
        println!("tactile_gmr: keyframe {index} moved by 12 cm, metres from what was shown: {after:.4?}");
        assert!(after.iter().all(|error| *error < 0.03), "{index}: {after:?}");
    }
    let shown: Vec<_> = pick().iter().map(|keyframe| moved(keyframe, [0.07, 0.0, 0.0975])).collect();
    let after = errors(&[noisy(&shown, 10)], &shown);
    println!("tactile_gmr: all moved by 12 cm: {after:.4?}");
    assert!(after.iter().all(|error| *error < 0.03), "{after:?}");
}

/// A pour: to the cup, tilted by 2 rad there, back upright, and away. A correction tilts half a radian further.
#[test]
fn turns_are_regressed() {
    let tilted = |place: [f64; 3], tilt: f64| {
        let keyframe = keyframe(place, true);
        RelativeKeyframe { pose: exp(&keyframe.pose, &Tangent::new(0.0, 0.0, 0.0, tilt, 0.0, 0.0)), ..keyframe }
    };
    let pour = |tilt: f64| {
        vec![
            tilted([0.0, 0.1, 0.3], 0.0),
            tilted([0.0, 0.08, 0.2], tilt),
            tilted([0.0, 0.1, 0.25], 0.0),
            tilted([0.0, 0.4, 0.25], 0.0),
        ]
    };
    let originals: Vec<Segment> = (0..3).map(|seed| noisy(&pour(2.0), seed)).collect();
    let originals: Vec<&Segment> = originals.iter().collect();
    let policy = policy(&originals);
    let mut primitive = TactileGmr.fit(&policy, &originals, &mut Default::default()).unwrap();
    let turned = |primitive: &MixturePrimitive, expected: &[RelativeKeyframe]| -> Vec<f64> {
        let found = TactileGmr.keyframes(primitive);
        let pairs = found.iter().zip(expected);
        pairs.map(|(found, expected)| log(&expected.pose, &found.mean.pose).fixed_rows::<3>(3).norm()).collect()
    };
    let before = turned(&primitive, &pour(2.0));
    TactileGmr.correct(&mut primitive, &noisy(&pour(2.5), 10), &mut Default::default()).unwrap();
    let after = turned(&primitive, &pour(2.5));
    println!("tactile_gmr: radians from what was shown, before {before:.3?} and after {after:.3?} a correction");
    assert!(before.iter().chain(&after).all(|error| *error < 0.15), "{before:?} {after:?}");
}

/// When the regression takes over from the original policy, it is on average less than half a millimetre off, although
/// a mixture smooths.
#[test]
fn the_regression_takes_over_from_the_original_policy() {
    let mut distances = Vec::new();
    for draw in 0..20 {
        let originals: Vec<Segment> = (0..3).map(|seed| noisy(&pick(), 100 * draw + seed)).collect();
        let originals: Vec<&Segment> = originals.iter().collect();
        let policy = policy(&originals);
        let primitive = TactileGmr.fit(&policy, &originals, &mut Default::default()).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let means = policy.keyframes(situ::keyframe::policy::Execution::Mean, &mut rng);
        let found = TactileGmr.keyframes(&primitive);
        distances.extend(found.iter().zip(&means).map(|(found, mean)| apart(&found.mean.pose, &mean.pose)));
    }
    let mean = distances.iter().sum::<f64>() / distances.len() as f64;
    let greatest = distances.iter().copied().fold(0.0, f64::max);
    println!("tactile_gmr: {mean:.4} m from the original policy on average, {greatest:.4} m at the most");
    assert!(mean < 0.0005 && greatest < 0.002, "{mean} {greatest}");
}

#[test]
fn points_that_make_no_mixture_are_refused() {
    let prior = CovariancePrior { deviations: [0.1; 2], weight: 1.0 };
    let points = [[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]];
    let refused = |points: &[[f64; 2]], weights: &[f64], labels: &[usize]| {
        assert!(fit(points, weights, labels, 2, &prior).is_err(), "{points:?} {weights:?} {labels:?}");
    };
    assert!(fit(&points, &[1.0, 0.0, 2.0], &[0, 1, 1], 2, &prior).is_ok());
    refused(&points, &[1.0, 1.0], &[0, 1, 1]);
    refused(&points, &[1.0; 3], &[0, 1]);
    refused(&points[..2], &[1.0; 3], &[0, 1, 1]);
    refused(&points, &[1.0, -1.0, 1.0], &[0, 1, 1]);
    refused(&points, &[0.0; 3], &[0, 1, 1]);
    refused(&points, &[1.0; 3], &[0, 1, 2]);
    refused(&[[0.0, f64::INFINITY], [1.0, 1.0], [2.0, 0.0]], &[1.0; 3], &[0, 1, 1]);
    refused(&points, &[1.0, f64::NAN, 1.0], &[0, 1, 1]);
}

/// The fit goes on until it gains no more, and not much longer.
#[test]
fn the_fit_ends_where_it_gains_no_more() {
    let truth = mixture(1);
    let mut rng = ChaCha8Rng::seed_from_u64(stream(1, "end"));
    let points: Vec<[f64; 3]> = (0..60)
        .map(|index| std::array::from_fn(|axis| truth.0[index % 3].mean[axis] + 0.3 * standard_normal(&mut rng)))
        .collect();
    let labels: Vec<usize> = (0..60).map(|_| rng.random_range(0..3)).collect();
    let prior = CovariancePrior { deviations: [0.1; 3], weight: 1.0 };
    let objective = fit(&points, &[1.0; 60], &labels, 3, &prior).unwrap().objective;
    let gains: Vec<f64> = objective.windows(2).map(|pair| (pair[1] - pair[0]) / pair[1].abs()).collect();
    let (last, before) = gains.split_last().unwrap();
    assert!(*last <= 1e-7 && before.len() > 3 && before.iter().all(|gain| *gain > 1e-7), "{gains:?}");
}
