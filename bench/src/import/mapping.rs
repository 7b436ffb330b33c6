//! The mapping of a recording: a small TOML file that says where in the recording things are, and in what units.
//!
//! All its keys: `bench/docs/import.md`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use situ::demonstration::Kind;
use situ::state::Axis;
use situ_tasks::key::{Document, KeyPath};

use crate::error::BenchError;

/// The order of the four numbers of a quaternion. It is nowhere assumed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum QuaternionOrder {
    /// The real part first.
    Wxyz,
    /// The real part last.
    Xyzw,
}

/// What must be said wherever a quaternion is read.
const ORDER: &str = "expected \"wxyz\" (the real part first, as in MuJoCo, Drake and our own files) or \"xyzw\" (the \
                     real part last, as in ROS, PyBullet and SciPy): a quaternion is read here, and its order is \
                     never guessed";

/// Metres of a unit of length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub(super) enum LengthUnit {
    #[default]
    #[serde(rename = "m")]
    Metre,
    #[serde(rename = "cm")]
    Centimetre,
    #[serde(rename = "mm")]
    Millimetre,
}

impl LengthUnit {
    /// Units in a metre. To divide by it is exact where to multiply by its inverse is not.
    pub(super) fn per_metre(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 100.0,
            Self::Millimetre => 1000.0,
        }
    }
}

/// The unit of rotation vectors and of roll, pitch and yaw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum AngleUnit {
    #[default]
    Rad,
    Deg,
}

/// The unit of the time column.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum TimeUnit {
    #[default]
    S,
    Ms,
    Us,
    Ns,
}

impl TimeUnit {
    /// Units in a second.
    pub(super) fn per_second(self) -> f64 {
        match self {
            Self::S => 1.0,
            Self::Ms => 1e3,
            Self::Us => 1e6,
            Self::Ns => 1e9,
        }
    }
}

/// The unit of the gripper's opening.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum OpeningUnit {
    #[default]
    Share,
    M,
    Cm,
    Mm,
}

impl OpeningUnit {
    /// The unit as one of length; `None` for a share of the stroke.
    pub(super) fn length(self) -> Option<LengthUnit> {
        match self {
            Self::Share => None,
            Self::M => Some(LengthUnit::Metre),
            Self::Cm => Some(LengthUnit::Centimetre),
            Self::Mm => Some(LengthUnit::Millimetre),
        }
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct UnitKeys {
    pub(super) length: LengthUnit,
    pub(super) angle: AngleUnit,
    pub(super) time: TimeUnit,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct ColumnKeys {
    pub(super) time: Option<String>,
    pub(super) rate: Option<f64>,
    pub(super) episode: Option<String>,
    pub(super) mark: Option<String>,
    pub(super) reference: Option<String>,
    pub(super) narration: Option<String>,
    pub(super) announced: Option<String>,
    pub(super) intervention: Option<String>,
    pub(super) hold: Option<String>,
}

/// Where nothing is known of the way a thing is turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Unturned {
    None,
}

/// A pose of the mapping itself.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FixedKeys {
    pub(super) position: [f64; 3],
    pub(super) quaternion: Option<[f64; 4]>,
}

/// Where a pose is found.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct PoseKeys {
    pub(super) position: Option<[String; 3]>,
    pub(super) quaternion: Option<[String; 4]>,
    pub(super) rotation_vector: Option<[String; 3]>,
    pub(super) roll_pitch_yaw: Option<[String; 3]>,
    pub(super) matrix: Option<[String; 9]>,
    pub(super) orientation: Option<Unturned>,
    pub(super) quaternion_order: Option<QuaternionOrder>,
    pub(super) topic: Option<String>,
    pub(super) frame: Option<String>,
    pub(super) index: Option<usize>,
    pub(super) fixed: Option<FixedKeys>,
    pub(super) near: Option<f64>,
}

/// The parts of a pose of a topic, in the order of its columns.
const PARTS: [&str; 7] = ["x", "y", "z", "qw", "qx", "qy", "qz"];

