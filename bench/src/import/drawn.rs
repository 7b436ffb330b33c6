//! A demonstration drawn from frames: its keyframes, what each is about, and the world before each.

use std::ops::Range;

use situ::demonstration::{Gripper, Kind, Pose};

use crate::demonstration_file::Instance;
use crate::error::BenchError;
use crate::import::frames::{Frame, Take};
use crate::import::keyframes::{Picked, departure, pick};
use crate::import::mapping::{Mapping, key};
use crate::import::mapping_keys::OverrideKeys;
use crate::import::references::{About, about};
use crate::import::written::{self, Shown, Title, World};

/// Printed seconds have two decimals; a time in the mapping may be as far from the keyframe's.
const PRINTED_TIME: f64 = 0.0051;
/// Decimals of seconds, and of openings that are a middle of many.
const DECIMALS: f64 = 1e4;

/// A keyframe that was drawn.
pub(super) struct DrawnKeyframe {
    /// Its frame, from the first of the demonstration.
    pub(super) picked: Picked,
    pub(super) about: About,
    pub(super) announced: bool,
    pub(super) narration: Option<String>,
    pub(super) gripper: Gripper,
    pub(super) hold: f64,
    /// The frame from which the motion to it begins.
    before: usize,
}

/// A demonstration that was drawn from frames of a recording.
pub(super) struct Drawn<'a> {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) frames: &'a [Frame],
    pub(super) keyframes: Vec<DrawnKeyframe>,
    pub(super) carried_to_end: bool,
    mapping: &'a Mapping,
}

/// The last keyframe of a segment, and what the segment is about.
pub(super) struct SegmentEnd {
    pub(super) object: usize,
    /// In the frame of the object as it was when the segment began.
    pub(super) pose: Pose,
    pub(super) closed: bool,
}

impl<'a> Drawn<'a> {
    /// Draws a demonstration from some frames of an episode; `closed` says of all its frames whether the gripper is.
    ///
    /// # Errors
    /// [`BenchError::Recording`] where nothing is marked though the mapping says that keyframes are;
    /// [`BenchError::Task`] for an override of a keyframe that is not there.
    pub(super) fn new(
        name: String,
        kind: Kind,
        (take, range): (&'a Take, Range<usize>),
        closed: &[bool],
        mapping: &'a Mapping,
    ) -> Result<Self, BenchError> {
        let frames = &take.frames[range.clone()];
        let closed = &closed[range];
        let picked = pick(frames, closed, mapping);
        let is_marked = picked.first().is_some_and(|picked| frames[picked.frame].mark.unwrap_or(0.0) != 0.0);
        if let (Some(column), false) = (&mapping.keys.columns.mark, is_marked) {
            let problem = format!("no frame of `{name}` is marked: expected a mark, or leave the key out");
            return Err(mapping.refuse(&key(&["columns", "mark"]), format!("column `{column}`: {problem}")));
        }
        let abouts = about(frames, closed, &picked, mapping);
        let mut drawn = Self { name, kind, frames, keyframes: Vec::new(), carried_to_end: true, mapping };
        for (picked, about) in picked.into_iter().zip(abouts) {
            let narration = frames[picked.frame].narration.clone();
            let announced = frames[picked.frame].announced;
            let gripper = Gripper::Opening(0.0);
            drawn.keyframes.push(DrawnKeyframe { picked, about, announced, narration, gripper, hold: 0.0, before: 0 });
        }
        drawn.override_keyframes()?;
        drawn.complete(closed);
        Ok(drawn)
    }

    /// What the mapping says of single keyframes.
    fn override_keyframes(&mut self) -> Result<(), BenchError> {
        let mapping = self.mapping;
        let mut left_out = Vec::new();
        for (number, keys) in mapping.keys.overrides.iter().enumerate() {
            if keys.demonstration.as_ref().is_some_and(|named| *named != self.name) {
                continue;
            }
            let index = self.overridden(number, keys)?;
            let keyframe = &mut self.keyframes[index];
            if let Some(object) = &keys.reference {
                let object = mapping.objects().position(|name| name == object).unwrap_or_default();
                keyframe.about = About { object, because: "the mapping says so".to_owned() };
            }
            keyframe.narration = keys.narration.clone().or(keyframe.narration.take());
            keyframe.announced = keys.announced.unwrap_or(keyframe.announced);
            if keys.leave_out && !left_out.contains(&index) {
                left_out.push(index);
            }
            if left_out.len() == self.keyframes.len() {
                let at = key(&["override"]).index(number).field("leave_out");
                return Err(mapping.refuse(&at, "leaves no keyframe: expected at least one"));
            }
        }
        let mut index = 0..;
        self.keyframes.retain(|_| index.next().is_none_or(|index: usize| !left_out.contains(&index)));
        Ok(())
    }

    /// The keyframe that an override means.
    fn overridden(&self, number: usize, keys: &OverrideKeys) -> Result<usize, BenchError> {
        let at = key(&["override"]).index(number);
        if let Some(index) = keys.keyframe {
            if index < self.keyframes.len() {
                return Ok(index);
            }
            let problem = format!("{index}: expected 0 to {} (`{}`)", self.keyframes.len() - 1, self.name);
            return Err(self.mapping.refuse(&at.field("keyframe"), problem));
        }
        let time = keys.time.unwrap_or_default();
        let near = |keyframe: &DrawnKeyframe| (self.seconds(keyframe) - time).abs() <= PRINTED_TIME;
        self.keyframes.iter().position(near).ok_or_else(|| {
            let times: Vec<String> = self.keyframes.iter().map(|each| format!("{:.2}", self.seconds(each))).collect();
            let problem = format!("{time}: expected one of {} (`{}`)", times.join(", "), self.name);
            self.mapping.refuse(&at.field("time"), problem)
        })
    }

    /// Seconds of a keyframe since the episode began.
    pub(super) fn seconds(&self, keyframe: &DrawnKeyframe) -> f64 {
        self.frames[keyframe.picked.frame].seconds
    }

    /// The gripper, the rest and the beginning of each motion.
    fn complete(&mut self, closed: &[bool]) {
        let keys = &self.mapping.keys;
        let mut before = 0;
        for index in 0..self.keyframes.len() {
            let frame = self.keyframes[index].picked.frame;
            let end = self.keyframes.get(index + 1).map_or(self.frames.len(), |next| next.picked.frame);
            let leaves = departure(self.frames, frame, end, self.mapping);
            let rest = self.frames[leaves].seconds - self.frames[frame].seconds;
            let rest = if rest < keys.keyframes.rest_seconds { 0.0 } else { rounded(rest) };
            let gripper = self.gripper(frame..end, closed[leaves], closed);
            let keyframe = &mut self.keyframes[index];
            keyframe.hold = self.frames[frame].hold.unwrap_or(rest);
            keyframe.gripper = gripper;
            keyframe.before = before;
            before = leaves;
        }
    }

    /// The command from a keyframe on: what was recorded; or closed; or as wide as the gripper mostly is in the frames
    /// until the next keyframe.
    fn gripper(&self, frames: Range<usize>, is_closed: bool, closed: &[bool]) -> Gripper {
        let opening = &self.mapping.keys.opening;
        if let Some(command) = self.frames[frames.start].command {
            let is_width = matches!(command, Gripper::Open(_)) && opening.command_kind.is_none();
            return if is_width && is_closed { self.closing() } else { command };
        }
        if is_closed {
            return self.closing();
        }
        let of_state = frames.filter(|frame| !closed[*frame]).filter_map(|frame| self.frames[frame].opening);
        let mut widths: Vec<f64> = of_state.collect();
        widths.sort_by(f64::total_cmp);
        let middle = widths.get(widths.len() / 2).copied().map_or(1.0, rounded);
        match opening.unit.length() {
            Some(_) if !widths.is_empty() => Gripper::Open(middle),
            _ => Gripper::Opening(middle),
        }
    }

    fn closing(&self) -> Gripper {
        self.mapping.keys.opening.force.map_or(Gripper::Opening(0.0), Gripper::Close)
    }

    fn world(&self, frame: usize) -> World<'_> {
        let Frame { objects, hand, opening, .. } = &self.frames[frame];
        World { objects: self.mapping.objects().zip(objects.iter().copied()).collect(), hand: *hand, opening: *opening }
    }

