//! The edits that are chosen on block sorting.

use std::collections::BTreeSet;

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use situ::correction::Correction;
use situ::demonstration::{Demonstration, Gripper, Keyframe, Kind, Pose};
use situ::edit::{Edit, difference};
use situ::keyframe::policy::Execution;
use situ::method::itmcd::ItmcdTask;
use situ::method::itmcd::parameters::ItmcdParameters;
use situ::method::{KeyframeAutomaton, Learned};
use situ::place::{Place, SegmentId};
use situ::random::stream;
use situ::state::State;

use crate::itmcd::sorting::{Need, Skill, TASK, World, correction, originals, schema};

/// The draws of each kind of correction.
const DRAWS: u64 = 25;

/// The chosen edit. An addition of a node counts before a modification, and that before an edge, as in [`difference`].
fn chosen(task: &ItmcdTask) -> Option<Edit> {
    let edits: Option<Vec<Edit>> =
        task.rounds().iter().map(|round| round.chosen.map(|candidate| candidate.edit())).collect();
    let edits = edits?;
    [Edit::NodeAddition, Edit::NodeModification, Edit::EdgeAddition]
        .into_iter()
        .find(|edit| edits.contains(edit))
        .or(Some(Edit::None))
}

/// The original model, and the place that ran last after so many skills of the task.
fn taught(originals: &[Demonstration], done: usize, parameters: ItmcdParameters) -> Option<(ItmcdTask, Place)> {
    let task = learned(originals, parameters);
    let graph = task.graph().unwrap();
    let holders = graph.holders();
    let place = |index: usize| holders[&SegmentId { demonstration: 0, index: index as u32 }].id;
    let last = done.checked_sub(1).map_or(Place::Start, |index| Place::Node(place(index)));
    // If the common start is not the task, the choice says nothing.
    (graph.nodes.len() == TASK.len()).then_some((task, last))
}

/// Two to four originals, by a careful teacher and a novice in turns (0.5 cm and 1 cm, 2° and more). Both give needless
/// keyframes and forget some.
///
/// Measured: 212 of 224 are right; of 25 that need nothing 15, of the others 197 of 199. The errors are needless
/// modifications and nodes. They occur if the correction, or one of few originals, has a keyframe too many: it moves
/// all ten points behind it along the path, which count as ten witnesses (see `frames`). No parameter was chosen on
/// these draws. The bounds: at 0.946 the standard error over 224 draws is 0.015, and 0.9 is three of them lower. Half
/// of a need's draws is three of *its* standard errors below the worst need, except for the need of nothing, where it
/// is one.
#[test]
fn the_planted_edit_is_chosen() {
    let (mut right, mut all) = (0, 0);
    let mut wrong = Vec::new();
    for need in Need::ALL {
        let (mut own, mut drawn) = (0, 0);
        for draw in 0..DRAWS {
            let seed = stream(draw, &format!("held out: {need:?}"));
            let (count, noise) = (2 + (draw % 3) as usize, if draw % 2 == 0 { 0.005 } else { 0.01 });
            let (done, shown) = correction(need, seed, noise);
            let Some((mut task, last)) = taught(&originals(count, seed, noise), done, ItmcdParameters::default())
            else {
                continue;
            };
            task.correct(Correction::after(last, &shown)).unwrap();
            drawn += 1;
            if chosen(&task) == Some(need.edit()) {
                own += 1;
            } else {
                let edits = task.rounds().iter().filter_map(|round| round.chosen).map(|edit| edit.to_string());
                wrong.push(format!("{need:?}, {count} originals: {:?}", edits.collect::<Vec<_>>()));
            }
        }
        assert!(2 * own >= drawn, "{need:?}: {own} of {drawn}");
        (right, all) = (right + own, all + drawn);
    }
    assert!(all >= 200, "{all}");
    assert!(right as f64 >= 0.9 * all as f64, "{right} of {all}: {}", wrong.join("\n"));
}

