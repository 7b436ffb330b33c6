//! An episode that is served: where it began, and what was done in it since.

use std::sync::Arc;

use serde_json::{Value, json};
use situ::demonstration::{Demonstration, Kind, Pose};
use situ::random::stream;
use situ::state::Schema;
use situ_sim::Image;
use situ_tasks::{Episode, Setting};
use situ_teachers::{Shown, Teacher, convert};

use super::deed::Deed;
use super::request::{About, Look, Target};
use crate::caption::PixelSize;
use crate::demonstration_file::{Before, render};
use crate::ended::Ended;
use crate::error::BenchError;
use crate::stride::Stride;
use crate::track::Track;
use crate::view::{CameraView, things};

/// The most keyframes of an episode: ten times as many as a rollout may have primitives. A keyframe that is out of
/// reach takes no simulated time, so the task's limit of time alone would have no end.
pub(super) const MOST_KEYFRAMES: usize = 400;

/// An episode that is served. A copy goes on as the original does, bit for bit.
#[derive(Clone)]
pub(super) struct Served {
    pub(super) episode: Episode,
    pub(super) teacher: Teacher,
    pub(super) seed: u64,
    /// What was done since the start, in order.
    pub(super) deeds: Vec<Deed>,
    schema: Arc<Schema>,
    start: Arc<Episode>,
}

/// Which of a teacher's demonstrations.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Occasion {
    /// The whole task, from the start of the episode.
    Whole,
    /// From where the episode stands.
    Here,
}

impl Served {
    /// An episode at its start, which this seed decided.
    ///
    /// # Errors
    /// Where the setting's schema breaks a rule of the learner's.
    pub(super) fn begin(start: Arc<Episode>, teacher: Teacher, seed: u64) -> Result<Self, BenchError> {
        let schema = Arc::new(convert::schema(start.setting())?);
        Ok(Self { episode: (*start).clone(), teacher, seed, deeds: Vec::new(), schema, start })
    }

    pub(super) fn setting(&self) -> &Arc<Setting> {
        self.episode.setting()
    }

    pub(super) fn schema(&self) -> &Schema {
        &self.schema
    }

    /// About how many bytes a copy takes.
    pub(super) fn bytes(&self) -> usize {
        self.episode.bytes()
    }

    /// Whether the task's limit of time has passed, or that of keyframes.
    pub(super) fn is_truncated(&self) -> bool {
        self.episode.finished_out_of_time() || self.deeds.len() >= MOST_KEYFRAMES
    }

    /// The keyframe that is asked for.
    ///
    /// # Errors
    /// What is wrong with it, and what was expected.
    pub(super) fn deed(&self, target: Target) -> Result<Deed, String> {
        if let Some(about) = &target.about {
            self.check_reference(&about.reference)?;
        }
        Deed::of(target, self.episode.world().gripper(), |target| self.about(target))
    }

    /// The gripper's command where the hand is.
    pub(super) fn grip(&self, gripper: situ::demonstration::Gripper, hold: f64) -> Result<Deed, String> {
        let target = self.episode.world().tcp();
        Deed { target, gripper, hold, about: self.about(&target) }.checked()
    }

    /// # Errors
    /// A name that is no object of the setting and no role, with those that are.
    pub(super) fn check_reference(&self, name: &str) -> Result<(), String> {
        let setting = self.setting();
        let objects = setting.objects.iter().map(|placed| placed.body.name.as_str());
        let known: Vec<&str> = objects.chain(setting.roles.iter().map(|role| role.name.as_str())).collect();
        if known.contains(&name) {
            return Ok(());
        }
        Err(BenchError::unknown("object", name, known).to_string())
    }

    /// The primitive that a keyframe is taken to be of where nobody says it: that on the nearest object that a skill of
    /// the task is about. Keyframes in a row that are nearest to one object are taken for one primitive.
    fn about(&self, target: &Pose) -> About {
        let mut best: Option<(&str, [f64; 2])> = None;
        // The last of the things is the hand.
        let objects = things(self.setting()).split_last().map_or(Vec::new(), |(_, objects)| objects.to_vec());
        for name in objects {
            let Some(distances) = self.distances(name, target) else { continue };
            if best.is_none_or(|(_, least)| distances < least) {
                best = Some((name, distances));
            }
        }
        let reference = best.map_or("", |(name, _)| name).to_owned();
        let last = self.deeds.last().map(|deed| &deed.about).filter(|about| about.reference == reference);
        About { keyframe: last.map_or(0, |about| about.keyframe + 1), reference }
    }

