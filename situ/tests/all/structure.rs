//! Structures against what the teacher meant: by hand, against counting every pair, and over the planted tasks.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::common::{CAREFUL, Planted, Task};
use nalgebra::Isometry3;
use proptest::prelude::*;
use situ::correction::Correction;
use situ::demonstration::{Demonstration, Gripper, Keyframe, Kind};
use situ::graph::{Graph, GraphNode};
use situ::method::named;
use situ::place::{NodeId, Place, SegmentId};
use situ::segmentation::by_reference_object;
use situ::state::{Feature, Schema, State};
use situ::structure::{Agreement, Structure, Truth};

/// A demonstration by the objects and the teacher's names of its keyframes: `a` the object, the digit the name.
fn shown(words: &[&str], carried_to_end: bool) -> Demonstration {
    let schema = Schema::new(vec![Feature { name: "x".to_owned(), scale: 1.0 }]).unwrap();
    let keyframe = |word: &&str| Keyframe {
        reference: word[..1].into(),
        reference_pose: Isometry3::identity(),
        gripper_pose: Isometry3::identity(),
        gripper: Gripper::Open(0.08),
        hold: 0.0,
        state: State::new(vec![0.0]),
        announced: false,
        narration: (word.len() > 1).then(|| (*word).into()),
    };
    let keyframes = words.iter().map(keyframe).collect();
    Demonstration::new("shown", Kind::Original, &schema, keyframes, State::new(vec![0.0]), carried_to_end).unwrap()
}

fn graph(nodes: &[&[(u32, u32)]], edges: &[(Place, Place)], lengths: &[Vec<usize>]) -> Graph {
    let node = |(id, held): (u32, &&[(u32, u32)])| GraphNode {
        id: NodeId(id),
        reference: "a".into(),
        segments: held
            .iter()
            .map(|(demonstration, index)| SegmentId { demonstration: *demonstration, index: *index })
            .collect(),
        paths: vec![Vec::new()],
    };
    Graph { nodes: (0..).zip(nodes).map(node).collect(), edges: edges.to_vec(), lengths: lengths.to_vec() }
}

const START: Place = Place::Start;
const END: Place = Place::End;
const fn z(id: u32) -> Place {
    Place::Node(NodeId(id))
}

/// An original a1 a1 a2 b3 and a correction b3 from where b3 ran, which goes on to the end. Two skills on one object
/// are one segment.
///
/// True pairs: 1 of a1, 0 of a2, 1 of b3. Transitions: START a1, a1 a2, a2 b3, b3 END, and b3 b3 of the correction.
#[test]
fn a_small_task_by_hand() {
    let (original, again) = (shown(&["a1", "a1", "a2", "b3"], true), shown(&["b3"], true));
    let mut truth = Truth::default();
    truth.original(&original);
    let graph = |nodes: &[&[(u32, u32)]], edges: &[(Place, Place)]| graph(nodes, edges, &[vec![3, 1], vec![1]]);
    let taught = graph(&[&[(0, 0)], &[(0, 1)]], &[(START, z(0)), (z(0), z(1)), (z(1), END)]);
    truth.correction(&again, z(1), &taught);
    // The retry as an edge: three keyframes in the node of a are three pairs, of which a1 a1 is right.
    let joined = graph(&[&[(0, 0)], &[(0, 1), (1, 0)]], &[(START, z(0)), (z(0), z(1)), (z(1), z(1)), (z(1), END)]);
    let agreement = |both, model, truth| Agreement { both, model, truth };
    let score = |graph: &Graph| truth.score(graph).unwrap();
    let expected = Structure {
        nodes: 2,
        edges: 4,
        duplicates: 0,
        skills: 2,
        pairs: agreement(2, 4, 2),
        transitions: agreement(5, 5, 5),
    };
    assert_eq!(score(&joined), expected);
    assert_eq!(expected.pairs.f1(), Some(4.0 / 6.0));
    // The retry as a node of its own, after which nothing is known to follow but END.
    let split = graph(
        &[&[(0, 0)], &[(0, 1)], &[(1, 0)]],
        &[(START, z(0)), (z(0), z(1)), (z(1), z(2)), (z(2), END), (z(1), END)],
    );
    let expected = Structure {
        nodes: 3,
        edges: 5,
        duplicates: 1,
        skills: 2,
        pairs: agreement(1, 3, 2),
        transitions: agreement(5, 5, 5),
    };
    assert_eq!(score(&split), expected);
    // The model that was never corrected lacks the retry. An edge that nobody showed is wrong, and so is an empty node.
    assert_eq!(score(&taught).transitions, agreement(4, 4, 5));
    let odd =
        graph(&[&[(0, 0)], &[(0, 1)], &[]], &[(START, z(0)), (z(0), z(1)), (z(1), z(0)), (z(1), z(2)), (z(1), END)]);
    assert_eq!((score(&odd).transitions, score(&odd).duplicates), (agreement(4, 6, 5), 0));
    // Of a teacher who is silent nothing is known.
    truth.original(&shown(&["a", "b"], true));
    assert_eq!(truth.score(&joined), None);
    assert_eq!(agreement(0, 0, 0).f1(), None);
}

