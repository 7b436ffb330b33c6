//! What can be seen and felt in a world, and which things are inside each other.

use std::collections::BTreeSet;

use nalgebra::{Point3, Vector3};
use rapier3d::geometry::{ContactPair, Group, Ray};
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::parry::query::contact;
use rapier3d::prelude::{Collider, ColliderHandle, Pose as EnginePose, RigidBodyHandle};

use crate::arm::Configuration;
use crate::camera::meet;
use crate::frame::{Pose, from_engine, from_engine_vector, to_engine_vector};
use crate::hand::GripperCommand;
use crate::hinge::Pivot;
use crate::mechanism::Guide;
use crate::object::Object;
use crate::step::DT;
use crate::tag::{ARM, HAND, TABLE, Tag};
use crate::world::{Entry, World};

/// A finger squeezes if its normal force points within 45° of the other finger. This is the cosine.
const SQUEEZE_PART: f64 = core::f64::consts::FRAC_1_SQRT_2;

impl World {
    /// Names of the objects, in the order in which they were added.
    pub fn objects(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|entry| entry.object.name.as_str())
    }

    /// The description of an object.
    pub fn object(&self, name: &str) -> Option<&Object> {
        self.names.get(name).map(|&index| &self.entries[index].object)
    }

    fn body(&self, name: &str) -> Option<RigidBodyHandle> {
        self.names.get(name).map(|&index| self.entries[index].body)
    }

    /// Pose of the object's frame in the world.
    pub fn pose(&self, object: &str) -> Option<Pose> {
        self.body(object).map(|body| from_engine(self.physics.bodies[body].position()))
    }

    /// The least and the largest corner of the box along the world's axes that holds a thing, metres. `table` and
    /// `hand` are names, too.
    pub fn bounds(&self, name: &str) -> Option<[[f64; 3]; 2]> {
        let boxes = self.colliders_of(name).into_iter().map(|collider| self.physics.colliders[collider].compute_aabb());
        let bounds = boxes.reduce(|sum, next| sum.merged(&next))?;
        Some([bounds.mins, bounds.maxs].map(|corner| from_engine_vector(corner).into()))
    }

    /// Whether something stands between a place (metres, world frame) and the middle of an object's box along the
    /// world's axes: another object, a bead, the hand or the arm. The object itself, the table and marks hide nothing.
    /// One that is not there is hidden.
    pub fn is_hidden(&self, object: &str, eye: [f64; 3]) -> bool {
        let (Some(body), Some([low, high])) = (self.body(object), self.bounds(object)) else { return true };
        let (from, to) = (Vector3::from(eye), 0.5 * (Vector3::from(low) + Vector3::from(high)));
        let ray = Ray::new(to_engine_vector(&from), to_engine_vector(&(to - from)));
        self.physics.colliders.iter().any(|(_, collider)| {
            let is_mark = collider.collision_groups().memberships == Group::NONE;
            let hides = collider.parent() != Some(body) && Tag::decode(collider.user_data) != Tag::Table && !is_mark;
            // The ray is as long as its direction: beyond 1 is behind the middle.
            hides && meet(collider, &ray, 1.0).is_some()
        })
    }

    /// Speed of the object's centre of mass in m/s.
    pub fn speed(&self, object: &str) -> Option<f64> {
        self.body(object).map(|body| f64::from(self.physics.bodies[body].linvel().length()))
    }

    /// Mass of the object in kg; none for a fixed one.
    pub fn mass(&self, object: &str) -> Option<f64> {
        let body = &self.physics.bodies[self.body(object)?];
        body.is_dynamic().then(|| f64::from(body.mass()))
    }

    /// Pose of the tool centre point in the world: between the pads, 12 mm above their tips, with z away from the tips
    /// and y along the closing axis.
    pub fn tcp(&self) -> Pose {
        self.hand.tcp(&self.physics)
    }

    /// The gripper command in force.
    pub fn gripper(&self) -> GripperCommand {
        self.hand.command()
    }

    /// Distance between the finger pads in metres.
    pub fn opening(&self) -> f64 {
        self.hand.opening(&self.physics)
    }

    /// Magnitude of the force of the surroundings on the hand in newtons, low-passed over 12 steps. A squeeze cancels.
    /// The weight of what is held is not in it, since friction carries that.
    pub fn hand_force(&self) -> f64 {
        self.hand.force()
    }

    /// How hard each finger presses on the object towards the other finger in the last step, in newtons: the part of
    /// its normal force along the closing axis. The object is held if both are above a threshold. Tips that stand on a
    /// thing, or push it, press on it and do not hold it.
    pub fn grip_force(&self, object: &str) -> [f64; 2] {
        let Some(body) = self.body(object) else {
            return [0.0; 2];
        };
        let closing = self.tcp().rotation * Vector3::y();
        let [_, left, right] = *self.hand.colliders();
        [(left, -closing), (right, closing)].map(|(finger, inward)| {
            let on_object = |pair: &ContactPair| {
                let (other, sign) =
                    if pair.collider1 == finger { (pair.collider2, 1.0) } else { (pair.collider1, -1.0) };
                let is_it = self.physics.colliders[other].parent() == Some(body) && pair.has_any_active_contact();
                let impulse = from_engine_vector(pair.total_impulse()) * sign;
                let squeeze = impulse.dot(&inward);
                (is_it && squeeze >= SQUEEZE_PART * impulse.norm()).then_some(squeeze)
            };
            self.physics.contact_pairs_with(finger).filter_map(on_object).sum::<f64>().max(0.0) / DT
        })
    }

    /// What goes where the hand goes, by index: the objects that it squeezes, and those that rest on them and on
    /// nothing else, as a lid does.
    pub(crate) fn carried(&self) -> BTreeSet<usize> {
        let squeezed = |entry: &Entry| self.grip_force(&entry.object.name).iter().all(|force| *force > 0.0);
        let mut carried: BTreeSet<usize> =
            (0..self.entries.len()).filter(|&index| squeezed(&self.entries[index])).collect();
        while let Some(next) = (0..self.entries.len()).find(|index| {
            let touched = || self.touched_by(*index);
            !carried.contains(index)
                && touched().any(|tag| matches!(tag, Tag::Object(other) if carried.contains(&other)))
                && touched().all(|tag| match tag {
                    Tag::Object(other) => carried.contains(&other),
                    Tag::Hand | Tag::Bead => true,
                    Tag::Table | Tag::Arm => false,
                })
        }) {
            carried.insert(next);
        }
        carried
    }

    /// Where a collider is by the pose of its body now. The engine's own pose of the collider is that of the last step.
    pub(crate) fn place_of(&self, collider: &Collider) -> EnginePose {
        let body = collider.parent().map(|body| *self.physics.bodies[body].position());
        body.zip(collider.position_wrt_parent()).map_or(*collider.position(), |(body, local)| body * *local)
    }

    /// What an object touches, other than itself.
    fn touched_by(&self, index: usize) -> impl Iterator<Item = Tag> + '_ {
        let colliders = self.physics.bodies[self.entries[index].body].colliders();
        let pairs = colliders.iter().flat_map(move |&collider| {
            self.physics.contact_pairs_with(collider).filter(|pair| pair.has_any_active_contact()).map(move |pair| {
                let other = if pair.collider1 == collider { pair.collider2 } else { pair.collider1 };
                Tag::decode(self.physics.colliders[other].user_data)
            })
        });
        pairs.filter(move |tag| *tag != Tag::Object(index))
    }

    /// Centres of all beads in metres, world frame, in the order in which they were put in.
    pub fn beads(&self) -> Vec<[f64; 3]> {
        let center = |&body: &RigidBodyHandle| from_engine_vector(self.physics.bodies[body].translation()).into();
        self.beads.iter().map(center).collect()
    }

    /// Poses of all beads, in the same order. A bead's rotation is that since it was put in.
    pub fn bead_poses(&self) -> Vec<Pose> {
        self.beads.iter().map(|&body| from_engine(self.physics.bodies[body].position())).collect()
    }

    /// How many beads have their centre inside the container, up to its rim; none if it is no container.
    pub fn beads_inside(&self, container: &str) -> Option<usize> {
        let interior = self.object(container)?.container?;
        let inverse = self.pose(container)?.inverse();
        let inside = |center: &[f64; 3]| interior.contains((inverse * Point3::from(*center)).coords.into(), 0.0);
        Some(self.beads().iter().filter(|center| inside(center)).count())
    }

    /// How far an object that slides is from the start of its range, in metres; none if it does not slide.
    pub fn slide_value(&self, object: &str) -> Option<f64> {
        self.guide(object).map(|guide| guide.value(&self.physics))
    }

    /// Length of the range of an object that slides, in metres; none if it does not slide.
    pub fn slide_travel(&self, object: &str) -> Option<f64> {
        self.guide(object).map(|guide| guide.travel)
    }

    /// How far an object that turns is from the start of its range, in radians; none if it has no hinge.
    pub fn hinge_value(&self, object: &str) -> Option<f64> {
        self.pivot(object).map(|pivot| pivot.value(&self.physics))
    }

    /// Length of the range of an object that turns, in radians; none if it has no hinge.
    pub fn hinge_travel(&self, object: &str) -> Option<f64> {
        self.pivot(object).map(|pivot| pivot.travel())
    }

    fn pivot(&self, object: &str) -> Option<&Pivot> {
        let child = *self.names.get(object)?;
        self.pivots.iter().find(|pivot| pivot.child == child)
    }

    fn guide(&self, object: &str) -> Option<&Guide> {
        let child = *self.names.get(object)?;
        self.guides.iter().find(|guide| guide.child == child)
    }

    /// The angles of the arm's joints in radians, from the mount to the hand; none without an arm.
    pub fn configuration(&self) -> Option<Configuration> {
        self.arm.as_ref().map(|arm| arm.configuration)
    }

    /// Whether two things touch. `table`, `hand` and `arm` are names, too.
    pub fn touching(&self, a: &str, b: &str) -> bool {
        let (first, second) = (self.colliders_of(a), self.colliders_of(b));
        first.iter().any(|&collider| {
            self.physics.contact_pairs_with(collider).any(|pair| {
                let other = if pair.collider1 == collider { pair.collider2 } else { pair.collider1 };
                second.contains(&other) && pair.has_any_active_contact()
            })
        })
    }

    pub(crate) fn colliders_of(&self, name: &str) -> Vec<ColliderHandle> {
        match name {
            TABLE => vec![self.table],
            HAND => self.hand.colliders().to_vec(),
            ARM => self.arm.as_ref().map(|arm| arm.colliders.clone()).unwrap_or_default(),
            _ => self.body(name).map(|body| self.physics.bodies[body].colliders().to_vec()).unwrap_or_default(),
        }
    }
}

