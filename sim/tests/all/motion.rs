//! Motions of the hand: they arrive, keep their limits, and do not press on things.

use crate::common::{block, pitched, standing};
use situ_sim::{
    ABORT_FORCE, Bin, CONTACT_SPEED, DT, GUARD_FORCE, GripperCommand, MAX_SPEED, MAX_TURN, MotionEnd, Pose, World,
};

#[test]
fn a_free_motion_arrives_within_its_limits() {
    let mut world = World::new();
    world.place_gripper(standing(-0.2, 0.1, 0.3, 0.0), 0.05);
    for target in [pitched(0.2, 0.2, 1.2), pitched(0.2, 0.2, -0.4), pitched(0.201, 0.2, -0.4)] {
        let mut before = world.tcp();
        let end = world.move_hand(target, &mut |world| {
            let now = world.tcp();
            let speed = (now.translation.vector - before.translation.vector).norm() / DT;
            let turn = now.rotation.angle_to(&before.rotation) / DT;
            // The engine's poses are in single precision, so a speed is known to about a millimetre per second.
            assert!(speed < MAX_SPEED + 2e-3 && turn < MAX_TURN + 0.1, "{speed} m/s, {turn} rad/s");
            before = now;
        });
        assert_eq!(end, MotionEnd::Reached);
        let (off, turned) = crate::common::apart(&target, &world.tcp());
        assert!(off < 1e-6 && turned < 1e-3, "{off} m, {turned} rad off the target");
        assert!((world.opening() - 0.05).abs() < 1e-3);
    }
}

#[test]
fn a_hand_is_fast_far_from_things_and_slow_near_them() {
    let mut world = World::new();
    world.place_gripper(standing(0.0, 0.0, 0.5, 0.0), 0.06);
    let mut before = world.tcp();
    let (mut fastest, mut lowest_fast) = (0.0_f64, f64::INFINITY);
    let end = world.move_hand(standing(0.0, 0.0, 0.02, 0.0), &mut |world| {
        let speed = (world.tcp().translation.vector - before.translation.vector).norm() / DT;
        fastest = fastest.max(speed);
        if speed > CONTACT_SPEED + 2e-3 {
            lowest_fast = lowest_fast.min(world.tcp().translation.z);
        }
        before = world.tcp();
    });
    assert_eq!(end, MotionEnd::Reached);
    // The tips reach 12 mm below the tool centre point, and what is 20 mm from them is near.
    assert!(fastest > 3.0 * CONTACT_SPEED && lowest_fast > 0.012 + 0.02, "{fastest} m/s, {lowest_fast} m");
}

#[test]
fn a_grip_ends_when_the_fingers_rest() {
    for (command, opening) in
        [(GripperCommand::Close(20.0), 0.04), (GripperCommand::Open(0.07), 0.07), (GripperCommand::Open(0.06), 0.06)]
    {
        let mut world = World::new();
        world.add(block("cube", [0.02; 3], 1000.0, 0.6), standing(0.0, 0.0, 0.02, 0.0)).unwrap();
        world.place_gripper(standing(0.0, 0.0, 0.02, 0.0), 0.06);
        world.settle(0.1);
        let begins = world.time();
        world.grip(command, &mut |_| {});
        let seconds = world.time() - begins;
        assert!((0.04..0.3).contains(&seconds), "{command:?}: {seconds} s");
        assert!((world.opening() - opening).abs() < 1e-3, "{command:?}: {} m", world.opening());
    }
}

/// Drives the hand into something. Returns how that ended, and the hardest force on the way in newtons.
fn drive_into(world: &mut World, target: Pose) -> (MotionEnd, f64) {
    let mut hardest: f64 = 0.0;
    let end = world.move_hand(target, &mut |world| hardest = hardest.max(world.hand_force()));
    // The hand has backed off, so nothing presses any longer, and it can go on from there.
    world.hold(0.2, &mut |_| {});
    assert!(world.hand_force() < 3.0, "still pressing with {} N", world.hand_force());
    let from = world.tcp().translation.vector;
    let away = standing(from.x - 0.05, from.y, from.z + 0.1, 0.0);
    assert_eq!(world.move_hand(away, &mut |_| {}), MotionEnd::Reached);
    (end, hardest)
}

#[test]
fn the_guard_backs_off_from_a_wall() {
    let bin = Bin { inner: [0.14; 2], height: 0.06, wall: 0.005, density: 1000.0, friction: 0.4 };
    let mut on_wall = World::new();
    on_wall.add(bin.object("bin"), Pose::identity()).unwrap();
    on_wall.place_gripper(standing(0.0725, 0.0, 0.15, 0.0), 0.06);
    let mut on_post = World::new();
    let post = block("post", [0.02, 0.02, 0.1], 1000.0, 0.5).fixed();
    on_post.add(post, standing(0.1, 0.03, 0.1, 0.0)).unwrap();
    on_post.place_gripper(standing(0.0, 0.0, 0.1, 0.0), 0.06);
    // The keyframe is 3 mm too low, where the hand is already slow.
    let mut on_table = World::new();
    on_table.place_gripper(standing(0.0, 0.0, 0.1, 0.0), 0.06);

    for (name, world, target) in [
        ("wall", &mut on_wall, standing(0.0725, 0.0, 0.02, 0.0)),
        ("post", &mut on_post, standing(0.2, 0.0, 0.1, 0.0)),
        ("table", &mut on_table, standing(0.0, 0.0, 0.009, 0.0)),
    ] {
        let (end, hardest) = drive_into(world, target);
        // A palm in the post, which is fixed, makes no force in the engine. It stops the hand all the same.
        let felt = if name == "post" { 0.0 } else { GUARD_FORCE };
        assert!(matches!(end, MotionEnd::Guarded { force } if force >= felt), "{name}: {end:?}");
        assert!(hardest < 2.0 * ABORT_FORCE, "{name}: {hardest} N");
    }
    // The bin was touched, not thrown about.
    assert!(on_wall.pose("bin").unwrap().translation.vector.norm() < 0.01);
}

#[test]
fn a_blow_at_full_speed_aborts() {
    let mut world = World::new();
    world.place_gripper(standing(0.0, 0.0, 0.1, 0.0), 0.06);
    let (end, _) = drive_into(&mut world, standing(0.0, 0.0, -0.1, 0.0));
    assert!(matches!(end, MotionEnd::Aborted { force } if force > ABORT_FORCE), "{end:?}");
    assert!(world.is_finite());
}

#[test]
fn impossible_targets_are_refused() {
    let mut world = World::new();
    let before = crate::common::bits(&world);
    for x in [f64::NAN, f64::INFINITY, 50.0] {
        let end = world.move_hand(standing(x, 0.0, 0.2, 0.0), &mut |_| {});
        assert!(matches!(end, MotionEnd::Aborted { .. }));
    }
    assert_eq!(before, crate::common::bits(&world));
}