/// A policy that is shifted as a whole is a modification, not noise at one point. That is why a point is not regressed
/// on the one before it: neighbours are so similar that an autoregression learns to copy, wherever the path is.
#[test]
fn a_path_that_moved_is_seen() {
    let mut seen = 0;
    for draw in 0..6 {
        let seed = stream(draw, "moved");
        let (done, shown) = correction(Need::HighBin, seed, 0.005);
        let parameters = ItmcdParameters::default();
        let Some((mut task, last)) = taught(&originals(3, seed, 0.005), done, parameters) else { continue };
        task.correct(Correction::after(last, &shown)).unwrap();
        seen += usize::from(chosen(&task) == Some(Edit::NodeModification));
    }
    assert!(seen >= 5, "{seen}");
}

/// Two points per segment are fewer numbers than the model of one original has parameters.
#[test]
fn what_is_too_large_for_the_data_is_refused_and_said() {
    let (done, shown) = correction(Need::HighBin, 3, 0.005);
    let parameters = ItmcdParameters { points: 2, ..ItmcdParameters::default() };
    let (mut task, last) = taught(&originals(1, 3, 0.005), done, parameters).unwrap();
    let before = task.to_json();
    let trace = task.correct(Correction::after(last, &shown)).unwrap();
    assert!(trace.steps.is_empty() && trace.counters.hmm_fits == 1, "the automaton's own fit alone: {trace:?}");
    assert_eq!(task.to_json()["model"], before["model"], "nothing is chosen, nothing is changed");
    let [round] = task.rounds() else { panic!("{:?}", task.rounds()) };
    assert!(round.chosen.is_none() && !round.evaluations.is_empty());
    for evaluation in &round.evaluations {
        assert!(evaluation.observations <= evaluation.parameters + 1 && evaluation.weight == 0.0, "{evaluation:?}");
        assert_eq!((evaluation.criterion, evaluation.log_likelihood), (None, None));
    }
    assert_eq!(task.to_json()["rounds"][0]["evaluations"].as_array().unwrap().len(), round.evaluations.len());
    // The refused correction was still shown: the next one is the third demonstration, not the second.
    let more = originals(8, 9, 0.005);
    let keyframes: Vec<Keyframe> = more.iter().flat_map(|shown| shown.keyframes().iter().cloned()).collect();
    let segments = 1 + keyframes.windows(2).filter(|pair| pair[0].reference != pair[1].reference).count();
    let long = Demonstration::new("long", Kind::Corrective, &schema(), keyframes, more[7].final_state().clone(), true);
    assert_eq!(task.correct(Correction::after(Place::Start, &long.unwrap())).unwrap().steps.len(), segments);
    let graph = task.graph().unwrap();
    let shown: BTreeSet<u32> = graph.holders().keys().map(|segment| segment.demonstration).collect();
    assert_eq!(shown, BTreeSet::from([0, 2]));
}

/// After a modification the node does what was shown. The same correction once more needs nothing, and the weights
/// agree.
#[test]
fn a_modification_is_needed_once() {
    let (done, shown) = correction(Need::HighBin, 5, 0.005);
    let (mut task, last) = taught(&originals(3, 5, 0.005), done, ItmcdParameters::default()).unwrap();
    let mut edits = Vec::new();
    for _ in 0..3 {
        task.correct(Correction::after(last, &shown)).unwrap();
        edits.push(chosen(&task).unwrap());
        let weights: f64 = task.rounds()[0].evaluations.iter().map(|evaluation| evaluation.weight).sum();
        assert!((weights - 1.0).abs() < 1e-12);
    }
    assert_eq!(edits, [Edit::NodeModification, Edit::None, Edit::None]);
}

/// If no single edit makes a correction possible, the first goes as far as an edit can, and the next goes further.
#[test]
fn two_new_skills_are_two_nodes() {
    let originals = originals(3, 9, 0.005);
    let (mut task, last) = taught(&originals, 4, ItmcdParameters::default()).unwrap();
    let mut world = World::new(9, 0.005);
    TASK.iter().for_each(|skill| world.after(*skill));
    world.lid = true;
    let skills = [Skill::Uncover, Skill::Nudge(0)].map(|skill| (skill, Vector3::zeros()));
    let shown = world.demonstrate("correction", &skills, Kind::Corrective, true);
    let trace = task.correct(Correction::after(last, &shown)).unwrap();
    assert_eq!(
        task.rounds().iter().map(|round| round.chosen.unwrap().edit()).collect::<Vec<_>>(),
        [Edit::NodeAddition; 2]
    );
    let graph = task.graph().unwrap();
    let [first, second] = [&trace.steps[0], &trace.steps[1]].map(|step| Place::Node(step.node));
    assert_eq!(graph.nodes.len(), 6);
    for edge in [(last, first), (first, second), (second, Place::End)] {
        assert!(graph.edges.contains(&edge), "{edge:?} of {:?}", graph.edges);
    }
}

