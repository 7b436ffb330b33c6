//! What a camera sees of a thing, and what something else hides.

use nalgebra::{Point3, Vector3};
use rapier3d::geometry::Ray;

use crate::camera::{Camera, FAR, Scene, meet};
use crate::frame::to_engine_vector;
use crate::tag::Tag;
use crate::world::World;

/// Rays to a thing go through a grid of so many points along each edge of the box that holds it.
const GRID: usize = 6;

/// How much of a thing is seen.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sight {
    /// Rays that meet the thing before anything else.
    pub seen: u32,
    /// Rays that would meet it if there were nothing else.
    pub all: u32,
}

impl Sight {
    /// The part of the thing that is seen, 0 to 1; none where no ray would meet it.
    pub fn part(&self) -> Option<f64> {
        (self.all > 0).then(|| f64::from(self.seen) / f64::from(self.all))
    }
}

impl Camera {
    /// How much of each of these things is seen, whether it lies in the picture or not. `table`, `hand` and `arm` are
    /// names, too. Nothing is seen of what is not there.
    pub fn sight(&self, world: &World, names: &[&str]) -> Vec<Sight> {
        let scene = Scene::new(world);
        let eye = Point3::from(self.eye).coords;
        let origin = to_engine_vector(&eye);
        let sight = |name: &&str| {
            let colliders = world.colliders_of(name);
            let parts: Vec<_> = colliders.iter().map(|collider| &world.physics.colliders[*collider]).collect();
            let (Some(bounds), Some(tag)) = (world.bounds(name), parts.first().map(|part| Tag::decode(part.user_data)))
            else {
                return Sight::default();
            };
            let mut sight = Sight::default();
            for point in grid(bounds) {
                let ray = Ray::new(origin, to_engine_vector(&(point - eye).normalize()));
                if parts.iter().any(|part| meet(part, &ray, FAR).is_some()) {
                    sight.all += 1;
                    let first = scene.hit(&ray).map(|(collider, ..)| Tag::decode(collider.user_data));
                    sight.seen += u32::from(first == Some(tag));
                }
            }
            sight
        };
        names.iter().map(sight).collect()
    }
}

/// Points evenly spread in a box, which is given by its least and largest corner.
fn grid([least, largest]: [[f64; 3]; 2]) -> impl Iterator<Item = Vector3<f64>> {
    (0..GRID.pow(3)).map(move |index| {
        let place = [index % GRID, index / GRID % GRID, index / GRID.pow(2)];
        Vector3::from_fn(|axis, _| {
            let part = (place[axis] as f64 + 0.5) / GRID as f64;
            least[axis] + part * (largest[axis] - least[axis])
        })
    })
}
