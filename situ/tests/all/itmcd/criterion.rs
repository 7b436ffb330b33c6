//! AICc and Akaike weights, by hand.

use situ::edit::Edit;
use situ::method::Method;
use situ::method::itmcd::Itmcd;
use situ::method::itmcd::candidate::Candidate;
use situ::method::itmcd::selection::{akaike_weights, corrected_akaike};
use situ::place::{NodeId, Place};

#[test]
fn the_criterion_is_what_the_hand_computes() {
    // 2·3 + 2·10 + 2·3·4/(20 − 3 − 1) = 6 + 20 + 1.5
    assert_eq!(corrected_akaike(-10.0, 3, 20), Some(27.5));
    // 2·1 − 2·4 + 2·1·2/(4 − 1 − 1) = 2 − 8 + 2
    assert_eq!(corrected_akaike(4.0, 1, 4), Some(-4.0));
    assert_eq!(corrected_akaike(-7.0, 0, 2), Some(14.0));
    assert_eq!(corrected_akaike(f64::NEG_INFINITY, 3, 20), Some(f64::INFINITY));
}

#[test]
fn too_many_parameters_are_refused() {
    for parameters in 0..40 {
        for observations in 0..40 {
            let defined = corrected_akaike(-1.0, parameters, observations).is_some();
            assert_eq!(defined, observations > parameters + 1, "k {parameters}, n {observations}");
        }
    }
}

#[test]
fn weights_are_relative_likelihoods() {
    // Δ = 0, 2 ln 2, 2 ln 4: supports 1, 1/2, 1/4.
    let criteria =
        [Some(10.0), Some(10.0 + 2.0 * 2_f64.ln()), None, Some(10.0 + 2.0 * 4_f64.ln()), Some(f64::INFINITY)];
    for (found, expected) in akaike_weights(&criteria).iter().zip([4.0 / 7.0, 2.0 / 7.0, 0.0, 1.0 / 7.0, 0.0]) {
        assert!((found - expected).abs() < 1e-15, "{found} {expected}");
    }
    assert_eq!(akaike_weights(&[None, Some(f64::INFINITY)]), [0.0, 0.0]);
    assert!(akaike_weights(&[]).is_empty());
}

#[test]
fn a_candidate_reads_as_what_it_does() {
    let (from, to) = (Place::Start, Place::Node(NodeId(3)));
    let texts = [
        (Candidate::Nothing, "none"),
        (Candidate::Edge { from, to: Place::End }, "edge(START -> END)"),
        (Candidate::Node { from, new: NodeId(5), to, segment: 1 }, "node(START -> z5 -> z3) by segment 1"),
        (Candidate::Modify { node: NodeId(3), segment: 0 }, "modify(z3) by segment 0"),
    ];
    for (candidate, text) in texts {
        assert_eq!(candidate.to_string(), text);
        assert_eq!(serde_json::to_value(candidate).unwrap(), text);
    }
    let made: Vec<Edit> = texts.iter().map(|(candidate, _)| candidate.edit()).collect();
    assert_eq!(made, [Edit::None, Edit::EdgeAddition, Edit::NodeAddition, Edit::NodeModification]);
}

#[test]
fn every_edit_can_be_chosen() {
    assert_eq!(Itmcd::default().edits(), Edit::ALL);
}
