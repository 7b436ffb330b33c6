//! Ridge logistic regression: the minima of scikit-learn, the gradient by finite differences, and both dimensions of
//! the step.

use proptest::prelude::*;
use serde::Deserialize;
use situ::keyframe::logistic::{LogisticError, LogisticFit, LogisticParameters, Path, fit, objective};

use crate::kernels::sample::slices;

#[derive(Deserialize)]
struct Case {
    rows: Vec<Vec<f64>>,
    labels: Vec<bool>,
    ridge: f64,
    balanced: bool,
    positive: f64,
    negative: f64,
    weights: Vec<f64>,
    intercept: f64,
    probabilities: Vec<f64>,
}

fn same(found: &LogisticFit, weights: &[f64], intercept: f64, tolerance: f64) -> bool {
    let pairs = found.weights.iter().zip(weights).chain([(&found.intercept, &intercept)]);
    pairs.into_iter().all(|(found, expected)| (found - expected).abs() <= tolerance * expected.abs().max(1.0))
}

#[test]
fn the_coefficients_are_those_of_scikit_learn() {
    let cases: Vec<Case> =
        serde_json::from_str(include_str!("../data/logistic.json")).expect("minted by the script beside it");
    for (index, case) in cases.iter().enumerate() {
        for path in [Path::Primal, Path::Dual, Path::Auto] {
            let parameters = LogisticParameters {
                ridge: case.ridge,
                balanced: case.balanced,
                positive: case.positive,
                negative: case.negative,
                tolerance: 1e-14,
                path,
                ..LogisticParameters::default()
            };
            let rows = slices(&case.rows);
            let found = fit(&rows, &case.labels, &parameters).expect("fits");
            assert!(same(&found, &case.weights, case.intercept, 1e-9), "case {index}, {path:?}: {found:?}");
            for (row, expected) in rows.iter().zip(&case.probabilities) {
                assert!((found.probability(row) - expected).abs() < 1e-10);
            }
        }
    }
}

/// Rows and labels of any shape: more features than samples or fewer, with one class missing or not.
fn data() -> impl Strategy<Value = (Vec<Vec<f64>>, Vec<bool>)> {
    (1_usize..14, 1_usize..14).prop_flat_map(|(n, d)| {
        (prop::collection::vec(prop::collection::vec(-3.0..3.0, d), n), prop::collection::vec(any::<bool>(), n))
    })
}

fn parameters() -> impl Strategy<Value = LogisticParameters> {
    let targets = prop_oneof![Just((0.95, 0.05)), (0.6..0.99, 0.01..0.4)];
    (1e-3..0.5, any::<bool>(), targets).prop_map(|(ridge, balanced, (positive, negative))| LogisticParameters {
        ridge,
        balanced,
        positive,
        negative,
        tolerance: 1e-12,
        ..LogisticParameters::default()
    })
}

proptest! {
    #[test]
    fn the_gradient_is_the_slope(
        (rows, labels) in data(),
        parameters in parameters(),
        at in prop::collection::vec(-2.0..2.0, 14),
    ) {
        let rows = slices(&rows);
        let d = rows[0].len();
        let (weights, intercept) = (&at[..d], at[13]);
        let (_, gradient) = objective(&rows, &labels, &parameters, weights, intercept);
        prop_assert_eq!(gradient.len(), d + 1);
        const STEP: f64 = 1e-5;
        for (axis, component) in gradient.iter().enumerate() {
            let moved = |step: f64| {
                let mut weights = weights.to_vec();
                let mut intercept = intercept;
                *weights.get_mut(axis).unwrap_or(&mut intercept) += step;
                objective(&rows, &labels, &parameters, &weights, intercept).0
            };
            let slope = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
            prop_assert!((component - slope).abs() < 1e-8 * slope.abs().max(1.0), "axis {axis}: {slope}");
        }
    }

    /// There is one minimum for every way: both dimensions, and rows in another order.
    #[test]
    fn every_way_finds_the_same_minimum((rows, labels) in data(), parameters in parameters()) {
        let views = slices(&rows);
        let by = |path| fit(&views, &labels, &LogisticParameters { path, ..parameters }).expect("fits");
        let primal = by(Path::Primal);
        prop_assert!(primal.converged);
        let (_, gradient) = objective(&views, &labels, &parameters, &primal.weights, primal.intercept);
        prop_assert!(gradient.iter().all(|component| component.abs() <= parameters.tolerance));
        let other = by(Path::Dual);
        prop_assert!(other.converged);
        prop_assert!(same(&other, &primal.weights, primal.intercept, 1e-8), "{other:?} is not {primal:?}");
        let reversed: Vec<&[f64]> = views.iter().rev().copied().collect();
        let other_labels: Vec<bool> = labels.iter().rev().copied().collect();
        let reversed = fit(&reversed, &other_labels, &parameters).expect("fits");
        prop_assert!(same(&reversed, &primal.weights, primal.intercept, 1e-8));
    }
}

