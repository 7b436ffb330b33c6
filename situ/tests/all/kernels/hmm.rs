//! Inference against the enumeration of every path, on any chain.

use proptest::prelude::*;
use situ::keyframe::hmm::{EmissionDensity, Hmm};

use crate::kernels::scalar::{Scalar, left_to_right};

/// Probabilities in proportion to the weights.
fn normalised(weights: &[f64]) -> Vec<f64> {
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|weight| weight / sum).collect()
}

/// A weight in a row; some ways are shut.
fn weight() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 4 => 0.01..1.0]
}

/// Any chain of two or three states. Every state can end, but some sequences are impossible.
fn model() -> impl Strategy<Value = Hmm<Scalar>> {
    (2_usize..=3).prop_flat_map(|k| {
        let row = (prop::collection::vec(weight(), k), 0.01..1.0);
        let start = (prop::collection::vec(weight(), k - 1), 0.01..1.0);
        let emission = (-2.0..2.0, 0.3..2.0).prop_map(|(mean, deviation)| Scalar { mean, deviation });
        (start, prop::collection::vec(row, k), prop::collection::vec(emission, k)).prop_map(
            |((mut start, certain), rows, emissions)| {
                start.push(certain);
                let (mut transition, mut end) = (Vec::new(), Vec::new());
                for (mut row, last) in rows {
                    row.push(last);
                    let mut row = normalised(&row);
                    end.extend(row.pop());
                    transition.extend(row);
                }
                Hmm { initial: normalised(&start), transition, end, emissions }
            },
        )
    })
}

/// Every path with its probability: the product of its start, its transitions, its densities and its end.
fn paths(hmm: &Hmm<Scalar>, frames: &[f64]) -> Vec<(Vec<usize>, f64)> {
    let k = hmm.emissions.len();
    let mut paths: Vec<(Vec<usize>, f64)> = (0..k).map(|state| (vec![state], hmm.initial[state])).collect();
    for _ in 1..frames.len() {
        paths = paths
            .into_iter()
            .flat_map(|(path, probability)| {
                let before = path[path.len() - 1];
                (0..k).map(move |next| {
                    let mut longer = path.clone();
                    longer.push(next);
                    (longer, probability * hmm.transition[before * k + next])
                })
            })
            .collect();
    }
    for (path, probability) in &mut paths {
        for (state, frame) in path.iter().zip(frames) {
            *probability *= hmm.emissions[*state].log_density(frame).exp();
        }
        *probability *= hmm.end[path[path.len() - 1]];
    }
    paths
}

