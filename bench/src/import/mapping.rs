//! The mapping of a recording: a small TOML file that says where in the recording things are, and in what units.

use std::fs;
use std::path::{Path, PathBuf};

use situ_tasks::key::{Document, KeyPath};

use super::mapping_keys::{
    ColumnKeys, EpisodeKeys, FixedKeys, KeyframeKeys, MappingFile, OpeningKeys, PoseKeys, QuaternionOrder,
};
use crate::error::BenchError;

/// What must be said wherever a quaternion is read.
const ORDER: &str = "expected \"wxyz\" (the real part first, as in MuJoCo, Drake and our own files) or \"xyzw\" (the \
                     real part last, as in ROS, PyBullet and SciPy): a quaternion is read here, and its order is \
                     never guessed";

/// A mapping that was read and checked by itself.
#[derive(Debug)]
pub struct Mapping {
    pub(super) keys: MappingFile,
    path: PathBuf,
    text: String,
}

/// The path of keys `words`, from the root of the file.
pub(super) fn key(words: &[&str]) -> KeyPath {
    words.iter().fold(KeyPath::default(), |path, word| path.field(word))
}

impl Mapping {
    /// Reads a mapping.
    ///
    /// # Errors
    /// [`BenchError::Read`]; [`BenchError::Task`] for a mistake in the file: with file, line and key.
    pub fn read(path: &Path) -> Result<Self, BenchError> {
        let text = fs::read_to_string(path).map_err(|source| BenchError::Read { path: path.to_owned(), source })?;
        Self::parse(&text, path)
    }

    /// The mapping of a file's text; `path` is for messages.
    ///
    /// # Errors
    /// [`BenchError::Task`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, BenchError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let document = Document::parse(text, path)?;
        document.check_finite()?;
        let keys: MappingFile = toml::from_str(text).map_err(|error| document.serde_error(&error))?;
        let mapping = Self { keys, path: path.to_owned(), text: text.to_owned() };
        mapping.check()?;
        Ok(mapping)
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The names of the objects, in order.
    pub fn objects(&self) -> impl Iterator<Item = &str> {
        self.keys.objects.keys().map(String::as_str)
    }

    /// The error of a mistake at `key`.
    pub(super) fn refuse(&self, key: &KeyPath, expected: impl Into<String>) -> BenchError {
        match Document::parse(&self.text, &self.path) {
            Ok(document) => document.error(key, expected).into(),
            Err(error) => error.into(),
        }
    }

    fn check(&self) -> Result<(), BenchError> {
        self.check_pose(&self.keys.gripper, &key(&["gripper"]))?;
        if self.keys.gripper.fixed.is_some() {
            return Err(self.refuse(&key(&["gripper", "fixed"]), "a gripper moves: expected columns or a topic"));
        }
        if self.keys.objects.is_empty() {
            let problem = "expected at least one object: where none was recorded, a fixed one (`fixed`)";
            return Err(self.refuse(&key(&["objects"]), problem));
        }
        for (name, pose) in &self.keys.objects {
            let at = key(&["objects", name]);
            if name.is_empty() || name.chars().any(char::is_control) || name.chars().count() > LONGEST_NAME {
                let problem = format!("expected a name of 1 to {LONGEST_NAME} letters and no control character");
                return Err(self.refuse(&at, problem));
            }
            self.check_pose(pose, &at)?;
        }
        if let Some(all) = &self.keys.task_objects
            && let Some(missing) = self.objects().find(|name| !all.iter().any(|other| other == name))
        {
            let problem = format!("`{missing}` has a pose below: expected the names of all objects of the task");
            return Err(self.refuse(&key(&["task_objects"]), problem));
        }
        self.check_numbers()?;
        self.check_references()
    }

