//! Scenes and hands for the tests: the pouring scene as measured, and keyframes relative to a frame.

use situ_sim::{
    Beads, Block, Cup, GripperCommand, Handle, Lid, Magnet, Mat, MotionEnd, Object, Pose, World, pose_at,
    rotation_about,
};

/// Seconds that a gripper command takes.
pub(crate) const GRIPPER_TIME: f64 = 0.5;

/// The bowl: 6 cm high, radius 5.5 cm at the floor, leaning outwards.
pub(crate) const BOWL: Cup = Cup {
    inner_radius: 0.055,
    height: 0.06,
    wall: 0.005,
    flare: 0.35,
    density: 1500.0,
    friction: 0.4,
    sides: 16,
    handle: None,
};

/// A pitcher without its handle: 10 cm high, inner radius 4 cm.
pub(crate) const JUG: Cup = Cup { inner_radius: 0.04, height: 0.10, flare: 0.0, ..BOWL };

/// The lid that fits [`JUG`] with 2 mm of clearance; 46 g.
pub(crate) const LID: Lid = Lid {
    flange_radius: 0.047,
    flange_thickness: 0.004,
    plug_radius: 0.038,
    plug_depth: 0.012,
    knob: [0.008, 0.007, 0.013],
    density: 500.0,
    friction: 0.4,
};

/// The handle of the pitcher: a bar 16 mm square and 7 cm long, 8 cm from the axis on the side of −x.
pub(crate) fn handle() -> Handle {
    Handle {
        center: [-0.08, 0.0, 0.055],
        half: [0.008, 0.008, 0.035],
        struts: vec![0.085, 0.025],
        strut_half: [0.006, 0.005],
        density: 1500.0,
        friction: 0.8,
    }
}

/// A block.
pub(crate) fn block(name: impl Into<String>, half: [f64; 3], density: f64, friction: f64) -> Object {
    Block { half, density, friction }.object(name)
}

/// A pose at a place on the table, turned about the vertical.
pub(crate) fn standing(x: f64, y: f64, z: f64, yaw: f64) -> Pose {
    pose_at([x, y, z], rotation_about([0.0, 0.0, 1.0], yaw))
}

/// A pose in the plane y = 0, pitched about y.
pub(crate) fn pitched(x: f64, z: f64, pitch: f64) -> Pose {
    pose_at([x, 0.0, z], rotation_about([0.0, 1.0, 0.0], pitch))
}

/// Pitcher with beads near −x, bowl near +x, a mat under the pitcher, the hand above the middle.
pub(crate) fn pouring(beads: &Beads, pitcher: Pose, bowl: Pose) -> World {
    let mut world = World::new();
    world.add(Mat { half: [0.06; 2] }.object("mat"), pitcher).unwrap();
    world.add(Cup { handle: Some(handle()), ..JUG }.object("pitcher"), pitcher).unwrap();
    world.add(BOWL.object("bowl").with_color([150, 170, 110]), bowl).unwrap();
    world.fill("pitcher", beads).unwrap();
    world.place_gripper(standing(0.0, 0.0, 0.30, 0.0), 0.06);
    world.settle(0.3);
    world
}

/// Puts the magnetic lid on the pitcher.
pub(crate) fn close_pitcher(world: &mut World) {
    let seat = Pose::translation(0.0, 0.0, JUG.height);
    let pose = world.pose("pitcher").unwrap() * seat;
    world.add(LID.object("lid"), pose).unwrap();
    world.magnet(Magnet { a: "lid".into(), b: "pitcher".into(), seat, force: 2.0, range: 0.005 }).unwrap();
    world.settle(0.3);
}

/// One keyframe: move, then command the gripper if there is a command, then wait.
pub(crate) fn keyframe(
    world: &mut World,
    frame: &Pose,
    tcp: Pose,
    gripper: Option<GripperCommand>,
    wait: f64,
    observer: &mut dyn FnMut(&World),
) -> MotionEnd {
    let end = world.move_hand(frame * tcp, observer);
    if let Some(gripper) = gripper {
        world.command(gripper);
        world.hold(GRIPPER_TIME, observer);
    }
    world.hold(wait, observer);
    end
}

/// Takes the pitcher by its handle and lifts it.
pub(crate) fn grasp(world: &mut World, observer: &mut dyn FnMut(&World)) {
    let frame = world.pose("pitcher").unwrap();
    for (z, gripper) in
        [(0.17, Some(GripperCommand::Open(0.06))), (0.06, Some(GripperCommand::Close(30.0))), (0.22, None)]
    {
        keyframe(world, &frame, pitched(-0.08, z, 0.0), gripper, 0.0, observer);
    }
}

/// Where the tool centre point is when the pitcher's lip is at (x, z) in the bowl's frame and the hand is pitched.
pub(crate) fn lip(x: f64, z: f64, pitch: f64) -> Pose {
    pitched(x, z, pitch) * Pose::translation(-0.12, 0.0, -0.04)
}

/// The first half of the pour: up to the full tilt.
pub(crate) fn tilt(world: &mut World, observer: &mut dyn FnMut(&World)) {
    let frame = world.pose("bowl").unwrap();
    for (x, z, pitch) in [(-0.03, 0.22, 0.0), (-0.03, 0.17, 0.8), (-0.03, 0.14, 1.5), (-0.03, 0.13, 2.0)] {
        keyframe(world, &frame, lip(x, z, pitch), None, 0.0, observer);
    }
}

/// The second half: wait, come back upright, put the pitcher on the mat.
pub(crate) fn put_back(world: &mut World, observer: &mut dyn FnMut(&World)) {
    world.hold(1.0, observer);
    let bowl = world.pose("bowl").unwrap();
    for (x, z, pitch) in [(-0.03, 0.17, 0.8), (-0.03, 0.22, 0.0)] {
        keyframe(world, &bowl, lip(x, z, pitch), None, 0.0, observer);
    }
    let mat = world.pose("mat").unwrap();
    for (z, gripper) in [(0.22, None), (0.062, Some(GripperCommand::Open(0.06))), (0.20, None)] {
        keyframe(world, &mat, pitched(-0.08, z, 0.0), gripper, 0.0, observer);
    }
}

/// How far apart two poses are: metres and radians.
pub(crate) fn apart(a: &Pose, b: &Pose) -> (f64, f64) {
    ((a.translation.vector - b.translation.vector).norm(), a.rotation.angle_to(&b.rotation))
}

/// Every bit that can be seen of a world: poses, speeds, opening, force, beads.
pub(crate) fn bits(world: &World) -> Vec<u64> {
    let mut numbers: Vec<f64> = vec![world.time(), world.opening(), world.hand_force()];
    for name in world.objects() {
        let pose = world.pose(name).unwrap();
        numbers.extend(pose.translation.vector.iter().chain(pose.rotation.coords.iter()));
        numbers.push(world.speed(name).unwrap());
        numbers.extend(world.grip_force(name));
    }
    numbers.extend(world.beads().into_iter().flatten());
    numbers.into_iter().map(f64::to_bits).collect()
}
