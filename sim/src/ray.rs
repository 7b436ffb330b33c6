//! Where a ray meets a collider.

use rapier3d::geometry::{Collider, Ray};
use rapier3d::math::{Real, Vector};

/// Distance along the ray (in lengths of its direction) and the outward normal where it first meets the collider, up to `far`.
///
/// The engine searches for the meeting point on a cylinder by iteration, which leaves dents in a picture; here it is in closed form.
pub(crate) fn meet(collider: &Collider, ray: &Ray, far: Real) -> Option<(Real, Vector)> {
    let Some(cylinder) = collider.shape().as_cylinder() else {
        return collider
            .shape()
            .cast_ray_and_get_normal(collider.position(), ray, far, true)
            .map(|meeting| (meeting.time_of_impact, meeting.normal));
    };
    let pose = collider.position();
    let (o, d) = (pose.inverse_transform_point(ray.origin), pose.inverse_transform_vector(ray.dir));
    let (t, normal) = meet_cylinder(o, d, cylinder.radius, cylinder.half_height)?;
    (t <= far).then(|| (t, pose.transform_vector(normal)))
}

/// The ray `o + t d` against a cylinder about y; the far wall if the ray starts inside.
fn meet_cylinder(o: Vector, d: Vector, radius: Real, half_height: Real) -> Option<(Real, Vector)> {
    let mut best: Option<(Real, Vector)> = None;
    let mut offer = |t: Real, normal: Vector| {
        if t >= 0.0 && best.is_none_or(|(so_far, _)| t < so_far) {
            best = Some((t, normal));
        }
    };
    let a = d.x * d.x + d.z * d.z;
    let b = o.x * d.x + o.z * d.z;
    let c = o.x * o.x + o.z * o.z - radius * radius;
    let discriminant = b * b - a * c;
    if a > 0.0 && discriminant >= 0.0 {
        let root = libm::sqrtf(discriminant);
        for t in [(-b - root) / a, (-b + root) / a] {
            let point = o + d * t;
            if point.y.abs() <= half_height {
                offer(t, Vector::new(point.x, 0.0, point.z) / radius);
            }
        }
    }
    if d.y != 0.0 {
        for side in [-1.0, 1.0] {
            let t = (side * half_height - o.y) / d.y;
            let point = o + d * t;
            if point.x * point.x + point.z * point.z <= radius * radius {
                offer(t, Vector::new(0.0, side, 0.0));
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_meet_a_cylinder_where_geometry_says() {
        let cast = |o: [f32; 3], d: [f32; 3]| meet_cylinder(o.into(), d.into(), 0.5, 1.0);
        assert_eq!(cast([-2.0, 0.3, 0.0], [1.0, 0.0, 0.0]), Some((1.5, Vector::new(-1.0, 0.0, 0.0))));
        assert_eq!(cast([0.1, 3.0, 0.2], [0.0, -1.0, 0.0]), Some((2.0, Vector::new(0.0, 1.0, 0.0))));
        assert_eq!(cast([0.1, -3.0, 0.2], [0.0, 2.0, 0.0]), Some((1.0, Vector::new(0.0, -1.0, 0.0))));
        assert_eq!(cast([-2.0, 1.1, 0.0], [1.0, 0.0, 0.0]), None);
        assert_eq!(cast([-2.0, 0.0, 0.6], [1.0, 0.0, 0.0]), None);
        assert_eq!(cast([2.0, 0.0, 0.0], [1.0, 0.0, 0.0]), None);
    }
}
