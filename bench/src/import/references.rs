//! Which object each keyframe is about, and how that was found.
//!
//! What the recording or the mapping says counts. Where they say nothing: the object that the gripper is nearest to, if
//! it is near enough. While a thing is held it is the other thing that the held one is nearest to; what the held thing
//! stood at when it was taken does not count until it is let go there. A thing that was let go does not count until the
//! gripper closes again. Where nothing is near while a thing is held, it is that thing, as long as the gripper is
//! nearer to where it was taken than to what comes next: a thing is lifted from where it stood. Where nothing is near
//! otherwise, it is what the next keyframe is about, since the way leads there; after the last of those, what the one
//! before was about.

use std::rc::Rc;

use situ::demonstration::Pose;

use crate::import::frames::Frame;
use crate::import::keyframes::Picked;
use crate::import::mapping::Mapping;

/// What a keyframe is about.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct About {
    /// The index of the object.
    pub(super) object: usize,
    /// How it was found.
    pub(super) because: String,
}

/// What the gripper has to do with a thing.
#[derive(Clone)]
enum Grasp {
    /// It holds it; this was near it when it was taken; at that frame it closed.
    Holds(usize, Rc<[usize]>, usize),
    /// It holds it no longer.
    LetGo(usize),
    Nothing,
}

struct Finder<'a> {
    frames: &'a [Frame],
    closed: &'a [bool],
    mapping: &'a Mapping,
    names: Vec<&'a str>,
    /// Metres within which each object is near.
    near: Vec<f64>,
    /// Whether an object never moves.
    fixed: Vec<bool>,
}

/// What each keyframe is about.
pub(super) fn about(frames: &[Frame], closed: &[bool], picked: &[Picked], mapping: &Mapping) -> Vec<About> {
    let objects = &mapping.keys.objects;
    let finder = Finder {
        frames,
        closed,
        mapping,
        names: mapping.objects().collect(),
        near: objects.values().map(|pose| pose.near.unwrap_or(mapping.keys.keyframes.near)).collect(),
        fixed: objects.values().map(|pose| pose.fixed.is_some()).collect(),
    };
    let grasps = finder.grasps();
    let found: Vec<Option<About>> = picked.iter().map(|picked| finder.said(picked.frame)).collect();
    let found: Vec<Option<About>> = found
        .into_iter()
        .zip(picked)
        .map(|(said, picked)| said.or_else(|| finder.nearest(picked.frame, &grasps[picked.frame])))
        .collect();
    let next = |from: usize| found[from..].iter().position(Option::is_some).map(|more| from + more);
    let mut all: Vec<About> = Vec::with_capacity(found.len());
    for (index, own) in found.iter().enumerate() {
        let (frame, next) = (picked[index].frame, next(index));
        let next_object = next.and_then(|next| found[next].as_ref()).map(|next| next.object);
        let lifted = finder.lifted(frame, &grasps[frame], next_object);
        let lifted = lifted.filter(|lifted| all.last().is_some_and(|before| before.object == lifted.object));
        let lasting = || found[..index].iter().rev().flatten().next();
        all.push(match (own.as_ref().or(lifted.as_ref()), next, lasting()) {
            (Some(own), _, _) => own.clone(),
            (None, Some(next), _) => About {
                object: found[next].as_ref().map_or(0, |next| next.object),
                because: format!("on the way to keyframe {next}"),
            },
            (None, None, Some(before)) => {
                About { object: before.object, because: "nothing is near: as before".to_owned() }
            }
            (None, None, None) => finder.farther(frame),
        });
    }
    all
}

