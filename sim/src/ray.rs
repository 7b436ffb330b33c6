//! Where a ray meets a collider.

use rapier3d::geometry::{Collider, Ray};
use rapier3d::math::{Real, Vector};

/// Distance along the ray (in lengths of its direction) and the outward normal where it first meets the collider, up to
/// `far`.
///
/// The engine searches for the meeting point on a cylinder or a polyhedron by iteration, which leaves dents in a
/// picture. Here it is in closed form.
pub(crate) fn meet(collider: &Collider, ray: &Ray, far: Real) -> Option<(Real, Vector)> {
    let (shape, pose) = (collider.shape(), collider.position());
    let o = pose.inverse_transform_point(ray.origin);
    let d = pose.inverse_transform_vector(ray.dir);
    let (t, normal) = if let Some(cylinder) = shape.as_cylinder() {
        meet_cylinder(o, d, cylinder.radius, cylinder.half_height)?
    } else if let Some(hull) = shape.as_convex_polyhedron() {
        let (points, corners) = (hull.points(), hull.vertices_adj_to_face());
        let planes =
            hull.faces().iter().map(|face| (face.normal, points[corners[face.first_vertex_or_edge as usize] as usize]));
        meet_planes(o, d, planes)?
    } else {
        let meeting = shape.cast_local_ray_and_get_normal(&Ray::new(o, d), far, true)?;
        (meeting.time_of_impact, meeting.normal)
    };
    (t <= far).then(|| (t, pose.transform_vector(normal)))
}

/// The ray `o + t d` against the body behind all planes, each given by an outward normal and a point. A ray that starts
/// inside meets the far side.
fn meet_planes(o: Vector, d: Vector, planes: impl Iterator<Item = (Vector, Vector)>) -> Option<(Real, Vector)> {
    let mut enter = (Real::NEG_INFINITY, Vector::ZERO);
    let mut leave = (Real::INFINITY, Vector::ZERO);
    for (normal, point) in planes {
        let (slope, above) = (normal.dot(d), normal.dot(o - point));
        let t = -above / slope;
        if slope < 0.0 && t > enter.0 {
            enter = (t, normal);
        } else if slope > 0.0 && t < leave.0 {
            leave = (t, normal);
        } else if slope == 0.0 && above > 0.0 {
            return None;
        }
    }
    let (t, normal) = if enter.0 >= 0.0 { enter } else { leave };
    (enter.0 <= leave.0 && t >= 0.0 && t.is_finite()).then_some((t, normal))
}

/// The ray `o + t d` against a cylinder about y. A ray that starts inside meets the far wall.
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
    use rapier3d::parry::query::RayCast;

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

    #[test]
    fn rays_meet_a_box_of_planes_as_they_meet_a_box() {
        let half = Vector::new(0.5, 1.0, 0.25);
        let planes = || {
            [Vector::X, Vector::Y, Vector::Z]
                .into_iter()
                .flat_map(move |axis| [(axis, axis * half), (-axis, -axis * half)])
        };
        let cuboid = rapier3d::parry::shape::Cuboid::new(half);
        let mut met = 0;
        for k in 0..400 {
            let k = k as f32;
            let o = Vector::new(libm::sinf(k), libm::sinf(1.7 * k), libm::sinf(2.3 * k)) * 1.2;
            let d = Vector::new(libm::cosf(3.1 * k), libm::cosf(5.3 * k), libm::cosf(0.7 * k));
            let expected = cuboid.cast_local_ray_and_get_normal(&Ray::new(o, d), 100.0, false);
            let got = meet_planes(o, d, planes());
            assert_eq!(got.is_some(), expected.is_some(), "ray {k}");
            if let (Some((t, normal)), Some(meeting)) = (got, expected) {
                met += 1;
                assert!((t - meeting.time_of_impact).abs() < 1e-4 && normal.dot(meeting.normal).abs() > 0.999);
            }
        }
        assert!((50..350).contains(&met), "{met} of 400 rays met it");
    }
}
