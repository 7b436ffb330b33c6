//! A performance: what a teacher, the original program or a task model does in an episode, to be looked at.
//!
//! It can be done again and again, bit for bit alike. The first time tells where things go, what is under way at each
//! step and when keyframes are reached; later times are filmed.

use situ::demonstration::Keyframe;
use situ::place::Place;
use situ_sim::World;
use situ_tasks::Episode;
use situ_teachers::Shown;

use crate::calibration::Choice;
use crate::caption::{Caption, Captions};
use crate::ended::Ended;
use crate::error::BenchError;
use crate::observer::Observer;
use crate::rerun::NamedModel;
use crate::rollout::Rollout;
use crate::track::Track;

/// Does it once more. The observer sees every step.
pub type Again<'a> = Box<dyn Fn(&mut dyn FnMut(&World)) -> Result<(), BenchError> + 'a>;

/// A performance, and what is known of it after the first time.
pub struct Performance<'a> {
    /// Where it begins.
    pub start: Episode,
    /// Where things go.
    pub track: Track,
    /// What is under way.
    pub captions: Captions,
    /// The steps at which keyframes are reached, and the last one.
    pub moments: Vec<usize>,
    /// Does it once more.
    pub again: Again<'a>,
}

/// How a teacher's performance ended, in a caption.
fn end(is_goal: bool) -> Caption {
    Caption { what: "end".to_owned(), detail: reached(is_goal).to_owned(), reached: Some(is_goal) }
}

/// How a correction ended that the teacher did not carry on to the goal: what changed has been shown.
fn handed_over() -> Caption {
    Caption { what: "end".to_owned(), detail: "the robot can go on".to_owned(), reached: None }
}

fn reached(is_goal: bool) -> &'static str {
    if is_goal { "goal reached" } else { "goal not reached" }
}

impl<'a> Performance<'a> {
    /// What a teacher showed from here, and whether the goal holds at its end.
    pub fn shown(
        (start, track): (Episode, Track),
        title: &str,
        (shown, is_goal): (&Shown, bool),
        again: Again<'a>,
    ) -> Self {
        let keyframes: &[Keyframe] = shown.demonstration.as_ref().map_or(&[], |given| given.keyframes());
        let rests = track.rests(keyframes.iter().map(|keyframe| &keyframe.gripper_pose));
        let mut captions = Captions::new(title);
        let skill = |keyframe: &Keyframe| {
            let name = keyframe.narration.as_deref();
            name.map_or_else(|| format!("on {}", keyframe.reference), str::to_owned)
        };
        // A skill that is done twice in a row has a frame of its own each time.
        let is_one = |a: &Keyframe, b: &Keyframe| a.narration == b.narration && a.reference_pose == b.reference_pose;
        let mut from = 0;
        for group in keyframes.chunk_by(is_one) {
            for (index, keyframe) in group.iter().enumerate() {
                // Where nobody knows when it is come to, nothing is said.
                let Some(step) = first_step(&rests, from + index) else { continue };
                let detail = format!("keyframe {}/{}", index + 1, group.len());
                captions.add(step, Caption { what: skill(keyframe), detail, reached: None });
            }
            from += group.len();
        }
        let is_done = shown.demonstration.as_ref().is_none_or(|given| given.carried_to_end());
        captions.end(track.len(), if is_done { end(is_goal) } else { handed_over() });
        Self { moments: rests, start, track, captions, again }
    }

    /// A program that says nothing of what it does, and whether the goal holds at its end.
    pub fn silent((start, track): (Episode, Track), title: &str, is_goal: bool, again: Again<'a>) -> Self {
        let mut captions = Captions::new(title);
        captions.end(track.len(), end(is_goal));
        Self { moments: track.steps(), start, track, captions, again }
    }

    /// A rollout of a task model, as its recorder saw it.
    pub fn rolled_out(start: Episode, recorder: RolloutRecorder<'_>, rollout: &Rollout, again: Again<'a>) -> Self {
        let RolloutRecorder { track, mut captions, mut moments, model, .. } = recorder;
        let at = rollout.interrupted.map(|node| format!(" at {}", model.name(Place::Node(node))));
        let what = match &rollout.ended {
            Ended::End => "end".to_owned(),
            other => format!("stopped: {other}{}", at.unwrap_or_default()),
        };
        let chosen = rollout.choices.last().filter(|_| matches!(rollout.ended, Ended::End | Ended::NoConfidentChild));
        let choice = chosen.map_or(String::new(), |choice| match choice.child {
            Place::Node(_) => format!("  {} {}", model.name(choice.child), probability(choice)),
            Place::Start | Place::End => format!("  {}", probability(choice)),
        });
        let detail = format!("{}{choice}", reached(rollout.success));
        captions.end(track.len(), Caption { what, detail, reached: Some(rollout.success) });
        moments.push(track.len());
        moments.dedup();
        Self { start, track, captions, moments, again }
    }

    /// How long it takes, simulated seconds.
    pub fn seconds(&self) -> f64 {
        self.track.duration() as f64 * situ_sim::DT
    }

    /// Does it once more.
    ///
    /// # Errors
    /// Those of the first time.
    pub fn again(&self, observer: &mut dyn FnMut(&World)) -> Result<(), BenchError> {
        (self.again)(observer)
    }
}

/// The first step on the way to the keyframe of this index, where the one before it was come to.
fn first_step(rests: &[usize], index: usize) -> Option<usize> {
    match index.checked_sub(1) {
        None => Some(0),
        Some(before) => rests.get(before).map(|rest| rest + 1),
    }
}

fn probability(choice: &Choice) -> String {
    format!("p {:.2}", choice.probability)
}

/// Sees a rollout for the first time.
pub struct RolloutRecorder<'m> {
    model: &'m NamedModel,
    track: Track,
    captions: Captions,
    moments: Vec<usize>,
    choice: Option<Choice>,
}

impl<'m> RolloutRecorder<'m> {
    /// A recorder of a rollout of this model that begins here.
    pub fn new(model: &'m NamedModel, start: &Episode, title: &str) -> Self {
        let (track, captions) = (Track::new(start), Captions::new(title));
        Self { model, track, captions, moments: Vec::new(), choice: None }
    }
}

impl Observer for RolloutRecorder<'_> {
    fn chose(&mut self, choice: &Choice) {
        self.choice = Some(choice.clone());
    }

    fn sets_off(&mut self, reference: &str, index: usize, keyframes: usize) {
        if !self.track.is_empty() {
            self.moments.push(self.track.len());
            self.moments.dedup();
        }
        let chosen = self.choice.as_ref().map(|choice| (self.model.name(choice.child), probability(choice)));
        let (what, probability) = chosen.unwrap_or_else(|| (format!("on {reference}"), String::new()));
        let detail = format!("keyframe {}/{keyframes}  {probability}", index + 1);
        self.captions.add(self.track.len() + 1, Caption { what, detail, reached: None });
    }

    fn step(&mut self, world: &World) {
        self.track.see(world);
    }
}

/// Hands on the steps of a rollout, and nothing else.
pub struct StepsOnly<'a>(pub &'a mut dyn FnMut(&World));

impl Observer for StepsOnly<'_> {
    fn step(&mut self, world: &World) {
        (self.0)(world);
    }
}
