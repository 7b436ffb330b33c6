//! How well a camera sees: `[perception]`.

use super::check::Builder;
use crate::error::TaskError;
use crate::key::KeyPath;
use crate::sight::Perception;

/// The largest standard deviation of a position, in metres. With more, a cube of 4 cm may be seen beside its neighbour.
const MOST_POSITION: f64 = 0.1;
/// The largest standard deviation of a rotation, in radians.
const MOST_ROTATION: f64 = 0.5;
/// The furthest that a camera may be from the middle of the table, in metres, and the nearest to the table.
const FURTHEST: f64 = 5.0;
const LOWEST: f64 = 0.05;

impl Builder<'_> {
    pub(super) fn perception(&self, root: &KeyPath) -> Result<Option<Perception>, TaskError> {
        let Some(perception) = self.file.perception else { return Ok(None) };
        let key = root.field("perception");
        for (field, value, most, unit) in [
            ("position", perception.position, MOST_POSITION, "metres"),
            ("rotation", perception.rotation, MOST_ROTATION, "radians"),
        ] {
            if !(0.0..=most).contains(&value) {
                return self.wrong(&key.field(field), format!("{value}: expected a deviation of 0 to {most} {unit}"));
            }
        }
        match perception.eye {
            Some(eye) if eye[2] < LOWEST || nalgebra::Vector3::from(eye).norm() > FURTHEST => {
                let expected =
                    format!("expected a place {LOWEST} m or more above the table, and {FURTHEST} m away at most");
                self.wrong(&key.field("eye"), expected)
            }
            None if perception.position == 0.0 && perception.rotation == 0.0 => {
                self.wrong(&key, "nothing is seen in another way than it is; expected `position`, `rotation` or `eye`")
            }
            _ => Ok(Some(perception)),
        }
    }
}
