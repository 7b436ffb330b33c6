//! The keys of a mapping, as its file has them. All of them: `bench/docs/import.md`.

use std::collections::BTreeMap;

use serde::Deserialize;
use situ::demonstration::Kind;
use situ::state::Axis;

/// The order of the four numbers of a quaternion. It is nowhere assumed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum QuaternionOrder {
    /// The real part first.
    Wxyz,
    /// The real part last.
    Xyzw,
}

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
    pub(super) fn columns(&self) -> impl Iterator<Item = &String> {
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
