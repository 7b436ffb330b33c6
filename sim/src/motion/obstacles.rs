//! What hand and arm must not run into: the table, the objects, and the arm itself; and how far off it is.

use rapier3d::geometry::SharedShape;
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::parry::query::{contact, intersection_test};
use rapier3d::prelude::Pose as EnginePose;

use crate::arm::kinematics::Posture;
use crate::arm::{Configuration, Shells};
use crate::frame::{Pose, to_engine};
use crate::motion::pace::FAR;
use crate::tag::Tag;
use crate::world::World;

/// Links that are so near to each other along the arm meet at a joint. They are never tested against each other.
const NEIGHBOURS: usize = 2;
/// The first of the links that can reach anything. The pedestal and the turret stay where they are.
const FIRST: usize = 2;
/// On a way round, hand and load may be so deep in the scene, metres. A load that stands on the table touches it, and
/// so does a load that is about to be put there.
const TOUCH: f32 = 3e-3;

/// A shape with its place.
struct Placed {
    shape: SharedShape,
    pose: EnginePose,
    bounds: Aabb,
}

impl Placed {
    fn new(shape: SharedShape, pose: EnginePose) -> Placed {
        let bounds = shape.compute_aabb(&pose);
        Placed { shape, pose, bounds }
    }

    fn meets(&self, other: &Placed) -> bool {
        // The engine answers for all pairs of convex shapes. A pair that it did not know would count as free, as it
        // does in the physics.
        self.bounds.intersects(&other.bounds)
            && intersection_test(&self.pose, &*self.shape, &other.pose, &*other.shape)
                .is_ok_and(|intersection| intersection.intersecting)
    }

    fn is_deep_in(&self, other: &Placed) -> bool {
        self.bounds.intersects(&other.bounds)
            && contact(&self.pose, &*self.shape, &other.pose, &*other.shape, 0.0)
                .is_ok_and(|contact| contact.is_some_and(|contact| -contact.dist > TOUCH))
    }
}

/// The scene as it is at the beginning of a motion.
pub(crate) struct Obstacles {
    /// Palm and fingers in the frame of the tool centre point, the fingers where they are now.
    hand: Vec<(SharedShape, EnginePose)>,
    /// What goes with the hand, in the same frame.
    load: Vec<(SharedShape, EnginePose)>,
    /// Whether what goes with the hand has beads in it.
    pub(crate) spills: bool,
    scene: Vec<Placed>,
}

impl Obstacles {
    /// All that is solid, without the beads, which give way, and without what the hand carries.
    pub(crate) fn new(world: &World) -> Obstacles {
        let carried = world.carried();
        let tcp = to_engine(&world.hand.tcp(&world.physics)).inverse();
        let (mut scene, mut load) = (Vec::new(), Vec::new());
        for (_, collider) in world.physics.colliders.iter() {
            let shape = collider.shared_shape().clone();
            let place = world.place_of(collider);
            let is_solid = collider.collision_groups().memberships.bits() != 0;
            match Tag::decode(collider.user_data) {
                Tag::Object(index) if carried.contains(&index) => load.push((shape, tcp * place)),
                Tag::Table | Tag::Object(_) if is_solid => scene.push(Placed::new(shape, place)),
                Tag::Table | Tag::Object(_) | Tag::Hand | Tag::Arm | Tag::Bead => {}
            }
        }
        let hand = world.hand.colliders().iter().map(|handle| {
            let collider = &world.physics.colliders[*handle];
            (collider.shared_shape().clone(), tcp * world.place_of(collider))
        });
        let has_beads = |index: &usize| world.beads_inside(&world.entries[*index].object.name).is_some_and(|n| n > 0);
        Obstacles { hand: hand.collect(), load, spills: carried.iter().any(has_beads), scene }
    }

    /// How far hand and load are from the scene, at least, with the tool centre point at a pose: metres, at most
    /// [`FAR`].
    ///
    /// It is the distance between boxes along the world's axes, so it never says too much.
    pub(crate) fn clearance(&self, tcp: &Pose) -> f64 {
        let tcp = to_engine(tcp);
        let bounds = |(shape, local): &(SharedShape, EnginePose)| shape.compute_aabb(&(tcp * *local));
        let carried: Vec<Aabb> = self.hand.iter().chain(&self.load).map(bounds).collect();
        let nearest = |obstacle: &Placed| carried.iter().map(|part| apart(part, &obstacle.bounds)).fold(FAR, f64::min);
        self.scene.iter().map(nearest).fold(FAR, f64::min)
    }

    /// Whether hand and load, too, are free of the scene at this configuration.
    pub(crate) fn are_clear_of_all(&self, shells: &Shells, configuration: &Configuration) -> bool {
        let tcp = shells.model.tcp(configuration);
        let mut carried = place_all(&self.hand, &tcp);
        carried.extend(place_all(&self.load, &tcp));
        let is_deep = |carried: &Placed| self.scene.iter().any(|obstacle| carried.is_deep_in(obstacle));
        !carried.iter().any(is_deep) && self.are_clear_of(shells, configuration)
    }

    /// Whether the arm at this configuration meets neither the scene nor itself. The hand is tested against the arm
    /// alone.
    pub(crate) fn are_clear_of(&self, shells: &Shells, configuration: &Configuration) -> bool {
        let Posture { links, tcp } = shells.model.posture(configuration);
        let frames: Vec<Pose> = std::iter::once(shells.model.mount).chain(links).collect();
        let mut placed: Vec<Vec<Placed>> =
            frames.iter().enumerate().map(|(link, frame)| place_all(shells.of_link(link), frame)).collect();
        placed.push(place_all(&self.hand, &tcp));
        let hand = placed.len() - 1;
        for (index, link) in placed.iter().enumerate() {
            let meets = |others: &[Placed]| link.iter().any(|shell| others.iter().any(|other| shell.meets(other)));
            if (FIRST..hand).contains(&index) && meets(&self.scene) {
                return false;
            }
            if placed[..index.saturating_sub(NEIGHBOURS)].iter().any(|other| meets(other)) {
                return false;
            }
        }
        true
    }
}

/// The distance between two boxes along the world's axes, metres; 0 where they meet.
fn apart(one: &Aabb, other: &Aabb) -> f64 {
    let gap = (one.mins - other.maxs).max(other.mins - one.maxs);
    let squares = [gap.x, gap.y, gap.z].map(|gap| f64::from(gap.max(0.0)) * f64::from(gap.max(0.0)));
    libm::sqrt(squares.iter().sum())
}

fn place_all(shells: &[(SharedShape, EnginePose)], frame: &Pose) -> Vec<Placed> {
    let frame = to_engine(frame);
    shells.iter().map(|(shape, local)| Placed::new(shape.clone(), frame * *local)).collect()
}