/// Shapes near the sizes of the blocks of the matrices, against sums that are written out.
#[test]
fn any_number_of_samples_and_features_has_its_minimum() {
    for (n, d) in [(7, 7), (8, 8), (9, 15), (63, 16), (64, 17), (65, 24), (130, 3), (200, 12), (70, 90), (129, 131)] {
        let noise = |at: usize| 4.0 * (1e4 * f64::sin(at as f64)).fract();
        let rows: Vec<Vec<f64>> = (0..n).map(|row| (0..d).map(|at| noise(1 + row * d + at)).collect()).collect();
        let labels: Vec<bool> = rows.iter().enumerate().map(|(at, row)| row[0] + noise(at) > 0.5).collect();
        let parameters = LogisticParameters {
            ridge: 0.05,
            balanced: false,
            positive: 0.9,
            negative: 0.2,
            tolerance: 1e-12,
            ..LogisticParameters::default()
        };
        for path in [Path::Primal, Path::Dual] {
            let found = fit(&slices(&rows), &labels, &LogisticParameters { path, ..parameters }).expect("fits");
            assert!(found.converged, "{n} × {d}, {path:?}");
            let mut gradient: Vec<f64> = found.weights.iter().map(|weight| parameters.ridge * weight).collect();
            gradient.push(0.0);
            for (row, label) in rows.iter().zip(&labels) {
                let odds = found.intercept + row.iter().zip(&found.weights).map(|(x, weight)| x * weight).sum::<f64>();
                let residual = (1.0 / (1.0 + (-odds).exp()) - if *label { 0.9 } else { 0.2 }) / n as f64;
                gradient.iter_mut().zip(row.iter().chain([&1.0])).for_each(|(sum, x)| *sum += residual * x);
            }
            let steepest = gradient.iter().fold(0.0, |most: f64, part| most.max(part.abs()));
            assert!(steepest < 1e-11, "{n} × {d}, {path:?}: {steepest}");
        }
    }
}

/// The intercept is not penalised. With one class only, the target is reached exactly and no weight is needed.
#[test]
fn one_class_alone_gives_its_target() {
    let rows = [[1.0, 2.0, 0.5], [0.5, -1.0, 2.0]];
    let rows: Vec<&[f64]> = rows.iter().map(<[f64; 3]>::as_slice).collect();
    for path in [Path::Primal, Path::Dual] {
        let parameters = LogisticParameters { path, tolerance: 1e-13, ..LogisticParameters::default() };
        let found = fit(&rows, &[true, true], &parameters).expect("fits");
        assert!((found.intercept - (0.95_f64 / 0.05).ln()).abs() < 1e-10, "{found:?}");
        assert!(found.weights.iter().all(|weight| weight.abs() < 1e-10));
    }
}