    /// The distances of a place from the upright box about an object, or about what fills a role, and from its origin:
    /// metres.
    fn distances(&self, name: &str, target: &Pose) -> Option<[f64; 2]> {
        let (view, place) = (self.episode.view(), target.translation.vector);
        let object = view.object(name)?;
        let [low, high] = self.episode.world().bounds(object)?;
        let beyond = |axis: usize| (low[axis] - place[axis]).max(place[axis] - high[axis]).max(0.0);
        let box_distance = libm::sqrt((0..3).map(|axis| beyond(axis) * beyond(axis)).sum());
        Some([box_distance, (view.pose(object)?.translation.vector - place).norm()])
    }

    /// Goes to a keyframe. Returns the force on the hand where the guard stopped it on the way, or why it is not there.
    ///
    /// # Errors
    /// Where the limit has passed, or the physics is spoilt by it; the episode is as it was.
    pub(super) fn go(&mut self, deed: Deed) -> Result<Result<Option<f64>, Ended>, String> {
        if self.is_truncated() {
            let limit = self.setting().time_limit;
            return Err(format!(
                "the episode is over: its limit of {limit} simulated seconds or {MOST_KEYFRAMES} keyframes has passed; \
                 expected `reset` or `restore`"
            ));
        }
        let end = Self::performed(&mut self.episode, &deed);
        if end == Err(Ended::Spoilt) {
            self.go_back();
            return Err(
                "the physics does not stand this keyframe: the episode is as before, expected another".to_owned()
            );
        }
        self.deeds.push(deed);
        Ok(end)
    }

    fn performed(episode: &mut Episode, deed: &Deed) -> Result<Option<f64>, Ended> {
        let about = (deed.about.reference.as_str(), deed.about.keyframe);
        Stride { target: deed.target, gripper: deed.gripper, hold: deed.hold, about }.go(episode, &mut |_| {})
    }

    /// Does all deeds once more, from the start: the same bits as before the last one.
    fn go_back(&mut self) {
        self.episode = (*self.start).clone();
        for deed in &self.deeds {
            let _ = Self::performed(&mut self.episode, deed);
        }
    }

    /// The name of the setting's moment at which a watching teacher would stop the robot now.
    pub(super) fn stop(&self, look: &Look) -> Option<&str> {
        self.episode.intervention(look.moment(), &look.reference).map(|intervention| intervention.name.as_str())
    }

    /// The teacher's demonstration of the whole task, from the start of the episode: the first try is that of `show`.
    ///
    /// # Errors
    /// Those of the teacher.
    pub(super) fn demonstrate(&self, attempt: u32) -> Result<Value, BenchError> {
        self.shown(Occasion::Whole, attempt)
    }

    /// The teacher's correction from where the episode stands, which stays there.
    ///
    /// # Errors
    /// Those of the teacher.
    pub(super) fn correct(&self, attempt: u32) -> Result<Value, BenchError> {
        self.shown(Occasion::Here, attempt)
    }

    fn shown(&self, occasion: Occasion, attempt: u32) -> Result<Value, BenchError> {
        let (label, teacher) = (self.setting().label(), &self.teacher.profile().name);
        let first = format!("{label}-{}", self.seed);
        let (name, kind, mut episode, seed) = match occasion {
            Occasion::Whole => {
                let other = || stream(self.seed, &format!("{label}/{teacher}/served-whole/{attempt}"));
                let seed = if attempt == 0 { self.seed } else { other() };
                (first, Kind::Original, (*self.start).clone(), seed)
            }
            Occasion::Here => {
                let steps = self.episode.steps();
                let seed = stream(self.seed, &format!("{label}/{teacher}/served-correction/{steps}/{attempt}"));
                (format!("{first}-correction-{steps}"), Kind::Corrective, self.episode.clone(), seed)
            }
        };
        let shown = self.teacher.demonstrate(&name, kind, &self.schema, &mut episode, seed, &mut |_| {})?;
        let Shown { demonstration, effort, clean, skills, .. } = shown;
        Ok(json!({
            "demonstration": demonstration.map(|shown| self.keys(&shown)),
            "clean": clean,
            "solved": episode.succeeded(),
            "skills": skills,
            "seconds": effort.seconds,
        }))
    }

    /// The object of a demonstration file. What ran before it is for whoever holds the model to say.
    fn keys(&self, demonstration: &Demonstration) -> Value {
        let text = render(demonstration, &self.schema, &Before::default());
        serde_json::from_str(&text).expect("what is written is JSON")
    }

    /// A picture from the front, with the start of the episode in view.
    pub(super) fn picture(&self, [width, height]: PixelSize) -> Image {
        let view = CameraView::front(&[&Track::new(&self.start)], f64::from(width) / f64::from(height));
        view.camera.render(self.episode.world(), width, height)
    }
}
