//! Friction alone must hold what a competent hand has taken: through lifting, tilting and shaking.
//!
//! This is the premise of every task. It has caught: contact recycling (objects creep out of the hand), light fingers
//! (they sink into the object), uncoupled fingers (the pair drifts sideways).

use crate::common::{apart, block, keyframe, pitched, standing};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ_sim::{Bin, GripperCommand, MotionEnd, World};

/// How far an object may have moved in the hand, metres.
const SLIP: f64 = 0.002;
/// How far an object may have turned in the hand, radians.
const TWIST: f64 = 0.02;

#[test]
fn cubes_are_held_through_lift_tilt_and_shaking() {
    let mut rng = ChaCha8Rng::seed_from_u64(20);
    for _ in 0..8 {
        let (x, y) = (rng.random_range(-0.2..0.2), rng.random_range(-0.2..0.2));
        let yaw = rng.random_range(-0.5..0.5);
        let aside = [rng.random_range(-0.006..0.006), rng.random_range(-0.008..0.008)];
        let cube = standing(x, y, 0.02, yaw);
        let mut world = World::new();
        world.add(block("cube", [0.02; 3], 1000.0, 0.6), cube).unwrap();
        world.place_gripper(standing(x, y, 0.15, 0.0), 0.065);
        world.settle(0.1);

        let frame = cube * standing(aside[0], aside[1], 0.0, 0.0);
        let quiet = &mut |_: &World| {};
        let down =
            keyframe(&mut world, &frame, pitched(0.0, 0.008, 0.0), Some(GripperCommand::Close(20.0)), 0.0, quiet);
        assert_eq!(down, MotionEnd::Reached);
        let in_hand = |world: &World| world.tcp().inverse() * world.pose("cube").unwrap();
        let taken = in_hand(&world);
        // The fingers are coupled, so they have drawn the cube to the middle.
        assert!(taken.translation.y.abs() < 0.0005, "off the middle by {}", taken.translation.y);

        let swings = [(0.0, 0.0), (0.0, 1.57), (0.04, 1.57), (-0.04, 1.57), (0.04, 1.57), (-0.04, 1.57), (0.0, 0.0)];
        for (x, pitch) in swings {
            let end = keyframe(&mut world, &frame, pitched(x, 0.15, pitch), None, 0.0, quiet);
            assert_eq!(end, MotionEnd::Reached);
            let (slip, twist) = apart(&taken, &in_hand(&world));
            assert!(slip < SLIP && twist < TWIST, "slipped {slip} m, {twist} rad at pitch {pitch}");
        }
        for force in world.grip_force("cube") {
            assert!((force - 20.0).abs() < 1.0, "the squeeze is {force} N instead of 20 N");
        }
        assert!(world.hand_force() < 2.0, "a squeeze must cancel in the force on the hand");
        assert!(world.touching("cube", "hand") && !world.touching("cube", "table"));
    }
}

#[test]
fn a_gentle_squeeze_arrives_in_time() {
    for force in [3.0, 10.0, 40.0] {
        let mut world = World::new();
        world.add(block("cube", [0.02; 3], 500.0, 0.6), standing(0.0, 0.0, 0.02, 0.0)).unwrap();
        world.place_gripper(standing(0.0, 0.004, 0.028, 0.0), 0.08);
        world.command(GripperCommand::Close(force));
        world.settle(0.5);
        for got in world.grip_force("cube") {
            assert!((got - force).abs() < 0.05 * force, "asked for {force} N, got {got} N");
        }
    }
}

/// Whether a block stands on the floor of the bin or on another block there: its middle is between the walls, and less
/// than 2 cm above the rim.
fn is_in_bin(world: &World, block: &str) -> bool {
    let place = (world.pose("bin").unwrap().inverse() * world.pose(block).unwrap()).translation;
    place.x.abs() <= 0.07 && place.y.abs() <= 0.07 && (0.005..=0.08).contains(&place.z)
}

#[test]
fn a_block_is_carried_into_a_bin() {
    let mut world = World::new();
    let bin = Bin { inner: [0.14; 2], height: 0.06, wall: 0.005, density: 1000.0, friction: 0.4 };
    let place = standing(0.2, 0.15, 0.0, 0.3);
    world.add(bin.object("bin"), place).unwrap();
    let quiet = &mut |_: &World| {};
    for (k, name) in ["first", "second"].into_iter().enumerate() {
        let start = standing(-0.1, 0.12 * k as f64 - 0.05, 0.02, 0.2);
        world.add(block(name, [0.02; 3], 1000.0, 0.6), start).unwrap();
        world.settle(0.1);
        for (z, gripper) in
            [(0.13, Some(GripperCommand::Open(0.065))), (0.008, Some(GripperCommand::Close(20.0))), (0.15, None)]
        {
            keyframe(&mut world, &start, standing(0.0, 0.0, z, 0.0), gripper, 0.0, quiet);
        }
        assert!(!is_in_bin(&world, name));
        for (z, gripper) in [(0.17, None), (0.10, Some(GripperCommand::Open(0.065))), (0.17, None)] {
            keyframe(&mut world, &place, standing(0.0, 0.0, z, 0.0), gripper, 0.0, quiet);
        }
        world.settle(0.5);
        assert!(is_in_bin(&world, name), "{name} is at {:?}", world.pose(name));
    }
    // The same keyframes put the second on top of the first, which is still in the bin.
    assert!(is_in_bin(&world, "first") && world.speed("first").unwrap() < 0.01);
}