/// Far from the minimum a sigmoid is flat, and a plain Newton step would be far too long.
#[test]
fn large_features_still_converge() {
    let rows: Vec<Vec<f64>> = (0..12).map(|at| vec![100.0 * f64::from(at), 50.0 - f64::from(at * at)]).collect();
    let labels: Vec<bool> = (0..12).map(|at| at >= 6).collect();
    for path in [Path::Primal, Path::Dual] {
        let parameters =
            LogisticParameters { path, tolerance: 1e-6, max_iterations: 500, ..LogisticParameters::default() };
        let cold = fit(&slices(&rows), &labels, &parameters).expect("fits");
        assert!(cold.converged, "{path:?}: {cold:?}");
        assert!(cold.probability(&rows[11]) > 0.9 && cold.probability(&rows[0]) < 0.1);
    }
}

#[test]
fn probabilities_do_not_overflow() {
    let sure = LogisticFit { weights: vec![1.0], intercept: 0.0, iterations: 0, converged: true };
    assert_eq!(sure.probability(&[1e6]), 1.0);
    assert_eq!(sure.probability(&[-1e6]), 0.0);
    assert_eq!(sure.probability(&[0.0]), 0.5);
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    let parameters = LogisticParameters::default();
    assert_eq!(fit(&[], &[], &parameters), Err(LogisticError::NoSample));
    let length = |what, found, expected| Err(LogisticError::Length { what, found, expected });
    assert_eq!(fit(&[&[1.0]], &[], &parameters), length("labels", 0, 1));
    assert_eq!(fit(&[&[1.0], &[1.0, 2.0]], &[true, false], &parameters), length("a row", 2, 1));
    let broken = fit(&[&[1.0], &[f64::NAN]], &[true, false], &parameters);
    assert_eq!(broken, Err(LogisticError::NotFinite { sample: 1, feature: 0 }));
    let wrong = LogisticParameters { ridge: 0.0, ..parameters };
    assert!(matches!(fit(&[&[1.0]], &[true], &wrong), Err(LogisticError::Parameter { parameter: "ridge", .. })));
}

/// Without features there is only the intercept: the log odds of the mean target.
#[test]
fn no_feature_and_one_sample_are_no_exception() {
    for path in [Path::Primal, Path::Dual] {
        let parameters = LogisticParameters { path, balanced: false, ..LogisticParameters::default() };
        let found = fit(&[&[], &[], &[]], &[true, false, false], &parameters).unwrap();
        let mean: f64 = (0.95 + 0.05 + 0.05) / 3.0;
        assert!(
            found.converged && found.weights.is_empty() && (found.probability(&[]) - mean).abs() < 1e-8,
            "{found:?}"
        );
        let found = fit(&[&[0.3, -2.0]], &[true], &parameters).unwrap();
        assert!(found.converged && (found.probability(&[0.3, -2.0]) - 0.95).abs() < 1e-6, "{found:?}");
    }
}

/// Each step that is taken is counted: with that many the fit ends, and with one fewer it is not there yet.
#[test]
fn steps_are_counted() {
    let noise = |at: usize| 4.0 * (1e4 * f64::sin(at as f64)).fract();
    let rows: Vec<Vec<f64>> = (0..40).map(|row| (0..5).map(|at| noise(1 + row * 5 + at)).collect()).collect();
    let labels: Vec<bool> = rows.iter().enumerate().map(|(at, row)| row[0] + noise(at) > 0.5).collect();
    for path in [Path::Primal, Path::Dual] {
        let by = |max_iterations| {
            let parameters = LogisticParameters { path, max_iterations, ..LogisticParameters::default() };
            fit(&slices(&rows), &labels, &parameters).unwrap()
        };
        let whole = by(LogisticParameters::default().max_iterations);
        assert!(whole.converged && whole.iterations > 1, "{whole:?}");
        assert_eq!(by(whole.iterations), whole);
        for fewer in 0..whole.iterations {
            let short = by(fewer);
            assert_eq!((short.iterations, short.converged), (fewer, false), "{path:?}");
        }
    }
}
