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
//! The keys:
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
//! A key that is not in this list is a mistake, and so is a key that is missing or appears twice. A quaternion whose
//! length is more than 0.001 from 1 is a mistake too; a nearer one is normalised.

use std::fs;
use std::path::{Path, PathBuf};

use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use situ::demonstration::{Demonstration, Gripper, Keyframe, Kind, Pose};
use situ::place::SegmentId;
use situ::segmentation::by_reference_object;
use situ::state::{Feature, Schema, State};
use situ::trail::{PastStep, StepEnd};
use situ_tasks::name::shown;

use crate::demonstration_content::{FileContent, FileGripper, FileKeyframe, FilePose, FileStep};
use crate::error::BenchError;
use crate::json_lines::line_of;
use crate::stop::StopPoint;
use crate::tally::count;

pub use crate::demonstration_content::Instance;

/// How far the length of a quaternion may be from 1. A few printed decimals lose so much.
const QUATERNION_TOLERANCE: f64 = 1e-3;
/// The greatest number of metres, seconds and newtons that is taken for one. Far beyond it a square is infinite.
const FARTHEST: f64 = 1e6;
/// The most scales of its feature that a number of a state may be.
const MOST_SCALES: f64 = 1e9;
/// The most features of a schema. The work of a fit grows with them.
const MOST_FEATURES: usize = 10_000;
/// The scales that a feature may have.
const SCALES: std::ops::RangeInclusive<f64> = 1e-9..=1e9;

/// The most letters of a name.
const LONGEST_NAME: usize = 200;

/// A length this near to 1 differs by rounding alone. The quaternion then stays as it was written.
const QUATERNION_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Where the robot had stopped before a demonstration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Before {
    /// The primitive that ran last to its end; `None` for START.
    pub after: Option<Instance>,
    /// The primitive that was under way when it failed or was stopped, if one was.
    pub interrupted: Option<Instance>,
    /// What it had chosen, in order; empty where nobody wrote it down.
    pub trail: Vec<BeforeStep>,
}

/// A choice on the trail that led to a demonstration.
#[derive(Clone, Debug, PartialEq)]
pub struct BeforeStep {
    /// The world in which it was made.
    pub state: State,
    /// The primitive.
    pub primitive: Instance,
    /// How it ended.
    pub end: StepEnd,
}

/// A demonstration read from a file, checked by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct DemonstrationFile {
    /// The demonstration.
    pub demonstration: Demonstration,
    /// The features of its states.
    pub schema: Schema,
    /// Where the robot had stopped before it.
    pub before: Before,
    path: PathBuf,
    text: String,
}

/// A mistake: its key, what is wrong, and what was expected.
pub(crate) type Mistake = (String, String);

fn mistake(key: impl Into<String>, problem: impl Into<String>) -> Mistake {
    (key.into(), problem.into())
}

/// A pose whose quaternion has the length 1.
pub(crate) fn pose(pose: &FilePose, key: &str) -> Result<Pose, Mistake> {
    let [w, x, y, z] = pose.quaternion;
    let quaternion = Quaternion::new(w, x, y, z);
    let length = libm::sqrt(quaternion.coords.dot(&quaternion.coords));
    if (length - 1.0).abs() > QUATERNION_TOLERANCE {
        let problem = format!("a quaternion of length {length}, expected length 1 (order w, x, y, z)");
        return Err(mistake(format!("{key}.quaternion"), problem));
    }
    let is_unit = (length - 1.0).abs() <= QUATERNION_ROUNDING;
    let rotation = UnitQuaternion::new_unchecked(if is_unit { quaternion } else { quaternion / length });
    if let Some(axis) = pose.position.iter().position(|value| value.abs() > FARTHEST) {
        let problem = format!("{:e} metres, expected at most {FARTHEST} either way", pose.position[axis]);
        return Err(mistake(format!("{key}.position[{axis}]"), problem));
    }
    let [x, y, z] = pose.position;
    Ok(Pose::from_parts(Translation3::new(x, y, z), rotation))
}

