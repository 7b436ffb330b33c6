//! The arm: its description, where it can reach, and what it goes round. The hand goes where it is told all the same.

use std::sync::Arc;

use crate::common::{apart, bits, block, pitched, standing};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ_sim::{
    ARM, ArmModel, Beads, DT, GripperCommand, HAND, JOINTS, MAX_SPEED, MAX_TURN, MotionEnd, Snapshot, TABLE, World,
    pose_at, rotation_about,
};

/// The file that comes with the program.
const URDF: &str = include_str!("../../src/arm/arm.urdf");

fn with_arm(tcp: situ_sim::Pose) -> World {
    let mut world = World::new();
    world.place_gripper(tcp, 0.06);
    world.mount(ArmModel::builtin(), 1).unwrap();
    world
}

fn ready() -> World {
    with_arm(standing(0.0, 0.0, 0.3, 0.0))
}

#[test]
fn the_description_is_read_as_it_is_written() {
    let model = ArmModel::parse(URDF).unwrap();
    assert_eq!(model, *ArmModel::builtin());
    // With the arm stretched upright, the tool is as high as the lengths say, and points up: its z axis, which leads
    // away from the tips, is down.
    let tcp = model.tcp(&situ_sim::Configuration::zeros());
    let height = 0.30 + 0.15 + 2.0 * 0.29 + 2.0 * 0.28 + 0.06 + 0.121;
    assert!((tcp.translation.vector - Vector3::new(0.12, 0.70, height)).norm() < 1e-12, "{tcp}");
    assert!((tcp.rotation * Vector3::z() + Vector3::z()).norm() < 1e-12);
    // With the shoulder bent forward by a right angle, the arm lies along −y at the shoulder's height.
    let mut forward = situ_sim::Configuration::zeros();
    forward[1] = std::f64::consts::FRAC_PI_2;
    let tcp = model.tcp(&forward);
    assert!((tcp.translation.vector - Vector3::new(0.12, 0.70 - (height - 0.45), 0.45)).norm() < 1e-12, "{tcp}");
}

#[test]
fn a_wrong_description_is_refused_with_a_reason() {
    let changed = |from: &str, to: &str| {
        assert!(URDF.contains(from), "{from}");
        ArmModel::parse(&URDF.replacen(from, to, 1)).unwrap_err().to_string()
    };
    for (from, to, reason) in [
        ("</robot>", "", "arm: "),
        ("type=\"revolute\"", "type=\"fixed\"", "6 revolute joints, expected 7"),
        ("type=\"revolute\"", "type=\"prismatic\"", "joint `shoulder_yaw` is Prismatic, expected revolute or fixed"),
        ("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 0\"/>", "joint `shoulder_yaw`: its axis has no direction"),
        ("lower=\"-2.9\" upper=\"2.9\"", "lower=\"2.9\" upper=\"-2.9\"", "expected a limit with lower < upper"),
        ("velocity=\"1.8\"", "velocity=\"0\"", "a velocity of more than 0"),
        (
            "<parent link=\"turret\"/>",
            "<parent link=\"pedestal\"/>",
            "link `pedestal` has more than one joint after it",
        ),
        ("<parent link=\"room\"/>", "<parent link=\"tool\"/>", "0 revolute joints, expected 7"),
        (
            "<link name=\"room\"/>",
            "<link name=\"room\"/><link name=\"hall\"/>",
            "expected one link that no joint leads to",
        ),
        (
            "<cylinder radius=\"0.08\" length=\"0.30\"/>",
            "<mesh filename=\"x.stl\"/>",
            "link `pedestal`: a shell is Mesh",
        ),
    ] {
        let message = changed(from, to);
        assert!(message.contains(reason), "{from} → {to}: {message}");
    }
}

