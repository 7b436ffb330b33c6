//! What every method of the harness must do. A new method is covered by being named in `situ::method::all`.

use std::collections::{BTreeMap, BTreeSet};

use crate::common::{CAREFUL, Planted, Task};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use situ::correction::Correction;
use situ::decisions::Decisions;
use situ::demonstration::Demonstration;
use situ::edit::{Edit, difference};
use situ::error::SituError;
use situ::graph::GraphNode;
use situ::keyframe::parameters::KeyframeParameters;
use situ::keyframe::policy::Execution;
use situ::method::keyframe_method;
use situ::method::rebuild::rebuild;
use situ::method::{KEYFRAME_AUTOMATON, Learned, Method, Role, all, named};
use situ::place::{NodeId, Place, SegmentId};
use situ::segmentation::by_reference_object;
use situ::state::{Feature, Schema, State};
use situ::task_model::History;
use situ::trace::Counters;

/// A node addition that stops early, a self-loop, and a modification that is carried on to the end.
const CORRECTIONS: [(Planted, bool); 3] =
    [(Planted::NewNode, false), (Planted::SelfLoop, false), (Planted::Modified, true)];
const SEED: u64 = 11;
/// Does again what was shown, number for number.
const REPLAYS: &str = "nearest";

fn task() -> Task {
    Task::new(5, 5, 3)
}

fn taught(method: &dyn Method, task: &Task) -> Box<dyn Learned> {
    method.teach(&task.schema, &task.originals(3, CAREFUL), SEED).unwrap()
}

/// What can be asked of a model at any time.
fn check(name: &str, model: &dyn Learned, state: &State) {
    let graph = model.graph().unwrap();
    assert!(!graph.nodes.is_empty(), "{name}");
    let ids: BTreeSet<NodeId> = graph.nodes.iter().map(|node| node.id).collect();
    assert_eq!(ids.len(), graph.nodes.len(), "{name}: an id is given twice");
    let segments: usize = graph.nodes.iter().map(|node| node.segments.len()).sum();
    assert_eq!(segments, graph.holders().len(), "{name}: a segment is held twice");
    for (from, to) in &graph.edges {
        let is_node = |place: &Place| matches!(place, Place::Node(id) if ids.contains(id));
        assert!(*from == Place::Start || is_node(from), "{name}: an edge from {from}");
        assert!(*to == Place::End || is_node(to), "{name}: an edge to {to}");
    }
    let dot = graph.to_dot(name);
    let mut drawn = false;
    for node in &graph.nodes {
        assert!(dot.contains(&format!("  {} [shape=box", node.id)), "{name}: {dot}");
        assert!(graph.edges.iter().any(|(_, to)| *to == Place::Node(node.id)), "{name}: {} is out of reach", node.id);
        let ways = model.ways(node.id, state).unwrap();
        let numbers: BTreeSet<usize> = ways.iter().copied().collect();
        assert!(
            numbers.into_iter().eq(0..ways.len()) && !ways.is_empty(),
            "{name}: ways are numbered through, {ways:?}"
        );
        assert_eq!(ways.len(), node.paths.len(), "{name}: a path for each way");
        let executions = ways.iter().flat_map(|way| [(*way, Execution::Mean), (*way, Execution::Sample)]);
        for (way, execution) in executions {
            let draw =
                |seed| model.keyframes(node.id, way, state, execution, &mut ChaCha8Rng::seed_from_u64(seed)).unwrap();
            let (reference, keyframes) = draw(1);
            assert_eq!(reference, node.reference, "{name}");
            assert!(!keyframes.is_empty(), "{name}: {} does nothing", node.id);
            for keyframe in &keyframes {
                assert!(keyframe.pose.to_homogeneous().iter().all(|value| value.is_finite()), "{name}");
                assert!((keyframe.pose.rotation.norm() - 1.0).abs() < 1e-9, "{name}: not a rotation");
                assert!(keyframe.gripper.value().is_finite() && keyframe.hold.is_finite(), "{name}");
            }
            assert_eq!(draw(1), (reference, keyframes.clone()), "{name}: the same seed, the same keyframes");
            let differs = draw(2).1 != keyframes;
            assert!(!(differs && execution == Execution::Mean), "{name}: a mean is drawn");
            drawn |= differs;
        }
    }
    assert_eq!(drawn, name != REPLAYS, "{name}: samples are the same for every seed");
    for place in ids.iter().map(|id| Place::Node(*id)).chain([Place::Start]) {
        let ranked = model.ranked(place, state).unwrap();
        assert_eq!(ranked.first().copied(), model.next(place, state).unwrap(), "{name}: the first is the next");
        assert!(ranked.is_sorted_by(|one, other| one.1 >= other.1), "{name}: {ranked:?}");
    }
    let stranger = ids.last().map(|id| NodeId(id.0 + 1)).unwrap();
    let asked = model.keyframes(stranger, 0, state, Execution::Mean, &mut ChaCha8Rng::seed_from_u64(0));
    assert_eq!(asked, Err(SituError::UnknownNode(stranger)), "{name}");
}

