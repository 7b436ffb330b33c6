//! Spurious keyframes move no contact, and split no primitive (decision D25).
//!
//! A button is pressed, or a block taken: approach, contact, retreat, by a careful teacher. Some demonstrations have a
//! needless keyframe half way, somewhere before the contact or behind it.

use nalgebra::{Translation3, UnitQuaternion};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use situ::demonstration::{Demonstration, Gripper, Keyframe, Kind, Pose};
use situ::keyframe::policy::Execution;
use situ::method::{Learned, named};
use situ::state::{Feature, Schema, State};

const OPEN: Gripper = Gripper::Open(0.08);
const CLOSE: Gripper = Gripper::Close(20.0);
/// Where the hand approaches the thing and retreats to, in metres along the axis of the contact, which is at 0.
const APART: f64 = 0.12;
/// The greatest error of a careful teacher at the contact, metres.
const CAREFUL: f64 = 0.002;

/// A demonstration: where a needless keyframe is, as a share of the way, how often the thing is tried before it works,
/// and the noise of the contact.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shown {
    before: Option<f64>,
    behind: Option<f64>,
    tries: usize,
    noise: f64,
}

const PLAIN: Shown = Shown { before: None, behind: None, tries: 0, noise: 0.0 };

fn schema() -> Schema {
    Schema::new(vec![Feature { name: "x".to_owned(), scale: 0.1 }]).unwrap()
}

fn demonstration(number: usize, shown: Shown, at_contact: Gripper) -> Demonstration {
    let half_way = |share: f64| (share * APART, 0.03);
    let mut path = vec![(APART, 0.0, OPEN)];
    path.extend(shown.before.map(half_way).map(|(x, y)| (x, y, OPEN)));
    (0..shown.tries).for_each(|_| path.extend([(shown.noise, 0.0, at_contact), (APART, 0.0, OPEN)]));
    path.push((shown.noise, 0.0, at_contact));
    path.extend(shown.behind.map(half_way).map(|(x, y)| (x, y, at_contact)));
    path.push((APART, 0.0, at_contact));
    let keyframes = path.into_iter().map(|(x, y, gripper)| Keyframe {
        reference: "thing".into(),
        reference_pose: Pose::identity(),
        gripper_pose: Pose::from_parts(Translation3::new(x, y, 0.0), UnitQuaternion::identity()),
        gripper,
        hold: 0.0,
        state: State::new([0.0]),
        announced: false,
        narration: None,
    });
    let name = format!("shown-{number}");
    Demonstration::new(name, Kind::Original, &schema(), keyframes.collect(), State::new([1.0]), true).unwrap()
}

fn taught(method: &str, shown: &[Shown], at_contact: Gripper) -> Box<dyn Learned> {
    let originals: Vec<Demonstration> =
        shown.iter().enumerate().map(|(number, shown)| demonstration(number, *shown, at_contact)).collect();
    named(method).unwrap().teach(&schema(), &originals, 0).unwrap()
}

/// How near the one primitive comes to the contact, metres, and the gripper's command there.
fn nearest(model: &dyn Learned) -> (f64, Gripper) {
    let graph = model.graph().unwrap();
    assert_eq!(graph.nodes.len(), 1, "one primitive");
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let (_, keyframes) = model.keyframes(graph.nodes[0].id, 0, &State::new([0.0]), Execution::Mean, &mut rng).unwrap();
    let all = keyframes.iter().map(|keyframe| (keyframe.pose.translation.vector.norm(), keyframe.gripper));
    all.min_by(|left, right| left.0.total_cmp(&right.0)).unwrap()
}

/// A demonstration with a needless keyframe before the contact, behind it, both or none, and perhaps with tries.
fn shown() -> impl Strategy<Value = Shown> {
    let needless = || prop::option::weighted(0.4, 0.3..0.7);
    let tries = prop_oneof![4 => Just(0), 1 => 1..4_usize];
    let all = (needless(), needless(), tries, -CAREFUL..CAREFUL);
    all.prop_map(|(before, behind, tries, noise)| Shown { before, behind, tries, noise })
}

/// Demonstrations of which at most half have needless keyframes or tries, in any order; three at least.
fn at_most_half() -> impl Strategy<Value = Vec<Shown>> {
    (prop::collection::vec(shown(), 1..5), prop::collection::vec(-CAREFUL..CAREFUL, 4..7)).prop_flat_map(
        |(some, noises)| {
            let plain = noises.into_iter().take(some.len().max(2)).map(|noise| Shown { noise, ..PLAIN });
            Just(some.iter().copied().chain(plain).collect::<Vec<_>>()).prop_shuffle()
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_spurious_keyframe_moves_no_contact(shown in at_most_half(), grasps: bool) {
        let at_contact = if grasps { CLOSE } else { OPEN };
        let (apart, command) = nearest(&*taught("situ", &shown, at_contact));
        prop_assert!(apart <= CAREFUL && !command.is_moved_by(at_contact), "{apart} m short, {command:?}");
    }

    #[test]
    fn without_spurious_keyframes_nothing_changes(noises in prop::collection::vec(-CAREFUL..CAREFUL, 1..6)) {
        let shown: Vec<Shown> = noises.iter().map(|noise| Shown { noise: *noise, ..PLAIN }).collect();
        let written = |method| taught(method, &shown, CLOSE).to_json().to_string();
        prop_assert_eq!(written("situ"), written("situ:keep_spurious"));
    }
}

/// The command anchors a grasp even where most demonstrations have a needless keyframe, each elsewhere.
#[test]
fn most_demonstrations_may_have_a_spurious_keyframe() {
    let (before, behind) = (Some(0.6), Some(0.6));
    let shown = [Shown { before, ..PLAIN }, Shown { behind, ..PLAIN }, PLAIN, Shown { before, ..PLAIN }, PLAIN];
    let shown = [&shown[..], &[Shown { behind, ..PLAIN }]].concat();
    let (left_out, averaged) =
        (nearest(&*taught("situ", &shown, CLOSE)), nearest(&*taught("situ:keep_spurious", &shown, CLOSE)));
    assert!(left_out.0 <= CAREFUL && averaged.0 > 0.01, "{left_out:?} against {averaged:?}");
}

#[test]
fn averaged_a_spurious_keyframe_stops_the_hand_short() {
    let (before, behind) = (Some(0.35), Some(0.5));
    let shown = [PLAIN, Shown { before, behind, ..PLAIN }, PLAIN, Shown { before, ..PLAIN }];
    let short = |method| nearest(&*taught(method, &shown, OPEN)).0;
    let (left_out, averaged) = (short("situ"), short("situ:keep_spurious"));
    assert!(left_out <= CAREFUL && averaged > 0.01, "{left_out} m against {averaged} m");
}
