//! Demonstrations as frames, some in every second.
//!
//! A demonstration file has no clock. So the hand goes from keyframe to keyframe in a straight line at [`SPEED`] and
//! [`TURN`], whichever takes longer, and rests there for the keyframe's `hold`, for a frame at least. Where the file
//! gives the poses of everything, the objects are there; where it gives states, each is where a keyframe about it says.
//! A correction stands behind its attempt: the segments of the demonstration that it names, up to the one that ran
//! last. That is what the model had learned to do, not what the robot did: nobody recorded that.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::UnitQuaternion;
use situ::demonstration::{Gripper, Keyframe, Kind, Pose};
use situ::segmentation::lengths;
use situ_tasks::Poses;

use crate::demonstration_file::DemonstrationFile;
use crate::demonstration_file::Instance;

/// Frames a second.
pub const RATE: u32 = 30;
/// Metres a second of the hand's way.
pub const SPEED: f64 = 0.25;
/// Radians a second of the hand's turn.
pub const TURN: f64 = 1.0;

/// A frame of an exported episode. Poses are in the world frame, metres.
#[derive(Clone, Debug)]
pub(super) struct ExportedFrame<'a> {
    pub(super) hand: Pose,
    /// In the order of [`Timeline::objects`].
    pub(super) objects: Vec<Pose>,
    /// The command that is in force.
    pub(super) gripper: Gripper,
    /// The keyframe that is reached here, from 1; 0 on the way.
    pub(super) mark: u32,
    /// The keyframe that the hand goes to, or rests at.
    pub(super) keyframe: &'a Keyframe,
    /// A person shows a correction.
    pub(super) intervention: bool,
}

/// An episode: an original, or an attempt and its correction.
pub(super) struct ExportedEpisode<'a> {
    pub(super) file: &'a DemonstrationFile,
    pub(super) frames: Vec<ExportedFrame<'a>>,
}

/// All episodes, with the same objects.
pub(super) struct Timeline<'a> {
    pub(super) objects: Vec<&'a str>,
    pub(super) episodes: Vec<ExportedEpisode<'a>>,
    /// Objects that a file says nothing of: its name, and theirs.
    pub(super) unknown: Vec<(&'a str, Vec<&'a str>)>,
    /// The widest opening of a command in metres, for shares of the stroke.
    pub(super) widest: f64,
}

/// The timeline of files in the order in which they are learned.
pub(super) fn timeline(files: &[DemonstrationFile]) -> Timeline<'_> {
    let keyframes = || files.iter().flat_map(|file| file.demonstration.keyframes());
    let seen = files.iter().flat_map(|file| &file.worlds).flat_map(|world| world.objects.keys().map(String::as_str));
    let names: BTreeSet<&str> = keyframes().map(|keyframe| &*keyframe.reference).chain(seen).collect();
    let objects: Vec<&str> = names.into_iter().collect();
    let mut first: BTreeMap<&str, Pose> = BTreeMap::new();
    for (name, pose) in files.iter().flat_map(|file| &file.worlds).flat_map(|world| &world.objects) {
        first.entry(name).or_insert(*pose);
    }
    for keyframe in keyframes() {
        first.entry(&keyframe.reference).or_insert(keyframe.reference_pose);
    }
    let widths = keyframes().filter_map(|keyframe| match keyframe.gripper {
        Gripper::Open(metres) => Some(metres),
        _ => None,
    });
    let widest = widths.fold(0.0, f64::max);
    let (mut episodes, mut unknown) = (Vec::new(), Vec::new());
    for (index, file) in files.iter().enumerate() {
        let seen = file.worlds.iter().flat_map(|world| world.objects.keys().map(String::as_str));
        let own = file.demonstration.keyframes().iter().map(|each| &*each.reference);
        let own: BTreeSet<&str> = own.chain(seen).collect();
        let missing: Vec<&str> = objects.iter().copied().filter(|name| !own.contains(name)).collect();
        if !missing.is_empty() {
            unknown.push((file.demonstration.name().as_ref(), missing));
        }
        let mut player = Player { objects: &objects, first: &first, frames: Vec::new() };
        for part in attempt(file, &files[..index]) {
            player.play(part, false);
        }
        let all = file.demonstration.keyframes();
        player.play(Part { keyframes: all, worlds: &file.worlds }, file.demonstration.kind() == Kind::Corrective);
        episodes.push(ExportedEpisode { file, frames: player.frames });
    }
    Timeline { objects, episodes, unknown, widest }
}

/// Some keyframes from the first of a demonstration on, and its worlds, where they are known: before each, and after
/// the last.
#[derive(Clone, Copy)]
struct Part<'a> {
    keyframes: &'a [Keyframe],
    worlds: &'a [Poses],
}