/// Finds its own segments: its nodes are not those of the segments by reference object.
const SEGMENTS_ITSELF: &str = "bp_ar_hmm";

/// Whether the most probable children lead from START to END through the states of a demonstration.
///
/// A method that finds its own runs can have several nodes for a segment's state, or one node for two. So the test asks
/// for a path to END in the final state. On it each child is the most probable in the present state or the next, on the
/// object of the present segment or of a neighbour, with a probability of at least ½.
fn leads_to_end(model: &dyn Learned, demonstration: &Demonstration) -> bool {
    let runs = demonstration.keyframes().chunk_by(|left, right| left.reference == right.reference);
    let (mut states, objects): (Vec<&State>, Vec<&str>) = runs.map(|run| (&run[0].state, &*run[0].reference)).unzip();
    let graph = model.graph().unwrap();
    let is_on = |id: NodeId, segment: usize| {
        let own = graph.nodes.iter().find(|node| node.id == id).map(|node| &*node.reference);
        objects[segment.saturating_sub(1)..objects.len().min(segment + 2)].iter().any(|object| own == Some(*object))
    };
    states.push(demonstration.final_state());
    let mut reached = vec![(Place::Start, 0)];
    let mut index = 0;
    while let Some((place, at)) = reached.get(index).copied() {
        for state in at..states.len().min(at + 2) {
            match model.next(place, states[state]).unwrap() {
                Some((_, probability)) if !(0.5..=1.0).contains(&probability) => return false,
                Some((Place::End, _)) if state + 1 == states.len() => return true,
                Some((next @ Place::Node(id), _)) if is_on(id, state) && !reached.contains(&(next, state)) => {
                    reached.push((next, state));
                }
                _ => {}
            }
        }
        index += 1;
    }
    false
}

/// Whether following the most probable child through the states of a demonstration visits its segments and then END.
fn follows(model: &dyn Learned, demonstration: &Demonstration) -> bool {
    let graph = model.graph().unwrap();
    let holders = graph.holders();
    let mut last = Place::Start;
    let runs = demonstration.keyframes().chunk_by(|left, right| left.reference == right.reference);
    for (index, run) in (0..).zip(runs) {
        let Some((next, probability)) = model.next(last, &run[0].state).unwrap() else { return false };
        let expected = holders[&SegmentId { demonstration: 0, index }].id;
        if next != Place::Node(expected) || !(0.5..=1.0).contains(&probability) {
            return false;
        }
        last = next;
    }
    model.next(last, demonstration.final_state()).unwrap().is_some_and(|(next, _)| next == Place::End)
}