fn state(values: &[f64], schema: &Schema, key: String) -> Result<State, Mistake> {
    if values.len() != schema.len() {
        let problem = format!("{} numbers, expected {} (one a feature of the schema)", values.len(), schema.len());
        return Err(mistake(key, problem));
    }
    let scales = schema.features().iter().map(|feature| feature.scale);
    if let Some(index) = values.iter().zip(scales).position(|(value, scale)| (value / scale).abs() > MOST_SCALES) {
        let problem = format!("{:e}, expected at most {MOST_SCALES} times the feature's scale", values[index]);
        return Err(mistake(format!("{key}[{index}]"), problem));
    }
    Ok(State::new(values))
}

fn schema(features: &[Feature]) -> Result<Schema, Mistake> {
    if features.len() > MOST_FEATURES {
        return Err(mistake("schema", format!("{} features, expected at most {MOST_FEATURES}", features.len())));
    }
    for (index, feature) in features.iter().enumerate() {
        if !SCALES.contains(&feature.scale) {
            let problem = format!("{}, expected a scale of {} to {}", feature.scale, SCALES.start(), SCALES.end());
            return Err(mistake(format!("schema[{index}].scale"), problem));
        }
        if let Some(first) = features[..index].iter().position(|other| other.name == feature.name) {
            let problem = format!("`{}` is the name of schema[{first}] as well, expected another", feature.name);
            return Err(mistake(format!("schema[{index}].name"), problem));
        }
    }
    Schema::new(features.to_vec()).map_err(|error| mistake("schema", error.to_string()))
}

/// Refuses a command that no gripper has, and a rest that has no end.
pub(crate) fn check_gripper(gripper: Gripper, hold: f64) -> Result<(), Mistake> {
    let (is_fine, rule) = match gripper {
        Gripper::Opening(share) => ((0.0..=1.0).contains(&share), "an opening from 0 (closed) to 1 (open)"),
        Gripper::Open(metres) => ((0.0..=FARTHEST).contains(&metres), "a width of 0 to 1000000 metres"),
        Gripper::Close(newtons) => ((0.0..=FARTHEST).contains(&newtons), "a force of 0 to 1000000 newtons"),
    };
    if !is_fine {
        return Err(mistake("gripper", format!("{}, expected {rule}", gripper.value())));
    }
    if !(0.0..=FARTHEST).contains(&hold) {
        return Err(mistake("hold", format!("{hold}, expected 0 to {FARTHEST} seconds")));
    }
    Ok(())
}

fn keyframe(keyframe: &FileKeyframe, schema: &Schema, key: &str) -> Result<Keyframe, Mistake> {
    check_gripper(keyframe.gripper.0, keyframe.hold)
        .map_err(|(own, problem)| mistake(format!("{key}.{own}"), problem))?;
    word(&keyframe.reference, format!("{key}.reference"), "that of an object")?;
    if let Some(narration) = &keyframe.narration {
        word(narration, format!("{key}.narration"), "that of a skill")?;
    }
    Ok(Keyframe {
        reference: keyframe.reference.as_str().into(),
        reference_pose: pose(&keyframe.reference_pose, &format!("{key}.reference_pose"))?,
        gripper_pose: pose(&keyframe.gripper_pose, &format!("{key}.gripper_pose"))?,
        gripper: keyframe.gripper.0,
        hold: keyframe.hold,
        state: state(&keyframe.state, schema, format!("{key}.state"))?,
        announced: keyframe.announced,
        narration: keyframe.narration.as_deref().map(Into::into),
    })
}

/// Refuses a text that is no name: pictures and reports of the model show it on a line of its own.
fn word(text: &str, key: String, expected: &str) -> Result<(), Mistake> {
    if text.is_empty() {
        return Err(mistake(key, format!("an empty name, expected {expected}")));
    }
    if text.chars().any(char::is_control) || text.chars().count() > LONGEST_NAME {
        let problem = format!("`{text}`: expected a name of at most {LONGEST_NAME} letters and no control character");
        return Err(mistake(key, problem));
    }
    Ok(())
}