/// The poses that the arm has at configurations drawn at random are within its reach by construction. A hand that
/// stands above the table can be mounted there, unless every start of the search misses the ranges of the joints.
#[test]
fn what_is_within_reach_is_reached_and_what_is_not_is_refused() {
    let model = ArmModel::builtin();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (mut tried, mut found) = (0, 0);
    while tried < 200 {
        let angles = situ_sim::Configuration::from_fn(|joint, _| {
            let joint = &model.joints[joint];
            joint.lower + (joint.upper - joint.lower) * rng.random::<f64>()
        });
        let tcp = model.tcp(&angles);
        if tcp.translation.z < 0.05 {
            continue;
        }
        tried += 1;
        let mut world = World::new();
        world.place_gripper(tcp, 0.05);
        if world.mount(Arc::clone(&model), tried).is_ok() {
            found += 1;
            let angles = world.configuration().unwrap();
            assert!(model.allows(&angles));
            let (off, turned) = apart(&model.tcp(&angles), &tcp);
            assert!(off < 1e-6 && turned < 1e-5, "{off} m, {turned} rad");
        }
    }
    assert!(found >= 196, "{found} of {tried}");
    for far in [standing(-1.1, 0.0, 0.3, 0.0), standing(0.0, 0.0, 1.9, 0.0), standing(0.12, 0.70, 0.2, 0.0)] {
        let mut world = World::new();
        world.place_gripper(far, 0.05);
        let error = world.mount(Arc::clone(&model), 0).unwrap_err().to_string();
        assert!(error.contains("out of its reach"), "{error}");
    }
}

#[test]
fn the_hand_goes_as_it_would_alone_and_the_arm_with_it() {
    let mut alone = World::new();
    alone.place_gripper(standing(0.0, 0.0, 0.3, 0.0), 0.06);
    let mut carried = ready();
    let model = ArmModel::builtin();
    // The poses that the scenes ask for: over the table, near and far, turned about the vertical, tilted as in a pour
    // and a scoop.
    for target in [
        standing(-0.29, 0.05, 0.06, 0.5),
        standing(-0.2, -0.27, 0.03, -0.5),
        pitched(0.17, 0.24, 2.0),
        pitched(0.02, 0.12, 1.3),
        standing(0.25, -0.15, 0.1, 0.3),
        standing(-0.05, 0.36, 0.11, 0.0),
        standing(0.0, 0.0, 0.3, 0.0),
    ] {
        let mut way = Vec::new();
        let mut before = carried.configuration().unwrap();
        let mut last = carried.tcp();
        let end = carried.move_hand(target, &mut |world| {
            let (angles, now) = (world.configuration().unwrap(), world.tcp());
            assert!(model.allows(&angles));
            for joint in 0..JOINTS {
                let speed = (angles[joint] - before[joint]).abs() / DT;
                assert!(speed <= 1.001 * model.joints[joint].speed, "{}: {speed} rad/s", model.joints[joint].name);
            }
            let (off, turned) = apart(&model.tcp(&angles), &now);
            assert!(off < 2e-4 && turned < 2e-3, "the arm is {off} m, {turned} rad from its hand");
            let (moved, turned) = apart(&last, &now);
            assert!(moved / DT < MAX_SPEED + 2e-3 && turned / DT < MAX_TURN + 0.1);
            (before, last) = (angles, now);
            way.push(now);
        });
        assert_eq!(end, MotionEnd::Reached, "{target}");
        let (off, turned) = apart(&target, &carried.tcp());
        assert!(off < 1e-6 && turned < 1e-3, "{off} m, {turned} rad off the target");
        // The way is straight: every place is on the line between the ends.
        let start = alone.tcp();
        assert_eq!(alone.move_hand(target, &mut |_| {}), MotionEnd::Reached);
        let line = (target.translation.vector - start.translation.vector).normalize();
        for place in &way {
            let from = place.translation.vector - start.translation.vector;
            assert!((from - line * from.dot(&line)).norm() < 1e-5, "{target}: not on the way");
        }
    }
    assert!(carried.is_finite());
}

