//! Demonstration files, for people with a robot of their own.
//!
//! A demonstration is one JSON file. Poses are in the world frame: positions in metres, quaternions as `[w, x, y, z]`.
//! A state is the world as the robot perceives it: one number for each feature of the schema, in any unit.
//!
//! ```json
//! {
//!   "name": "tea-1",
//!   "kind": "original",
//!   "schema": [{"name": "cup_x", "scale": 0.2}, {"name": "cup_fill", "scale": 0.3}],
//!   "after": null,
//!   "carried_to_end": true,
//!   "keyframes": [
//!     {
//!       "reference": "cup",
//!       "reference_pose": {"position": [0.5, 0.1, 0.0], "quaternion": [1.0, 0.0, 0.0, 0.0]},
//!       "gripper_pose": {"position": [0.5, 0.1, 0.2], "quaternion": [0.0, 1.0, 0.0, 0.0]},
//!       "gripper": {"open": 0.08},
//!       "hold": 0.5,
//!       "state": [0.5, 0.0]
//!     }
//!   ],
//!   "final_state": [0.5, 1.0]
//! }
//! ```
//!
//! The keys of version 1, which a file is of where it says no `version`:
//!
//! - `name`: a name that no other file of the call has.
//! - `kind`: `"original"`, the task from its start; or `"corrective"`, a part of the task, given at a failure.
//! - `schema`: the features of a state in order. `scale` is the typical size of a difference that matters, above 0. All
//!   files of one call have the same schema.
//! - `half_turn`: `"x"`, `"y"` or `"z"` where half a turn of the hand about this axis of its own frame is the same
//!   grasp, as for a parallel gripper about its approach. It may be left out; all files of one call agree.
//! - `after`: what ran last before the demonstration. `null` is START, and always so for an original. Otherwise
//!   `{"demonstration": name, "segment": index}` is the node that holds that segment of an earlier demonstration;
//!   indices count from 0.
//! - `interrupted`: the primitive that was under way when the robot failed or was stopped, named as in `after`. `null`,
//!   or left out, where none was.
//! - `trail`: what the robot had chosen in the rollout that failed, in order: `state`, the world in which it chose;
//!   `primitive`, named as in `after`; and `end`: `"finished"`, `"interrupted"`, or `"prevented"` where it was stopped
//!   before it began. It may be left out; a method that heeds it then takes the state in which the demonstration
//!   begins.
//! - `carried_to_end`: whether the teacher went on to the end of the task. Only then is `final_state` an example of
//!   END.
//! - `keyframes`: at least one, in order. Each has these keys:
//!   - `reference`: the object that the keyframe is about. Consecutive keyframes about one object are a segment.
//!   - `announced`: true where the teacher names the object anew, so that a segment begins although the keyframe before
//!     is about the same object: a second try, say. False where it is left out.
//!   - `reference_pose`: the object's pose. Of the poses of one segment the first counts, because the object may move
//!     with the
//!     hand.
//!   - `gripper_pose`: the gripper's pose.
//!   - `gripper`: the command to the gripper from this keyframe on: its opening from 0 (closed) to 1 (open), or
//!     `{"open": metres}`, or `{"close": newtons}`.
//!   - `hold`: seconds of rest at the keyframe; 0 where it is left out.
//!   - `state`: the world *before* the motion to this keyframe, one number for each feature.
//!   - `narration`: the teacher's name for the skill. It may be left out; few methods use it.
//! - `final_state`: the world after the last keyframe.
//!
//! Version 2 of the format spares people the states. With `"version": 2` at the top a file may leave `schema` out. It
//! then gives the poses of all objects instead, and the states follow from them, scaled as those of the tasks here
//! ([`PoseSchema`]). [`learn`](crate::cmd::learn) says which version it has read. Its keys in the place of
//! `reference_pose`, `state`, `final_state` and `schema`:
//!
//! - `world`, of a keyframe and of a step of the `trail`: what there is, and where, *before* the motion to this
//!   keyframe.
//!   - `objects`: the pose of each object, by its name. The reference object is one of them.
//!   - `hand`: the pose of the hand.
//!   - `opening`: metres between its fingers. All worlds give it, or none.
//! - `final_world`: the same after the last keyframe.
//! - `objects`: the names of all objects of the task. It is needed where one of them may be absent, as a lid that only
//!   a correction has met: whether an object is seen is then a feature too. Where it is left out, every world has the
//!   objects of the first.
//! - `observe`: what the state is made of, in order, where it is not the usual ([`PoseSchema::usual`]): a list of
//!   `"opening()"`, `"offset(a, b)"` (the origin of a in the frame of b: three numbers, metres), `"distance(a, b)"`
//!   (metres), `"tilt(a)"` (radians) and `"seen(a)"` (0 or 1), where `gripper` is the hand.
//!
//! ```json
//! {
//!   "version": 2,
//!   "name": "tea-1",
//!   "kind": "original",
//!   "after": null,
//!   "carried_to_end": true,
//!   "keyframes": [
//!     {
//!       "reference": "cup",
//!       "world": {
//!         "objects": {"cup": {"position": [0.5, 0.1, 0.0], "quaternion": [1.0, 0.0, 0.0, 0.0]}},
//!         "hand": {"position": [0.3, 0.0, 0.4], "quaternion": [0.0, 1.0, 0.0, 0.0]},
//!         "opening": 0.08
//!       },
//!       "gripper_pose": {"position": [0.5, 0.1, 0.2], "quaternion": [0.0, 1.0, 0.0, 0.0]},
//!       "gripper": {"open": 0.08}
//!     }
//!   ],
//!   "final_world": {
//!     "objects": {"cup": {"position": [0.5, 0.1, 0.0], "quaternion": [1.0, 0.0, 0.0, 0.0]}},
//!     "hand": {"position": [0.5, 0.1, 0.2], "quaternion": [0.0, 1.0, 0.0, 0.0]},
//!     "opening": 0.08
//!   }
//! }
//! ```
//!
//! A key that is not in this list is a mistake, and so is a key that is missing or appears twice. A quaternion whose
//! length is more than 0.001 from 1 is a mistake too; a nearer one is normalised.