/// Two things that are inside each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Overlap {
    /// The one that was added first.
    pub a: String,
    /// The other.
    pub b: String,
    /// How far one would have to move, at least, to be out of the other: metres.
    pub depth: f64,
}

/// A collider, and where it is.
struct Placed<'a> {
    collider: &'a Collider,
    tag: Tag,
    pose: EnginePose,
    bounds: Aabb,
}

impl World {
    /// The two things that are deepest inside each other, by more than `allowed` metres. Beads and marks are left out,
    /// and so are an object that slides and its parent. `table`, `hand` and `arm` are things, too.
    pub fn overlap(&self, allowed: f64) -> Option<Overlap> {
        let solid: Vec<Placed> =
            self.physics.colliders.iter().filter_map(|(_, collider)| self.placed(collider)).collect();
        let mut deepest: Option<(Tag, Tag, f64)> = None;
        for (index, one) in solid.iter().enumerate() {
            for other in &solid[index + 1..] {
                let (first, second) = if order(one.tag) <= order(other.tag) { (one, other) } else { (other, one) };
                let groups = [first, second].map(|placed| placed.collider.collision_groups());
                if first.tag == second.tag || !groups[0].test(groups[1]) || !first.bounds.intersects(&second.bounds) {
                    continue;
                }
                if self.is_joined(first.collider, second.collider) {
                    continue;
                }
                let [a, b] = [first, second].map(|placed| placed.collider.shape());
                let found = contact(&first.pose, a, &second.pose, b, 0.0);
                let depth = found.ok().flatten().map_or(0.0, |contact| -f64::from(contact.dist));
                if depth > allowed && deepest.is_none_or(|(_, _, most)| depth > most) {
                    deepest = Some((first.tag, second.tag, depth));
                }
            }
        }
        deepest.map(|(a, b, depth)| Overlap { a: self.name_of(a), b: self.name_of(b), depth })
    }

