//! Things that are inside each other: a scene that the physics would burst apart.

use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::parry::query::contact;
use rapier3d::prelude::{Collider, Pose as EnginePose, RigidBodyHandle};

use crate::tag::{ARM, HAND, TABLE, Tag};
use crate::world::World;

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