    fn check_pose(&self, pose: &PoseKeys, at: &KeyPath) -> Result<(), BenchError> {
        let places = [pose.position.is_some(), pose.topic.is_some(), pose.fixed.is_some()];
        if places.iter().filter(|is_there| **is_there).count() != 1 {
            let problem = "expected one of `position` (three columns), `topic` (MCAP) and `fixed` (a pose that stays)";
            return Err(self.refuse(at, problem));
        }
        let turned = [
            ("quaternion", pose.quaternion.is_some()),
            ("rotation_vector", pose.rotation_vector.is_some()),
            ("roll_pitch_yaw", pose.roll_pitch_yaw.is_some()),
            ("matrix", pose.matrix.is_some()),
            ("orientation", pose.orientation.is_some()),
        ];
        let said: Vec<&str> = turned.iter().filter(|(_, is_there)| *is_there).map(|(name, _)| *name).collect();
        if pose.position.is_some() && said.len() != 1 {
            let problem = "expected one of `quaternion`, `rotation_vector`, `roll_pitch_yaw`, `matrix` and \
                           `orientation = \"none\"` beside `position`";
            return Err(self.refuse(&said.last().map_or(at.clone(), |name| at.field(name)), problem));
        }
        if let (None, Some(name)) = (&pose.position, said.first()) {
            return Err(self.refuse(&at.field(name), "columns of an orientation go with those of a `position`"));
        }
        for (name, is_there) in [("frame", pose.frame.is_some()), ("index", pose.index.is_some())] {
            if is_there && pose.topic.is_none() {
                return Err(self.refuse(&at.field(name), "goes with a `topic`"));
            }
        }
        let fixed = pose.fixed.as_ref().is_some_and(|fixed| fixed.quaternion.is_some());
        if (pose.quaternion.is_some() || fixed) && self.order(pose).is_none() {
            let quaternion = if fixed { at.field("fixed").field("quaternion") } else { at.field("quaternion") };
            return Err(self.refuse(&quaternion, format!("key `quaternion_order` is not said: {ORDER}")));
        }
        if let Some(fixed) = &pose.fixed {
            self.check_fixed(fixed, &at.field("fixed"))?;
        }
        self.check_number(&at.field("near"), pose.near, 0.0..=FARTHEST, "metres of 0 or more")
    }

    fn check_fixed(&self, fixed: &FixedKeys, at: &KeyPath) -> Result<(), BenchError> {
        let scale = self.keys.units.length.per_metre();
        if fixed.position.iter().any(|value| (value / scale).abs() > FARTHEST) {
            return Err(self.refuse(&at.field("position"), format!("expected at most {FARTHEST} metres either way")));
        }
        let length = fixed.quaternion.map_or(1.0, |parts| parts.iter().map(|part| part * part).sum::<f64>());
        if (length - 1.0).abs() > QUATERNION_TOLERANCE {
            return Err(self.refuse(&at.field("quaternion"), "expected a quaternion of length 1"));
        }
        Ok(())
    }

    fn check_number(
        &self,
        at: &KeyPath,
        value: Option<f64>,
        range: std::ops::RangeInclusive<f64>,
        rule: &str,
    ) -> Result<(), BenchError> {
        match value {
            Some(value) if !range.contains(&value) => Err(self.refuse(at, format!("{value}: expected {rule}"))),
            _ => Ok(()),
        }
    }

    fn check_numbers(&self) -> Result<(), BenchError> {
        let KeyframeKeys { metres, radians, rest_metres, rest_radians, rest_seconds, near } = self.keys.keyframes;
        let numbers = [
            ("metres", metres, SMALLEST, "a tolerance above 0"),
            ("radians", radians, SMALLEST, "a tolerance above 0"),
            ("rest_metres", rest_metres, 0.0, "a tolerance of 0 or more"),
            ("rest_radians", rest_radians, 0.0, "a tolerance of 0 or more"),
            ("rest_seconds", rest_seconds, 0.0, "seconds of 0 or more"),
            ("near", near, 0.0, "metres of 0 or more"),
        ];
        for (name, value, least, rule) in numbers {
            self.check_number(&key(&["keyframes", name]), Some(value), least..=FARTHEST, rule)?;
        }
        let rate = self.keys.columns.rate;
        self.check_number(&key(&["columns", "rate"]), rate, 1e-3..=1e6, "frames a second, 0.001 to 1000000")?;
        if rate.is_some() && self.keys.columns.time.is_some() {
            return Err(self.refuse(&key(&["columns", "rate"]), "expected `time` or `rate`, not both"));
        }
        let OpeningKeys { column, unit, closed, open, command, command_kind, force, close_below, open_above } =
            &self.keys.opening;
        let at = |name| key(&["opening", name]);
        self.check_number(&at("force"), *force, 0.0..=FARTHEST, "newtons of 0 or more")?;
        let (closed, open) = (closed.unwrap_or(0.0), open.unwrap_or(1.0));
        let span = (open - closed).abs();
        if !(SMALLEST..=FARTHEST).contains(&span) {
            return Err(self.refuse(&at("open"), "expected another number than `closed`, and not too far from it"));
        }
        if unit.length().is_some() && (self.keys.opening.closed.is_some() || self.keys.opening.open.is_some()) {
            return Err(self.refuse(&at("unit"), "`closed` and `open` go with the unit \"share\""));
        }
        let has_thresholds = close_below.is_some() && open_above.is_some();
        if unit.length().is_some() && (column.is_some() || command.is_some()) && !has_thresholds {
            let problem = "a width: expected `close_below` and `open_above`, in this unit, beside it";
            return Err(self.refuse(&at("unit"), problem));
        }
        if close_below.unwrap_or(CLOSE_BELOW) > open_above.unwrap_or(OPEN_ABOVE) {
            let name = if close_below.is_some() { "close_below" } else { "open_above" };
            return Err(self.refuse(&at(name), "expected `close_below` to be no more than `open_above`"));
        }
        if command_kind.is_some() && command.is_none() {
            return Err(self.refuse(&at("command_kind"), "goes with `command`"));
        }
        Ok(())
    }

