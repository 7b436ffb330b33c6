//! Measurements of a world, for conditions and features. An object that is not there has none.

use nalgebra::Vector3;
use situ_sim::{Convex, Part, Pose, TABLE, World};

use crate::view::{GRIPPER, View};

/// An object is held when both fingers press on it with at least this force, in newtons. One finger that touches by
/// accident is no grasp, and a grasp squeezes with 10 N or more.
pub const HELD_FORCE: f64 = 1.0;
/// An object stands still below this speed, in m/s: a fall of one millimetre reaches 0.14 m/s.
pub const REST_SPEED: f64 = 0.05;
/// How far the origin of an object may be below the top of what it is on, in metres: contacts give, and so does a plug
/// in a rim.
pub const ON_SLACK: f64 = 0.005;
/// How far the origin of an object must be below the rim of what it is inside, in metres. The origin of a lid lies at
/// the rim that the lid is on, and contacts give.
const INSIDE_MARGIN: f64 = 0.001;

/// Whether both fingers press on the object, from either side.
pub(crate) fn is_held(world: &World, object: &str) -> bool {
    world.grip_force(object).iter().all(|&force| force >= HELD_FORCE)
}

/// Whether `a` touches `b`, and in the frame of `b` the origin of `a` is within its outline and not lower than its top.
/// The outline is the circle and the rectangle that hold it, both. The table has no other frame than the world's.
pub(crate) fn is_on(view: &View<'_>, a: &str, b: &str) -> Option<bool> {
    if b == TABLE {
        // What touches the table and is not lower than its top has nowhere else to be.
        return Some(view.position(a)?.z >= -ON_SLACK && view.world().touching(a, b));
    }
    let (place, base) = (place_in(view, a, b)?, view.world().object(b)?);
    Some(
        view.world().touching(a, b)
            && place.z >= base.outline.top - ON_SLACK
            && place.xy().norm() <= base.outline.reach
            && is_within_rectangle(&base.parts, &place),
    )
}

/// Whether the origin of `a` is in the room of the container `b`, a millimetre or more below its rim.
pub(crate) fn is_inside(view: &View<'_>, a: &str, b: &str) -> Option<bool> {
    let room = view.world().object(b)?.container?;
    Some(room.contains(place_in(view, a, b)?.into(), -INSIDE_MARGIN))
}

/// Whether `a` has been put down at the place `b`: at most `limit` metres from it in the plane, still, and not held.
pub(crate) fn is_put_down(view: &View<'_>, a: &str, b: &str, limit: f64) -> Option<bool> {
    let apart = (view.position(a)? - view.position(b)?).xy().norm();
    let world = view.world();
    Some(apart <= limit && world.speed(a)? <= REST_SPEED && !is_held(world, a))
}

/// The distance of two origins, or of an origin and the TCP of the gripper, in metres.
pub(crate) fn distance(view: &View<'_>, a: &str, b: &str) -> Option<f64> {
    Some((view.position(a)? - view.position(b)?).norm())
}

/// The origin of `a` in the full frame of `b`, which turns and tilts with `b`: metres. Either may be the gripper.
pub(crate) fn offset(view: &View<'_>, a: &str, b: &str) -> Option<[f64; 3]> {
    let frame = if b == GRIPPER { view.world().tcp() } else { view.canonical_pose(b)? };
    Some(offset_in(&frame, &view.position(a)?))
}

/// A position of the world in a frame: metres.
pub(crate) fn offset_in(frame: &Pose, position: &Vector3<f64>) -> [f64; 3] {
    (frame.rotation.inverse() * (position - frame.translation.vector)).into()
}

/// The angle between the z axis of an object and the vertical, in radians.
pub(crate) fn tilt(view: &View<'_>, object: &str) -> Option<f64> {
    Some(tilt_of(&view.canonical_pose(object)?))
}

/// The angle between the z axis of a pose and the vertical, in radians.
pub(crate) fn tilt_of(pose: &Pose) -> f64 {
    let axis = pose.rotation * Vector3::z();
    libm::acos(axis.z.clamp(-1.0, 1.0))
}

/// The fraction of all beads that is in the container. It is 0 in a world without beads.
pub(crate) fn fill(view: &View<'_>, container: &str) -> Option<f64> {
    let (inside, all) = (view.world().beads_inside(container)?, view.world().beads().len());
    Some(if all == 0 { 0.0 } else { inside as f64 / all as f64 })
}

/// The origin of `a` in the frame of `b`, by the product of their poses: metres.
fn place_in(view: &View<'_>, a: &str, b: &str) -> Option<Vector3<f64>> {
    Some((view.pose(b)?.inverse() * view.pose(a)?).translation.vector)
}

/// Whether a place in the frame of an object is above or below the upright rectangle that holds the object's parts. The
/// circle about a plank alone would hold places beside its long sides, where nothing can lie on it.
fn is_within_rectangle(parts: &[Part], place: &Vector3<f64>) -> bool {
    [0, 1].iter().all(|&axis| {
        let ends = parts.iter().map(|part| extent(part, axis));
        let (low, high) = ends
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (least, most)| (low.min(least), high.max(most)));
        (low..=high).contains(&place[axis])
    })
}

/// From where to where a part reaches along an axis of its object, in metres.
fn extent(part: &Part, axis: usize) -> (f64, f64) {
    let (turn, middle) = (part.pose.rotation.to_rotation_matrix(), part.pose.translation.vector[axis]);
    let along = |half: [f64; 3]| (0..3).map(|k| turn[(axis, k)].abs() * half[k]).sum();
    let half: f64 = match part.shape {
        Convex::Cuboid { half } => along(half),
        Convex::Ball { radius } => radius,
        // The box about it.
        Convex::Cylinder { radius, half_height } | Convex::Prism { radius, half_height, .. } => {
            along([radius, radius, half_height])
        }
        Convex::Hull { ref corners } => {
            let places = corners.iter().map(|corner| middle + (0..3).map(|k| turn[(axis, k)] * corner[k]).sum::<f64>());
            return places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        }
    };
    (middle - half, middle + half)
}
