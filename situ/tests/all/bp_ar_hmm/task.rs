//! The whole method on demonstrations: a pick and a place, on a table that is laid anew each time.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use situ::correction::Correction;
use situ::demonstration::{Demonstration, Gripper, Keyframe, Kind, Pose};
use situ::error::SituError;
use situ::keyframe::policy::Execution;
use situ::method::bp_ar_hmm::BpArHmm;
use situ::method::bp_ar_hmm::parameters::BpArHmmParameters;
use situ::method::{Learned, Method, named};
use situ::place::Place;
use situ::state::{Feature, Schema, State};

const OPEN: Gripper = Gripper::Open(0.08);
const CLOSE: Gripper = Gripper::Close(20.0);

fn schema() -> Schema {
    Schema::new(vec![Feature { name: "held".to_owned(), scale: 0.2 }]).unwrap()
}

/// A keyframe above an object: where the object is, how high above it, the command, and whether something is held.
fn keyframe(object: &str, at: Vector3<f64>, height: f64, gripper: Gripper, held: f64) -> Keyframe {
    Keyframe {
        reference: object.into(),
        reference_pose: Pose::translation(at.x, at.y, at.z),
        gripper_pose: Pose::translation(at.x, at.y, at.z + height),
        gripper,
        hold: 0.0,
        state: State::new([held]),
        announced: false,
        narration: None,
    }
}

fn shown(name: &str, keyframes: Vec<Keyframe>, carried_to_end: bool) -> Demonstration {
    Demonstration::new(name, Kind::Original, &schema(), keyframes, State::new([0.0]), carried_to_end).unwrap()
}

fn pick_and_place(name: &str, left: Vector3<f64>, right: Vector3<f64>) -> Demonstration {
    let keyframes = vec![
        keyframe("cube", left, 0.25, OPEN, 0.0),
        keyframe("cube", left, 0.02, CLOSE, 0.0),
        keyframe("cube", left, 0.25, CLOSE, 1.0),
        keyframe("tray", right, 0.25, CLOSE, 1.0),
        keyframe("tray", right, 0.05, OPEN, 1.0),
        keyframe("tray", right, 0.25, OPEN, 0.0),
    ];
    shown(name, keyframes, true)
}

fn taught() -> Box<dyn Learned> {
    let demonstrations = [
        pick_and_place("first", Vector3::new(0.0, 0.0, 0.0), Vector3::new(0.4, 0.1, 0.0)),
        pick_and_place("second", Vector3::new(0.1, -0.1, 0.0), Vector3::new(0.5, 0.2, 0.0)),
        pick_and_place("third", Vector3::new(-0.1, 0.1, 0.0), Vector3::new(0.3, 0.0, 0.0)),
    ];
    named("bp_ar_hmm").unwrap().teach(&schema(), &demonstrations, 3).unwrap()
}

/// The primitives follow their objects, and the gripper gets the commands that were shown.
#[test]
fn a_pick_and_a_place_follow_their_objects() {
    let model = taught();
    // Follows the primitives through the states: what the gripper does, and where.
    let (mut last, mut held, mut told) = (Place::Start, 0.0, OPEN);
    let (mut grasped, mut released, mut steps) = (None, None, 0);
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    while let Some((Place::Node(id), _)) = model.next(last, &State::new([held])).unwrap() {
        let (reference, keyframes) = model.keyframes(id, 0, &State::new([held]), Execution::Mean, &mut rng).unwrap();
        for keyframe in keyframes {
            let place = Some((reference.to_string(), keyframe.pose.translation.vector));
            match (told, keyframe.gripper) {
                (Gripper::Open(_), Gripper::Close(_)) => (grasped, held) = (place, 1.0),
                (Gripper::Close(_), Gripper::Open(_)) => (released, held) = (place, 0.0),
                _ => {}
            }
            told = keyframe.gripper;
        }
        last = Place::Node(id);
        steps += 1;
        assert!(steps < 50, "it goes round in circles");
    }
    assert_eq!(model.next(last, &State::new([held])).unwrap(), Some((Place::End, 1.0)));
    let (object, at) = grasped.expect("a grasp");
    assert!(object == "cube" && (at - Vector3::new(0.0, 0.0, 0.02)).norm() < 0.01, "a grasp at {at} of {object}");
    let (object, at) = released.expect("a release");
    assert!(object == "tray" && (at - Vector3::new(0.0, 0.0, 0.05)).norm() < 0.01, "a release at {at} of {object}");
}

