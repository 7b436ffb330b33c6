//! The magnetic lid: it keeps the beads in a tilted pitcher, and comes off at its knob. A loose lid does neither.

use crate::common::{JUG, LID, close_pitcher, grasp, keyframe, pouring, standing, tilt};
use situ_sim::{Beads, GripperCommand, MotionEnd, Pose, World};

fn scene() -> World {
    pouring(&Beads::new(60), standing(-0.16, 0.0, 0.0, 0.0), standing(0.16, 0.0, 0.0, 0.0))
}

#[test]
fn a_magnetic_lid_keeps_the_beads() {
    let quiet = &mut |_: &World| {};
    let mut world = scene();
    close_pitcher(&mut world);
    grasp(&mut world, quiet);
    tilt(&mut world, quiet);
    world.hold(1.0, quiet);
    assert_eq!((world.beads_inside("pitcher"), world.beads_inside("bowl")), (Some(60), Some(0)));
    assert!(world.touching("lid", "pitcher"));

    // Without a magnet the lid falls off and the beads with it. So it is the magnet that holds.
    let mut loose = scene();
    let seat = loose.pose("pitcher").unwrap() * Pose::translation(0.0, 0.0, JUG.height);
    loose.add(LID.object("lid"), seat).unwrap();
    loose.settle(0.3);
    grasp(&mut loose, quiet);
    tilt(&mut loose, quiet);
    loose.hold(1.0, quiet);
    assert!(loose.beads_inside("pitcher") < Some(10), "{:?}", loose.beads_inside("pitcher"));
}

#[test]
fn the_lid_comes_off_at_its_knob() {
    let quiet = &mut |_: &World| {};
    let mut world = scene();
    close_pitcher(&mut world);
    let pitcher = world.pose("pitcher").unwrap();
    let lid = world.pose("lid").unwrap();
    for (z, gripper) in
        [(0.12, Some(GripperCommand::Open(0.06))), (0.020, Some(GripperCommand::Close(20.0))), (0.12, None)]
    {
        let end = keyframe(&mut world, &lid, Pose::translation(0.0, 0.0, z), gripper, 0.0, quiet);
        assert_eq!(end, MotionEnd::Reached);
    }
    assert!(world.pose("lid").unwrap().translation.z > lid.translation.z + 0.09);
    assert!(!world.touching("lid", "pitcher"));
    let stayed = world.pose("pitcher").unwrap();
    assert!((stayed.translation.vector - pitcher.translation.vector).norm() < 0.01, "the pitcher came along");

    let mat = world.pose("mat").unwrap();
    for (z, gripper) in [(0.17, None), (0.033, Some(GripperCommand::Open(0.06))), (0.16, None)] {
        keyframe(&mut world, &mat, Pose::translation(0.0, 0.20, z), gripper, 0.0, quiet);
    }
    assert!(world.touching("lid", "table") && !world.touching("lid", "hand"));
    assert_eq!(world.beads_inside("pitcher"), Some(60));
}
