//! A camera: one ray for each pixel against the true collision shapes, Lambert shading, one ray for the shadow.

use nalgebra::{Point3, Vector3};
use rapier3d::geometry::{Collider, Ray};
use rapier3d::math::{Real, Vector};
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy};
use serde::{Deserialize, Serialize};

use crate::frame::to_engine_vector;
use crate::image::Image;
use crate::tag::Tag;
use crate::world::World;

/// A pinhole camera. Metres, world frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Where it is.
    pub eye: [f64; 3],
    /// What it looks at. Up is up in the picture.
    pub target: [f64; 3],
    /// Vertical angle of view in radians.
    pub fov: f64,
}

impl Default for Camera {
    /// From the front and above, over the middle of the table.
    fn default() -> Camera {
        Camera { eye: [0.12, -0.7, 0.42], target: [0.0, 0.0, 0.12], fov: 0.6 }
    }
}

/// The direction to the lamp.
const LAMP: [f64; 3] = [0.35, -0.45, 0.9];
/// Part of the light that comes from everywhere.
const AMBIENT: f32 = 0.42;
/// A shadow ray starts so far from the surface, metres.
const SHADOW_OFFSET: f32 = 2e-4;
/// The furthest that can be seen, metres.
pub(crate) const FAR: f32 = 10.0;
/// Edge of the checks on the table, metres.
const CHECK: f32 = 0.05;
/// The two colours of the checks.
const CHECKS: [[u8; 3]; 2] = [[226, 222, 214], [208, 203, 194]];
/// Colour of the hand.
const HAND_COLOR: [u8; 3] = [92, 96, 104];
/// Colour of the arm.
const ARM_COLOR: [u8; 3] = [222, 224, 228];
/// Colour of beads.
const BEAD_COLOR: [u8; 3] = [236, 146, 38];
/// Colour of what lies beyond the table.
const SKY: [u8; 3] = [238, 241, 245];

/// The direction from the table to a camera in front of it: high enough to see into a bin. No unit vector.
pub const FRONT: [f64; 3] = [0.16, -0.7, 0.46];
/// How much of the picture, from its middle to its edge, a camera that [`Camera::around`] sets up fills.
const FILLED: f64 = 0.94;

impl Camera {
    /// The camera that looks from this direction ([`FRONT`], for one, of any length but 0), from as near as it can with
    /// all these boxes in the picture. `aspect` is the picture's width over its height. A box is given by its least and
    /// largest corner, metres, world frame. No boxes give the default camera.
    pub fn around(boxes: &[[[f64; 3]; 2]], direction: [f64; 3], aspect: f64) -> Camera {
        let default = Camera::default();
        let [right, up, ahead] = Camera { eye: direction, target: [0.0; 3], fov: default.fov }.axes();
        let corner = |bounds: &[[f64; 3]; 2], index: usize| {
            let pick = |axis: usize| bounds[(index >> axis) & 1][axis];
            Vector3::new(pick(0), pick(1), pick(2))
        };
        let points: Vec<Vector3<f64>> =
            boxes.iter().flat_map(|bounds| (0..8).map(move |index| corner(bounds, index))).collect();
        if points.is_empty() {
            return default;
        }
        // An eye at (x₀, z₀) sees a point at (x, z), sideways and ahead, if |x − x₀| ≤ s (z − z₀). So each side of the
        // picture bounds x₀ − s z₀ from below and x₀ + s z₀ from above. The nearest eye is where both bounds of the
        // tighter axis meet.
        let half = FILLED * libm::tan(0.5 * default.fov);
        let limits = [(right, half * aspect), (up, half)].map(|(axis, slope)| {
            let low = points.iter().map(|p| p.dot(&axis) - slope * p.dot(&ahead)).fold(f64::NEG_INFINITY, f64::max);
            let high = points.iter().map(|p| p.dot(&axis) + slope * p.dot(&ahead)).fold(f64::INFINITY, f64::min);
            (low, high, slope)
        });
        let depth = limits.iter().map(|(low, high, slope)| (high - low) / (2.0 * slope)).fold(f64::INFINITY, f64::min);
        let [x, y] = limits.map(|(low, high, _)| 0.5 * (low + high));
        let eye = right * x + up * y + ahead * depth;
        Camera { eye: eye.into(), target: (eye + ahead).into(), fov: default.fov }
    }

    /// The directions to the right, up and ahead.
    fn axes(&self) -> [Vector3<f64>; 3] {
        let ahead = (Point3::from(self.target) - Point3::from(self.eye)).normalize();
        let across = ahead.cross(&Vector3::z());
        // For a camera that looks straight down, y is up in the picture.
        let right = if across.norm() > 1e-9 { across.normalize() } else { Vector3::x() };
        [right, right.cross(&ahead), ahead]
    }