#[test]
fn names_are_unique_and_described() {
    let methods = all();
    let names: BTreeSet<&str> = methods.iter().map(|method| method.name()).collect();
    let summaries: BTreeSet<&str> = methods.iter().map(|method| method.summary()).collect();
    assert_eq!((names.len(), summaries.len()), (41, 41), "41 methods, each with a name and a summary of its own");
    for method in &methods {
        assert!(method.summary().len() > 20 && !method.source().is_empty(), "{}", method.name());
        assert_eq!(named(method.name()).unwrap().summary(), method.summary());
        // The ablations of `situ` are ours.
        let is_ablation = method.name().starts_with("situ:") && method.name() != "situ:literal";
        assert!(!is_ablation || method.source() == "this project", "{}", method.name());
    }
    assert!(named("nobody").is_none());
}

#[test]
fn every_method_teaches_corrects_and_repeats_itself() {
    let task = task();
    for method in all() {
        let name = method.name();
        let run = || {
            let mut model = taught(&*method, &task);
            let shown = &task.originals(1, CAREFUL)[0];
            let does = if name == SEGMENTS_ITSELF { leads_to_end(&*model, shown) } else { follows(&*model, shown) };
            assert!(does, "{name}: it does what it was shown");
            let mut states = vec![model.to_json()];
            for (draw, (planted, end)) in (0..).zip(CORRECTIONS) {
                check(name, &*model, &shown.keyframes()[0].state);
                let (graph, json) = (model.graph().unwrap(), model.to_json());
                let correction = task.correction(planted, draw, CAREFUL, end);
                let last = correction.last_in(&graph);
                let oracle = correction.oracle();
                let after =
                    |last| Correction { oracle: Some(&oracle), ..Correction::after(last, &correction.demonstration) };

                // What cannot be is refused, and changes nothing.
                let mut refuse = |last, expected| {
                    assert_eq!(
                        model.correct(Correction::after(last, &correction.demonstration)),
                        Err(expected),
                        "{name}"
                    );
                };
                refuse(Place::End, SituError::NotExecutable(Place::End));
                let stranger = NodeId(1 + graph.nodes.iter().map(|node| node.id.0).max().unwrap());
                refuse(Place::Node(stranger), SituError::UnknownNode(stranger));
                let interrupted = Correction { interrupted: Some(stranger), ..after(Place::Start) };
                assert_eq!(model.correct(interrupted), Err(SituError::UnknownNode(stranger)), "{name}");
                assert_eq!(model.to_json(), json, "{name}: an error leaves the model as it was");

                // A copy knows nothing of what its original learns.
                let copy = model.boxed();
                let trace = model.correct(after(last)).unwrap();
                assert_eq!((copy.graph().unwrap(), copy.to_json()), (graph, json), "{name}");
                let changed = model.to_json() != copy.to_json();
                assert_eq!(changed, method.role() != Role::Control, "{name}: corrections are learnt, but by controls");
                let made = difference(&copy.graph().unwrap(), &model.graph().unwrap()).edit();
                assert!(method.edits().contains(&made), "{name}: {made} is none of its edits");
                states.push(serde_json::json!([model.to_json(), trace]));
            }
            check(name, &*model, &shown.keyframes()[0].state);
            states
        };
        assert_eq!(run(), run(), "{name}: the same demonstrations and seed, the same model");
    }
}

/// Full retraining keeps no trace of the order in which it learned.
#[test]
fn rebuild_after_corrections_is_rebuild_at_once() {
    let task = task();
    let mut model = taught(&*named("rebuild:no_modify").unwrap(), &task);
    let (original, learner) = task.taught(CAREFUL, KeyframeParameters::default());
    let mut histories = crate::common::histories(&task.originals(3, CAREFUL));
    for (draw, (planted, end)) in (0..).zip(CORRECTIONS) {
        let correction = task.correction(planted, draw, CAREFUL, end);
        let last = correction.last_in(&model.graph().unwrap());
        model.correct(Correction::after(last, &correction.demonstration)).unwrap();
        let after = original.origin(correction.last(&original)).unwrap();
        histories.push(History::new(&correction.demonstration, by_reference_object(&correction.demonstration), after));
    }
    let (at_once, _) = rebuild(histories, Some(*original.calibration()), &learner, &Decisions::mended()).unwrap();
    assert_eq!(serde_json::to_value(&at_once).unwrap(), model.to_json());
}

