//! The matrix normal inverse Wishart posterior, against other ways to the same numbers.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use situ::method::bp_ar_hmm::sampler::{Dynamics, DynamicsPrior, Statistics};
use situ::random::standard_normal;

fn prior() -> DynamicsPrior<2> {
    DynamicsPrior {
        precision: Matrix2::new(0.7, 0.2, 0.2, 0.5),
        scale: Matrix2::new(1.5, -0.4, -0.4, 0.9),
        freedom: 5.0,
    }
}

fn frames(count: usize) -> Vec<(Vector2<f64>, Vector2<f64>)> {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut normal = || Vector2::from_fn(|_, _| standard_normal(&mut rng));
    (0..count)
        .map(|_| {
            let lagged = normal() * 2.0;
            (Matrix2::new(0.6, -0.5, 0.4, 0.8) * lagged + normal() * 0.7, lagged)
        })
        .collect()
}

fn said<const D: usize>(frames: &[(SVector<f64, D>, SVector<f64, D>)]) -> Statistics<D> {
    let mut statistics = Statistics::default();
    frames.iter().for_each(|(current, lagged)| statistics.add(current, lagged, 1.0));
    statistics
}

/// Bayes's rule: evidence × posterior = prior × likelihood, at any θ. If one term of the densities or of the evidence
/// were wrong, this would fail.
#[test]
fn evidence_is_prior_times_likelihood_over_posterior_wherever_it_is_asked() {
    let (prior, frames) = (prior(), frames(9));
    let statistics = said(&frames);
    let evidence = prior.log_evidence(&statistics).unwrap();
    let posterior = prior.posterior(&statistics).unwrap();
    let before = prior.posterior(&Statistics::default()).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for turn in 0..20 {
        let theta = if turn % 2 == 0 { &posterior } else { &before }.draw(&mut rng).unwrap();
        let likelihood: f64 = frames.iter().map(|(current, lagged)| theta.log_density(current, lagged)).sum();
        let found = before.log_density(&theta) + likelihood - posterior.log_density(&theta);
        assert!((found - evidence).abs() < 1e-8 * evidence.abs(), "{found} is not {evidence}");
    }
}

/// In one dimension it is a Student's t: x ~ t_ν(0, S₀/ν · (1 + y²/K⁻¹)), frame by frame, each given the frames before.
#[test]
fn one_dimension_is_a_product_of_students() {
    let (precision, scale, freedom): (f64, f64, f64) = (0.5, 0.8, 3.0);
    let prior = DynamicsPrior {
        precision: SMatrix::<f64, 1, 1>::from_element(precision),
        scale: SMatrix::from_element(scale),
        freedom,
    };
    let frames: Vec<_> = [(0.3, -1.0), (1.4, 0.2), (-0.9, 1.1), (2.5, 2.0)]
        .map(|(current, lagged)| (SVector::from([current]), SVector::from([lagged])))
        .to_vec();
    let found = prior.log_evidence(&said(&frames)).unwrap();
    // Recursive least squares, one frame at a time.
    let (mut slope, mut weight, mut rest, mut freedom) = (0.0, precision, scale, freedom);
    let mut expected = 0.0;
    for (current, lagged) in &frames {
        let (x, y) = (current[0], lagged[0]);
        let spread = rest / freedom * (1.0 + y * y / weight);
        let surprise = (x - slope * y).powi(2) / spread;
        expected += libm::lgamma(0.5 * (freedom + 1.0))
            - libm::lgamma(0.5 * freedom)
            - 0.5 * (freedom * core::f64::consts::PI * spread).ln()
            - 0.5 * (freedom + 1.0) * (surprise / freedom).ln_1p();
        rest += (x - slope * y).powi(2) / (1.0 + y * y / weight);
        slope = (slope * weight + x * y) / (weight + y * y);
        weight += y * y;
        freedom += 1.0;
    }
    assert!((found - expected).abs() < 1e-11, "{found} is not {expected}");
}

/// The means of draws: that of A is S_xy S_yy⁻¹, that of Σ is S / (ν + n − D − 1). Each entry is within 4.5 standard
/// errors.
#[test]
fn draws_have_the_posterior_means() {
    const DRAWS: usize = 40_000;
    let posterior = prior().posterior(&said(&frames(9))).unwrap();
    let mean = posterior.at_mean().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let draws: Vec<Dynamics<2>> = (0..DRAWS).map(|_| posterior.draw(&mut rng).unwrap()).collect();
    let check = |value: &dyn Fn(&Dynamics<2>) -> f64| {
        let values: Vec<f64> = draws.iter().map(value).collect();
        let found = values.iter().sum::<f64>() / DRAWS as f64;
        let spread = values.iter().map(|value| (value - found).powi(2)).sum::<f64>() / DRAWS as f64;
        let z = (found - value(&mean)) / (spread / DRAWS as f64).sqrt();
        assert!(z.abs() < 4.5, "{found} is not {}, z {z}", value(&mean));
    };
    for entry in 0..4 {
        check(&|own| own.transition[entry]);
        check(&|own| own.covariance[entry]);
    }
}
