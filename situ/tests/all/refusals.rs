//! What is refused, and that the message says where.

use std::cell::Cell;
use std::rc::Rc;
use std::sync::Arc;

use crate::common::toy::{Line, Nearest, Toy};
use crate::common::{corrective, histories, spelt};
use situ::correction::Correction;
use situ::decisions::{Decisions, Ways};
use situ::demonstration::{Demonstration, Gripper, Keyframe, Kind, Pose};
use situ::error::SituError;
use situ::fold::situ;
use situ::method::rebuild::rebuild;
use situ::place::{NodeId, Place, SegmentId};
use situ::primitive::{Clustering, Learner};
use situ::segment::Segment;
use situ::state::{Feature, Schema, State};
use situ::task_model::TaskModel;
use situ::trace::{Branch, Counters};
use situ::trail::{StepEnd, TrailStep};

fn feature(name: &str, scale: f64) -> Feature {
    Feature { name: name.to_owned(), scale }
}

#[test]
fn schemas() {
    let refused = |features: Vec<Feature>| match Schema::new(features) {
        Err(SituError::Schema { feature, .. }) => feature,
        other => panic!("{other:?}"),
    };
    assert_eq!(refused(Vec::new()), "");
    assert_eq!(refused(vec![feature("x", 0.2), feature("y", 0.2), feature("x", 0.3)]), "x");
    for scale in [0.0, -0.2, f64::NAN, f64::INFINITY] {
        assert_eq!(refused(vec![feature("x", 0.2), feature("y", scale)]), "y", "{scale}");
    }
    assert_eq!(Schema::new(vec![feature("x", 0.2), feature("y", 0.1)]).unwrap().len(), 2);
}

/// Spoils a keyframe.
type Change<'a> = &'a dyn Fn(&mut Keyframe);

#[test]
fn demonstrations() {
    let schema = Schema::new(vec![feature("x", 0.2), feature("y", 0.2)]).unwrap();
    let sound = Keyframe {
        reference: "cup".into(),
        reference_pose: Pose::identity(),
        gripper_pose: Pose::translation(0.1, 0.2, 0.3),
        gripper: Gripper::Close(20.0),
        hold: 0.5,
        state: State::new([0.1, 0.2]),
        announced: false,
        narration: None,
    };
    let last = State::new([0.0, 0.0]);
    let make =
        |keyframes: Vec<Keyframe>, last: State| Demonstration::new("d", Kind::Original, &schema, keyframes, last, true);
    assert!(make(vec![sound.clone()], last.clone()).is_ok());
    assert!(matches!(
        make(Vec::new(), last.clone()),
        Err(SituError::EmptyDemonstration { demonstration }) if demonstration == "d"
    ));
    // The second of two keyframes is wrong: the message names it, and the field.
    let refused = |change: Change<'_>| {
        let mut wrong = sound.clone();
        change(&mut wrong);
        make(vec![sound.clone(), wrong], last.clone()).unwrap_err().to_string()
    };
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let named: [(Change<'_>, &str); 6] = [
            (&|keyframe| keyframe.gripper_pose.translation.y = value, "gripper_pose"),
            (&|keyframe| keyframe.reference_pose.translation.z = value, "reference_pose"),
            (&|keyframe| keyframe.reference_pose.rotation.as_mut_unchecked().coords.x = value, "reference_pose"),
            (&|keyframe| keyframe.gripper = Gripper::Open(value), "gripper"),
            (&|keyframe| keyframe.hold = value, "hold"),
            (&|keyframe| keyframe.state = State::new([0.0, value]), "feature `y`"),
        ];
        for (change, name) in named {
            let message = refused(change);
            assert!(message.starts_with("demonstration `d`, keyframe 1: ") && message.contains(name), "{message}");
        }
    }
    assert!(refused(&|keyframe| keyframe.hold = -0.1).contains("hold"));
    let message = refused(&|keyframe| keyframe.state = State::new([0.0]));
    assert_eq!(
        message,
        "demonstration `d`, keyframe 1: a state of 1 numbers, expected 2 (one a feature of the schema)"
    );
    let message = make(vec![sound.clone()], State::new([0.0; 3])).unwrap_err().to_string();
    assert!(message.starts_with("demonstration `d`, final state: a state of 3 numbers"), "{message}");
    let message = make(vec![sound.clone()], State::new([f64::NAN, 0.0])).unwrap_err().to_string();
    assert!(message.starts_with("demonstration `d`, final state: ") && message.contains("`x`"), "{message}");
}

#[test]
fn places_that_cannot_have_run() {
    let learner = Toy::on_a_line(2.0);
    let decisions = Decisions::mended();
    let shown = spelt(&[(0, 0.0, 0.0)], 1.0, true);
    let (model, _) = rebuild(histories(std::slice::from_ref(&shown)), None, &learner, &decisions).unwrap();
    let update = |last| situ(Correction::after(last, &shown), &mut model.clone(), &learner, &decisions).map(|_| ());
    assert_eq!(update(Place::Start), Ok(()));
    assert_eq!(update(Place::End), Err(SituError::NotExecutable(Place::End)));
    assert_eq!(update(Place::Node(NodeId(7))), Err(SituError::UnknownNode(NodeId(7))));
    assert_eq!(rebuild(Vec::new(), None, &learner, &decisions).map(|_| ()), Err(SituError::NoDemonstration));
}

/// A learner on a line that refuses its n-th fit, of policies and of classifiers together.
#[derive(Clone, Debug, PartialEq)]
struct Refusing {
    learner: Toy,
    left: Rc<Cell<u32>>,
}

impl Refusing {
    fn ask(&self) -> Result<(), SituError> {
        let left = self.left.get().checked_sub(1).ok_or(SituError::Classifier("enough".to_owned()))?;
        self.left.set(left);
        Ok(())
    }
}

