//! Where things start: objects in regions, and the hand.

use serde::Deserialize;
use situ_sim::Object;

/// Where an object starts: anywhere in a region, all places equally likely.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// The object in whose frame the region is. None: the frame of the world.
    pub on: Option<String>,
    /// Least and largest x of the object's origin, in metres.
    pub x: [f64; 2],
    /// Least and largest y of the object's origin, in metres.
    pub y: [f64; 2],
    /// Height of the object's origin, in metres.
    #[serde(default)]
    pub z: f64,
    /// Least and largest turn about z, in radians.
    #[serde(default)]
    pub yaw: [f64; 2],
    /// Least distance of the origin from those of all objects listed before, in the plane, in metres.
    pub apart: Option<f64>,
    /// Least and largest factor of the object's mass, drawn anew at each start, all equally likely. None: its own mass.
    pub mass: Option<[f64; 2]>,
    /// Least and largest factor of its coefficients of friction, in the same way.
    pub friction: Option<[f64; 2]>,
}

/// An object, and where it starts.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// Its body.
    pub body: Object,
    /// Where it starts.
    pub start: Start,
}

/// Where the hand starts.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandStart {
    /// Position of the TCP in the world, in metres; the hand points straight down.
    pub at: [f64; 3],
    /// Metres between the pads.
    pub open: f64,
}