fn checked(file: FileContent) -> Result<(Demonstration, Schema, Before), Mistake> {
    word(&file.name, "name".to_owned(), "one that no other demonstration has")?;
    for (index, feature) in file.schema.iter().enumerate() {
        word(&feature.name, format!("schema[{index}].name"), "that of a feature")?;
    }
    if file.keyframes.is_empty() {
        return Err(mistake("keyframes", "an empty demonstration, expected at least one keyframe"));
    }
    let schema = schema(&file.schema)?.with_half_turn(file.half_turn);
    let step = |(index, step): (usize, FileStep)| {
        let state = state(&step.state, &schema, format!("trail[{index}].state"))?;
        Ok(BeforeStep { state, primitive: step.primitive, end: step.end })
    };
    let trail = file.trail.into_iter().enumerate().map(step).collect::<Result<_, Mistake>>()?;
    let before = Before { after: file.after, interrupted: file.interrupted, trail };
    if file.kind == Kind::Original
        && let Some((key, _)) = before.named().first()
    {
        return Err(mistake(key, "an original demonstration begins at START, expected null, or no such key"));
    }
    let keyframes = (file.keyframes.iter().enumerate())
        .map(|(index, each)| keyframe(each, &schema, &format!("keyframes[{index}]")))
        .collect::<Result<Vec<_>, _>>()?;
    let final_state = state(&file.final_state, &schema, "final_state".to_owned())?;
    let demonstration = Demonstration::new(file.name, file.kind, &schema, keyframes, final_state, file.carried_to_end)
        .map_err(|error| mistake(".", error.to_string()))?;
    Ok((demonstration, schema, before))
}

impl Before {
    /// A stop in the words of a file; `shown` are the names of the earlier demonstrations in order.
    pub fn of(stop: &StopPoint, shown: &[&str]) -> Self {
        let instance = |SegmentId { demonstration, index }| Instance {
            demonstration: shown[demonstration as usize].to_owned(),
            segment: index,
        };
        let step =
            |step: &PastStep| BeforeStep { state: step.state.clone(), primitive: instance(step.of), end: step.end };
        Self {
            after: stop.last.map(instance),
            interrupted: stop.interrupted.map(instance),
            trail: stop.trail.iter().map(step).collect(),
        }
    }

    /// The primitives that it names, each with its key.
    fn named(&self) -> Vec<(String, &Instance)> {
        let after = self.after.iter().map(|instance| ("after".to_owned(), instance));
        let interrupted = self.interrupted.iter().map(|instance| ("interrupted".to_owned(), instance));
        let trail = self.trail.iter().enumerate();
        let trail = trail.map(|(index, step)| (format!("trail[{index}].primitive"), &step.primitive));
        after.chain(interrupted).chain(trail).collect()
    }
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
            Ok((demonstration, schema, before)) => {
                Ok(Self { demonstration, schema, before, path: path.to_owned(), text })
            }
            Err((key, problem)) => Err(refuse(path, &text, &key, problem)),
        }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The error of a mistake at `key`, such as `after.segment`.
    pub fn refuse(&self, key: &str, problem: impl Into<String>) -> BenchError {
        refuse(&self.path, &self.text, key, problem)
    }

    /// The segment that `instance`, the value of `key`, names among the demonstrations of the `former` files.
    fn segment(&self, key: &str, instance: &Instance, former: &[Self]) -> Result<SegmentId, BenchError> {
        let Instance { demonstration, segment } = instance;
        let Some(number) = former.iter().position(|other| **other.demonstration.name() == **demonstration) else {
            let known: Vec<String> = former.iter().map(|other| format!("`{}`", other.demonstration.name())).collect();
            let known = known.join(", ");
            let problem = format!("no demonstration `{demonstration}` before this one, expected one of {known}");
            return Err(self.refuse(&format!("{key}.demonstration"), problem));
        };
        let segments = by_reference_object(&former[number].demonstration).len();
        if *segment as usize >= segments {
            let problem =
                format!("{segment}, expected 0 to {} (`{demonstration}` has {segments} segments)", segments - 1);
            return Err(self.refuse(&format!("{key}.segment"), problem));
        }
        Ok(SegmentId { demonstration: count(number), index: *segment })
    }
}

fn refuse(path: &Path, text: &str, key: &str, problem: impl Into<String>) -> BenchError {
    mistaken(path, line_of(text, key), key, &problem.into())
}

/// The error of a mistake. Both texts may repeat what the file says.
fn mistaken(path: &Path, line: usize, key: &str, problem: &str) -> BenchError {
    BenchError::Demonstration { path: path.to_owned(), line, key: shown(key), problem: shown(problem) }
}

