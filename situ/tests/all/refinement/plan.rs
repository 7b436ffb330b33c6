//! The plan of least cost.

use proptest::prelude::*;
use situ::keyframe::pose::{Tangent, log};
use situ::method::refinement::cost_weights::{CostWeights, FEATURES, Physical, Rule};
use situ::method::refinement::cost_weights::{RANGES, features, plan};
use situ::method::refinement::{Refine, RefinedKeyframe};
use situ::segment::Segment;

use super::fixture::{apart, moved, pick, policy, segment};

fn weights() -> impl Strategy<Value = [f64; FEATURES]> {
    prop::array::uniform12(-1.0..1.0_f64)
}

fn displacements(keyframes: usize) -> impl Strategy<Value = Vec<Tangent>> {
    let tangent = prop::array::uniform6(-1.0..1.0_f64).prop_map(Tangent::from);
    prop::collection::vec(tangent, keyframes)
}

fn problem() -> impl Strategy<Value = (Vec<bool>, [f64; FEATURES], Vec<Tangent>)> {
    prop::collection::vec(any::<bool>(), 1..8)
        .prop_flat_map(|contacts| (Just(contacts.clone()), weights(), displacements(contacts.len())))
}

/// J(u) = Σ_g (1/2n_g) Σ_{k ∈ g} |u_k|² + wᵀ φ(u), the groups g being the free keyframes and the contacts.
fn cost(contacts: &[bool], displacements: &[Tangent], weights: &[f64; FEATURES]) -> f64 {
    let size = |group: bool| contacts.iter().filter(|contact| **contact == group).count() as f64;
    let distances = contacts.iter().zip(displacements).map(|(contact, moved)| 0.5 * moved.dot(moved) / size(*contact));
    let features = features(contacts, displacements);
    distances.sum::<f64>() + weights.iter().zip(features).map(|(weight, feature)| weight * feature).sum::<f64>()
}

proptest! {
    /// No other plan costs less, near or far.
    #[test]
    fn nothing_costs_less((contacts, weights, other) in problem(), scale in 1e-4..1.0_f64) {
        let best = plan(&contacts, &weights);
        let moved: Vec<Tangent> = best.iter().zip(&other).map(|(best, other)| best + other * scale).collect();
        let (least, more) = (cost(&contacts, &best, &weights), cost(&contacts, &moved, &weights));
        prop_assert!(more > least, "{} instead of {}", more, least);
    }

    /// Descent along numerical derivatives of the cost ends at the plan, from any start.
    #[test]
    fn descent_ends_there((contacts, weights, start) in problem()) {
        const STEP: f64 = 1e-4;
        let mut found = start;
        for _ in 0..200 {
            let mut gradient = vec![Tangent::zeros(); found.len()];
            for keyframe in 0..found.len() {
                for axis in 0..6 {
                    let mut at = |by: f64| {
                        found[keyframe][axis] += by;
                        let cost = cost(&contacts, &found, &weights);
                        found[keyframe][axis] -= by;
                        cost
                    };
                    gradient[keyframe][axis] = (at(STEP) - at(-STEP)) / (2.0 * STEP);
                }
            }
            for (found, gradient) in found.iter_mut().zip(&gradient) {
                *found -= gradient;
            }
        }
        for (found, planned) in found.iter().zip(plan(&contacts, &weights)) {
            prop_assert!((found - planned).norm() < 1e-5, "{} instead of {}", found, planned);
        }
    }

    /// One weight moves, the one with the greatest difference in ranges, and never beyond its limit.
    #[test]
    fn one_weight_at_a_time(before in weights(), shown in weights(), planned in weights()) {
        let mut after = before;
        Physical { ranges: &RANGES, gain: 0.5, limit: 1.5, one_at_a_time: true }.correct(&mut after, &shown, &planned);
        let share = |feature: usize| ((shown[feature] - planned[feature]) / RANGES[feature]).abs();
        for feature in 0..FEATURES {
            if (0..FEATURES).any(|other| share(other) > share(feature)) {
                prop_assert_eq!(after[feature], before[feature]);
            } else {
                let bound = 1.5 * RANGES[feature];
                let expected = (before[feature] - 0.5 * (shown[feature] - planned[feature])).clamp(-bound, bound);
                prop_assert!((after[feature] - expected).abs() < 1e-12);
            }
        }
    }
}

fn corrected(rule: Rule, corrections: &[Segment]) -> Vec<RefinedKeyframe> {
    let refine = CostWeights { rule };
    let original = segment(pick());
    let mut primitive = refine.fit(&policy(&[&original]), &[&original], &mut Default::default()).unwrap();
    for correction in corrections {
        refine.correct(&mut primitive, correction, &mut Default::default()).unwrap();
    }
    refine.keyframes(&primitive)
}

/// A shift can be expressed by the features. Every rule that moves all weights learns it from one correction; the other
/// learns one axis at a time.
#[test]
fn a_shift_is_learnt() {
    const BY: [f64; 3] = [0.0, 0.06, 0.10];
    let shifted = segment(pick().iter().map(|keyframe| moved(keyframe, BY)).collect());
    let errors = |rule, times| -> Vec<f64> {
        let found = corrected(rule, &vec![shifted.clone(); times]);
        found.iter().zip(&shifted.keyframes).map(|(found, shown)| apart(&found.mean.pose, &shown.pose)).collect()
    };
    for rule in [Rule::All, Rule::Coactive] {
        assert!(errors(rule, 1).iter().all(|error| *error < 1e-9), "{rule:?}: {:?}", errors(rule, 1));
    }
    // Free keyframes and contacts each have a height and an offset: four weights, four corrections.
    let remaining: Vec<f64> = (0..=4).map(|times| errors(Rule::OneAtATime, times).iter().sum()).collect();
    assert!(remaining.windows(2).all(|pair| pair[1] < pair[0] - 0.01), "{remaining:?}");
    assert!(remaining[4] < 1e-9, "{remaining:?}");
}

/// A bend cannot be expressed: if one of four free keyframes is moved, all four move, by a quarter of the way.
#[test]
fn a_bend_is_not() {
    let mut shown = pick();
    shown[1] = moved(&shown[1], [0.0, 0.12, 0.0]);
    let found = corrected(Rule::All, &[segment(shown)]);
    for (index, (found, original)) in found.iter().zip(pick()).enumerate() {
        let moved = log(&original.pose, &found.mean.pose)[1];
        let expected = if index == 2 { 0.0 } else { 0.03 };
        assert!((moved - expected).abs() < 1e-9, "keyframe {index}: {moved}");
    }
}

/// The features of the plan are its weights with the other sign.
#[test]
fn a_plan_has_the_features_that_its_weights_ask_for() {
    let weights: [f64; FEATURES] = std::array::from_fn(|feature| 0.1 * feature as f64 - 0.4);
    let contacts = [false, true, false, true, false];
    for (feature, weight) in features(&contacts, &plan(&contacts, &weights)).iter().zip(weights) {
        assert!((feature + weight).abs() < 1e-15);
    }
}