/// Who is told the structure has it, whatever was shown; who never clusters has each skill that was shown again twice.
#[test]
fn the_planted_tasks() {
    let mut appended = 0;
    for draw in 0..3 {
        let task = Task::new(draw, 5, 3);
        let originals = task.originals(3, CAREFUL);
        for planted in Planted::ALL {
            let correction = task.correction(planted, draw, CAREFUL, true);
            let oracle = correction.oracle();
            for name in ["oracle_edit", "append_only", "no_update", "situ"] {
                let method = named(name).unwrap();
                let mut model = method.teach(&task.schema, &originals, 1).unwrap();
                let mut truth = Truth::default();
                originals.iter().for_each(|shown| truth.original(shown));
                let perfect = |structure: Structure| {
                    structure.duplicates == 0
                        && structure.pairs.f1() == Some(1.0)
                        && structure.transitions.f1() == Some(1.0)
                };
                let before = model.graph().unwrap();
                assert!(perfect(truth.score(&before).unwrap()), "{name}: the originals are careful");
                let last = correction.last_in(&before);
                let shown = &correction.demonstration;
                truth.correction(shown, last, &before);
                model.correct(Correction { oracle: Some(&oracle), ..Correction::after(last, shown) }).unwrap();
                let structure = truth.score(&model.graph().unwrap()).unwrap();
                match name {
                    "oracle_edit" => assert!(perfect(structure), "{planted:?}, {draw}: {structure:?}"),
                    // What was not learned is missed; nothing is wrong that was right.
                    "no_update" => assert!(
                        !perfect(structure) && structure.pairs.both == structure.pairs.model,
                        "{planted:?}, {draw}: {structure:?}"
                    ),
                    "append_only" => appended += structure.duplicates,
                    _ => assert!(structure.transitions.f1() > Some(0.7), "{planted:?}, {draw}: {structure:?}"),
                }
            }
        }
    }
    assert!(appended > 0);
}

proptest! {
    /// Pairs are what counting every pair gives.
    #[test]
    fn pairs_as_counted_one_by_one(words in prop::collection::vec((0..3_u8, 0..3_u8), 1..14), nodes in 1..4_u32, placed in prop::collection::vec(0..4_u32, 14)) {
        let words: Vec<String> = words.iter().map(|(object, name)| format!("{}{name}", ["a", "b", "c"][usize::from(*object)])).collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let demonstration = shown(&words, true);
        let segments = by_reference_object(&demonstration);
        let mut truth = Truth::default();
        truth.original(&demonstration);
        let lengths = [segments.iter().map(|segment| segment.keyframes.len()).collect()];
        // Where each segment is; 3 is nowhere.
        let node_of = |segment: usize| (placed[segment] < nodes).then_some(placed[segment]);
        let held: Vec<Vec<(u32, u32)>> = (0..nodes).map(|node| (0..segments.len()).filter(|index| node_of(*index) == Some(node)).map(|index| (0, index as u32)).collect()).collect();
        let score = truth.score(&graph(&held.iter().map(Vec::as_slice).collect::<Vec<_>>(), &[], &lengths)).unwrap();
        let node_of_keyframe: Vec<Option<u32>> = segments.iter().enumerate().flat_map(|(index, segment)| vec![node_of(index); segment.keyframes.len()]).collect();
        let names: Vec<Option<Arc<str>>> = demonstration.keyframes().iter().map(|keyframe| keyframe.narration.clone()).collect();
        let mut expected = Agreement::default();
        for left in 0..names.len() {
            for right in left + 1..names.len() {
                let together = node_of_keyframe[left].is_some() && node_of_keyframe[left] == node_of_keyframe[right];
                let alike = names[left] == names[right];
                expected.model += u64::from(together);
                expected.truth += u64::from(alike);
                expected.both += u64::from(together && alike);
            }
        }
        prop_assert_eq!(score.pairs, expected);
        let known: BTreeSet<_> = names.iter().collect();
        let labelled = held.iter().filter(|held| !held.is_empty()).count();
        prop_assert_eq!((score.duplicates + score.skills) as usize, labelled);
        prop_assert!(score.duplicates as usize + known.len() >= held.iter().filter(|held| !held.is_empty()).count());
    }
}
