//! What stands on the table: a named body made of convex parts.

use serde::{Deserialize, Serialize};

use crate::error::SimError;
use crate::interior::Interior;
use crate::part::Part;

/// The most parts that an object may have: a cup of 64 walls with floor and handle.
const MAX_PARTS: usize = 72;

/// Whether an object can be moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mobility {
    /// It stays where it is put.
    Fixed,
    /// It moves by forces.
    Dynamic,
}

/// The outline of an object in its frame: what it takes to say that another object is on it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Outline {
    /// Height of the upper face above the origin, in metres: a rim, the plate of a cover, the top of a block.
    pub top: f64,
    /// Radius of the circle about the z axis that holds the object without its handle, in metres.
    pub reach: f64,
}

/// A named body on the table. A [`crate::Shape`] makes one.
///
/// The frame's origin is at the *centre* of blocks, cylinders and balls, at the centre of the *base* of containers,
/// furniture and marks, and at the centre of the *underside of the flange or plate* of lids and covers. So a keyframe
/// relative to an object says how high above its base, not above its rim.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// Its name, unique in the world.
    pub name: String,
    /// Whether it can be moved.
    pub mobility: Mobility,
    /// The convex pieces it is made of.
    pub parts: Vec<Part>,
    /// Its colour in pictures: red, green, blue.
    pub color: [u8; 3],
    /// The room inside, if it is a container.
    pub container: Option<Interior>,
    /// What another object can be on.
    pub outline: Outline,
}

impl Object {
    /// A brick-red object that moves by forces and is no container.
    pub fn new(name: impl Into<String>, parts: Vec<Part>, outline: Outline) -> Object {
        let (mobility, color) = (Mobility::Dynamic, [201, 76, 60]);
        Object { name: name.into(), mobility, parts, color, container: None, outline }
    }

    /// The same object in another colour.
    pub fn with_color(self, color: [u8; 3]) -> Object {
        Object { color, ..self }
    }

    /// The same object as a container.
    pub fn with_room(self, room: Interior) -> Object {
        Object { container: Some(room), ..self }
    }

    /// The same object, immovable: a stand, a bin screwed to the table.
    pub fn fixed(self) -> Object {
        Object { mobility: Mobility::Fixed, ..self }
    }

    /// Says what is wrong with the description, if anything.
    pub(crate) fn check(&self) -> Result<(), SimError> {
        let refuse = |what, value| Err(SimError::BadValue { object: self.name.clone(), what, value });
        let count = self.parts.len();
        if !(1..=MAX_PARTS).contains(&count) {
            return refuse("it must have 1 to 72 parts (a cup has 3 to 64 sides)", count as f64);
        }
        self.parts.iter().try_for_each(|part| part.check(&self.name))?;
        if self.mobility == Mobility::Dynamic && !self.parts.iter().any(|part| part.solid && part.density > 0.0) {
            return refuse("a dynamic object needs a solid part of positive density", 0.0);
        }
        self.container.as_ref().map_or(Ok(()), |interior| interior.check(&self.name))
    }
}
