//! Scenes of rigid bodies in our default world, as the tasks use it: what moved where, and how long its phases take.
//!
//! `bench/peers/scenes.py` has the dimensions. Everything that is measured is made of poses, by
//! `bench/peers/figures.py`.

use std::error::Error;

use serde::Deserialize;
use situ_sim::{Beads, GripperCommand, HAND, MotionEnd, Object, Outline, Part, Pose, Slide, World};

use crate::{Outcome, Values, measured_from};

/// A scene, and what happens in it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Scene {
    bodies: Vec<Body>,
    beads: Option<Heap>,
    slides: Vec<Slide>,
    hand: Hand,
    /// Iterations of the solver, where the tasks have other than the default.
    iterations: Option<usize>,
    phases: Vec<Vec<Act>>,
    /// The phase that is timed. Without one, the answer has the poses after every step, and no times.
    timed: Option<usize>,
}

/// An object, made of parts.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Body {
    name: String,
    fixed: bool,
    pose: Pose,
    parts: Vec<Part>,
}

/// Beads, and their centres in the world.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Heap {
    beads: Beads,
    centers: Vec<[f64; 3]>,
}

/// Where the hand is at the start.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Hand {
    tcp: Pose,
    opening: f64,
}

/// What is done, one after the other.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Act {
    /// Seconds pass.
    Wait(f64),
    /// A body is carried along, there and not back.
    Push { body: String, by: [f64; 3], seconds: f64 },
    /// The hand moves to this pose of its tool centre point.
    Move(Pose),
    /// The hand squeezes with this force from now on, newtons.
    Close(f64),
}

impl Scene {
    /// The poses after every step, or the times of runs of the phase that is asked for and the poses at its end.
    pub(crate) fn answer(&self, seconds: f64) -> Outcome<(Values, Vec<f64>)> {
        let mut world = self.world()?;
        let mut film = Film::default();
        film.take(&world);
        film.bounds = bounds_of_hand(world.clone());
        let Some(timed) = self.timed else {
            for phase in &self.phases {
                let before = film.frames;
                play(phase, &mut world, &mut |world| film.take(world))?;
                film.steps.push((film.frames - before) as f64);
            }
            return Ok((film.values(), Vec::new()));
        };
        let phase = self.phases.get(timed).ok_or("there is no such phase")?;
        for earlier in &self.phases[..timed] {
            play(earlier, &mut world, &mut |_| {})?;
        }
        let (world, nanoseconds) =
            measured_from(seconds, || world.clone(), |mut world| play(phase, &mut world, &mut |_| {}).map(|()| world))?;
        let mut film = Film::default();
        film.take(&world);
        Ok((film.values(), nanoseconds))
    }

    fn world(&self) -> Outcome<World> {
        let mut world = World::new();
        world.place_gripper(self.hand.tcp, self.hand.opening);
        if let Some(iterations) = self.iterations {
            world.set_solver_iterations(iterations);
        }
        for Body { name, fixed, pose, parts } in &self.bodies {
            let object = Object::new(name.as_str(), parts.clone(), Outline { top: 0.0, reach: 0.0 });
            world.add(if *fixed { object.fixed() } else { object }, *pose)?;
        }
        for slide in &self.slides {
            world.slide(slide)?;
        }
        if let Some(Heap { beads, centers }) = &self.beads {
            world.scatter(beads, centers)?;
        }
        Ok(world)
    }
}

/// The box that holds the hand, after a step: a hand that was put somewhere gets there by the next one.
fn bounds_of_hand(mut world: World) -> Vec<f64> {
    world.step();
    world.bounds(HAND).into_iter().flatten().flatten().collect()
}

/// Does all that a phase asks for.
fn play(phase: &[Act], world: &mut World, observer: &mut dyn FnMut(&World)) -> Result<(), Box<dyn Error>> {
    for act in phase {
        match act {
            Act::Wait(seconds) => world.hold(*seconds, observer),
            Act::Push { body, by, seconds } => {
                world.push(body, *by, *seconds)?;
                world.hold(*seconds, observer);
            }
            Act::Move(tcp) => {
                let end = world.move_hand(*tcp, observer);
                if end != MotionEnd::Reached {
                    return Err(format!("a motion of the hand ended with {end:?}").into());
                }
            }
            Act::Close(force) => world.command(GripperCommand::Close(*force)),
        }
    }
    Ok(())
}

/// Poses of bodies, beads and hand, frame by frame.
#[derive(Default)]
struct Film {
    frames: usize,
    /// Shape (frames, bodies + beads, 7): place, then the quaternion, w first.
    poses: Vec<f64>,
    /// Shape (frames, 9): pose of the tool centre point, distance of the pads, squeeze asked for.
    hand: Vec<f64>,
    /// Steps of each phase.
    steps: Vec<f64>,
    /// Least and largest corner of the box that holds the hand at the start.
    bounds: Vec<f64>,
}

impl Film {
    fn take(&mut self, world: &World) {
        self.frames += 1;
        let bodies = world.objects().filter_map(|object| world.pose(object));
        self.poses.extend(bodies.chain(world.bead_poses()).flat_map(|pose| numbers(&pose)));
        let squeeze = match world.gripper() {
            GripperCommand::Close(force) => force,
            GripperCommand::Open(_) => 0.0,
        };
        self.hand.extend(numbers(&world.tcp()).into_iter().chain([world.opening(), squeeze]));
    }

    fn values(self) -> Values {
        Values::from([("poses", self.poses), ("hand", self.hand), ("steps", self.steps), ("bounds", self.bounds)])
    }
}

fn numbers(pose: &Pose) -> [f64; 7] {
    let (place, turn) = (pose.translation, pose.rotation);
    [place.x, place.y, place.z, turn.w, turn.i, turn.j, turn.k]
}