/// Nothing varies: the hand does not move, and the world does not change.
#[test]
fn a_task_that_stands_still_can_be_corrected() {
    let keyframe = Keyframe {
        reference: "table".into(),
        reference_pose: Pose::identity(),
        gripper_pose: Pose::identity(),
        gripper: Gripper::Open(0.08),
        hold: 0.0,
        state: State::new([0.0; 9]),
        announced: false,
        narration: None,
    };
    let still = |kind| Demonstration::new("still", kind, &schema(), vec![keyframe.clone()], State::new([0.0; 9]), true);
    let originals = [still(Kind::Original).unwrap(), still(Kind::Original).unwrap()];
    let mut task = learned(&originals, ItmcdParameters::default());
    task.correct(Correction::after(Place::Start, &still(Kind::Corrective).unwrap())).unwrap();
    assert_eq!(chosen(&task), Some(Edit::None));
}

/// Corrections that nobody would give: one keyframe, about a known or an unknown object, from anywhere, again and
/// again, after one or two originals. Each is folded in or refused. The model that is left can be executed, and a
/// repetition gives the same model.
#[test]
fn odd_corrections_are_folded_in_or_refused() {
    let keyframe = |object: &str, at: f64| Keyframe {
        reference: object.into(),
        reference_pose: Pose::identity(),
        gripper_pose: Pose::translation(at, 0.0, 0.0),
        gripper: Gripper::Open(0.08),
        hold: 0.0,
        state: State::new([at.min(3.0); 9]),
        announced: false,
        narration: None,
    };
    // Only a new node makes an unknown object possible.
    let (node, edge, modify) = (Edit::NodeAddition, Edit::EdgeAddition, Edit::NodeModification);
    let later = [node, node, edge, edge, edge, edge, node, node, edge];
    for (count, first) in [(1, [modify, node, node]), (2, [node, node, edge])] {
        let originals = originals(count, 4, 0.005);
        let expected = [&first[..], &later].concat();
        let run = || {
            let task = learned(&originals, ItmcdParameters::default());
            let mut task = Box::new(task) as Box<dyn Learned>;
            let mut edits = Vec::new();
            for (draw, object) in ["bin-0", "nowhere", "nowhere", "block-1"].into_iter().enumerate() {
                for (at, ends) in [(0.0, false), (1e3, true), (0.0, true)] {
                    let before = task.graph().unwrap();
                    let ids: Vec<Place> = before.nodes.iter().map(|node| Place::Node(node.id)).collect();
                    let last = if draw % 2 == 0 { Place::Start } else { ids[draw % ids.len()] };
                    let (shown, state) = (vec![keyframe(object, at)], State::new([at.min(3.0); 9]));
                    let shown = Demonstration::new("odd", Kind::Corrective, &schema(), shown, state, ends).unwrap();
                    let trace = task.correct(Correction::after(last, &shown)).unwrap();
                    assert!(trace.steps.len() <= 1 && trace.counters.em_iterations > 0, "{trace:?}");
                    edits.push(difference(&before, &task.graph().unwrap()).edit());
                }
            }
            assert_eq!(edits, expected, "{count} originals");
            let mut rng = ChaCha8Rng::seed_from_u64(0);
            for node in &task.graph().unwrap().nodes {
                assert!(
                    !task.keyframes(node.id, 0, &State::new([0.0]), Execution::Sample, &mut rng).unwrap().1.is_empty()
                );
            }
            task.to_json()
        };
        assert_eq!(run(), run());
    }
}

/// The task model of these originals.
fn learned(originals: &[Demonstration], parameters: ItmcdParameters) -> ItmcdTask {
    ItmcdTask::new(&KeyframeAutomaton::learn(&schema(), originals, 0).unwrap(), parameters).unwrap()
}
