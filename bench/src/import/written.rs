//! A demonstration as `import` writes it: version 2 of the format. The state is left to the reader: it follows from the
//! poses.

use situ::demonstration::{Gripper, Kind, Pose};
use situ::state::Axis;

use crate::demonstration_file::Instance;
use crate::demonstration_file::content::{FileContent, FileGripper, FileKeyframe, FilePose, FileWorld};

/// The version that is written.
const VERSION: u32 = 2;

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
    pub(super) objects: Option<Vec<String>>,
    pub(super) after: Option<Instance>,
    pub(super) interrupted: Option<Instance>,
    pub(super) carried_to_end: bool,
}

/// The text of a demonstration file.
pub(super) fn text(title: Title<'_>, keyframes: Vec<Shown<'_>>, last: World<'_>) -> String {
    let keyframe = |shown: Shown<'_>| FileKeyframe {
        reference: shown.reference.to_owned(),
        reference_pose: None,
        gripper_pose: FilePose::from(&shown.pose),
        gripper: FileGripper(shown.gripper),
        hold: shown.hold,
        state: None,
        world: Some(world(&shown.before)),
        announced: shown.announced,
        narration: shown.narration,
    };
    let demonstration = FileContent {
        version: Some(VERSION),
        name: title.name.to_owned(),
        kind: title.kind,
        schema: None,
        objects: title.objects,
        observe: None,
        half_turn: title.half_turn,
        after: title.after,
        interrupted: title.interrupted,
        trail: Vec::new(),
        carried_to_end: title.carried_to_end,
        keyframes: keyframes.into_iter().map(keyframe).collect(),
        final_state: None,
        final_world: Some(world(&last)),
    };
    serde_json::to_string_pretty(&demonstration).expect("finite numbers and string keys") + "\n"
}

fn world(world: &World<'_>) -> FileWorld {
    FileWorld {
        objects: world.objects.iter().map(|(name, at)| ((*name).to_owned(), FilePose::from(at))).collect(),
        hand: FilePose::from(&world.hand),
        opening: world.opening,
    }
}
