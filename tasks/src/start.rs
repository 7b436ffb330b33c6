//! The start of an episode. Places are random, but each object's place depends on the seed and its name alone, whatever
//! else stands on the table.

use nalgebra::Vector3;
use rand::RngExt;
use situ_sim::{ArmModel, Convex, Object, Outline, Part, Pose, SimError, World, pose_at, rotation_about};

use crate::error::TaskError;
use crate::placement::Placed;
use crate::plant::Plant;
use crate::setting::Setting;
use crate::stream::stream;

/// How often a place is drawn anew before the region counts as full.
const TRIES: usize = 1000;
/// How long things are left to come to rest before an episode begins, in seconds.
const SETTLE: f64 = 0.5;

/// The name of the border of the table.
pub(crate) const BORDER: &str = "border";
/// Distance of the border from the middle of the table, in metres: within the table's 1.5 m, out of the hand's way.
const BORDER_AT: f64 = 0.9;
/// Half of the border's height and thickness, in metres: more than any bead's radius.
const BORDER_HALF: f64 = 0.02;

/// The name of the stream of random numbers of the arm's planner. No object can have this name.
const PLANNER: &str = "the planner of the arm";

/// A low wall all round. A spilled bead that rolled over the edge would fall for ever, and the run would be spoilt as
/// if the physics had failed.
fn border() -> Object {
    let wall = |half, x, y| Part::new(Convex::Cuboid { half }, Pose::translation(x, y, BORDER_HALF), 1000.0, 0.6);
    let along = [BORDER_AT + BORDER_HALF, BORDER_HALF, BORDER_HALF];
    let across = [BORDER_HALF, BORDER_AT + BORDER_HALF, BORDER_HALF];
    let parts = vec![
        wall(along, 0.0, BORDER_AT),
        wall(along, 0.0, -BORDER_AT),
        wall(across, BORDER_AT, 0.0),
        wall(across, -BORDER_AT, 0.0),
    ];
    let outline = Outline { top: 2.0 * BORDER_HALF, reach: std::f64::consts::SQRT_2 * (BORDER_AT + BORDER_HALF) };
    Object::new(BORDER, parts, outline).fixed().with_color([150, 120, 90])
}

/// Things may start this deep inside each other, in metres. The lower corners of a bowl's leaning walls reach a
/// millimetre below its base, and a plug may touch its rim.
const PRESSED: f64 = 2e-3;

/// Builds the world of an episode and lets it settle.
///
/// Each object has its own stream of random numbers, named after it. So an object that a variation adds moves none of
/// the others. What stands on the container that is filled is put there after the beads.
pub(crate) fn world(setting: &Setting, seed: u64) -> Result<World, TaskError> {
    let refused = |source| TaskError::World { task: setting.label(), source };
    let mut world = World::new();
    place_hand(setting, seed, &mut world).map_err(refused)?;
    let filled = setting.beads.as_ref().map(|(container, _)| container);
    let is_late = |placed: &&Placed| placed.start.on.is_some() && placed.start.on.as_ref() == filled;
    world.set_guard(setting.guard).map_err(refused)?;
    if let Some(iterations) = setting.solver_iterations {
        world.set_solver_iterations(iterations);
    }
    world.add(border(), Pose::identity()).map_err(refused)?;
    for placed in setting.objects.iter().filter(|placed| !is_late(placed)) {
        put(setting, placed, seed, &mut world)?;
    }
    if let Some((container, beads)) = &setting.beads {
        world.fill(container, beads).map_err(refused)?;
    }
    for placed in setting.objects.iter().filter(is_late) {
        put(setting, placed, seed, &mut world)?;
    }
    for magnet in &setting.magnets {
        world.magnet(magnet.clone()).map_err(refused)?;
    }
    check_apart(setting, seed, &world)?;
    world.settle(SETTLE);
    if setting.premise.holds(setting.view(&world)) {
        Ok(world)
    } else {
        Err(TaskError::Premise { task: setting.label(), seed, condition: setting.premise.to_string() })
    }
}

/// Puts the objects in their places and nothing more: an error where two of them are inside each other.
pub(crate) fn check_places(setting: &Setting, seed: u64) -> Result<(), TaskError> {
    let mut world = World::new();
    world.place_gripper(pose_at(setting.hand.at, Default::default()), setting.hand.open);
    for placed in &setting.objects {
        put(setting, placed, seed, &mut world)?;
    }
    check_apart(setting, seed, &world)
}

