//! Every method of refinement keeps the automaton and only makes modifications.

use std::collections::BTreeMap;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use situ::correction::Correction;
use situ::decisions::{Limit, Modify};
use situ::edit::{Edit, difference};
use situ::graph::GraphNode;
use situ::keyframe::parameters::KeyframeParameters;
use situ::keyframe::policy::Execution;
use situ::method::refinement::attribution::Attribution;
use situ::method::{Learned, Method, named, refinement};
use situ::place::{Place, SegmentId};
use situ::segmentation::by_reference_object;
use situ::state::State;

use crate::common::{CAREFUL, Correction as Shown, Planted, Task};

const TASKS: u64 = 6;
const DRAWS: u64 = 3;

/// What each primitive does; a refined primitive does one thing, whatever the state.
fn executed(model: &dyn Learned) -> Vec<String> {
    let graph = model.graph().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let execute =
        |node: &GraphNode| format!("{:?}", model.keyframes(node.id, 0, &State::new([]), Execution::Mean, &mut rng));
    graph.nodes.iter().map(execute).collect()
}

fn cells(method: &dyn Method) -> BTreeMap<Edit, BTreeMap<Edit, usize>> {
    let name = method.name();
    let mut table: BTreeMap<Edit, BTreeMap<Edit, usize>> = BTreeMap::new();
    for seed in 0..TASKS {
        let task = Task::new(seed, 5, 3);
        let originals = task.originals(3, CAREFUL);
        let taught = method.teach(&task.schema, &originals, seed).unwrap();
        let situ = named("situ").unwrap().teach(&task.schema, &originals, seed).unwrap();
        assert_eq!(taught.graph().unwrap(), situ.graph().unwrap(), "{name}: the original model is every method's");
        assert_eq!(executed(&*taught), executed(&*situ), "{name}: and does what the original policy does");
        for planted in Planted::ALL {
            for draw in 0..DRAWS {
                let mut model = taught.boxed();
                let correction = task.correction(planted, draw, CAREFUL, draw == 0);
                let before = model.graph().unwrap();
                let last = correction.last_in(&before);
                let trace = model.correct(Correction::after(last, &correction.demonstration)).unwrap();
                let after = model.graph().unwrap();
                assert_eq!(after.edges, before.edges, "{name}: edges");
                let mut learnt: Vec<SegmentId> = Vec::new();
                for (before, after) in before.nodes.iter().zip(&after.nodes) {
                    assert_eq!((before.id, &before.reference), (after.id, &after.reference), "{name}: nodes");
                    assert!(after.segments.starts_with(&before.segments), "{name}: originals stay where they are");
                    learnt.extend(&after.segments[before.segments.len()..]);
                    assert!(before.paths == after.paths || after.segments.len() > before.segments.len(), "{name}");
                }
                assert_eq!(after.nodes.len(), before.nodes.len(), "{name}");
                assert!(learnt.iter().all(|id| id.demonstration == 3), "{name}: {learnt:?}");
                let changed =
                    executed(&*taught).iter().zip(executed(&*model)).filter(|(old, new)| **old != *new).count();
                assert!(changed as u64 <= trace.counters.nodes_touched, "{name}: what is not touched is as it was");
                let made = difference(&before, &after).edit();
                assert!(method.edits().contains(&made), "{name}: {made}");
                *table.entry(planted.edit()).or_default().entry(made).or_default() += 1;
            }
        }
    }
    table
}

/// Corrections that need a node or an edge leave the structure as it was. Those that need a modification get it.
#[test]
fn only_what_a_primitive_does_changes() {
    for method in refinement::all() {
        let table = cells(&*method);
        println!("{}: made, by what was needed: {table:?}", method.name());
        let made = |needed, edit| table[&needed].get(&edit).copied().unwrap_or(0) as f64;
        let share = |needed, edit| made(needed, edit) / table[&needed].values().sum::<usize>() as f64;
        for needed in [Edit::None, Edit::NodeAddition, Edit::EdgeAddition] {
            assert!(share(needed, Edit::None) > 0.9, "{}: {table:?}", method.name());
        }
        assert!(share(Edit::NodeModification, Edit::NodeModification) > 0.9, "{}: {table:?}", method.name());
    }
}

/// A segment that shows no primitive in another way is ignored: nothing that is executed changes.
#[test]
fn what_is_about_no_primitive_is_ignored() {
    for method in refinement::all() {
        let task = Task::new(1, 5, 3);
        let mut model = method.teach(&task.schema, &task.originals(3, CAREFUL), 0).unwrap();
        let before = executed(&*model);
        let correction = task.correction(Planted::NewEdge, 0, CAREFUL, false);
        let last = correction.last_in(&model.graph().unwrap());
        let trace = model.correct(Correction::after(last, &correction.demonstration)).unwrap();
        assert_eq!(trace.counters.nodes_touched, 0, "{}", method.name());
        assert_eq!(executed(&*model), before, "{}", method.name());
        // The next correction is the second one. Its segments are numbered after those of the ignored correction.
        let correction = task.correction(Planted::Modified, 0, CAREFUL, false);
        let last = correction.last_in(&model.graph().unwrap());
        model.correct(Correction::after(last, &correction.demonstration)).unwrap();
        let second = SegmentId { demonstration: 4, index: 0 };
        assert!(model.graph().unwrap().holders().contains_key(&second), "{}", method.name());
    }
}