mod before;
mod checked;
pub(crate) mod content;
pub(crate) mod perceived;
pub(crate) mod rules;

use std::fs;
use std::path::{Path, PathBuf};

use situ::demonstration::{Demonstration, Keyframe, Kind};
use situ::state::Schema;
use situ_tasks::name::shown;
use situ_tasks::{PoseSchema, Poses};

use crate::digest;
use crate::error::BenchError;
use crate::json_lines::line_of;
use checked::{Checked, checked};
use content::{FileContent, FileGripper, FileKeyframe, FilePose, FileStep};

pub use before::{Before, BeforeStep};
pub use content::Instance;

/// A demonstration read from a file, checked by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct DemonstrationFile {
    /// The demonstration.
    pub demonstration: Demonstration,
    /// The features of its states.
    pub schema: Schema,
    /// Where the robot had stopped before it.
    pub before: Before,
    /// The version of the format, 1 or 2.
    pub version: u32,
    /// How its states follow from the poses in it; `None` where it gives the states.
    pub features: Option<PoseSchema>,
    /// The poses of everything before the motion to each keyframe, and after the last; empty where it gives the states.
    pub worlds: Vec<Poses>,
    path: PathBuf,
    text: String,
}

impl DemonstrationFile {
    /// Reads a demonstration file.
    ///
    /// # Errors
    /// [`BenchError::Read`]; [`BenchError::Demonstration`] for a mistake in the file: with file, line and key.
    pub fn read(path: &Path) -> Result<Self, BenchError> {
        let text = fs::read_to_string(path).map_err(|source| BenchError::Read { path: path.to_owned(), source })?;
        Self::parse(text, path)
    }

