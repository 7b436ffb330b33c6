//! A teacher performs the task's program and writes down what was seen.

use std::sync::Arc;

use nalgebra::Isometry3;
use situ::demonstration::{Demonstration, Keyframe, Kind, Pose};
use situ::state::Schema;
use situ_tasks::{Episode, MotionEnd, Skill, World};

use crate::convert::{observe, observed_gripper};
use crate::error::TeacherError;
use crate::grasp::Hold;
use crate::mistakes::Mistakes;
use crate::onset::{Onset, onset};
use crate::path::displaced;
use crate::profile::Profile;
use crate::tally::Tally;

/// What a demonstration cost its teacher.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TeachingEffort {
    /// Keyframes recorded.
    pub keyframes: u32,
    /// Simulated seconds.
    pub seconds: f64,
    /// Path of the gripper, metres.
    pub metres: f64,
    /// Grasps that were thought of and dropped, because they would not hold. Nobody saw them, so they are no tries.
    pub foreseen: u32,
}

/// A demonstration given, or an attempt at one.
#[derive(Clone, Debug)]
pub struct Shown {
    /// What was recorded. `None` where nothing was recorded, because the program had nothing to do.
    pub demonstration: Option<Demonstration>,
    /// What it cost.
    pub effort: TeachingEffort,
    /// Whether it is fit to be handed in: every skill did what it is for, and a program that was carried on to the end
    /// met the goal.
    pub clean: bool,
    /// The mistakes made.
    pub tally: Tally,
    /// The skills performed, by name.
    pub skills: Vec<String>,
}

/// A scripted teacher.
#[derive(Clone, Debug)]
pub struct Teacher {
    profile: Profile,
}

/// Skills in one demonstration after which the teacher gives up: more than twice what the longest task needs.
const MOST_SKILLS: usize = 40;

impl Teacher {
    /// A teacher of this profile.
    pub fn new(profile: Profile) -> Self {
        Self { profile }
    }

    /// The profile.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// When this teacher steps in at the correction of this seed.
    pub fn onset(&self, seed: u64) -> Onset {
        onset(&self.profile, seed)
    }

    /// Demonstrates from where the episode stands, until the goal is met. A correction may end once what changed has
    /// been shown and the robot knows how to go on, if the draw says that this teacher stops there. `observer` sees
    /// every simulated step.
    ///
    /// # Errors
    /// A reference object is missing, or an observation is not finite. An unclean attempt is no error.
    pub fn demonstrate(
        &self,
        name: &str,
        kind: Kind,
        schema: &Schema,
        episode: &mut Episode,
        seed: u64,
        observer: &mut dyn FnMut(&World),
    ) -> Result<Shown, TeacherError> {
        let mut mistakes = Mistakes::new(&self.profile, seed);
        let stops_early = mistakes.stops_early(kind == Kind::Corrective);
        let setting = episode.setting().clone();
        let (seconds, metres) = (episode.seconds(), episode.path());
        let mut hand = Hold::default();
        let mut recorder = Recorder { keyframes: Vec::new(), before: observe(episode) };
        let mut skills = Vec::new();
        let mut clean = true;
        let mut stopped = false;
        // Nobody stops before having shown what changed. Where no skill did, any skill shows where to go on.
        let mut change_is_shown = setting.skills.iter().all(|skill| setting.is_original(skill));
        while !episode.succeeded() {
            let Some(skill) = episode.next_skill().cloned() else { break };
            if skills.len() == MOST_SKILLS || episode.finished_out_of_time() || !episode.is_sound() {
                clean = false;
                break;
            }
            let events = episode.events_fired();
            let way = hand.next(&skill, episode, &mut mistakes);
            clean &= perform((&skill, &way), episode, &mut mistakes, &mut recorder, observer)?;
            // What somebody else did is not the teacher's slip. Nor is a skill that must be done again by its nature,
            // such as opening a drawer that opens half-way: the program goes on from there.
            clean &= episode.holds(&skill.until) || episode.events_fired() > events || setting.repeats(&skill.name);
            skills.push(skill.name.clone());
            if !clean {
                // A person who sees that it went wrong stops, and begins again.
                break;
            }
            change_is_shown |= !setting.is_original(&skill);
            if stops_early && change_is_shown && setting.is_original(&skill) && !episode.succeeded() {
                stopped = true;
                break;
            }
        }
        clean &= stopped || episode.succeeded();
        let effort = TeachingEffort {
            keyframes: recorder.keyframes.len() as u32,
            seconds: episode.seconds() - seconds,
            metres: episode.path() - metres,
            foreseen: hand.dropped,
        };
        clean &= !recorder.keyframes.is_empty();
        let demonstration = if recorder.keyframes.is_empty() || !episode.is_sound() {
            None
        } else {
            Some(Demonstration::new(name, kind, schema, recorder.keyframes, observe(episode), !stopped)?)
        };
        Ok(Shown { demonstration, effort, clean, tally: mistakes.tally, skills })
    }
}

