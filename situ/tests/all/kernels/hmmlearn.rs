//! Expectation maximisation against hmmlearn. `data/mint_hmmlearn.py` explains how both become the same model.

use nalgebra::Matrix6;
use serde::Deserialize;
use situ::demonstration::Pose;
use situ::keyframe::hmm::{Emission, Hmm, HmmFit, HmmParameters, Observation};

use crate::kernels::sample::{pose_of, slices};

#[derive(Deserialize)]
struct Start {
    initial: Vec<f64>,
    transition: Vec<f64>,
    end: Vec<f64>,
    means: Vec<[f64; 6]>,
    covariances: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
struct Case {
    sequences: Vec<Vec<[f64; 3]>>,
    start: Start,
    log_likelihoods: Vec<f64>,
    initial: Vec<f64>,
    transition: Vec<f64>,
    end: Vec<f64>,
    means: Vec<[f64; 6]>,
    covariances: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
struct Minted {
    prior_weight: f64,
    position_floor: f64,
    rotation_floor: f64,
    iterations: usize,
    even_cut: Case,
    skips: Case,
}

fn minted() -> Minted {
    serde_json::from_str(include_str!("../data/hmmlearn.json")).expect("minted by the script beside it")
}

impl Minted {
    /// The chain is maximum likelihood there, so there is no floor. Nothing stops the fit before its iterations are
    /// over.
    fn parameters(&self, skip: bool) -> HmmParameters {
        HmmParameters {
            position_floor: self.position_floor,
            rotation_floor: [self.rotation_floor; 3],
            prior_weight: self.prior_weight,
            transition_floor: 0.0,
            skip,
            max_iterations: self.iterations,
            tolerance: 0.0,
            ..HmmParameters::default()
        }
    }
}

impl Case {
    /// The frames, all turned in the same way, which must not matter.
    fn sequences(&self, turn: [f64; 3]) -> Vec<Vec<Observation>> {
        let observe = |position: &[f64; 3]| Observation { pose: pose_of(*position, turn), gripper: None };
        self.sequences.iter().map(|sequence| sequence.iter().map(observe).collect()).collect()
    }

    fn check(&self, fit: &HmmFit, iterations: usize) {
        assert_eq!(fit.iterations, iterations);
        same("log likelihoods", &fit.log_likelihoods, &self.log_likelihoods, 1.0);
        same("initial", &fit.hmm.initial, &self.initial, 1.0);
        same("transition", &fit.hmm.transition, &self.transition, 1.0);
        same("end", &fit.hmm.end, &self.end, 1.0);
        for ((emission, mean), covariance) in fit.hmm.emissions.iter().zip(&self.means).zip(&self.covariances) {
            same("mean", emission.mean.translation.vector.as_slice(), &mean[..3], 0.01);
            // The rotations are all equal, so only the prior determines the scale of the rotation block.
            same("covariance", emission.covariance.as_slice(), covariance, 1e-4);
        }
    }
}

/// Compares relative to the greater of the value and `scale`, a typical value.
#[track_caller]
fn same(what: &str, found: &[f64], expected: &[f64], scale: f64) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (index, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!(
            (found - expected).abs() <= 1e-9 * expected.abs().max(scale),
            "{what} {index}: {found} is not {expected}"
        );
    }
}

#[test]
fn from_the_even_cut_every_iteration_is_the_same() {
    let minted = minted();
    for turn in [[0.0; 3], [0.3, -1.0, 2.0]] {
        let sequences = minted.even_cut.sequences(turn);
        let fit = Hmm::fit(&slices(&sequences), 4, &minted.parameters(false)).expect("fits");
        minted.even_cut.check(&fit, minted.iterations);
    }
}

#[test]
fn from_a_given_model_with_skips_and_ends_every_iteration_is_the_same() {
    let minted = minted();
    let case = &minted.skips;
    let start = Hmm {
        initial: case.start.initial.clone(),
        transition: case.start.transition.clone(),
        end: case.start.end.clone(),
        emissions: (case.start.means.iter().zip(&case.start.covariances))
            .map(|(mean, covariance)| {
                let mean = Pose::translation(mean[0], mean[1], mean[2]);
                Emission::new(mean, Matrix6::from_row_slice(covariance), Matrix6::zeros(), None).expect("definite")
            })
            .collect(),
    };
    let sequences = case.sequences([0.0; 3]);
    let fit = start.refit(&slices(&sequences), &minted.parameters(true)).expect("fits");
    case.check(&fit, minted.iterations);
}
