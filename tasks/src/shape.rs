//! The objects of a task: from the words of the file to bodies of the physics.

use std::collections::BTreeMap;

use situ_sim::{Bin, Cabinet, Cover, Cup, Drawer, Handle, Lid, Object, Part, Pose, Shape};

use crate::file::{HandleFile, ObjectFile, ShapeFile};
use crate::key::Key;

/// The outline of an object: what it takes to say that another one is on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Size {
    /// Height of its upper face above its origin, in metres: a rim, the plate of a cover, the top of a block.
    pub top: f64,
    /// Radius of the circle about its axis that holds its outline (without a handle), in metres.
    pub reach: f64,
}

/// The outlines of the objects of a setting, by name.
pub type Sizes = BTreeMap<String, Size>;

/// The body of an object, and its outline.
pub(crate) fn body(object: &ObjectFile) -> (Object, Size) {
    let name = object.name.clone();
    let (body, top, reach) = match &object.shape {
        ShapeFile::Block { half, density, friction } => {
            (Object::block(name, *half, *density, *friction), half[2], libm::hypot(half[0], half[1]))
        }
        ShapeFile::Cylinder { radius, height, density, friction } => {
            let shape = Shape::Cylinder { radius: *radius, half_height: 0.5 * height };
            (single(name, shape, *density, *friction), 0.5 * height, *radius)
        }
        ShapeFile::Ball { radius, density, friction } => {
            (single(name, Shape::Ball { radius: *radius }, *density, *friction), *radius, *radius)
        }
        ShapeFile::Cup { inner_radius, height, wall, flare, density, friction, sides, handle } => {
            let cup = Cup {
                inner_radius: *inner_radius,
                height: *height,
                wall: *wall,
                flare: *flare,
                density: *density,
                friction: *friction,
                sides: *sides,
            };
            let reach = inner_radius + wall + height * libm::tan(*flare);
            (Object::cup(name, &cup, handle.as_ref().map(handle_of).as_ref()), *height, reach)
        }
        ShapeFile::Bin { inner, height, wall, density, friction } => {
            let bin = Bin {
                inner_x: inner[0],
                inner_y: inner[1],
                height: *height,
                wall: *wall,
                density: *density,
                friction: *friction,
            };
            (Object::bin(name, &bin), *height, libm::hypot(0.5 * inner[0] + wall, 0.5 * inner[1] + wall))
        }
        ShapeFile::Lid { flange_radius, flange_thickness, plug_radius, plug_depth, knob, density, friction } => {
            let lid = Lid {
                flange_radius: *flange_radius,
                flange_thickness: *flange_thickness,
                plug_radius: *plug_radius,
                plug_depth: *plug_depth,
                knob_half: *knob,
                density: *density,
                friction: *friction,
            };
            (Object::lid(name, &lid), *flange_thickness, *flange_radius)
        }
        ShapeFile::Cover { half, thickness, knob, density, friction } => {
            let cover = Cover {
                half_x: half[0],
                half_y: half[1],
                thickness: *thickness,
                knob_half: *knob,
                density: *density,
                friction: *friction,
            };
            (Object::cover(name, &cover), *thickness, libm::hypot(half[0], half[1]))
        }
        ShapeFile::Mat { half } => (Object::mat(name, half[0], half[1]), 0.0, libm::hypot(half[0], half[1])),
        ShapeFile::Cabinet { size, base, wall, density, friction } => {
            let [depth, width, height] = *size;
            let (base, wall, density, friction) = (*base, *wall, *density, *friction);
            let cabinet = Cabinet { depth, width, height, base, wall, density, friction };
            (Object::cabinet(name, &cabinet), height, libm::hypot(0.5 * depth, 0.5 * width))
        }
        ShapeFile::Drawer { inner, height, wall, panel, fin, fin_z, density, friction } => {
            let drawer = Drawer {
                inner_x: inner[0],
                inner_y: inner[1],
                height: *height,
                wall: *wall,
                panel_half: *panel,
                fin_half: *fin,
                fin_z: *fin_z,
                density: *density,
                friction: *friction,
            };
            (Object::drawer(name, &drawer), *height, libm::hypot(0.5 * inner[0], 0.5 * inner[1]))
        }
        ShapeFile::Housing { half, density, friction } => {
            (Object::housing(name, *half, *density, *friction), 2.0 * half[2], libm::hypot(half[0], half[1]))
        }
    };
    let body = if object.fixed { body.fixed() } else { body };
    let body = if let Some(color) = object.color { body.with_color(color) } else { body };
    (body, Size { top, reach })
}