impl Learner for Refusing {
    type Policy = Line;
    type Classifier = Nearest;
    type Calibration = ();

    fn fit_policy(&self, segments: &[&Segment], (): &(), counters: &mut Counters) -> Result<Line, SituError> {
        self.ask()?;
        self.learner.fit_policy(segments, &(), counters)
    }

    fn fit_classifier(
        &self,
        positives: &[&State],
        negatives: &[&State],
        counters: &mut Counters,
    ) -> Result<Nearest, SituError> {
        self.ask()?;
        self.learner.fit_classifier(positives, negatives, counters)
    }

    fn cluster_and_find(
        &self,
        own: &Line,
        candidates: &[Vec<&Line>],
        among: &[f64],
        calibration: &(),
        counters: &mut Counters,
    ) -> Clustering {
        self.learner.cluster_and_find(own, candidates, among, calibration, counters)
    }

    fn distance(&self, left: &Line, right: &Line, calibration: Option<&()>, counters: &mut Counters) -> f64 {
        self.learner.distance(left, right, calibration, counters)
    }

    fn calibrate(&self, originals: &[&[Arc<Segment>]], counters: &mut Counters) -> Result<(), SituError> {
        self.learner.calibrate(originals, counters)
    }

    fn cluster(
        &self,
        segments: &[&Segment],
        calibration: &(),
        counters: &mut Counters,
    ) -> Result<Vec<usize>, SituError> {
        self.learner.cluster(segments, calibration, counters)
    }

    fn scales(&self) -> &[f64] {
        self.learner.scales()
    }

    fn path(&self, policy: &Line) -> Vec<Pose> {
        self.learner.path(policy)
    }
}

/// Wherever in a correction the learner refuses, the model is as it was, and learns the same afterwards. The correction
/// adds a node, merges three nodes that are fragments of one, adds edges, tells siblings, and ends at END.
#[test]
fn a_correction_is_folded_in_whole_or_not_at_all() {
    for decisions in [Decisions::mended(), Decisions::literal()] {
        let learner = Refusing { learner: Toy::on_a_line(0.05), left: Rc::new(Cell::new(u32::MAX)) };
        let fragments = |x: f64| spelt(&[(0, x, 0.0), (1, x, 1.0), (2, x, 2.0)], 3.0, true);
        let originals = [fragments(0.0), fragments(0.3), fragments(0.6)];
        let (before, _) = rebuild(histories(&originals), None, &learner, &decisions).unwrap();
        let correct = |model: &mut TaskModel<Refusing>, fits| {
            learner.left.set(fits);
            let last = Place::Node(before.nodes().next().unwrap().0);
            let shown = spelt(&[(3, 5.0, 1.5), (1, 0.4, 1.0), (2, 0.4, 2.0)], 3.0, true);
            situ(Correction::after(last, &shown), model, &learner, &decisions)
        };
        let mut whole = before.clone();
        let expected = correct(&mut whole, u32::MAX).unwrap();
        assert!(expected.steps.iter().any(|step| !step.merged.is_empty()) && expected.steps[0].branch == Branch::New);
        let mut model = before.clone();
        let refused = (0..).take_while(|fits| correct(&mut model, *fits).is_err() && model == before).count();
        assert!(refused > 10, "{refused} places of refusal");
        assert!(model == whole, "after {refused} refusals");
    }
}

/// The same for a correction that adds a way, drops another, counts a choice of the rollout, retires a positive, and
/// ends at END.
#[test]
fn ways_and_retired_positives_come_back() {
    let decisions = Decisions { ways: Ways::Keep(2), ..Decisions::mended() };
    let learner = Refusing { learner: Toy::on_a_line(2.0), left: Rc::new(Cell::new(u32::MAX)) };
    let original = |c: f64| spelt(&[(0, 0.0, 0.0), (1, 0.0, 1.0), (2, 0.0, c)], 3.0, true);
    let originals = [original(2.0), original(2.5)];
    let (mut before, _) = rebuild(histories(&originals), None, &learner, &decisions).unwrap();
    let [a, b] = [0, 1].map(|index| before.node_of(SegmentId { demonstration: 0, index }).unwrap());
    let correct = |model: &mut TaskModel<Refusing>, failed: f64, words: &[(u8, f64, f64)], end: bool| {
        let step = |node, state: f64, end| TrailStep { state: State::new([state]), node, end };
        let trail = [step(a, 0.0, StepEnd::Finished), step(b, failed, StepEnd::Interrupted)];
        let shown = corrective(words, 3.0, end);
        let correction =
            Correction { interrupted: Some(b), trail: &trail, ..Correction::after(Place::Node(a), &shown) };
        situ(correction, model, &learner, &decisions)
    };
    correct(&mut before, 5.0, &[(1, 10.0, 40.0)], false).unwrap();
    let correct = |model: &mut TaskModel<Refusing>, fits| {
        learner.left.set(fits);
        // After B in the state in which C began: the first in order is C.
        correct(model, 8.0, &[(1, 20.0, 40.0), (3, 0.0, 2.0)], true)
    };
    let mut whole = before.clone();
    let expected = correct(&mut whole, u32::MAX).unwrap();
    assert_eq!((expected.steps[0].branch, expected.obedience.retired), (Branch::Modify, 1));
    let ways = &whole.node(b).unwrap().ways;
    assert_eq!(ways.iter().map(|way| way.policy.x).collect::<Vec<_>>(), [0.0, 20.0]);
    let mut model = before.clone();
    let refused = (0..).take_while(|fits| correct(&mut model, *fits).is_err() && model == before).count();
    assert!(refused > 5, "{refused} places of refusal");
    assert!(model == whole, "after {refused} refusals");
}