    /// A collider where its body is now. None for a bead.
    fn placed<'a>(&self, collider: &'a Collider) -> Option<Placed<'a>> {
        let tag = Tag::decode(collider.user_data);
        let pose = self.place_of(collider);
        (tag != Tag::Bead).then(|| Placed { collider, tag, pose, bounds: collider.shape().compute_aabb(&pose) })
    }

    /// Whether a joint of the engine keeps the two from colliding.
    fn is_joined(&self, first: &Collider, second: &Collider) -> bool {
        let bodies = [first.parent(), second.parent()];
        let joins = |one: RigidBodyHandle, other: RigidBodyHandle| bodies == [Some(one), Some(other)];
        if self.pivots.iter().any(|&Pivot { bodies: [one, other], .. }| joins(one, other) || joins(other, one)) {
            return true;
        }
        self.physics.impulse_joints.iter().any(|(_, joint)| {
            !joint.data.contacts_enabled && (joins(joint.body1(), joint.body2()) || joins(joint.body2(), joint.body1()))
        })
    }

    fn name_of(&self, tag: Tag) -> String {
        match tag {
            Tag::Table => TABLE.to_owned(),
            Tag::Object(index) => self.entries[index].object.name.clone(),
            Tag::Arm => ARM.to_owned(),
            Tag::Hand | Tag::Bead => HAND.to_owned(),
        }
    }
}

/// The table first, then the objects as they were added, then the hand and the arm.
fn order(tag: Tag) -> usize {
    match tag {
        Tag::Table => 0,
        Tag::Object(index) => index + 1,
        Tag::Hand | Tag::Bead => usize::MAX - 1,
        Tag::Arm => usize::MAX,
    }
}