/// What is taken to have been done before a correction, demonstration by demonstration.
fn attempt<'a>(file: &DemonstrationFile, former: &'a [DemonstrationFile]) -> Vec<Part<'a>> {
    let Some(Instance { demonstration, segment }) = &file.before.after else { return Vec::new() };
    let Some(index) = former.iter().position(|other| **other.demonstration.name() == **demonstration) else {
        return Vec::new();
    };
    let other = &former[index];
    let done: usize = lengths(&other.demonstration).iter().take(*segment as usize + 1).sum();
    let mut parts = attempt(other, &former[..index]);
    parts.push(Part { keyframes: &other.demonstration.keyframes()[..done], worlds: &other.worlds });
    parts
}

/// Plays keyframes and keeps the frames.
struct Player<'a, 'b> {
    objects: &'b [&'a str],
    /// Where each object was first seen in any file.
    first: &'b BTreeMap<&'a str, Pose>,
    frames: Vec<ExportedFrame<'a>>,
}

impl<'a> Player<'a, '_> {
    fn play(&mut self, part: Part<'a>, intervention: bool) {
        // A person steps in where the robot is then, wherever its attempt has led to here.
        let begins = self.frames.is_empty() || intervention;
        if let (Some(world), Some(keyframe), true) = (part.worlds.first(), part.keyframes.first(), begins) {
            let (hand, objects) = (world.hand, self.poses(part, 0));
            let gripper = world.opening.map_or(keyframe.gripper, Gripper::Open);
            self.frames.push(ExportedFrame { hand, objects, gripper, mark: 0, keyframe, intervention });
        }
        for (index, keyframe) in part.keyframes.iter().enumerate() {
            let (objects, next) = (self.poses(part, index), self.poses(part, index + 1));
            let (to, last) = (keyframe.gripper_pose, self.frames.last());
            let from = last.map_or(to, |last| last.hand);
            let before = last.map_or(keyframe.gripper, |last| last.gripper);
            let way = (to.translation.vector - from.translation.vector).norm() / SPEED;
            let turn = from.rotation.angle_to(&to.rotation) / TURN;
            let steps = frames_of(way.max(turn));
            let frame = |hand, objects: &[Pose], gripper, mark| ExportedFrame {
                hand,
                objects: objects.to_vec(),
                gripper,
                mark,
                keyframe,
                intervention,
            };
            let between = (1..steps).map(|step| between(&from, &to, f64::from(step) / f64::from(steps)));
            let moving: Vec<_> = between.map(|hand| frame(hand, &objects, before, 0)).collect();
            self.frames.extend(moving);
            self.frames.push(frame(to, &objects, keyframe.gripper, index as u32 + 1));
            let rest = (0..frames_of(keyframe.hold)).map(|_| frame(to, &next, keyframe.gripper, 0));
            self.frames.extend(rest);
        }
    }

    /// Where the objects are before the motion to a keyframe, or after the last: each where the world says so; or where
    /// a keyframe about it last did, or will; or where another file did.
    fn poses(&self, Part { keyframes, worlds }: Part<'_>, index: usize) -> Vec<Pose> {
        let (world, index) = (worlds.get(index), index.min(keyframes.len() - 1));
        let pose = |name: &&str| {
            if let Some(pose) = world.and_then(|world| world.objects.get(*name)) {
                return *pose;
            }
            let own = |keyframe: &&Keyframe| *keyframe.reference == **name;
            let last = keyframes[..=index].iter().rev().find(own);
            let found = last.or_else(|| keyframes[index..].iter().find(own)).map(|keyframe| keyframe.reference_pose);
            found.or_else(|| self.first.get(name).copied()).unwrap_or_default()
        };
        self.objects.iter().map(pose).collect()
    }
}

/// So many frames take as long, one at least.
fn frames_of(seconds: f64) -> u32 {
    const MOST: f64 = 1e6;
    (seconds * f64::from(RATE)).ceil().clamp(1.0, MOST) as u32
}

fn between(from: &Pose, to: &Pose, share: f64) -> Pose {
    let turn = (from.rotation.inverse() * to.rotation).scaled_axis();
    let at = from.translation.vector.lerp(&to.translation.vector, share);
    Pose::from_parts(at.into(), from.rotation * UnitQuaternion::from_scaled_axis(turn * share))
}

impl Timeline<'_> {
    /// A command as a share of the stroke, 0 closed to 1 open, for those who learn from one number.
    pub(super) fn share(&self, gripper: Gripper) -> f64 {
        match gripper {
            Gripper::Opening(share) => share,
            Gripper::Open(metres) if self.widest > 0.0 => metres / self.widest,
            Gripper::Open(_) | Gripper::Close(_) => 0.0,
        }
    }
}

/// The word of a command's kind: what its number is.
pub(super) fn kind_word(gripper: Gripper) -> &'static str {
    match gripper {
        Gripper::Opening(_) => "share",
        Gripper::Open(_) => "open",
        Gripper::Close(_) => "close",
    }
}

/// A pose as seven numbers: position, and a quaternion with its real part first.
pub(super) fn seven(pose: &Pose) -> [f64; 7] {
    let (at, turned) = (&pose.translation, &pose.rotation);
    [at.x, at.y, at.z, turned.w, turned.i, turned.j, turned.k]
}