impl PoseKeys {
    /// The names of the seven columns that hold the pose of a topic: position, and a quaternion with its real part
    /// first.
    pub(super) fn topic_columns(&self) -> Option<[String; 7]> {
        let topic = self.topic.as_ref()?;
        let index = self.index.map(|index| format!("[{index}]")).unwrap_or_default();
        let frame = self.frame.as_ref().map(|frame| format!("({frame})")).unwrap_or_default();
        Some(PARTS.map(|part| format!("{topic}{index}{frame}:{part}")))
    }

    /// The columns that hold the pose.
    fn columns(&self) -> impl Iterator<Item = &String> {
        let three = [&self.position, &self.rotation_vector, &self.roll_pitch_yaw];
        let quaternion = self.quaternion.iter().flatten();
        three.into_iter().flatten().flatten().chain(quaternion).chain(self.matrix.iter().flatten())
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct OpeningKeys {
    pub(super) column: Option<String>,
    pub(super) unit: OpeningUnit,
    pub(super) closed: Option<f64>,
    pub(super) open: Option<f64>,
    pub(super) command: Option<String>,
    pub(super) command_kind: Option<String>,
    pub(super) force: Option<f64>,
    pub(super) close_below: Option<f64>,
    pub(super) open_above: Option<f64>,
}

/// Tolerances of the choice of keyframes.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct KeyframeKeys {
    pub(super) metres: f64,
    pub(super) radians: f64,
    pub(super) rest_metres: f64,
    pub(super) rest_radians: f64,
    pub(super) rest_seconds: f64,
    pub(super) near: f64,
}

impl Default for KeyframeKeys {
    fn default() -> Self {
        Self { metres: 0.05, radians: 0.5, rest_metres: 0.005, rest_radians: 0.05, rest_seconds: 0.2, near: 0.15 }
    }
}

/// A label of an episode: a whole number or a word.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged, expecting = "the label of an episode: a whole number or a word")]
pub(super) enum Label {
    Number(i64),
    Word(String),
}

impl Label {
    pub(super) fn text(&self) -> String {
        match self {
            Self::Number(number) => number.to_string(),
            Self::Word(word) => word.clone(),
        }
    }
}

/// A place of the automaton: a segment of the followed original, or START, or no segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged, expecting = "the index of a segment of the followed original, from 0, or \"none\"")]
pub(super) enum Stopped {
    Segment(u32),
    Nowhere(Unturned),
}

impl Stopped {
    pub(super) fn segment(self) -> Option<u32> {
        match self {
            Self::Segment(index) => Some(index),
            Self::Nowhere(_) => None,
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EpisodeKeys {
    pub(super) episode: Label,
    pub(super) name: Option<String>,
    #[serde(default)]
    pub(super) corrections: Vec<String>,
    pub(super) kind: Option<Kind>,
    #[serde(default)]
    pub(super) skip: bool,
    pub(super) carried_to_end: Option<bool>,
    pub(super) follows: Option<String>,
    pub(super) after: Option<Stopped>,
    pub(super) interrupted: Option<Stopped>,
    pub(super) correction: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OverrideKeys {
    /// Of every demonstration, where it is left out.
    pub(super) demonstration: Option<String>,
    pub(super) keyframe: Option<usize>,
    pub(super) time: Option<f64>,
    pub(super) reference: Option<String>,
    pub(super) narration: Option<String>,
    pub(super) announced: Option<bool>,
    #[serde(default)]
    pub(super) leave_out: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MappingFile {
    pub(super) name: Option<String>,
    pub(super) kind: Option<Kind>,
    pub(super) half_turn: Option<Axis>,
    /// The objects of the task, where there are more than the recording has.
    pub(super) task_objects: Option<Vec<String>>,
    pub(super) quaternion_order: Option<QuaternionOrder>,
    pub(super) follows: Option<String>,
    #[serde(default)]
    pub(super) units: UnitKeys,
    #[serde(default)]
    pub(super) columns: ColumnKeys,
    pub(super) gripper: PoseKeys,
    #[serde(default)]
    pub(super) opening: OpeningKeys,
    pub(super) objects: BTreeMap<String, PoseKeys>,
    #[serde(default)]
    pub(super) narrations: BTreeMap<String, String>,
    #[serde(default)]
    pub(super) keyframes: KeyframeKeys,
    #[serde(default)]
    pub(super) episodes: Vec<EpisodeKeys>,
    #[serde(default, rename = "override")]
    pub(super) overrides: Vec<OverrideKeys>,
}

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