impl Finder<'_> {
    fn distance(&self, frame: usize, from: &Pose, object: usize) -> f64 {
        (self.frames[frame].objects[object].translation.vector - from.translation.vector).norm()
    }

    /// What recording and mapping say.
    fn said(&self, frame: usize) -> Option<About> {
        let index = |name: &str| self.names.iter().position(|own| *own == name);
        if self.names.len() == 1 {
            return Some(About { object: 0, because: "the only object".to_owned() });
        }
        let Frame { reference, narration, .. } = &self.frames[frame];
        if let Some(object) = reference.as_deref().and_then(index) {
            return Some(About { object, because: "the column says so".to_owned() });
        }
        let narration = narration.as_ref()?;
        let object = self.mapping.keys.narrations.get(narration).and_then(|name| index(name))?;
        Some(About { object, because: format!("narrated `{narration}`") })
    }

    /// The nearest object that is near: to the gripper, or to what it holds.
    fn nearest(&self, frame: usize, grasp: &Grasp) -> Option<About> {
        let poses = &self.frames[frame];
        let lets_go = !self.closed[frame];
        let (from, to) = match grasp {
            Grasp::Holds(held, ..) => (&poses.objects[*held], format!(" to the held {}", self.names[*held])),
            Grasp::LetGo(_) | Grasp::Nothing => (&poses.hand, String::new()),
        };
        let counts = |object: &usize| match grasp {
            Grasp::Holds(held, beside, _) => object != held && (lets_go || !beside.contains(object)),
            Grasp::LetGo(thing) => object != thing || self.closed[frame],
            Grasp::Nothing => true,
        };
        let all = (0..self.names.len()).filter(counts).map(|object| (object, self.distance(frame, from, object)));
        let near = all.filter(|(object, metres)| *metres <= self.near[*object]);
        let (object, metres) = near.min_by(|one, other| one.1.total_cmp(&other.1))?;
        Some(About { object, because: format!("nearest{to}, {metres:.2} m") })
    }

    /// The held thing, where the gripper is nearer to where it was taken than to the object that comes next.
    fn lifted(&self, frame: usize, grasp: &Grasp, next: Option<usize>) -> Option<About> {
        let Grasp::Holds(held, _, taken) = grasp else { return None };
        let from = |pose: &Pose| (pose.translation.vector - self.frames[frame].hand.translation.vector).norm();
        let (stood, leads) = (from(&self.frames[*taken].objects[*held]), from(&self.frames[frame].objects[next?]));
        (stood < leads).then(|| About { object: *held, because: "lifted from where it stood".to_owned() })
    }

    /// The nearest object, however far.
    fn farther(&self, frame: usize) -> About {
        let hand = &self.frames[frame].hand;
        let all = (0..self.names.len()).map(|object| (object, self.distance(frame, hand, object)));
        let nearest = all.min_by(|one, other| one.1.total_cmp(&other.1));
        let (object, metres) = nearest.unwrap_or_default();
        About { object, because: format!("nearest, though {metres:.2} m away") }
    }

    /// What the gripper holds at each frame: from the frame after it closes to the frame at which it opens.
    fn grasps(&self) -> Vec<Grasp> {
        let mut grasps: Vec<Grasp> = Vec::with_capacity(self.frames.len());
        for frame in 0..self.frames.len() {
            let now = match frame.checked_sub(1) {
                None => Grasp::Nothing,
                Some(before) => {
                    let has_just_closed = self.closed[before] && (before == 0 || !self.closed[before - 1]);
                    match (&grasps[before], has_just_closed, self.closed[before]) {
                        (_, true, _) => self.taken(before),
                        (Grasp::Holds(object, ..), false, false) => Grasp::LetGo(*object),
                        (same, false, _) => same.clone(),
                    }
                }
            };
            grasps.push(now);
        }
        grasps
    }

    /// What the gripper takes as it closes: the nearest thing that is near and can move.
    fn taken(&self, frame: usize) -> Grasp {
        let hand = &self.frames[frame].hand;
        let is_near = |object: &usize, from: &Pose| self.distance(frame, from, *object) <= self.near[*object];
        let can_move = (0..self.names.len()).filter(|object| !self.fixed[*object] && is_near(object, hand));
        let distance = |object: usize| self.distance(frame, hand, object);
        let Some(object) = can_move.min_by(|one, other| distance(*one).total_cmp(&distance(*other))) else {
            return Grasp::Nothing;
        };
        let from = &self.frames[frame].objects[object];
        let beside = (0..self.names.len()).filter(|other| *other != object && is_near(other, from)).collect();
        Grasp::Holds(object, beside, frame)
    }
}
