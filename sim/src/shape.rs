//! The kinds of objects, with their dimensions: read as they stand in a task's file, and built from convex parts.
//!
//! Metres, radians, kg/m³. A new kind is a struct in a file below this one, and a variant here.

mod container;
mod mesh;
mod number;
mod solid;

use serde::Deserialize;

pub use container::{Bin, Cup, Drawer, Handle};
pub use mesh::{Corners, Mesh, MeshFormat};
pub use solid::{Block, Cabinet, Cover, Cylinder, Housing, Lid, Mat, Panel, Sphere};

use crate::object::Object;

/// The kind of an object with its dimensions. A file names it by its variant in small letters: `shape.block = { half =
/// [0.02, 0.02, 0.02], density = 1000, friction = 0.6 }`. Unknown keys are refused, and so are dimensions and densities
/// that are not more than 0.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// A cuboid.
    Block(Block),
    /// A cylinder that stands upright.
    Cylinder(Cylinder),
    /// A ball.
    Ball(Sphere),
    /// A round container, with or without a handle.
    Cup(Cup),
    /// An open box.
    Bin(Bin),
    /// What closes a cup.
    Lid(Lid),
    /// A flat plate with a knob.
    Cover(Cover),
    /// A mark on the table.
    Mat(Mat),
    /// What a drawer slides in.
    Cabinet(Cabinet),
    /// What slides in a cabinet.
    Drawer(Drawer),
    /// What a button slides in.
    Housing(Housing),
    /// A plate with a bar: a door, the lid of a box, a lever.
    Panel(Panel),
    /// What a file of triangles shows.
    Mesh(Mesh),
}

impl Shape {
    /// The object of this kind and this name.
    pub fn object(&self, name: impl Into<String>) -> Object {
        match self {
            Shape::Block(shape) => shape.object(name),
            Shape::Cylinder(shape) => shape.object(name),
            Shape::Ball(shape) => shape.object(name),
            Shape::Cup(shape) => shape.object(name),
            Shape::Bin(shape) => shape.object(name),
            Shape::Lid(shape) => shape.object(name),
            Shape::Cover(shape) => shape.object(name),
            Shape::Mat(shape) => shape.object(name),
            Shape::Cabinet(shape) => shape.object(name),
            Shape::Drawer(shape) => shape.object(name),
            Shape::Housing(shape) => shape.object(name),
            Shape::Panel(shape) => shape.object(name),
            Shape::Mesh(shape) => shape.object(name),
        }
    }
}
