//! The updates that do not search for what a segment is: what they are told is what they do.

use crate::common::{CAREFUL, Planted, Task};
use situ::correction::{Correction, Oracle};
use situ::demonstration::{Demonstration, Keyframe};
use situ::edit::difference;
use situ::error::SituError;
use situ::method::{Learned, named};
use situ::place::Place;

const SEED: u64 = 3;

fn taught(name: &str, task: &Task) -> Box<dyn Learned> {
    named(name).unwrap().teach(&task.schema, &task.originals(3, CAREFUL), SEED).unwrap()
}

/// The upper bound is one: a method that is told the structure gets it right, in random tasks and at random places. So
/// does a method that hears the names, because here every skill has one name, and a skill that is shown again replaces
/// the old.
#[test]
fn who_is_told_makes_the_edit_that_is_needed() {
    for draw in 0..12 {
        let task = Task::new(draw, 5, 3);
        for method in ["oracle_edit", "narrated_hierarchy"] {
            let model = taught(method, &task);
            for planted in Planted::ALL {
                let correction = task.correction(planted, draw, CAREFUL, draw % 2 == 0);
                let oracle = correction.oracle();
                let graph = model.graph().unwrap();
                let mut model = model.boxed();
                let last = correction.last_in(&graph);
                model
                    .correct(Correction { oracle: Some(&oracle), ..Correction::after(last, &correction.demonstration) })
                    .unwrap();
                let made = difference(&graph, &model.graph().unwrap());
                assert_eq!(made.edit(), planted.edit(), "{method}, {planted:?}, draw {draw}: {made:?}");
            }
        }
    }
}

/// Each segment is a node of its own, whatever it shows.
#[test]
fn who_never_clusters_adds_a_node_a_segment() {
    for draw in 0..10 {
        let task = Task::new(draw, 5, 3);
        let mut model = taught("append_only", &task);
        for planted in Planted::ALL {
            let correction = task.correction(planted, draw, CAREFUL, true);
            let before = model.graph().unwrap();
            let trace =
                model.correct(Correction::after(correction.last_in(&before), &correction.demonstration)).unwrap();
            let made = difference(&before, &model.graph().unwrap());
            assert_eq!(made.nodes_added.len(), trace.steps.len(), "{planted:?}");
            assert_eq!((made.nodes_modified.len(), made.nodes_merged), (0, 0), "{planted:?}");
        }
    }
}

/// A demonstration without its narration.
fn silent(shown: &Demonstration, task: &Task) -> Demonstration {
    let keyframes = shown.keyframes().iter().map(|keyframe| Keyframe { narration: None, ..keyframe.clone() }).collect();
    Demonstration::new(
        shown.name().clone(),
        shown.kind(),
        &task.schema,
        keyframes,
        shown.final_state().clone(),
        shown.carried_to_end(),
    )
    .unwrap()
}

#[test]
fn who_must_be_told_refuses_silence() {
    let task = Task::new(1, 5, 3);
    let correction = task.correction(Planted::NewNode, 1, CAREFUL, true);
    let originals: Vec<_> = task.originals(2, CAREFUL).iter().map(|shown| silent(shown, &task)).collect();
    for name in ["oracle_edit", "narrated_hierarchy"] {
        let refused = named(name).unwrap().teach(&task.schema, &originals, SEED).map(|_| ());
        assert!(matches!(refused, Err(SituError::Silent { ref method, .. }) if *method == name), "{refused:?}");
        let mut model = taught(name, &task);
        let before = model.to_json();
        let silent = silent(&correction.demonstration, &task);
        let oracle = Oracle::default();
        let refused = model.correct(Correction { oracle: Some(&oracle), ..Correction::after(Place::Start, &silent) });
        assert!(matches!(refused, Err(SituError::Silent { .. })), "{refused:?}");
        assert_eq!(model.to_json(), before);
    }
    let untold = taught("oracle_edit", &task).correct(Correction::after(Place::Start, &correction.demonstration));
    let message = untold.unwrap_err().to_string();
    assert!(message.ends_with("oracle_edit must be told which skills have changed"), "{message}");
}