/// A model of the toy task after these corrections, and the edits that they made.
fn corrected(name: &str, corrections: &[(Planted, bool)]) -> (Box<dyn Learned>, Vec<Edit>) {
    let task = task();
    let mut model = taught(&*named(name).unwrap(), &task);
    let mut made = Vec::new();
    for (draw, (planted, end)) in (0..).zip(corrections) {
        let correction = task.correction(*planted, draw, CAREFUL, *end);
        let before = model.graph().unwrap();
        let last = correction.last_in(&before);
        model.correct(Correction::after(last, &correction.demonstration)).unwrap();
        made.push(difference(&before, &model.graph().unwrap()).edit());
    }
    (model, made)
}

/// Where no correction shows another way of a thing, the order of the corrections is of no matter.
#[test]
fn the_order_matters_only_where_something_is_shown_in_another_way() {
    let shown = &CORRECTIONS[..2];
    let (joint, _) = corrected("rebuild:no_modify", shown);
    for name in ["rebuild", "rebuild:recency"] {
        assert_eq!(corrected(name, shown).0.to_json(), joint.to_json(), "{name}");
    }
}

/// `rebuild` modifies by SITU's rule. The joint model, which knows no order, cannot.
#[test]
fn retraining_in_order_modifies_where_situ_does() {
    let modified = [(Planted::Modified, true)];
    for name in ["situ", "rebuild"] {
        assert_eq!(corrected(name, &modified).1, [Edit::NodeModification], "{name}");
    }
    assert_ne!(corrected("rebuild:no_modify", &modified).1, [Edit::NodeModification]);
}

/// What was not given is explained by the primitives that are about its objects, segment by segment.
#[test]
fn a_demonstration_that_was_held_out_is_explained_as_far_as_its_objects_are_known() {
    let task = task();
    let held_out = task.originals(4, CAREFUL).pop().unwrap();
    let stranger = task.correction(Planted::NewNode, 5, CAREFUL, true).demonstration;
    for method in all().iter().filter(|method| method.role() != Role::FromScratch) {
        let (name, model) = (method.name(), taught(&**method, &task));
        let segments = model.held_out(&held_out);
        if segments.is_empty() {
            let is_density = keyframe_method::all().iter().any(|known| known.name() == name);
            assert!(!is_density, "{name} has policies with densities");
            continue;
        }
        let keyframes: usize = segments.iter().map(|(keyframes, _)| keyframes).sum();
        assert_eq!(keyframes, held_out.keyframes().len(), "{name}: every keyframe is in one segment");
        assert!(segments.iter().all(|(_, value)| value.is_some_and(f64::is_finite)), "{name}: {segments:?}");
        let known = model.graph().unwrap().nodes.iter().map(|node| node.reference.clone()).collect::<BTreeSet<_>>();
        let parts = by_reference_object(&stranger);
        let explained = model.held_out(&stranger);
        assert_eq!(explained.len(), parts.len(), "{name}");
        for (part, (keyframes, value)) in parts.iter().zip(explained) {
            assert_eq!(keyframes, part.keyframes.len(), "{name}");
            assert!(
                value.is_none() || known.contains(&part.reference),
                "{name}: nothing is known of {}",
                part.reference
            );
        }
    }
}