proptest! {
    #[test]
    fn every_path_enumerated_gives_the_same(hmm in model(), frames in prop::collection::vec(-3.0..3.0, 1..=3)) {
        let k = hmm.states();
        let paths = paths(&hmm, &frames);
        let total: f64 = paths.iter().map(|(_, probability)| probability).sum();
        let Some(found) = hmm.expectations(&frames) else {
            prop_assert_eq!(total, 0.0);
            prop_assert_eq!(hmm.log_likelihood(&frames), f64::NEG_INFINITY);
            return Ok(());
        };
        prop_assert!((hmm.log_likelihood(&frames) - total.ln()).abs() < 1e-11 * total.ln().abs().max(1.0));
        prop_assert_eq!(found.log_likelihood.to_bits(), hmm.log_likelihood(&frames).to_bits());
        let (mut occupancy, mut transitions) = (vec![0.0; frames.len() * k], vec![0.0; k * k]);
        for (path, probability) in &paths {
            for (frame, state) in path.iter().enumerate() {
                occupancy[frame * k + state] += probability / total;
            }
            for pair in path.windows(2) {
                transitions[pair[0] * k + pair[1]] += probability / total;
            }
        }
        let pairs = found.occupancy.iter().zip(&occupancy).chain(found.transitions.iter().zip(&transitions));
        for (found, expected) in pairs {
            prop_assert!((found - expected).abs() < 1e-11, "{found} is not {expected}");
        }

        let best = paths.iter().map(|(_, probability)| *probability).fold(0.0, f64::max);
        let (path, log_probability) = hmm.viterbi(&frames);
        prop_assert!((log_probability - best.ln()).abs() < 1e-11 * best.ln().abs().max(1.0));
        let own = paths.iter().find(|(other, _)| *other == path).expect("a path").1;
        prop_assert!(own >= best * (1.0 - 1e-11));
    }

    #[test]
    fn the_names_of_the_states_do_not_matter(hmm in model(), frames in prop::collection::vec(-3.0..3.0, 1..=6)) {
        let k = hmm.states();
        let at = |state: usize| (state + 1) % k;
        let renamed = Hmm {
            initial: (0..k).map(|state| hmm.initial[at(state)]).collect(),
            transition: (0..k * k).map(|cell| hmm.transition[at(cell / k) * k + at(cell % k)]).collect(),
            end: (0..k).map(|state| hmm.end[at(state)]).collect(),
            emissions: (0..k).map(|state| hmm.emissions[at(state)].clone()).collect(),
        };
        let (own, other) = (hmm.log_likelihood(&frames), renamed.log_likelihood(&frames));
        prop_assert!(own == other || (own - other).abs() < 1e-12 * own.abs().max(1.0));
        prop_assert!((hmm.expected_length() - renamed.expected_length()).abs() < 1e-9 * hmm.expected_length());
    }

    /// The visits are the series π (1 + A + A² + …).
    #[test]
    fn visits_are_the_sum_over_time(hmm in model()) {
        let k = hmm.states();
        let (mut now, mut visits) = (hmm.initial.clone(), vec![0.0; k]);
        for _ in 0..20_000 {
            visits.iter_mut().zip(&now).for_each(|(sum, share)| *sum += share);
            now = (0..k).map(|to| (0..k).map(|from| now[from] * hmm.transition[from * k + to]).sum()).collect();
        }
        for (found, expected) in hmm.expected_visits().iter().zip(&visits) {
            prop_assert!((found - expected).abs() < 1e-8 * expected.max(1.0), "{found} is not {expected}");
        }
    }
}

/// A scaled forward recursion loses the second state here. After the first frame that state is e^−800 times as likely
/// as the first, but it is on the only path that explains the third frame.
#[test]
fn a_path_far_less_likely_at_first_is_not_lost() {
    let mut hmm = left_to_right(&[0.0, 40.0, 0.0], 1.0, 0.5);
    hmm.transition[0] = 0.0;
    hmm.transition[1] = 1e-3;
    hmm.transition[2] = 0.999;
    hmm.transition[8] = 0.5;
    hmm.transition[4] = 1.0 - 1e-6;
    hmm.transition[5] = 0.0;
    hmm.end[1] = 1e-6;
    let frames = [0.0, 0.0, 90.0];
    let density = |mean: f64, frame: f64| Scalar { mean, deviation: 1.0 }.log_density(&frame);
    let through_the_second = density(0.0, 0.0)
        + 1e-3_f64.ln()
        + density(40.0, 0.0)
        + (1.0 - 1e-6_f64).ln()
        + density(40.0, 90.0)
        + 1e-6_f64.ln();
    assert!((hmm.log_likelihood(&frames) - through_the_second).abs() < 1e-9);
    assert_eq!(hmm.viterbi(&frames).0, [0, 1, 1]);
}

#[test]
fn what_never_ends_is_infinitely_long_and_what_has_no_frame_impossible() {
    let mut hmm = left_to_right(&[0.0, 1.0], 1.0, 0.5);
    assert!((hmm.expected_length() - 4.0).abs() < 1e-12);
    assert_eq!(hmm.log_likelihood(&[]), f64::NEG_INFINITY);
    assert!(hmm.expectations(&[]).is_none());
    assert_eq!(hmm.total_log_likelihood::<Vec<f64>>(&[]), 0.0);
    assert_eq!(hmm.total_log_likelihood::<Vec<f64>>(&[vec![], vec![]]), 0.0);
    assert_eq!(hmm.total_log_likelihood(&[vec![], vec![0.0]]), hmm.log_likelihood(&[0.0]));
    hmm.transition[3] = 1.0;
    hmm.end[1] = 0.0;
    assert_eq!(hmm.expected_length(), f64::INFINITY);
    assert_eq!(hmm.log_likelihood(&[0.0, 1.0]), f64::NEG_INFINITY);
    assert!(hmm.expectations(&[0.0, 1.0]).is_none());
}
