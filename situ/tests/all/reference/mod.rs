//! Speed changes no decision: over a thousand random corrections the learner of the crate makes the same automata as a
//! plain one, which shares none of its kernels.
//!
//! If a number fell on its threshold, rounding alone could change a decision. That happens in none of these.

mod classifier;
mod commands;
mod comparison;
mod hmm;
mod learner;
mod linkage;
mod pose;
pub(crate) mod scatter;
mod task;
mod true_keyframes;

use std::ops::Range;

use comparison::{Comparison, Summary};
use learner::Reference;
use situ::keyframe::parameters::{Activation, KeyframeParameters, Spurious};
use situ::trace::Branch;
use task::Task;

/// Corrections of one task, each folded into the model after the one before.
const CHAINED: usize = 20;

/// Teaches and corrects the tasks of these seeds with both learners.
///
/// # Panics
/// At the first difference.
fn side_by_side(seeds: Range<u64>, rule: &KeyframeParameters) -> Summary {
    let mut summary = Summary::default();
    for seed in seeds {
        summary.now = format!("task {seed}, taught");
        let mut task = Task::new(seed);
        let reference = Reference::new(&task.schema, rule.clone());
        let mut models = Comparison::taught(&mut task, reference, &mut summary);
        for correction in 0..CHAINED {
            summary.now = format!("task {seed}, correction {correction}");
            models.correct(&task.correction(), &mut summary);
        }
    }
    summary
}

/// Half of the thousand, so that two tests can run at once.
fn no_decision_differs(seeds: Range<u64>) {
    let summary = side_by_side(seeds, &KeyframeParameters::default());
    println!("{summary}");
    assert!(summary.corrections >= 500);
    for branch in [Branch::New, Branch::Existing, Branch::Modify] {
        assert!(summary.branch(branch) >= 50, "{branch:?} was hardly tested");
    }
    assert!(summary.ways[1] >= 50 && summary.ways[2] >= 50 && summary.older >= 10, "ways were hardly tested");
    assert!(summary.retired >= 10, "obedience was hardly tested");
}

#[test]
fn no_decision_differs_in_the_first_half() {
    no_decision_differs(0..25);
}

#[test]
fn no_decision_differs_in_the_second_half() {
    no_decision_differs(25..50);
}

/// A fault in a kernel, planted in the reference: it makes one re-estimation too few.
#[test]
#[should_panic(expected = "by the reference")]
fn a_re_estimation_less_is_noticed() {
    let mut rule = KeyframeParameters::default();
    rule.signature.max_iterations -= 1;
    side_by_side(0..2, &rule);
}

/// A fault that only shows in decisions.
#[test]
#[should_panic(expected = "steps")]
fn another_decision_is_noticed() {
    let activation = Activation::Bounded { factor: 2.0, least: 0.0 };
    side_by_side(0..2, &KeyframeParameters { activation, ..KeyframeParameters::default() });
}

/// A fault that only shows where a keyframe is spurious.
#[test]
#[should_panic(expected = "by the reference")]
fn a_spurious_keyframe_that_is_averaged_is_noticed() {
    side_by_side(0..2, &KeyframeParameters { spurious: Spurious::Averaged, ..KeyframeParameters::default() });
}