/// A body of one convex part. Frame: the centre.
fn single(name: String, shape: Shape, density: f64, friction: f64) -> Object {
    let block = Object::block(name, [1.0; 3], density, friction);
    Object { parts: vec![Part::new(shape, Pose::identity(), density, friction)], ..block }
}

fn handle_of(handle: &HandleFile) -> Handle {
    Handle {
        center: handle.center,
        half: handle.half,
        struts: handle.struts.clone(),
        strut_half: handle.strut_half,
        density: handle.density,
        friction: handle.friction,
    }
}

/// The numbers of a shape that must be positive, with the keys they stand at.
pub(crate) fn positive_numbers(shape: &ShapeFile, key: &Key) -> Vec<(Key, f64)> {
    let mut numbers = Vec::new();
    let mut list = |key: &Key, fields: &[(&str, f64)]| {
        numbers.extend(fields.iter().map(|(name, value)| (key.field(name), *value)));
    };
    match shape {
        ShapeFile::Block { half, density, .. } => {
            let key = key.field("block");
            list(&key, &[("half", half[0]), ("half", half[1]), ("half", half[2]), ("density", *density)]);
        }
        ShapeFile::Cylinder { radius, height, density, .. } => {
            list(&key.field("cylinder"), &[("radius", *radius), ("height", *height), ("density", *density)]);
        }
        ShapeFile::Ball { radius, density, .. } => {
            list(&key.field("ball"), &[("radius", *radius), ("density", *density)]);
        }
        ShapeFile::Cup { inner_radius, height, wall, density, handle, .. } => {
            let key = key.field("cup");
            list(&key, &[("inner_radius", *inner_radius), ("height", *height), ("wall", *wall), ("density", *density)]);
            if let Some(HandleFile { half, strut_half, density, .. }) = handle {
                let key = key.field("handle");
                list(&key, &[("half", half[0]), ("half", half[1]), ("half", half[2]), ("density", *density)]);
                list(&key, &[("strut_half", strut_half[0]), ("strut_half", strut_half[1])]);
            }
        }
        ShapeFile::Bin { inner, height, wall, density, .. } => {
            let key = key.field("bin");
            list(&key, &[("inner", inner[0]), ("inner", inner[1]), ("height", *height)]);
            list(&key, &[("wall", *wall), ("density", *density)]);
        }
        ShapeFile::Lid { flange_radius, flange_thickness, plug_radius, plug_depth, knob, density, .. } => {
            let key = key.field("lid");
            list(&key, &[("flange_radius", *flange_radius), ("flange_thickness", *flange_thickness)]);
            list(&key, &[("plug_radius", *plug_radius), ("plug_depth", *plug_depth), ("density", *density)]);
            list(&key, &[("knob", knob[0]), ("knob", knob[1]), ("knob", knob[2])]);
        }
        ShapeFile::Cover { half, thickness, knob, density, .. } => {
            let key = key.field("cover");
            list(&key, &[("half", half[0]), ("half", half[1]), ("thickness", *thickness), ("density", *density)]);
            list(&key, &[("knob", knob[0]), ("knob", knob[1]), ("knob", knob[2])]);
        }
        ShapeFile::Mat { half } => list(&key.field("mat"), &[("half", half[0]), ("half", half[1])]),
        ShapeFile::Cabinet { size, base, wall, density, .. } => {
            let key = key.field("cabinet");
            list(&key, &[("size", size[0]), ("size", size[1]), ("size", size[2])]);
            list(&key, &[("base", *base), ("wall", *wall), ("density", *density)]);
        }
        ShapeFile::Drawer { inner, height, wall, panel, fin, density, .. } => {
            let key = key.field("drawer");
            list(&key, &[("inner", inner[0]), ("inner", inner[1]), ("height", *height), ("wall", *wall)]);
            list(&key, &[("panel", panel[0]), ("panel", panel[1]), ("panel", panel[2])]);
            list(&key, &[("fin", fin[0]), ("fin", fin[1]), ("fin", fin[2]), ("density", *density)]);
        }
        ShapeFile::Housing { half, density, .. } => {
            let key = key.field("housing");
            list(&key, &[("half", half[0]), ("half", half[1]), ("half", half[2]), ("density", *density)]);
        }
    }
    numbers
}
