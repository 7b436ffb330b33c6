//! The content of a demonstration file, key for key, before its rules are checked.

use std::collections::BTreeMap;

use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use situ::demonstration::{Gripper, Kind, Pose};
use situ::state::{Axis, Feature};
use situ::trail::StepEnd;

/// A primitive, named by a segment of an earlier demonstration that its node holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "null or {\"demonstration\": name, \"segment\": index}")]
pub struct Instance {
    /// The earlier demonstration's name.
    pub demonstration: String,
    /// The index of its segment, from 0.
    pub segment: u32,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FileContent {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) version: Option<u32>,
    pub(crate) name: String,
    pub(crate) kind: Kind,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) schema: Option<Vec<Feature>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) objects: Option<Vec<String>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) observe: Option<Vec<String>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) half_turn: Option<Axis>,
    // An `Option` may be left out, unless a function is named that reads it.
    #[serde(deserialize_with = "Option::deserialize")]
    pub(crate) after: Option<Instance>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) interrupted: Option<Instance>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) trail: Vec<FileStep>,
    pub(crate) carried_to_end: bool,
    pub(crate) keyframes: Vec<FileKeyframe>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) final_state: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) final_world: Option<FileWorld>,
}

/// The world as poses: what is there, the hand, and metres between its fingers.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FileWorld {
    #[serde(deserialize_with = "each_once")]
    pub(crate) objects: BTreeMap<String, FilePose>,
    pub(crate) hand: FilePose,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) opening: Option<f64>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FileStep {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) state: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) world: Option<FileWorld>,
    pub(crate) primitive: Instance,
    pub(crate) end: StepEnd,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FileKeyframe {
    pub(crate) reference: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) reference_pose: Option<FilePose>,
    pub(crate) gripper_pose: FilePose,
    pub(crate) gripper: FileGripper,
    #[serde(default)]
    pub(crate) hold: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) state: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) world: Option<FileWorld>,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(crate) announced: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) narration: Option<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FilePose {
    pub(crate) position: [f64; 3],
    pub(crate) quaternion: [f64; 4],
}

/// An object of JSON in which no key stands twice: a reader that takes the last of two does not see the first.
fn each_once<'de, D: Deserializer<'de>>(deserializer: D) -> Result<BTreeMap<String, FilePose>, D::Error> {
    deserializer.deserialize_map(EachOnce)
}

struct EachOnce;

impl<'de> Visitor<'de> for EachOnce {
    type Value = BTreeMap<String, FilePose>;

    fn expecting(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.write_str("the pose of each object, by its name")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut found = BTreeMap::new();
        while let Some((name, pose)) = map.next_entry::<String, FilePose>()? {
            if found.contains_key(&name) {
                return Err(A::Error::custom(format!("`{name}` stands there twice, expected once")));
            }
            found.insert(name, pose);
        }
        Ok(found)
    }
}

impl From<&Pose> for FilePose {
    fn from(pose: &Pose) -> Self {
        let rotation = pose.rotation.quaternion();
        Self { position: pose.translation.vector.into(), quaternion: [rotation.w, rotation.i, rotation.j, rotation.k] }
    }
}

pub(crate) struct FileGripper(pub(crate) Gripper);

impl Serialize for FileGripper {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Gripper::Opening(share) => serializer.serialize_f64(share),
            Gripper::Open(metres) => serializer.collect_map([("open", metres)]),
            Gripper::Close(newtons) => serializer.collect_map([("close", newtons)]),
        }
    }
}

impl<'de> Deserialize<'de> for FileGripper {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(GripperVisitor)
    }
}

struct GripperVisitor;

impl<'de> Visitor<'de> for GripperVisitor {
    type Value = FileGripper;

    fn expecting(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.write_str("an opening from 0 to 1, {\"open\": metres} or {\"close\": newtons}")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<FileGripper, E> {
        Ok(FileGripper(Gripper::Opening(value)))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<FileGripper, E> {
        self.visit_f64(value as f64)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<FileGripper, E> {
        self.visit_f64(value as f64)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<FileGripper, A::Error> {
        let gripper = match map.next_entry::<String, f64>()? {
            Some((key, metres)) if key == "open" => Gripper::Open(metres),
            Some((key, newtons)) if key == "close" => Gripper::Close(newtons),
            Some((key, _)) => return Err(A::Error::unknown_field(&key, &["open", "close"])),
            None => return Err(A::Error::invalid_length(0, &self)),
        };
        match map.next_key::<String>()? {
            Some(_) => Err(A::Error::invalid_length(2, &self)),
            None => Ok(FileGripper(gripper)),
        }
    }
}