    /// Takes a picture of the world: the true collision shapes, in the colours of the objects.
    pub fn render(&self, world: &World, width: u32, height: u32) -> Image {
        let scene = Scene::new(world);
        let eye = Point3::from(self.eye);
        let [right, up, ahead] = self.axes();
        let scale = libm::tan(0.5 * self.fov);
        let (w, h) = (f64::from(width), f64::from(height));
        let origin = to_engine_vector(&eye.coords);
        let look = |column: f64, row: f64| {
            let x = scale * (2.0 * column + 1.0 - w) / h;
            let y = scale * (h - 1.0 - 2.0 * row) / h;
            let direction = (ahead + right * x + up * y).normalize();
            scene.look(Ray::new(origin, to_engine_vector(&direction)))
        };
        let mut image = Image::plain(width, height, SKY);
        for row in 0..height {
            for column in 0..width {
                image.set(column, row, look(f64::from(column), f64::from(row)));
            }
        }
        // A pixel on an edge is looked at again with four rays, so that the edge is no staircase.
        let rough = image.clone();
        for row in 0..height {
            for column in 0..width {
                if is_edge(&rough, column, row) {
                    let rays = QUARTERS.map(|[x, y]| look(f64::from(column) + x, f64::from(row) + y));
                    image.set(column, row, mix(&rays));
                }
            }
        }
        image
    }
}

/// Where in a pixel the four rays of an edge go.
const QUARTERS: [[f64; 2]; 4] = [[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]];
/// Two pixels that differ by more than this in a channel have an edge between them.
const EDGE: u8 = 12;

/// Whether a pixel differs much from one beside, above or below it.
fn is_edge(image: &Image, column: u32, row: u32) -> bool {
    let Some(here) = image.pixel(column, row) else {
        return false;
    };
    let left = column.checked_sub(1).and_then(|column| image.pixel(column, row));
    let above = row.checked_sub(1).and_then(|row| image.pixel(column, row));
    let others = [left, above, image.pixel(column + 1, row), image.pixel(column, row + 1)];
    let differs = |other: [u8; 3]| (0..3).any(|c| here[c].abs_diff(other[c]) > EDGE);
    others.into_iter().flatten().any(differs)
}

/// The mean colour.
fn mix(colors: &[[u8; 3]; 4]) -> [u8; 3] {
    [0, 1, 2].map(|c| (colors.iter().map(|color| u16::from(color[c])).sum::<u16>() / 4) as u8)
}

/// The colliders of a world with a tree over where they are now. The engine's own tree is a step behind, and empty
/// before the first step.
pub(crate) struct Scene<'a> {
    world: &'a World,
    colliders: Vec<&'a Collider>,
    tree: Bvh,
    lamp: Vector,
}

impl<'a> Scene<'a> {
    pub(crate) fn new(world: &'a World) -> Scene<'a> {
        let colliders: Vec<&Collider> = world.physics.colliders.iter().map(|(_, collider)| collider).collect();
        let boxes: Vec<_> = colliders.iter().map(|collider| collider.compute_aabb()).collect();
        let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
        Scene { world, colliders, tree, lamp: to_engine_vector(&Vector3::from(LAMP).normalize()) }
    }

    /// The collider that the ray meets first, with distance and normal.
    pub(crate) fn hit(&self, ray: &Ray) -> Option<(&Collider, f32, Vector)> {
        let check = |leaf: u32, best: f32| meet(self.colliders[leaf as usize], ray, best).map(|(distance, _)| distance);
        let (leaf, _) = self.tree.cast_ray(ray, FAR, check)?;
        let collider = self.colliders[leaf as usize];
        meet(collider, ray, FAR).map(|(distance, normal)| (collider, distance, normal))
    }

    /// The colour that a ray meets.
    fn look(&self, ray: Ray) -> [u8; 3] {
        let Some((collider, distance, normal)) = self.hit(&ray) else {
            return SKY;
        };
        let point = ray.point_at(distance);
        let normal = if normal.dot(ray.dir) > 0.0 { -normal } else { normal };
        let facing = normal.dot(self.lamp).max(0.0);
        let lit = facing > 0.0 && self.hit(&Ray::new(point + normal * SHADOW_OFFSET, self.lamp)).is_none();
        let light = AMBIENT + if lit { (1.0 - AMBIENT) * facing } else { 0.0 };
        let color = match Tag::decode(collider.user_data) {
            Tag::Table => {
                CHECKS[(((point.x / CHECK).floor() + (point.y / CHECK).floor()).rem_euclid(2.0)) as usize % 2]
            }
            Tag::Hand => HAND_COLOR,
            Tag::Arm => ARM_COLOR,
            Tag::Bead => BEAD_COLOR,
            Tag::Object(index) => self.world.entries[index].object.color,
        };
        color.map(|channel| (f32::from(channel) * light).clamp(0.0, 255.0) as u8)
    }
}

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