    /// Every object that is named is one of the objects.
    fn check_references(&self) -> Result<(), BenchError> {
        let narrations = self.keys.narrations.iter().map(|(words, object)| (key(&["narrations", words]), object));
        let overrides = self.keys.overrides.iter().enumerate().filter_map(|(index, each)| {
            Some((key(&["override"]).index(index).field("reference"), each.reference.as_ref()?))
        });
        for (at, object) in narrations.chain(overrides) {
            if !self.keys.objects.contains_key(object) {
                let known = self.objects().collect::<Vec<_>>().join(", ");
                return Err(self.refuse(&at, format!("no object `{object}`: expected one of {known}")));
            }
        }
        for (index, each) in self.keys.overrides.iter().enumerate() {
            if each.keyframe.is_some() == each.time.is_some() {
                let problem = "expected one of `keyframe` (its number as printed) and `time` (seconds as printed)";
                return Err(self.refuse(&key(&["override"]).index(index), problem));
            }
        }
        Ok(())
    }

    /// The poses that are to be read: the gripper's first.
    pub(super) fn poses(&self) -> impl Iterator<Item = &PoseKeys> {
        std::iter::once(&self.keys.gripper).chain(self.keys.objects.values())
    }

    /// Columns whose number is 0 until it is told.
    pub(super) fn events(&self) -> impl Iterator<Item = &String> {
        let ColumnKeys { mark, intervention, announced, hold, .. } = &self.keys.columns;
        [mark, intervention, announced, hold].into_iter().flatten()
    }

    /// The columns that are named, those of poses first.
    pub(super) fn columns(&self) -> Vec<&String> {
        let ColumnKeys { time, episode, reference, narration, .. } = &self.keys.columns;
        let OpeningKeys { column, command, command_kind, .. } = &self.keys.opening;
        let others = [time, episode, reference, narration, column, command, command_kind];
        self.poses().flat_map(PoseKeys::columns).chain(others.into_iter().flatten()).chain(self.events()).collect()
    }

    /// The order of a pose's quaternion.
    pub(super) fn order(&self, pose: &PoseKeys) -> Option<QuaternionOrder> {
        pose.quaternion_order.or(self.keys.quaternion_order)
    }

    /// Below it the gripper is closed, in the unit of the opening.
    pub(super) fn close_below(&self) -> f64 {
        self.keys.opening.close_below.unwrap_or(CLOSE_BELOW)
    }

    /// Above it the gripper is open, in the unit of the opening.
    pub(super) fn open_above(&self) -> f64 {
        self.keys.opening.open_above.unwrap_or(OPEN_ABOVE)
    }

    /// The keys of an episode, and their index.
    pub(super) fn episode(&self, label: &str, correction: Option<usize>) -> Option<(usize, &EpisodeKeys)> {
        let mut found = self.keys.episodes.iter().enumerate().filter(|(_, keys)| keys.episode.text() == label);
        found.find(|(_, keys)| keys.correction == correction)
    }
}

/// The most letters of a name.
const LONGEST_NAME: usize = 200;
/// The most metres, seconds and newtons. Far beyond it a square is infinite.
const FARTHEST: f64 = 1e6;
/// The least number that is above 0 for a tolerance.
const SMALLEST: f64 = 1e-9;
/// A square of a length that differs by no more from 1 is that of a quaternion.
const QUATERNION_TOLERANCE: f64 = 2e-3;
/// Shares of the stroke at which a gripper has closed and opened, where nothing else is said. Between them is the
/// width of things.
const CLOSE_BELOW: f64 = 0.4;
const OPEN_ABOVE: f64 = 0.6;