/// Checks files that are learned together, in the order in which they are learned: they have one schema, no name twice,
/// and each primitive before a demonstration is a segment of an earlier demonstration. Returns where the robot had
/// stopped before each.
///
/// # Errors
/// [`BenchError::Demonstration`].
pub fn check_together(files: &[DemonstrationFile]) -> Result<Vec<StopPoint>, BenchError> {
    let mut stops = Vec::with_capacity(files.len());
    for (index, file) in files.iter().enumerate() {
        let former = &files[..index];
        let name = file.demonstration.name();
        if let Some(other) = former.iter().find(|other| other.demonstration.name() == name) {
            let problem = format!("`{name}` is the name in {} as well, expected another", other.path.display());
            return Err(file.refuse("name", problem));
        }
        if let Some(first) = former.first()
            && first.schema != file.schema
        {
            let (here, there) = (file.schema.features(), first.schema.features());
            let differs = here.iter().zip(there).position(|(here, there)| here != there);
            let other = if here.len() == there.len() { "half_turn" } else { "schema" };
            let key = differs.map_or(other.to_owned(), |feature| format!("schema[{feature}]"));
            let problem = format!("expected the schema of {}: all files of one call share it", first.path.display());
            return Err(file.refuse(&key, problem));
        }
        let mut named = file.before.named().into_iter().map(|(key, instance)| file.segment(&key, instance, former));
        let mut next = |is_there: bool| is_there.then(|| named.next()).flatten().transpose();
        let (last, interrupted) = (next(file.before.after.is_some())?, next(file.before.interrupted.is_some())?);
        let steps = file.before.trail.iter().zip(named);
        let trail = steps.map(|(step, of)| Ok(PastStep { state: step.state.clone(), of: of?, end: step.end }));
        let trail = trail.collect::<Result<_, BenchError>>()?;
        stops.push(StopPoint { last, interrupted, trail });
    }
    Ok(stops)
}

/// The text of a demonstration file.
pub fn render(demonstration: &Demonstration, schema: &Schema, before: &Before) -> String {
    serde_json::to_string_pretty(&content(demonstration, schema, before)).expect("finite numbers and string keys")
        + "\n"
}

/// The keys of a demonstration file that say what was shown: all but those of its schema and of what ran before.
pub(crate) fn shown_keys(demonstration: &Demonstration, schema: &Schema) -> serde_json::Value {
    let content = content(demonstration, schema, &Before::default());
    let mut value = serde_json::to_value(content).expect("finite numbers and string keys");
    if let Some(keys) = value.as_object_mut() {
        ["schema", "half_turn", "after"].into_iter().for_each(|key| drop(keys.remove(key)));
    }
    value
}

fn content(demonstration: &Demonstration, schema: &Schema, before: &Before) -> FileContent {
    let pose = |pose: &Pose| FilePose {
        position: pose.translation.vector.into(),
        quaternion: [pose.rotation.w, pose.rotation.i, pose.rotation.j, pose.rotation.k],
    };
    let keyframe = |keyframe: &Keyframe| FileKeyframe {
        reference: keyframe.reference.to_string(),
        reference_pose: pose(&keyframe.reference_pose),
        gripper_pose: pose(&keyframe.gripper_pose),
        gripper: FileGripper(keyframe.gripper),
        hold: keyframe.hold,
        state: keyframe.state.values().to_vec(),
        announced: keyframe.announced,
        narration: keyframe.narration.as_deref().map(str::to_owned),
    };
    let step = |step: &BeforeStep| FileStep {
        state: step.state.values().to_vec(),
        primitive: step.primitive.clone(),
        end: step.end,
    };
    FileContent {
        name: demonstration.name().to_string(),
        kind: demonstration.kind(),
        schema: schema.features().to_vec(),
        half_turn: schema.half_turn(),
        after: before.after.clone(),
        interrupted: before.interrupted.clone(),
        trail: before.trail.iter().map(step).collect(),
        carried_to_end: demonstration.carried_to_end(),
        keyframes: demonstration.keyframes().iter().map(keyframe).collect(),
        final_state: demonstration.final_state().values().to_vec(),
    }
}
