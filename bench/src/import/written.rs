//! A demonstration as it is written: version 2 of the format, key for key. The state is left to the reader: it follows
//! from the poses.

use std::collections::BTreeMap;

use serde::Serialize;
use situ::demonstration::{Gripper, Kind, Pose};
use situ::state::Axis;

use crate::demonstration_content::{FileGripper, FilePose, Instance};

/// The version that is written.
const VERSION: u32 = 2;

/// A demonstration. The names of the fields are the keys of the file.
#[derive(Serialize)]
pub(super) struct WrittenDemonstration {
    version: u32,
    name: String,
    kind: Kind,
    #[serde(skip_serializing_if = "Option::is_none")]
    half_turn: Option<Axis>,
    after: Option<Instance>,
    #[serde(skip_serializing_if = "Option::is_none")]
    interrupted: Option<Instance>,
    carried_to_end: bool,
    keyframes: Vec<WrittenKeyframe>,
    #[serde(rename = "final")]
    last: WrittenWorld,
}

/// The poses of all things, metres in the world frame.
#[derive(Serialize)]
struct WrittenWorld {
    objects: BTreeMap<String, FilePose>,
    hand: FilePose,
    #[serde(skip_serializing_if = "Option::is_none")]
    opening: Option<f64>,
}

#[derive(Serialize)]
struct WrittenKeyframe {
    reference: String,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    announced: bool,
    #[serde(flatten)]
    before: WrittenWorld,
    gripper_pose: FilePose,
    gripper: FileGripper,
    hold: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    narration: Option<String>,
}

/// A moment: objects with their names, the hand, and the gripper's opening where it is known.
pub(super) struct World<'a> {
    pub(super) objects: Vec<(&'a str, Pose)>,
    pub(super) hand: Pose,
    pub(super) opening: Option<f64>,
}

/// A keyframe, and the world before the motion to it.
pub(super) struct Shown<'a> {
    pub(super) reference: &'a str,
    pub(super) announced: bool,
    pub(super) before: World<'a>,
    pub(super) pose: Pose,
    pub(super) gripper: Gripper,
    pub(super) hold: f64,
    pub(super) narration: Option<String>,
}

/// What stands above the keyframes.
pub(super) struct Title<'a> {
    pub(super) name: &'a str,
    pub(super) kind: Kind,
    pub(super) half_turn: Option<Axis>,
    pub(super) after: Option<Instance>,
    pub(super) interrupted: Option<Instance>,
    pub(super) carried_to_end: bool,
}

/// The text of a demonstration file.
pub(super) fn text(title: Title<'_>, keyframes: Vec<Shown<'_>>, last: World<'_>) -> String {
    let keyframe = |shown: Shown<'_>| WrittenKeyframe {
        reference: shown.reference.to_owned(),
        announced: shown.announced,
        before: world(shown.before),
        gripper_pose: pose(&shown.pose),
        gripper: FileGripper(shown.gripper),
        hold: shown.hold,
        narration: shown.narration,
    };
    let demonstration = WrittenDemonstration {
        version: VERSION,
        name: title.name.to_owned(),
        kind: title.kind,
        half_turn: title.half_turn,
        after: title.after,
        interrupted: title.interrupted,
        carried_to_end: title.carried_to_end,
        keyframes: keyframes.into_iter().map(keyframe).collect(),
        last: world(last),
    };
    serde_json::to_string_pretty(&demonstration).expect("finite numbers and string keys") + "\n"
}

fn world(world: World<'_>) -> WrittenWorld {
    WrittenWorld {
        objects: world.objects.iter().map(|(name, at)| ((*name).to_owned(), pose(at))).collect(),
        hand: pose(&world.hand),
        opening: world.opening,
    }
}

fn pose(pose: &Pose) -> FilePose {
    FilePose {
        position: pose.translation.vector.into(),
        quaternion: [pose.rotation.w, pose.rotation.i, pose.rotation.j, pose.rotation.k],
    }
}