    /// The name of the object that a keyframe is about.
    pub(super) fn reference(&self, keyframe: &DrawnKeyframe) -> &str {
        self.mapping.objects().nth(keyframe.about.object).unwrap_or_default()
    }

    /// The first and the last keyframe of each segment.
    pub(super) fn segments(&self) -> Vec<&[DrawnKeyframe]> {
        self.keyframes.chunk_by(|left, right| left.about.object == right.about.object && !right.announced).collect()
    }

    /// Where each segment ends.
    pub(super) fn segment_ends(&self, is_closed: impl Fn(usize) -> bool) -> Vec<SegmentEnd> {
        let end = |run: &[DrawnKeyframe]| {
            let (first, last) = (run.first()?, run.last()?);
            let object = first.about.object;
            let frame = self.frames[first.before].objects[object];
            let pose = frame.inverse() * self.frames[last.picked.frame].hand;
            Some(SegmentEnd { object, pose, closed: is_closed(last.picked.frame) })
        };
        self.segments().into_iter().filter_map(end).collect()
    }

    /// The text of its file.
    pub(super) fn text(&self, after: Option<Instance>, interrupted: Option<Instance>) -> String {
        let shown = |keyframe: &DrawnKeyframe| Shown {
            reference: self.mapping.objects().nth(keyframe.about.object).unwrap_or_default(),
            announced: keyframe.announced,
            before: self.world(keyframe.before),
            pose: self.frames[keyframe.picked.frame].hand,
            gripper: keyframe.gripper,
            hold: keyframe.hold,
            narration: keyframe.narration.clone(),
        };
        let title = Title {
            name: &self.name,
            kind: self.kind,
            half_turn: self.mapping.keys.half_turn,
            objects: self.mapping.keys.task_objects.clone(),
            after,
            interrupted,
            carried_to_end: self.carried_to_end,
        };
        let keyframes = self.keyframes.iter().map(shown).collect();
        written::text(title, keyframes, self.world(self.frames.len() - 1))
    }
}

fn rounded(value: f64) -> f64 {
    (value * DECIMALS).round() / DECIMALS
}