/// A sample of a corrected primitive is drawn about its new mean, within the bounds of decision D15.
#[test]
fn a_corrected_primitive_is_sampled_about_its_mean() {
    // 5 mm per axis; a draw beyond the 95th percentile of χ² with 6 degrees of freedom is drawn again.
    const FARTHEST: f64 = 0.005 * 3.549;
    for method in refinement::all() {
        let name = method.name();
        let task = Task::new(1, 5, 3);
        let mut model = method.teach(&task.schema, &task.originals(3, CAREFUL), 0).unwrap();
        let correction = task.correction(Planted::Modified, 0, CAREFUL, false);
        let last = correction.last_in(&model.graph().unwrap());
        model.correct(Correction::after(last, &correction.demonstration)).unwrap();
        let graph = model.graph().unwrap();
        let node = graph.holders()[&SegmentId { demonstration: 3, index: 0 }].id;
        let state = correction.demonstration.final_state();
        let execute = |execution, seed| {
            let (_, keyframes) =
                model.keyframes(node, 0, state, execution, &mut ChaCha8Rng::seed_from_u64(seed)).unwrap();
            keyframes.iter().map(|keyframe| keyframe.pose.translation.vector).collect::<Vec<_>>()
        };
        let mean = execute(Execution::Mean, 0);
        let mut farthest = 0.0_f64;
        for seed in 0..200 {
            for (drawn, mean) in execute(Execution::Sample, seed).iter().zip(&mean) {
                farthest = farthest.max((drawn - mean).norm());
            }
        }
        assert!((0.003..FARTHEST * 1.001).contains(&farthest), "{name}: {farthest}");
    }
}

/// A correction is first compared with what was interrupted. After a segment that is about a primitive, the next
/// segment is compared with what follows that primitive.
#[test]
fn a_correction_is_about_what_was_interrupted_and_what_follows() {
    for method in refinement::all() {
        let name = method.name();
        let task = Task::new(1, 5, 3);
        let taught = method.teach(&task.schema, &task.originals(3, CAREFUL), 0).unwrap();
        let graph = taught.graph().unwrap();
        let length = |correction: &Shown| {
            let keyframes = correction.demonstration.keyframes();
            keyframes.chunk_by(|left, right| left.reference == right.reference).count() as u32
        };
        let mut corrections = (0..20).map(|draw| task.correction(Planted::Modified, draw, CAREFUL, true));
        let correction = corrections.find(|correction| length(correction) > 2).unwrap();
        let segments = length(&correction);
        let learnt = |last, interrupted| {
            let mut model = taught.boxed();
            let demonstration = &correction.demonstration;
            model.correct(Correction { interrupted, ..Correction::after(last, demonstration) }).unwrap();
            let graph = model.graph().unwrap();
            let holders = graph.holders();
            let held = |index| holders.get(&SegmentId { demonstration: 3, index }).map(|node| node.id);
            (0..segments).map(held).collect::<Vec<_>>()
        };
        let all = learnt(correction.last_in(&graph), None);
        assert!(all.iter().all(Option::is_some), "{name}: {all:?}");
        // A place that the shown primitives do not follow.
        let elsewhere = graph.edges.iter().find(|(_, to)| *to == Place::End).unwrap().0;
        assert_eq!(learnt(elsewhere, None)[0], None, "{name}");
        assert_eq!(learnt(elsewhere, all[0]), all, "{name}");
    }
}

/// The bounds of decision D18: a child must be probable, and every candidate must be near.
#[test]
fn attribution_keeps_to_its_bounds() {
    let task = Task::new(1, 5, 3);
    let (model, learner) = task.taught(CAREFUL, KeyframeParameters::default());
    let correction = task.correction(Planted::Modified, 0, CAREFUL, false);
    let segment = &by_reference_object(&correction.demonstration)[0];
    let last = correction.last(&model);
    let (child, probability) = model.most_probable_child(last, &segment.start).unwrap();
    let about = |min_probability, max_distance| {
        let limit = Limit { metres: 0.0, scatters: 0.0 };
        let rule = Modify { min_probability, max_distance, near: limit, far: limit };
        let attribution = Attribution { model: &model, learner: &learner, rule: &rule };
        let found = attribution.of(last, None, segment, &mut Default::default()).unwrap();
        found.map(Place::Node)
    };
    assert_eq!(about(probability, 40.0), Some(child));
    assert_eq!(about(probability + 1e-9, 40.0), None);
    assert_eq!(about(probability, 0.1), None);
}