    /// The demonstration of a file's text; `path` is for messages.
    ///
    /// # Errors
    /// [`BenchError::Demonstration`].
    pub fn parse(text: String, path: &Path) -> Result<Self, BenchError> {
        let text = text.strip_prefix('\u{feff}').map_or_else(|| text.clone(), str::to_owned);
        let mut deserializer = serde_json::Deserializer::from_str(&text);
        let read = serde_path_to_error::deserialize::<_, FileContent>(&mut deserializer).map_err(|error| {
            let (key, error) = (error.path().to_string(), error.into_inner());
            (key, error)
        });
        let file = read.and_then(|file| match deserializer.end() {
            Ok(()) => Ok(file),
            Err(error) => Err((".".to_owned(), error)),
        });
        let file = file.map_err(|(key, error)| {
            let place = format!(" at line {} column {}", error.line(), error.column());
            let problem = error.to_string().replace(&place, "");
            mistaken(path, error.line().max(1), &key, &problem)
        })?;
        match checked(file) {
            Ok(Checked { demonstration, schema, before, version, features, worlds }) => {
                Ok(Self { demonstration, schema, before, version, features, worlds, path: path.to_owned(), text })
            }
            Err((key, problem)) => Err(refuse(path, &text, &key, problem)),
        }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Refuses a demonstration of another kind.
    ///
    /// # Errors
    /// [`BenchError::Demonstration`].
    pub fn check_kind(&self, kind: Kind) -> Result<(), BenchError> {
        if self.demonstration.kind() == kind {
            return Ok(());
        }
        let word = if kind == Kind::Original { "original" } else { "corrective" };
        let problem = format!("expected \"{word}\" here: corrections follow --correct, originals do not");
        Err(self.refuse("kind", problem))
    }

    /// A hash of its text.
    pub fn hash(&self) -> String {
        digest::hash(&self.text)
    }

    /// The error of a mistake at `key`, such as `after.segment`.
    pub fn refuse(&self, key: &str, problem: impl Into<String>) -> BenchError {
        refuse(&self.path, &self.text, key, problem)
    }
}

fn refuse(path: &Path, text: &str, key: &str, problem: impl Into<String>) -> BenchError {
    mistaken(path, line_of(text, key), key, &problem.into())
}

/// The error of a mistake. Both texts may repeat what the file says.
fn mistaken(path: &Path, line: usize, key: &str, problem: &str) -> BenchError {
    BenchError::Demonstration { path: path.to_owned(), line, key: shown(key), problem: shown(problem) }
}

/// The text of a demonstration file.
pub fn render(demonstration: &Demonstration, schema: &Schema, before: &Before) -> String {
    serde_json::to_string_pretty(&written(demonstration, schema, before)).expect("finite numbers and string keys")
        + "\n"
}

/// The keys of a demonstration file that say what was shown: all but those of its schema and of what ran before.
pub(crate) fn shown_keys(demonstration: &Demonstration, schema: &Schema) -> serde_json::Value {
    let all = written(demonstration, schema, &Before::default());
    let mut value = serde_json::to_value(all).expect("finite numbers and string keys");
    if let Some(keys) = value.as_object_mut() {
        ["schema", "half_turn", "after"].into_iter().for_each(|key| drop(keys.remove(key)));
    }
    value
}

fn written(demonstration: &Demonstration, schema: &Schema, before: &Before) -> FileContent {
    let keyframe = |keyframe: &Keyframe| FileKeyframe {
        reference: keyframe.reference.to_string(),
        reference_pose: Some(FilePose::from(&keyframe.reference_pose)),
        gripper_pose: FilePose::from(&keyframe.gripper_pose),
        gripper: FileGripper(keyframe.gripper),
        hold: keyframe.hold,
        state: Some(keyframe.state.values().to_vec()),
        world: None,
        announced: keyframe.announced,
        narration: keyframe.narration.as_deref().map(str::to_owned),
    };
    let step = |step: &BeforeStep| FileStep {
        state: Some(step.state.values().to_vec()),
        world: None,
        primitive: step.primitive.clone(),
        end: step.end,
    };
    FileContent {
        version: None,
        name: demonstration.name().to_string(),
        kind: demonstration.kind(),
        schema: Some(schema.features().to_vec()),
        objects: None,
        observe: None,
        half_turn: schema.half_turn(),
        after: before.after.clone(),
        interrupted: before.interrupted.clone(),
        trail: before.trail.iter().map(step).collect(),
        carried_to_end: demonstration.carried_to_end(),
        keyframes: demonstration.keyframes().iter().map(keyframe).collect(),
        final_state: Some(demonstration.final_state().values().to_vec()),
        final_world: None,
    }
}