/// Puts the hand where it starts, and mounts what carries it.
fn place_hand(setting: &Setting, seed: u64, world: &mut World) -> Result<(), SimError> {
    world.place_gripper(pose_at(setting.hand.at, Default::default()), setting.hand.open);
    match setting.plant {
        Plant::Arm => world.mount(ArmModel::builtin(), stream(seed, PLANNER).random()),
        Plant::Hand => Ok(()),
    }
}

/// An error where two things are inside each other.
fn check_apart(setting: &Setting, seed: u64, world: &World) -> Result<(), TaskError> {
    world.overlap(PRESSED).map_or(Ok(()), |overlap| {
        Err(TaskError::Overlap {
            task: setting.label(),
            seed,
            first: overlap.a,
            second: overlap.b,
            millimetres: 1e3 * overlap.depth,
        })
    })
}

/// Puts an object in its place, on its slide or its hinge if it has one.
fn put(setting: &Setting, placed: &Placed, seed: u64, world: &mut World) -> Result<(), TaskError> {
    let refused = |source| TaskError::World { task: setting.label(), source };
    let pose = place(setting, placed, seed, world)?;
    world.add(material(placed, seed), pose).map_err(refused)?;
    for slide in setting.slides.iter().filter(|slide| slide.child == placed.body.name) {
        world.slide(slide).map_err(refused)?;
    }
    for hinge in setting.hinges.iter().filter(|hinge| hinge.child == placed.body.name) {
        world.hinge(hinge).map_err(refused)?;
    }
    Ok(())
}

/// The body of an object, with the mass and the friction that this start gives it. Each has a stream of its own, so
/// that the object's place does not depend on whether they vary.
fn material(placed: &Placed, seed: u64) -> Object {
    let body = placed.body.clone();
    let factor = |range: Option<[f64; 2]>, what: &str| {
        range.map(|[low, high]| stream(seed, &format!("the {what} of {}", body.name)).random_range(low..=high))
    };
    match (factor(placed.start.mass, "mass"), factor(placed.start.friction, "friction")) {
        (None, None) => body,
        (mass, friction) => body.with_material(mass.unwrap_or(1.0), friction.unwrap_or(1.0)),
    }
}

/// A random pose in the object's region, far enough from the objects that are there already.
fn place(setting: &Setting, placed: &Placed, seed: u64, world: &World) -> Result<Pose, TaskError> {
    let (name, start) = (&placed.body.name, &placed.start);
    let mut stream = stream(seed, name);
    for _ in 0..TRIES {
        let [x, y, yaw] = [start.x, start.y, start.yaw].map(|[low, high]| stream.random_range(low..=high));
        let local = pose_at([x, y, start.z], rotation_about([0.0, 0.0, 1.0], yaw));
        let pose = match start.on.as_ref().and_then(|on| world.pose(on)) {
            Some(frame) => frame * local,
            None => local,
        };
        let far = |apart: f64| {
            let others = world.objects().filter(|&other| other != BORDER).filter_map(|other| world.pose(other));
            others.map(|other| (other.translation.vector - pose.translation.vector).xy().norm()).all(|d| d >= apart)
        };
        if start.apart.is_none_or(far) {
            return Ok(about_hinge(setting, name, along_slide(setting, name, pose, world), world));
        }
    }
    Err(TaskError::Crowded { task: setting.label(), seed, object: name.clone(), tries: TRIES })
}

/// The pose of an object that starts further along its slide than its place at value 0. For any other object, its
/// place.
fn along_slide(setting: &Setting, name: &str, place: Pose, world: &World) -> Pose {
    let slide = setting.slides.iter().find(|slide| slide.child == name);
    match slide.and_then(|slide| Some((slide, world.pose(&slide.parent)?))) {
        Some((slide, frame)) => {
            let way = frame.rotation * Vector3::from(slide.axis).normalize() * slide.value;
            nalgebra::Translation3::from(way) * place
        }
        None => place,
    }
}

/// The pose of an object that starts further about its hinge than its place at value 0. For any other object, its
/// place.
fn about_hinge(setting: &Setting, name: &str, place: Pose, world: &World) -> Pose {
    let hinge = setting.hinges.iter().find(|hinge| hinge.child == name);
    match hinge.and_then(|hinge| Some((hinge, world.pose(&hinge.parent)?))) {
        Some((hinge, frame)) => frame * hinge.turned(&(frame.inverse() * place), hinge.value),
        None => place,
    }
}