/// What is written down.
struct Recorder {
    keyframes: Vec<Keyframe>,
    /// The world before the motion to the next keyframe: as the last *recorded* keyframe left it (decision D0).
    before: situ::state::State,
}

/// What the teacher names: the reference object with its frame at the beginning of the skill, and the skill.
struct Named {
    object: Arc<str>,
    frame: Pose,
    skill: Arc<str>,
    /// Whether the object is still to be said: it is with the first keyframe that is recorded.
    unsaid: bool,
}

impl Recorder {
    fn record(&mut self, episode: &Episode, named: &mut Named, hold: f64) {
        let after = observe(episode);
        self.keyframes.push(Keyframe {
            reference: named.object.clone(),
            reference_pose: named.frame,
            gripper_pose: episode.world().tcp(),
            gripper: observed_gripper(episode.world().gripper()),
            hold,
            state: std::mem::replace(&mut self.before, after),
            announced: std::mem::take(&mut named.unsaid),
            narration: Some(named.skill.clone()),
        });
    }
}

/// Performs one skill, with the gripper off from the script's by the pose beside it. Returns false if a motion was
/// aborted.
fn perform(
    (skill, way): (&Skill, &Isometry3<f64>),
    episode: &mut Episode,
    mistakes: &mut Mistakes<'_>,
    recorder: &mut Recorder,
    observer: &mut dyn FnMut(&World),
) -> Result<bool, TeacherError> {
    let none = || TeacherError::NoReference { skill: skill.name.clone(), reference: skill.reference.clone() };
    let frame = episode.true_reference_pose(&skill.reference).ok_or_else(none)?;
    // The person goes by the frame as it is. What is written down is the frame as the robot sees it, of the object that
    // the person means; one that the robot has never seen is pointed at.
    let meant = episode.view().object(&skill.reference).and_then(|object| episode.reference_pose(object));
    let slip = mistakes.next_skill();
    let right = || (skill.reference.as_str().into(), meant.unwrap_or(frame));
    let (object, frame_of_object) =
        slip.wrong_reference.and_then(|which| another(episode, &skill.reference, which)).unwrap_or_else(right);
    let mut named = Named { object, frame: frame_of_object, skill: skill.name.as_str().into(), unsaid: slip.announced };
    for (index, keyframe) in skill.keyframes.iter().enumerate() {
        let mistake = mistakes.next(keyframe.contact, keyframe.gripper.is_some());
        let mut aligned = frame * keyframe.pose * way;
        aligned.rotation *= slip.turn;
        let target = displaced(&aligned, &mistake.offset);
        for needless in mistake.needless(&episode.world().tcp(), &target) {
            if is_over(episode.perform(&needless, None, 0.0, observer)) {
                return Ok(false);
            }
            recorder.record(episode, &mut named, 0.0);
        }
        let hold = keyframe.hold + mistake.pause;
        let over = is_over(episode.perform(&target, keyframe.gripper, hold, observer));
        if !over {
            episode.reached_keyframe(&skill.reference, index);
        }
        if !mistake.missing {
            recorder.record(episode, &mut named, hold);
        }
        if over || !episode.is_sound() {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Whether a motion that ended so ends the skill.
fn is_over(end: MotionEnd) -> bool {
    !end.goes_on()
}

/// Another reference of the scene, named by mistake: an object, or the role that it can fill. `which` is its place
/// among the others, from 0 to 1. None in a scene of one object.
fn another(episode: &Episode, right: &str, which: f64) -> Option<(Arc<str>, Pose)> {
    let setting = episode.setting();
    let mut others: Vec<&str> = Vec::new();
    for name in setting.objects.iter().map(|placed| setting.reference_of(&placed.body.name)) {
        if name != right && !others.contains(&name) {
            others.push(name);
        }
    }
    let others: Vec<(Arc<str>, Pose)> =
        others.into_iter().filter_map(|name| episode.reference_pose(name).map(|frame| (name.into(), frame))).collect();
    let place = (which * others.len() as f64) as usize;
    others.into_iter().nth(place)
}