/// A beam over the table in the way of the links, high above the hand's own way.
fn beam(world: &mut World, half: [f64; 3], at: [f64; 3]) {
    let [x, y, z] = at;
    world.add(block("beam", half, 1000.0, 0.5).fixed(), standing(x, y, z, 0.0)).unwrap();
}

#[test]
fn the_arm_goes_round_what_it_would_run_into() {
    let target = standing(0.25, 0.0, 0.15, 0.0);
    let touches =
        |world: &World| world.touching(ARM, "beam") || world.touching(ARM, TABLE) || world.touching(HAND, "beam");
    // A post stands between the forearm's first and last place. The hand's own way, along y = 0, is free.
    let mut world = ready();
    beam(&mut world, [0.02, 0.02, 0.4], [0.13, 0.22, 0.4]);
    let (mut furthest, mut touched): (f64, bool) = (0.0, false);
    let end = world.move_hand(target, &mut |world| {
        let at = world.tcp().translation.vector;
        furthest = furthest.max((at.yz() - Vector3::new(0.0, 0.0, at.z).yz()).norm());
        touched |= touches(world);
    });
    assert_eq!(end, MotionEnd::Reached);
    let (off, turned) = apart(&target, &world.tcp());
    assert!(off < 1e-5 && turned < 1e-3 && !touched, "{off} m, {turned} rad, touched: {touched}");
    assert!(furthest > 0.02, "that was straight: the post is not in the way");

    // A second run from the same seed is the same, bit for bit.
    let mut again = ready();
    beam(&mut again, [0.02, 0.02, 0.4], [0.13, 0.22, 0.4]);
    again.move_hand(target, &mut |_| {});
    assert_eq!(bits(&again), bits(&world));
}

#[test]
fn what_cannot_be_reached_or_planned_has_that_name_and_moves_nothing() {
    let mut world = ready();
    let before = (bits(&world), world.configuration());
    assert_eq!(world.move_hand(standing(-1.2, 0.0, 0.3, 0.0), &mut |_| {}), MotionEnd::OutOfReach);
    assert_eq!((bits(&world), world.configuration()), before);
    // Under a shelf that comes down to the hand's back there is room for the hand, and there is none for the arm.
    let mut world = ready();
    beam(&mut world, [0.25, 0.25, 0.02], [-0.05, -0.25, 0.19]);
    let before = (bits(&world), world.configuration());
    assert_eq!(world.move_hand(standing(-0.05, -0.25, 0.05, 0.0), &mut |_| {}), MotionEnd::NoPlan);
    assert_eq!((bits(&world), world.configuration()), before);
}

#[test]
fn what_is_held_is_no_obstacle_and_goes_along() {
    let mut world = ready();
    world.add(block("cube", [0.02; 3], 1000.0, 0.6), standing(-0.1, 0.05, 0.02, 0.4)).unwrap();
    let frame = world.pose("cube").unwrap();
    for (z, gripper) in
        [(0.13, Some(GripperCommand::Open(0.08))), (0.012, Some(GripperCommand::Close(30.0))), (0.15, None)]
    {
        let end = crate::common::keyframe(&mut world, &frame, pitched(0.0, z - 0.02, 0.0), gripper, 0.0, &mut |_| {});
        assert_eq!(end, MotionEnd::Reached);
    }
    assert!(world.grip_force("cube").iter().all(|force| *force > 20.0));
    assert_eq!(world.move_hand(pitched(0.2, 0.2, 1.2), &mut |_| {}), MotionEnd::Reached);
    assert!(apart(&world.tcp(), &world.pose("cube").unwrap()).0 < 0.03);
}