/// A demonstration knows nothing of its schema; one of another task is refused where it comes in.
#[test]
fn states_of_another_schema_are_refused() {
    let task = task();
    let narrow = Schema::new(vec![Feature { name: "x".to_owned(), scale: 0.2 }]).unwrap();
    let other = crate::common::spelt(&[(0, 0.0, 0.0)], 1.0, true);
    for method in all() {
        let name = method.name();
        let refused = method.teach(&narrow, &task.originals(2, CAREFUL), SEED).map(|_| ());
        assert!(matches!(refused, Err(SituError::StateLength { .. })), "{name}: {refused:?}");
        assert_eq!(method.teach(&task.schema, &[], SEED).map(|_| ()), Err(SituError::NoDemonstration), "{name}");
        let mut model = taught(&*method, &task);
        let before = model.to_json();
        let refused = model.correct(Correction::after(Place::Start, &other));
        assert!(
            matches!(refused, Err(SituError::StateLength { expected, .. }) if expected == task.schema.len()),
            "{name}"
        );
        assert_eq!(model.to_json(), before, "{name}");
    }
}

/// What shares a word for its original model shares the model: it is evaluated once for all of them.
#[test]
fn methods_of_one_original_start_alike() {
    let task = task();
    let shown = task.originals(3, CAREFUL);
    let states: Vec<_> = shown.iter().flat_map(|shown| shown.keyframes()).map(|keyframe| &keyframe.state).collect();
    let mut known = BTreeMap::new();
    let methods = all();
    for method in &methods {
        let model = taught(&**method, &task);
        let graph = model.graph().unwrap();
        let lengths: Vec<usize> = graph.lengths.iter().map(|lengths| lengths.iter().sum()).collect();
        let keyframes: Vec<usize> = shown.iter().map(|shown| shown.keyframes().len()).collect();
        assert_eq!(lengths, keyframes, "{}: every keyframe is of one segment", method.name());
        let places = || graph.nodes.iter().map(|node| Place::Node(node.id)).chain([Place::Start]);
        let next: Vec<_> = places().flat_map(|place| states.iter().map(move |state| (place, *state))).collect();
        let next: Vec<_> = next.into_iter().map(|(place, state)| model.next(place, state).unwrap()).collect();
        let draw = |node: &GraphNode| {
            let draw = |execution, seed| {
                model.keyframes(node.id, 0, states[0], execution, &mut ChaCha8Rng::seed_from_u64(seed)).unwrap()
            };
            (draw(Execution::Mean, 0), draw(Execution::Sample, 1), draw(Execution::Sample, 2))
        };
        let executed: Vec<_> = graph.nodes.iter().map(draw).collect();
        let original = (graph.clone(), next, executed);
        let first = known.entry(method.original()).or_insert_with(|| original.clone());
        assert_eq!(*first, original, "{}: `{}` is another model", method.name(), method.original());
    }
    assert!(known.contains_key(KEYFRAME_AUTOMATON));
}

/// A counter of one method's work leaves the records of the others as they were.
#[test]
fn a_counter_of_nothing_is_not_written() {
    let none = serde_json::to_value(Counters::default()).unwrap();
    assert!(none.get("logistic_steps").is_none() && none.get("em_iterations").is_some(), "{none}");
    assert_eq!(serde_json::from_value::<Counters>(none).unwrap(), Counters::default());
    let some = Counters { logistic_steps: 3, ..Counters::default() };
    let written = serde_json::to_value(some).unwrap();
    assert_eq!(written["logistic_steps"], 3);
    assert_eq!(serde_json::from_value::<Counters>(written).unwrap(), some);
}

#[test]
fn counters_add_up_one_by_one() {
    let names = ["hmm_fits", "em_iterations", "divergences", "classifier_fits", "classifier_evaluations"];
    let names = names.into_iter().chain(["nodes_touched", "segments_touched", "logistic_steps"]);
    let counters = |numbers: fn(u64) -> u64| -> Counters {
        let named = names.clone().zip(1..).map(|(name, place)| (name.to_owned(), numbers(place).into()));
        serde_json::from_value(serde_json::Value::Object(named.collect())).unwrap()
    };
    let mut sum = counters(|place| place);
    sum += counters(|place| 100 * place * place);
    assert_eq!(sum, counters(|place| place + 100 * place * place));
}
