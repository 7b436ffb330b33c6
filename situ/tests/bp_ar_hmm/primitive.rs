//! Movement primitives, and what becomes of them in a task.

use nalgebra::{Vector2, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use situ::demonstration::{Demonstration, Feature, Gripper, Keyframe, Kind, Pose, Schema, State};
use situ::keyframe::policy::Execution;
use situ::method::bp_ar_hmm::dmp::Dmp;
use situ::method::named;
use situ::place::Place;

/// A bow from (0, 0) to (0.4, 0.2) m, of even points, from rest to rest (minimum jerk).
fn bow(points: usize) -> Vec<Vector2<f64>> {
    (0..points)
        .map(|index| {
            let t = index as f64 / (points - 1) as f64;
            let share = t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t);
            Vector2::new(0.4 * share, 0.2 * share + 0.1 * (share * core::f64::consts::PI).sin())
        })
        .collect()
}

#[test]
fn what_was_taught_is_reproduced_and_a_moved_goal_is_reached() {
    let taught = bow(41);
    let dmp = Dmp::taught(std::slice::from_ref(&taught));
    let (start, goal) = (taught[0], taught[40]);
    let points = dmp.rollout(&start, &goal);
    // 200 steps over the same time: five a point.
    let worst = taught.iter().enumerate().map(|(index, point)| (points[5 * index] - point).norm()).fold(0.0, f64::max);
    println!("greatest deviation {worst:.5} m");
    assert!(worst < 0.003, "it leaves what it was taught by {worst} m");
    assert!((points[points.len() - 1] - goal).norm() < 1e-3, "it ends at {}", points[points.len() - 1]);
    let moved = goal + Vector2::new(-0.1, 0.15);
    let points = dmp.rollout(&start, &moved);
    let missed = (points[points.len() - 1] - moved).norm();
    println!("a moved goal missed by {missed:.6} m");
    assert!(missed < 1e-3, "a moved goal is missed by {missed} m");
    // It is the taught shape that is led there, not a straight line: the bow is still above the chord.
    let middle = points[100] - (start + moved) / 2.0;
    let across = Vector2::new(-(moved - start).y, (moved - start).x).normalize();
    assert!(middle.dot(&across) > 0.05, "the bow is lost: {}", middle.dot(&across));
}

#[test]
fn two_that_mirror_each_other_make_the_one_between() {
    let up = bow(41);
    let down: Vec<Vector2<f64>> = up.iter().map(|point| Vector2::new(point.x, point.x - point.y)).collect();
    let points = Dmp::taught(&[up.clone(), down]).rollout(&up[0], &up[40]);
    let worst = points.iter().map(|point| (point.y - 0.5 * point.x).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-9, "{worst}");
}

/// A pick and a place on a table laid anew each time: where an object goes, the primitives go, and the gripper is told what it was told.
#[test]
fn a_pick_and_a_place_follow_their_objects() {
    let schema = Schema::new(vec![Feature { name: "held".to_owned(), scale: 0.2 }]).unwrap();
    let shown = |name: &str, left: Vector3<f64>, right: Vector3<f64>| {
        let keyframe = |object: &str, at: Vector3<f64>, height: f64, gripper, held: f64| Keyframe {
            reference: object.into(),
            reference_pose: Pose::translation(at.x, at.y, at.z),
            gripper_pose: Pose::translation(at.x, at.y, at.z + height),
            gripper,
            hold: 0.0,
            state: State::new([held]),
        };
        let (open, close) = (Gripper::Open(0.08), Gripper::Close(20.0));
        let keyframes = vec![
            keyframe("cube", left, 0.25, open, 0.0),
            keyframe("cube", left, 0.02, close, 0.0),
            keyframe("cube", left, 0.25, close, 1.0),
            keyframe("tray", right, 0.25, close, 1.0),
            keyframe("tray", right, 0.05, open, 1.0),
            keyframe("tray", right, 0.25, open, 0.0),
        ];
        Demonstration::new(name, Kind::Original, &schema, keyframes, State::new([0.0]), true).unwrap()
    };
    let demonstrations = [
        shown("first", Vector3::new(0.0, 0.0, 0.0), Vector3::new(0.4, 0.1, 0.0)),
        shown("second", Vector3::new(0.1, -0.1, 0.0), Vector3::new(0.5, 0.2, 0.0)),
        shown("third", Vector3::new(-0.1, 0.1, 0.0), Vector3::new(0.3, 0.0, 0.0)),
    ];
    let model = named("bp_ar_hmm").unwrap().teach(&schema, &demonstrations, 3).unwrap();
    // Followed through the states: what the gripper does, and where.
    let (mut last, mut held, mut told) = (Place::Start, 0.0, Gripper::Open(0.08));
    let (mut grasped, mut released, mut steps) = (None, None, 0);
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    while let Some((Place::Node(id), _)) = model.next(last, &State::new([held])) {
        let (reference, keyframes) = model.keyframes(id, Execution::Mean, &mut rng).unwrap();
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
    assert_eq!(model.next(last, &State::new([held])), Some((Place::End, 1.0)));
    let (object, at) = grasped.expect("a grasp");
    assert!(object == "cube" && (at - Vector3::new(0.0, 0.0, 0.02)).norm() < 0.01, "a grasp at {at} of {object}");
    let (object, at) = released.expect("a release");
    assert!(object == "tray" && (at - Vector3::new(0.0, 0.0, 0.05)).norm() < 0.01, "a release at {at} of {object}");
}
