//! A world as it is seen: what conditions and features measure.

use nalgebra::Vector3;
use situ_sim::{Pose, World};

use crate::level::level;
use crate::sight::Sight;

/// The name by which conditions and features speak of the point between the finger tips (TCP).
pub const GRIPPER: &str = "gripper";

/// A world, the objects that fill its roles, and where a camera has seen things.
///
/// Without a camera everything is where it is. With one, a thing is where it was seen last, and one that has never been
/// seen is not there. What the hand feels and where it is are known in any case.
#[derive(Clone)]
pub struct View<'a> {
    world: &'a World,
    sight: Option<&'a Sight>,
    /// Each role with the object that fills it.
    filled: Vec<(&'a str, Option<&'a str>)>,
}

/// A world as it is, in which names are those of objects.
impl<'a> From<&'a World> for View<'a> {
    fn from(world: &'a World) -> View<'a> {
        View::new(world, None)
    }
}

impl<'a> View<'a> {
    /// A world as a camera has seen it, or as it is, in which names are those of objects.
    pub(crate) fn new(world: &'a World, sight: Option<&'a Sight>) -> View<'a> {
        View { world, sight, filled: Vec::new() }
    }

    /// The same in which names of roles stand for these objects.
    pub(crate) fn with_roles(self, filled: Vec<(&'a str, Option<&'a str>)>) -> View<'a> {
        View { filled, ..self }
    }

    /// The world itself.
    pub fn world(&self) -> &'a World {
        self.world
    }

    /// The object of a name: that one, or the one that fills the role of that name. None where nothing fills it.
    pub fn object(&self, name: &'a str) -> Option<&'a str> {
        self.filled.iter().find(|(role, _)| *role == name).map_or(Some(name), |(_, object)| *object)
    }

    /// Pose of an object's frame in the world, in metres. None if there is no such object, or it has not been seen.
    pub fn pose(&self, object: &str) -> Option<Pose> {
        self.sight.map_or_else(|| self.world.pose(object), |sight| sight.pose(object))
    }

    /// The same; of all poses that look alike, the canonical one.
    pub(crate) fn canonical_pose(&self, object: &str) -> Option<Pose> {
        let (pose, symmetry) = (self.pose(object)?, self.world.object(object)?.symmetry);
        Some(symmetry.map_or(pose, |symmetry| symmetry.canonical(&pose)))
    }

    /// Where the origin of an object, or the TCP of the gripper, is: metres, world frame.
    pub(crate) fn position(&self, name: &str) -> Option<Vector3<f64>> {
        if name == GRIPPER {
            return Some(self.world.tcp().translation.vector);
        }
        Some(self.pose(name)?.translation.vector)
    }

    /// The frame that keyframes on an object are relative to: the object's origin and heading, with z vertical. Poses
    /// that look alike have the same frame.
    pub(crate) fn reference_frame(&self, object: &str) -> Option<Pose> {
        Some(level(&self.pose(object)?, self.world.object(object)?.symmetry.as_ref()))
    }
}
