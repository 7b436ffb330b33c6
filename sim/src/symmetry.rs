//! Symmetry of an object about an axis: the turns after which it is as it was before.

use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::error::{SimError, within};
use crate::frame::{Pose, rotation_about};

/// The most turns of a symmetry of few. A thing of more looks round.
const MOST_FOLD: u32 = 360;
/// An axis that points so far away from where it points in a reference is upside down: the cosine of 135°. Little
/// rests at such an angle.
const UPSIDE_DOWN: f64 = -core::f64::consts::FRAC_1_SQRT_2;

/// An axis about which an object can be turned, and then looks as before.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Symmetry {
    /// The axis, through the origin of the object's frame (any length but zero); z where none is given.
    #[serde(default = "upright")]
    pub axis: [f64; 3],
    /// How many turns of equal size go round: 2 for half a turn, 4 for a square. None: any turn, the thing is round.
    pub fold: Option<u32>,
}

fn upright() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

impl Symmetry {
    /// Says what is wrong with the numbers, if anything.
    pub(crate) fn check(&self, object: &str) -> Result<(), SimError> {
        let length = Vector3::from(self.axis).norm();
        within(object, "an axis of symmetry must not be zero", &[length], 1e-6, f64::MAX)?;
        let fold = f64::from(self.fold.unwrap_or(MOST_FOLD));
        within(object, "the fold of a symmetry must be 2 to 360", &[fold], 2.0, f64::from(MOST_FOLD))
    }

    /// The direction of the axis, of unit length, in the object's frame.
    pub fn direction(&self) -> Vector3<f64> {
        Vector3::from(self.axis).normalize()
    }

    /// Of all rotations of an object that look like this one, the one that is nearest to another rotation.
    ///
    /// Round things lose their turn about the axis. Where the axis points the other way round than in `to`, the nearest
    /// to `to` upside down is taken, because to `to` itself all are equally far.
    pub fn nearest(&self, rotation: &UnitQuaternion<f64>, to: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        let axis = self.direction();
        let is_over = (rotation * axis).dot(&(to * axis)) < UPSIDE_DOWN;
        let to = if is_over { to * rotation_about(across(&axis), core::f64::consts::PI) } else { *to };
        let apart = to.inverse() * rotation;
        let along = apart.imag().dot(&axis);
        let round = -2.0 * libm::atan2(along, apart.scalar());
        let turn = match self.fold {
            None => round,
            Some(fold) => {
                let part = core::f64::consts::TAU / f64::from(fold);
                part * libm::round(round / part)
            }
        };
        rotation * rotation_about(axis.into(), turn)
    }

    /// A pose of the object that looks like this one, and is the same for all that do: with the rotation that is
    /// nearest to the world's axes.
    pub fn canonical(&self, pose: &Pose) -> Pose {
        Pose::from_parts(pose.translation, self.nearest(&pose.rotation, &UnitQuaternion::identity()))
    }
}

/// A direction across an axis: always the same for the same axis.
fn across(axis: &Vector3<f64>) -> [f64; 3] {
    let least = (0..3).min_by(|&a, &b| axis[a].abs().total_cmp(&axis[b].abs())).unwrap_or(0);
    let mut other = Vector3::zeros();
    other[least] = 1.0;
    (other - axis * axis[least]).into()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::frame::pose_at;

    /// A rotation by a rotation vector.
    fn by(vector: [f64; 3]) -> UnitQuaternion<f64> {
        rotation_about(vector, Vector3::from(vector).norm())
    }

    proptest! {
        /// Whatever turn of the symmetry comes first, the canonical rotation is the same; and it is one of those that
        /// look alike, and none of them is nearer to the world's axes (up to the upside-down rule).
        #[test]
        fn turned_things_have_one_frame(
            vector in prop::array::uniform3(-2.0..2.0),
            axis in prop::array::uniform3(-1.0..1.0),
            fold in prop::option::of(2_u32..9),
            turns in 0_u32..9,
            angle in -7.0..7.0,
        ) {
            prop_assume!(Vector3::from(axis).norm() > 0.1);
            let symmetry = Symmetry { axis, fold };
            let rotation = by(vector);
            let turn = fold.map_or(angle, |fold| core::f64::consts::TAU * f64::from(turns) / f64::from(fold));
            let turned = rotation * rotation_about(axis, turn);
            let identity = UnitQuaternion::identity();
            let [one, other] = [rotation, turned].map(|rotation| symmetry.nearest(&rotation, &identity));
            // Half-way between two turns of few, rounding decides.
            let is_clear = fold.is_none_or(|fold| {
                let part = core::f64::consts::TAU / f64::from(fold);
                let alike = (0..fold).map(|k| (one * rotation_about(axis, part * f64::from(k))).angle());
                let mut angles: Vec<f64> = alike.collect();
                angles.sort_by(f64::total_cmp);
                angles[1] - angles[0] > 1e-6
            });
            prop_assume!(is_clear);
            prop_assert!(one.angle_to(&other) < 1e-6, "{one} {other}");
            let direction = symmetry.direction();
            prop_assert!(((one * direction) - (rotation * direction)).norm() < 1e-9, "the axis stays");
            if (rotation * direction).dot(&direction) >= UPSIDE_DOWN {
                for k in 0..fold.unwrap_or(36) {
                    let part = core::f64::consts::TAU / f64::from(fold.unwrap_or(36));
                    let alike = rotation * rotation_about(axis, part * f64::from(k));
                    prop_assert!(one.angle() <= alike.angle() + 1e-6, "{} is nearer", alike.angle());
                }
            }
        }
    }

    #[test]
    fn a_round_cup_that_stands_has_no_heading() {
        let round = Symmetry { axis: [0.0, 0.0, 2.0], fold: None };
        let square = Symmetry { fold: Some(4), ..round };
        for yaw in [-3.0, -0.4, 0.0, 1.0, 2.5] {
            let pose = pose_at([0.1, 0.2, 0.3], rotation_about([0.0, 0.0, 1.0], yaw));
            assert!(
                (round.canonical(&pose).to_homogeneous() - pose_at([0.1, 0.2, 0.3], by([0.0; 3])).to_homogeneous())
                    .norm()
                    < 1e-9
            );
            assert!(square.canonical(&pose).rotation.angle() <= core::f64::consts::FRAC_PI_4 + 1e-9);
        }
    }
}
