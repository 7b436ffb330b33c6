//! Lids: what closes a cup.

use serde::Deserialize;

use crate::convex::Convex;
use crate::frame::Pose;
use crate::object::{Object, Outline};
use crate::part::Part;
use crate::shape::number::{all_positive, positive};

/// Corners of the polygon that stands for a circle.
const ROUND_SIDES: u32 = 32;

/// A round lid: a flange that lies on the rim, a plug that reaches into the cup, a knob on top.
///
/// Frame: the centre of the *underside of its flange*. So its pose on a cup is the centre of the rim.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lid {
    /// Radius of the flange in metres.
    #[serde(deserialize_with = "positive")]
    pub flange_radius: f64,
    /// Thickness of the flange in metres.
    #[serde(deserialize_with = "positive")]
    pub flange_thickness: f64,
    /// Radius of the plug in metres. It must be at least 1 mm less than the cup's, or the lid jams.
    #[serde(deserialize_with = "positive")]
    pub plug_radius: f64,
    /// How far the plug reaches below the flange, in metres.
    #[serde(deserialize_with = "positive")]
    pub plug_depth: f64,
    /// Half extents of the knob in metres.
    #[serde(deserialize_with = "all_positive")]
    pub knob: [f64; 3],
    /// kg/m³.
    #[serde(deserialize_with = "positive")]
    pub density: f64,
    /// Coefficient of friction.
    pub friction: f64,
}

impl Lid {
    /// The lid as an object.
    pub fn object(&self, name: impl Into<String>) -> Object {
        let Lid { flange_radius, flange_thickness, plug_radius, plug_depth, knob, density, friction } = *self;
        let part = |shape, z| Part::new(shape, Pose::translation(0.0, 0.0, z), density, friction);
        let disc = |radius, thickness: f64| Convex::Prism { radius, half_height: 0.5 * thickness, sides: ROUND_SIDES };
        let parts = vec![
            part(disc(flange_radius, flange_thickness), 0.5 * flange_thickness),
            part(disc(plug_radius, plug_depth), -0.5 * plug_depth),
            part(Convex::Cuboid { half: knob }, flange_thickness + knob[2]),
        ];
        let outline = Outline { top: flange_thickness, reach: flange_radius };
        Object::new(name, parts, outline).with_color([222, 184, 96])
    }
}