/// What ran last ended where the originals ended. So what the correction shows follows a node that END follows too, in
/// the new nodes.
#[test]
fn a_correction_begins_after_what_ran_last() {
    let mut model = taught();
    let (last, _) = *model.graph().unwrap().edges.iter().find(|(_, to)| *to == Place::End).unwrap();
    // −5 is a value of `held` like no other.
    let lamp = |height: f64, gripper| keyframe("lamp", Vector3::new(0.2, 0.4, 0.0), height, gripper, -5.0);
    let correction = shown("lamp", vec![lamp(0.3, OPEN), lamp(0.02, CLOSE), lamp(0.3, OPEN)], false);
    let trace = model.correct(Correction::after(last, &correction)).unwrap();
    let graph = model.graph().unwrap();
    let first = graph.nodes.iter().find(|node| &*node.reference == "lamp").expect("a node on the lamp").id;
    let parents: Vec<Place> =
        graph.edges.iter().filter(|(_, to)| *to == Place::Node(first)).map(|(from, _)| *from).collect();
    let [parent] = parents[..] else { panic!("{:?}", graph.edges) };
    assert!(graph.edges.contains(&(parent, Place::End)), "it follows {parent}: {:?}", graph.edges);
    assert_eq!(model.next(parent, &State::new([-5.0])).unwrap().map(|(place, _)| place), Some(Place::Node(first)));
    let lamps: Vec<Place> =
        graph.nodes.iter().filter(|node| &*node.reference == "lamp").map(|node| Place::Node(node.id)).collect();
    assert!(!graph.edges.iter().any(|(from, to)| lamps.contains(from) && *to == Place::End), "{:?}", graph.edges);
    assert_eq!(trace.counters.nodes_touched, graph.nodes.len() as u64);
    assert!(trace.counters.segments_touched >= trace.counters.nodes_touched);
    assert_eq!((trace.counters.hmm_fits, trace.counters.em_iterations), (0, 0));
}

/// A hand that does not move, a single demonstration, and a correction of one keyframe are learned and can be executed.
#[test]
fn odd_demonstrations_are_learnt() {
    let still = |count: usize| vec![keyframe("cube", Vector3::zeros(), 0.1, OPEN, 0.0); count];
    let mut rest = still(2);
    rest[1].hold = 1.5;
    let alone = pick_and_place("alone", Vector3::zeros(), Vector3::new(0.4, 0.1, 0.0));
    let sets = [vec![shown("still", still(6), true)], vec![shown("rest", rest, false)], vec![alone]];
    for demonstrations in sets {
        let mut model = named("bp_ar_hmm").unwrap().teach(&schema(), &demonstrations, 5).unwrap();
        for last in [Place::Start, Place::Node(model.graph().unwrap().nodes[0].id)] {
            model.correct(Correction::after(last, &shown("one", still(1), false))).unwrap();
        }
        for node in model.graph().unwrap().nodes {
            for execution in [Execution::Mean, Execution::Sample] {
                let (_, keyframes) = model
                    .keyframes(node.id, 0, &State::new([0.0]), execution, &mut ChaCha8Rng::seed_from_u64(1))
                    .unwrap();
                let finite = |pose: &Pose| pose.to_homogeneous().iter().all(|value| value.is_finite());
                assert!(!keyframes.is_empty() && keyframes.iter().all(|keyframe| finite(&keyframe.pose)));
            }
        }
    }
    let refused = |parameters| {
        let method = BpArHmm { parameters };
        matches!(method.teach(&schema(), &[shown("still", still(2), true)], 0), Err(SituError::Parameter { .. }))
    };
    assert!(refused(BpArHmmParameters { chains: 0, ..BpArHmmParameters::default() }));
    assert!(refused(BpArHmmParameters { sweeps: 0, ..BpArHmmParameters::default() }));
}

/// A single keyframe has no motion; it is learned. In a world whose squares overflow there is no covariance; it is
/// refused.
#[test]
fn what_is_too_little_is_learnt_and_what_is_too_large_refused() {
    let teach = |demonstration| named("bp_ar_hmm").unwrap().teach(&schema(), &[demonstration], 0);
    let one = shown("one", vec![keyframe("cube", Vector3::zeros(), 0.1, OPEN, 0.0)], true);
    let model = teach(one).unwrap();
    assert_eq!(model.graph().unwrap().edges.len(), 2);
    let far = Vector3::new(1e200, 0.0, 0.0);
    let large = vec![keyframe("cube", Vector3::zeros(), 0.1, OPEN, 0.0), keyframe("cube", far, 0.1, CLOSE, 0.0)];
    assert!(matches!(teach(shown("large", large, true)).map(|_| ()), Err(SituError::Policy { .. })));
}