/// A motion loses nothing on its way, be it straight or round.
#[test]
fn what_is_held_is_held_on_every_way() {
    let mut rng = ChaCha8Rng::seed_from_u64(24);
    let (mut ways, mut straight) = (0, 0);
    for _ in 0..12 {
        let mut world = ready();
        world.add(block("cube", [0.02; 3], 1000.0, 0.6), standing(-0.1, 0.05, 0.02, 0.4)).unwrap();
        let frame = world.pose("cube").unwrap();
        for (z, gripper) in
            [(0.13, Some(GripperCommand::Open(0.08))), (0.012, Some(GripperCommand::Close(30.0))), (0.15, None)]
        {
            crate::common::keyframe(&mut world, &frame, pitched(0.0, z - 0.02, 0.0), gripper, 0.0, &mut |_| {});
        }
        let in_hand = |world: &World| world.tcp().inverse() * world.pose("cube").unwrap();
        let taken = in_hand(&world);
        for _ in 0..6 {
            let at = [rng.random_range(-0.25..0.3), rng.random_range(-0.25..0.25), rng.random_range(0.12..0.3)];
            let turn = rotation_about([0.0, 0.0, 1.0], rng.random_range(-1.5..1.5))
                * rotation_about([1.0, 0.0, 0.0], rng.random_range(-1.6..1.6));
            let (start, target) = (world.tcp().translation.vector, pose_at(at, turn));
            let line = (target.translation.vector - start).normalize();
            let mut widest = 0.0_f64;
            let end = world.move_hand(target, &mut |world| {
                let from = world.tcp().translation.vector - start;
                widest = widest.max((from - line * from.dot(&line)).norm());
            });
            if end == MotionEnd::Reached {
                ways += 1;
                straight += usize::from(widest < 1e-5);
            }
            let (slip, twist) = apart(&taken, &in_hand(&world));
            assert!(slip < 0.005 && twist < 0.05, "{end:?}: slipped {slip} m, {twist} rad, {widest} m off the line");
        }
    }
    assert!(straight >= 10 && ways - straight >= 10, "{straight} of {ways} ways were straight");
}

/// The lid rests on the pitcher alone, so it goes where the pitcher goes. It is not in the way of the arm that carries
/// both.
#[test]
fn what_rests_on_what_is_held_is_no_obstacle() {
    let mut world =
        crate::common::pouring(&Beads::new(5), standing(-0.16, 0.0, 0.0, 0.0), standing(0.16, 0.0, 0.0, 0.0));
    crate::common::close_pitcher(&mut world);
    world.mount(ArmModel::builtin(), 1).unwrap();
    crate::common::grasp(&mut world, &mut |_| {});
    let frame = world.pose("bowl").unwrap();
    let start = world.tcp().translation.vector;
    let target = frame * crate::common::lip(-0.03, 0.22, 0.0);
    let line = (target.translation.vector - start).normalize();
    let end = world.move_hand(target, &mut |world| {
        let from = world.tcp().translation.vector - start;
        assert!((from - line * from.dot(&line)).norm() < 1e-5, "not straight");
    });
    assert_eq!(end, MotionEnd::Reached);
    assert!(world.touching("lid", "pitcher"), "the lid is lost");
}

#[test]
fn a_snapshot_holds_the_arm_and_its_plans() {
    let mut world = ready();
    beam(&mut world, [0.02, 0.02, 0.4], [0.13, 0.22, 0.4]);
    world.move_hand(standing(0.0, -0.1, 0.25, 0.3), &mut |_| {});
    let snapshot = world.snapshot();
    let written: Snapshot = serde_json::from_str(&serde_json::to_string(&snapshot).unwrap()).unwrap();
    let on = |mut world: World| {
        let end = world.move_hand(standing(0.25, 0.0, 0.15, 0.0), &mut |_| {});
        let angles = world.configuration().unwrap();
        (end, bits(&world), angles.map(f64::to_bits))
    };
    let expected = on(world);
    assert_eq!(expected.0, MotionEnd::Reached);
    assert_eq!(on(World::restore(&snapshot)), expected);
    assert_eq!(on(World::restore(&written)), expected);
}
