//! What a profile says of a way of erring: how often, and how much where it has a size.

use serde::Deserialize;

/// A size of an error, as it stands in a profile.
pub(crate) struct Size {
    /// Its key, below that of the error.
    pub(crate) key: &'static str,
    pub(crate) value: f64,
    pub(crate) unit: &'static str,
    /// The greatest value that is allowed.
    pub(crate) most: f64,
}

/// What stands at the key of a way of erring.
pub(crate) trait Extent {
    /// The share of keyframes, skills or corrections that are erred in, from 0 to 1.
    fn rate(&self) -> f64;

    /// The key of the rate, below that of the error. None where the rate stands alone.
    fn rate_key(&self) -> Option<&'static str> {
        Some("rate")
    }

    /// How much, where it has a size.
    fn size(&self) -> Option<Size>;
}

/// A rate alone.
impl Extent for f64 {
    fn rate(&self) -> f64 {
        *self
    }

    fn rate_key(&self) -> Option<&'static str> {
        None
    }

    fn size(&self) -> Option<Size> {
        None
    }
}

/// Pauses to think.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pause {
    /// Share of keyframes with a pause.
    pub rate: f64,
    /// The length of a pause, simulated seconds.
    pub seconds: f64,
}

impl Extent for Pause {
    fn rate(&self) -> f64 {
        self.rate
    }

    fn size(&self) -> Option<Size> {
        Some(Size { key: "seconds", value: self.seconds, unit: "seconds", most: 60.0 })
    }
}

/// Excursions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Detour {
    /// Share of keyframes before which there is one.
    pub rate: f64,
    /// How far it leads away from the middle of the way, in metres: sideways or up, never down.
    pub reach: f64,
}

impl Extent for Detour {
    fn rate(&self) -> f64 {
        self.rate
    }

    fn size(&self) -> Option<Size> {
        Some(Size { key: "reach", value: self.reach, unit: "metres", most: 1.0 })
    }
}

/// A gripper that is not aligned with what it takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Misaligned {
    /// Share of skills that are performed so.
    pub rate: f64,
    /// The turn of the gripper about its own z axis, either way, in degrees.
    pub turn: f64,
}

impl Extent for Misaligned {
    fn rate(&self) -> f64 {
        self.rate
    }

    fn size(&self) -> Option<Size> {
        Some(Size { key: "turn", value: self.turn, unit: "degrees", most: 180.0 })
    }
}

/// The sizes of what is off in position, metres, and in rotation, degrees.
fn sizes(position: f64, rotation: f64) -> [Size; 2] {
    [
        Size { key: "position", value: position, unit: "metres", most: 1.0 },
        Size { key: "rotation", value: rotation, unit: "degrees", most: 180.0 },
    ]
}

/// How differently one person takes hold of one thing. It always happens, so it has no rate.
///
/// A grasp is off along the two axes across the gripper's own z axis and turned about it, by Student's t of so many
/// degrees of freedom: few of them make heavy tails. The three share their denominator, as in the multivariate t.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// The scale along either axis, metres.
    pub position: f64,
    /// The scale of the turn, degrees.
    pub rotation: f64,
    /// Degrees of freedom, from 1.
    pub freedom: u8,
}

impl Spread {
    pub(crate) fn sizes(&self) -> [Size; 2] {
        sizes(self.position, self.rotation)
    }
}

/// Gaussian noise on a pose, one standard deviation for each axis. It always happens, so it has no rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Noise {
    /// Metres.
    pub position: f64,
    /// Degrees, of the rotation vector.
    pub rotation: f64,
}

impl Noise {
    pub(crate) fn sizes(&self) -> [Size; 2] {
        sizes(self.position, self.rotation)
    }
}
