//! Scripts: the program of the competent teacher, and the original program, run without looking or watched by a
//! teacher.

use std::fmt;

use situ_sim::{MotionEnd, Pose, World};

use crate::episode::Episode;
use crate::moment::Moment;
use crate::skill::Skill;

/// No script runs more skills than this. A program that does not get on is stopped here, if the time limit does not
/// stop it.
const MAX_SKILLS: usize = 64;

/// How a script ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The goal holds.
    Succeeded,
    /// No skill may run, and the goal does not hold.
    NoSkill,
    /// The time limit passed, or far too many skills ran.
    OutOfTime,
    /// A watching teacher stopped it.
    Stopped,
    /// The arm cannot hold the hand at a keyframe.
    OutOfReach,
    /// The planner found no way to a keyframe on which the arm runs into nothing.
    NoPlan,
    /// The physics' numbers are no longer sound.
    Spoilt,
}

impl fmt::Display for Ending {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Ending::Succeeded => "succeeded",
            Ending::NoSkill => "had no skill left",
            Ending::OutOfTime => "ran out of time",
            Ending::Stopped => "was stopped",
            Ending::OutOfReach => "was out of reach",
            Ending::NoPlan => "found no plan",
            Ending::Spoilt => "spoilt the physics",
        })
    }
}

/// What a script did.
#[derive(Debug, Clone, PartialEq)]
pub struct ScriptRecord {
    /// How it ended.
    pub ending: Ending,
    /// The skills that ran, in order.
    pub skills: Vec<String>,
    /// Keyframes that were performed.
    pub keyframes: usize,
    /// Motions that the guard stopped.
    pub guarded: usize,
    /// Motions that were aborted, each of which ended its skill.
    pub aborted: usize,
}

impl ScriptRecord {
    fn new() -> ScriptRecord {
        ScriptRecord { ending: Ending::NoSkill, skills: Vec::new(), keyframes: 0, guarded: 0, aborted: 0 }
    }
}

/// How the frame of a skill's reference object is seen: by a person, or by the robot.
type Sees = fn(&Episode, &str) -> Option<Pose>;

/// Runs the program of the competent teacher, who sees things as they are: again and again the first skill that may
/// run, until the goal holds.
pub fn competent(episode: &mut Episode, observer: &mut dyn FnMut(&World)) -> ScriptRecord {
    let mut record = ScriptRecord::new();
    loop {
        if let Some(ending) = ending(episode) {
            record.ending = ending;
            return record;
        }
        let Some(skill) = episode.next_skill().cloned() else {
            record.ending = Ending::NoSkill;
            return record;
        };
        if record.skills.len() >= MAX_SKILLS {
            record.ending = Ending::OutOfTime;
            return record;
        }
        let seen = (&skill, Episode::true_reference_pose as Sees);
        if let Some(ending) = perform_skill(episode, seen, &mut record, &mut |_, _| false, observer) {
            record.ending = ending;
            return record;
        }
    }
}

/// Runs the original program without looking at what became of it: each skill once, in the order of the file, about
/// things where the robot sees them. A task model without the needed edit would do the same.
pub fn original(episode: &mut Episode, observer: &mut dyn FnMut(&World)) -> ScriptRecord {
    once(episode, &mut |_, _, _| false, observer)
}

/// Runs the original program as [`original`] does, while a teacher watches. The teacher stops it ([`Ending::Stopped`])
/// at the first of the setting's interventions. The episode is left as it is at that moment.
pub fn watched(episode: &mut Episode, observer: &mut dyn FnMut(&World)) -> ScriptRecord {
    once(episode, &mut |episode, moment, reference| episode.intervention(moment, reference).is_some(), observer)
}

/// Each of the original skills once, until `stops` says so.
fn once(
    episode: &mut Episode,
    stops: &mut dyn FnMut(&Episode, Moment, &str) -> bool,
    observer: &mut dyn FnMut(&World),
) -> ScriptRecord {
    let mut record = ScriptRecord::new();
    for skill in episode.setting().original_skills.clone() {
        if let Some(ending) = ending(episode) {
            record.ending = ending;
            return record;
        }
        let mut stops_here = |episode: &Episode, moment| stops(episode, moment, &skill.reference);
        if let Some(ending) =
            perform_skill(episode, (&skill, Episode::reference_pose), &mut record, &mut stops_here, observer)
        {
            record.ending = ending;
            return record;
        }
    }
    record.ending = ending(episode).unwrap_or(Ending::NoSkill);
    record
}

/// Performs a skill: freezes the frame of its reference object, then goes through its keyframes. Returns how the script
/// ended, if it ended on the way: because `stops` said so, or because the arm cannot go on.
fn perform_skill(
    episode: &mut Episode,
    (skill, sees): (&Skill, Sees),
    record: &mut ScriptRecord,
    stops: &mut dyn FnMut(&Episode, Moment) -> bool,
    observer: &mut dyn FnMut(&World),
) -> Option<Ending> {
    if stops(episode, Moment::Before) {
        return Some(Ending::Stopped);
    }
    record.skills.push(skill.name.clone());
    let frame = sees(episode, &skill.reference)?;
    for (index, keyframe) in skill.keyframes.iter().enumerate() {
        record.keyframes += 1;
        let end = episode.perform(&(frame * keyframe.pose), keyframe.gripper, keyframe.hold, observer);
        match end {
            MotionEnd::Reached => {}
            MotionEnd::Guarded { .. } => record.guarded += 1,
            MotionEnd::Aborted { .. } => record.aborted += 1,
            MotionEnd::OutOfReach => return Some(Ending::OutOfReach),
            MotionEnd::NoPlan => return Some(Ending::NoPlan),
        }
        if end != MotionEnd::Reached && stops(episode, Moment::Guard) {
            return Some(Ending::Stopped);
        }
        if !end.goes_on() {
            break;
        }
        episode.reached_keyframe(&skill.reference, index);
    }
    stops(episode, Moment::After).then_some(Ending::Stopped)
}

/// How the script has ended, if it has.
fn ending(episode: &Episode) -> Option<Ending> {
    if !episode.is_sound() {
        Some(Ending::Spoilt)
    } else if episode.succeeded() {
        Some(Ending::Succeeded)
    } else if episode.finished_out_of_time() {
        Some(Ending::OutOfTime)
    } else {
        None
    }
}
