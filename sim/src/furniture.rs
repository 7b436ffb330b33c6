//! What things slide in: a cabinet and its drawer, the housing of a button.

use serde::{Deserialize, Serialize};

use crate::frame::{Pose, pose_at};
use crate::object::{Interior, Motion, Object, Part, Shape};

/// The carcass of a cabinet, open towards −x, on a solid base. Metres, kg/m³.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cabinet {
    /// Extent along x.
    pub depth: f64,
    /// Extent along y.
    pub width: f64,
    /// Extent along z.
    pub height: f64,
    /// Height of the base, below the opening.
    pub base: f64,
    /// Thickness of sides, back and top.
    pub wall: f64,
    /// Density.
    pub density: f64,
    /// Friction.
    pub friction: f64,
}

/// A drawer: an open box, a front panel towards −x, and a fin on it to take it by. Metres, kg/m³.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Drawer {
    /// Inner extent along x.
    pub inner_x: f64,
    /// Inner extent along y.
    pub inner_y: f64,
    /// Height of the rim above the base.
    pub height: f64,
    /// Thickness of walls and floor.
    pub wall: f64,
    /// Half of the front panel's thickness, width and height; its lower edge is at the base.
    pub panel_half: [f64; 3],
    /// Half extents of the fin, which stands upright before the middle of the panel.
    pub fin_half: [f64; 3],
    /// Height of the fin's centre above the base.
    pub fin_z: f64,
    /// Density.
    pub density: f64,
    /// Friction.
    pub friction: f64,
}

impl Object {
    /// A cabinet, fixed. Frame: the centre of its base.
    pub fn cabinet(name: impl Into<String>, cabinet: &Cabinet) -> Object {
        let Cabinet { depth, width, height, base, wall, density, friction } = *cabinet;
        let (half_x, half_y, half_wall) = (0.5 * depth, 0.5 * width, 0.5 * wall);
        let part = |half, x, y, z| Part::new(Shape::Cuboid { half }, Pose::translation(x, y, z), density, friction);
        let (half_z, middle) = (0.5 * (height - base - wall), 0.5 * (height - wall + base));
        let side = [half_x, half_wall, half_z];
        let parts = vec![
            part([half_x, half_y, 0.5 * base], 0.0, 0.0, 0.5 * base),
            part([half_x, half_y, half_wall], 0.0, 0.0, height - half_wall),
            part(side, 0.0, half_y - half_wall, middle),
            part(side, 0.0, half_wall - half_y, middle),
            part([half_wall, half_y - wall, half_z], half_x - half_wall, 0.0, middle),
        ];
        Object { name: name.into(), motion: Motion::Fixed, parts, color: [158, 128, 96], container: None }
    }

    /// A drawer. Frame: the centre of the base of its box.
    pub fn drawer(name: impl Into<String>, drawer: &Drawer) -> Object {
        let Drawer { inner_x, inner_y, height, wall, panel_half, fin_half, fin_z, density, friction } = *drawer;
        let (half_x, half_y, half_wall) = (0.5 * inner_x, 0.5 * inner_y, 0.5 * wall);
        let part = |half, at| Part::new(Shape::Cuboid { half }, pose_at(at, Default::default()), density, friction);
        let (half_z, middle) = (0.5 * (height - wall), 0.5 * (height + wall));
        let side = [half_x, half_wall, half_z];
        let panel_x = -half_x - panel_half[0];
        let parts = vec![
            part([half_x + half_wall, half_y + wall, half_wall], [half_wall, 0.0, half_wall]),
            part([half_wall, half_y + wall, half_z], [half_x + half_wall, 0.0, middle]),
            part(side, [0.0, half_y + half_wall, middle]),
            part(side, [0.0, -half_y - half_wall, middle]),
            part(panel_half, [panel_x, 0.0, panel_half[2]]),
            part(fin_half, [panel_x - panel_half[0] - fin_half[0], 0.0, fin_z]),
        ];
        let container = Some(Interior::Box { half_x, half_y, floor: wall, height });
        Object { name: name.into(), motion: Motion::Dynamic, parts, color: [198, 166, 120], container }
    }

    /// A box that something slides in, fixed: as a block, but for its frame. Frame: the centre of its *base*.
    pub fn housing(name: impl Into<String>, half: [f64; 3], density: f64, friction: f64) -> Object {
        let part = Part::new(Shape::Cuboid { half }, Pose::translation(0.0, 0.0, half[2]), density, friction);
        Object { name: name.into(), motion: Motion::Fixed, parts: vec![part], color: [118, 124, 132], container: None }
    }
}
