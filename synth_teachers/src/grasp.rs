//! How a thing is taken, and how what is in the hand is put where it belongs.
//!
//! Two grasps of one thing by one person differ, and the person sees to it that both work. So a grasp is drawn once for
//! the whole skill, off from the script's in the gripper's frame: all its keyframes are off alike. The teacher sees
//! which grasp will not hold, or hardly, and takes the thing in another way; small errors, pauses and needless
//! keyframes are no part of what is foreseen. And the teacher guides the *thing*: as long as it is in the hand, the
//! hand goes where it brings the thing to the place to which the script's own grasp would have brought it.

use nalgebra::{Isometry3, Translation3};
use situ_tasks::{Episode, GripperCommand, KeyframeCommand, Skill};

use crate::mistakes::Mistakes;

/// Ways to take a thing that a teacher thinks of. One who has found none takes it as the script does.
const MOST_GRASPS: usize = 20;

/// A teacher does not choose a grasp that would not hold this much further off, in metres.
const MARGIN: f64 = 0.005;

/// Times that a skill is foreseen which has to be done again by its nature.
const MOST_TIMES: usize = 3;

/// A thing that lies in the hand turned further than this against the script's grasp, about another axis than the
/// gripper's, was taken up from another of its sides, in radians. Its turn is let alone.
const MOST_TILT: f64 = 0.6;

/// What the teacher took last, and how the script would have it in the hand.
#[derive(Default)]
pub(crate) struct Hold {
    /// The object, and its pose in the gripper's frame by the script's grasp.
    taken: Option<(String, Isometry3<f64>)>,
    /// Grasps that were thought of and dropped, because they would not hold.
    pub(crate) dropped: u32,
}

impl Hold {
    /// The pose of the gripper for this skill, in the frame of the gripper that the script would have: to be multiplied
    /// to the right of every keyframe's pose.
    pub(crate) fn next(&mut self, skill: &Skill, episode: &Episode, mistakes: &mut Mistakes<'_>) -> Isometry3<f64> {
        if !mistakes.varies_grasps() {
            return Isometry3::identity();
        }
        let Some(grasp) = grasp(skill) else { return self.guided(episode).unwrap_or_else(Isometry3::identity) };
        let view = episode.view();
        let object = view.object(&skill.reference);
        let (frame, body) =
            (episode.true_reference_pose(&skill.reference), object.and_then(|object| episode.world().pose(object)));
        self.taken = object
            .zip(frame.zip(body))
            .map(|(object, (frame, body))| (object.to_owned(), grasp.pose.inverse() * frame.inverse() * body));
        for _ in 0..MOST_GRASPS {
            let way = mistakes.next_grasp();
            if holds(&way, skill, episode) {
                return way;
            }
            self.dropped += 1;
        }
        Isometry3::identity()
    }

    /// Where the hand goes, so that what is in it gets to where the script would have it. None where nothing is held.
    fn guided(&self, episode: &Episode) -> Option<Isometry3<f64>> {
        let (held, grasp) = episode.setting().skills.iter().find_map(|skill| {
            let grasp = grasp(skill)?;
            (stays_closed(skill) && episode.holds(&skill.until)).then_some((&skill.reference, grasp))
        })?;
        let view = episode.view();
        let held = view.object(held)?;
        let own = self.taken.as_ref().filter(|(object, _)| object == held).map(|(_, pose)| *pose);
        let scripted = own.unwrap_or_else(|| grasp.pose.inverse());
        let seen = episode.world().tcp().inverse() * episode.world().pose(held)?;
        // Of the rotations that look alike, the one that is nearest to the script's.
        let symmetry = episode.world().object(held)?.symmetry;
        let rotation = symmetry.map_or(seen.rotation, |symmetry| symmetry.nearest(&seen.rotation, &scripted.rotation));
        let seen = Isometry3::from_parts(seen.translation, rotation);
        let turn = scripted.rotation * seen.rotation.inverse();
        let tilt = 2.0 * libm::asin(turn.imag().xy().norm().min(1.0));
        let turn = if tilt > MOST_TILT { nalgebra::UnitQuaternion::identity() } else { turn };
        let shift = scripted.translation.vector - turn * seen.translation.vector;
        Some(Isometry3::from_parts(Translation3::from(shift), turn))
    }
}

/// The keyframe at which a skill takes hold of its reference object, if it does. A hand that is closed where it touches
/// nothing takes nothing: it is made a fist to push with.
fn grasp(skill: &Skill) -> Option<&KeyframeCommand> {
    skill
        .keyframes
        .iter()
        .find(|keyframe| keyframe.contact && matches!(keyframe.gripper, Some(GripperCommand::Close(_))))
}

/// Whether the hand is closed when the skill is done.
fn stays_closed(skill: &Skill) -> bool {
    let last = skill.keyframes.iter().rev().find_map(|keyframe| keyframe.gripper);
    matches!(last, Some(GripperCommand::Close(_)))
}

/// Whether the skill does what it is for if the thing is taken in this way, and if it is taken a little further off.
fn holds(way: &Isometry3<f64>, skill: &Skill, episode: &Episode) -> bool {
    let off = way.translation.vector;
    let further =
        off.try_normalize(0.0).map(|along| Isometry3::from_parts((off + along * MARGIN).into(), way.rotation));
    does(way, skill, episode) && further.is_none_or(|further| does(&further, skill, episode))
}

/// Whether the skill does what it is for if the thing is taken in this way. One that has to be done again by its nature
/// is. What somebody else does then is not the grasp's fault.
fn does(way: &Isometry3<f64>, skill: &Skill, episode: &Episode) -> bool {
    let mut ahead = episode.clone();
    let times = if episode.setting().repeats(&skill.name) { MOST_TIMES } else { 1 };
    for _ in 0..times {
        let Some(frame) = ahead.true_reference_pose(&skill.reference) else { return false };
        for (index, keyframe) in skill.keyframes.iter().enumerate() {
            let target = frame * keyframe.pose * way;
            if !ahead.perform(&target, keyframe.gripper, keyframe.hold, &mut |_| {}).goes_on() {
                return false;
            }
            ahead.reached_keyframe(&skill.reference, index);
        }
        if ahead.holds(&skill.until) || ahead.events_fired() > episode.events_fired() {
            return true;
        }
    }
    false
}
