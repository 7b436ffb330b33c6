//! Rolling friction against the closed form: a solid ball slows down by 5/7 μ g, and stays on a slope of less than
//! atan(μ). Without it, a ball rolls on.

use situ_sim::{Pose, Snapshot, Sphere, World, pose_at, rotation_about};

use crate::common::{bits, block, pitched, standing};

const G: f64 = 9.81;
/// Radius of the balls, metres.
const RADIUS: f64 = 0.02;
/// Half of the thickness of a ramp, metres.
const HALF: f64 = 0.01;

/// A ball at rest on a ramp that leads down towards +x by `slope` radians.
fn scene(friction: f64, slope: f64) -> World {
    let mut world = World::new();
    let ramp = pose_at([-0.3, 0.0, 0.06], rotation_about([0.0, 1.0, 0.0], slope));
    world.add(block("ramp", [0.2, 0.05, HALF], 1000.0, 0.6).fixed(), ramp).unwrap();
    let ball = Sphere { radius: RADIUS, density: 1000.0, friction: 0.6, rolling_friction: friction };
    world.add(ball.object("ball"), ramp * Pose::translation(-0.1, 0.0, HALF + RADIUS)).unwrap();
    world.place_gripper(standing(0.6, 0.5, 0.3, 0.0), 0.06);
    world
}

fn place(world: &World) -> f64 {
    world.pose("ball").unwrap().translation.x
}

/// Steps until a condition holds, for a minute at most. Returns whether it does.
fn until(world: &mut World, holds: impl Fn(&World) -> bool) -> bool {
    for _ in 0..60 * 240 {
        if holds(world) {
            return true;
        }
        world.step();
    }
    false
}

#[test]
fn a_ball_rolls_as_far_as_the_closed_form_says() {
    // So steep that the ball comes to rest on the table, which ends 1.5 m away.
    for (friction, slope) in [(0.01, 0.05), (0.02, 0.08), (0.05, 0.15)] {
        let mut world = scene(friction, slope);
        // Down the ramp and on along the table.
        assert!(until(&mut world, |world| place(world) > 0.0), "it rolls down");
        let (from, speed) = (place(&world), world.speed("ball").unwrap());
        assert!(until(&mut world, |world| world.speed("ball").unwrap() < 1e-4), "{friction}: it never comes to rest");
        let (way, expected) = (place(&world) - from, speed * speed / (2.0 * 5.0 / 7.0 * friction * G));
        assert!((way / expected - 1.0).abs() < 0.03, "{friction}: {way} m from {speed} m/s, and not {expected} m");
        let rest = place(&world);
        assert!(rest < 1.4, "{friction}: it has come to {rest} m, to the edge of the table");
        world.settle(2.0);
        assert!((place(&world) - rest).abs() < 1e-5, "{friction}: it does not stay");
    }
}

#[test]
fn a_ball_without_it_rolls_on() {
    let mut world = scene(0.0, 0.15);
    assert!(until(&mut world, |world| place(world) > 0.0));
    let speed = world.speed("ball").unwrap();
    world.settle(1.0);
    assert!(world.speed("ball").unwrap() > 0.97 * speed);
}

#[test]
fn a_slope_has_to_be_steeper_than_the_friction() {
    let slope = 0.08;
    for (friction, stays) in [(0.10, true), (0.085, true), (0.07, false), (0.03, false), (0.0, false)] {
        let mut world = scene(friction, slope);
        world.settle(0.1);
        let (from, before) = (place(&world), world.speed("ball").unwrap());
        world.settle(0.5);
        let way = (place(&world) - from) / libm::cos(slope);
        let expected = 5.0 / 7.0 * G * (libm::sin(slope) - friction * libm::cos(slope));
        let expected = if stays { 0.0 } else { 0.5 * before + 0.5 * expected * 0.25 };
        assert!((way - expected).abs() < 1e-4 + 0.03 * expected, "{friction}: {way} m, and not {expected} m");
    }
}

/// What the ball rolls on gets the opposite torque and, by friction, the ball's momentum.
#[test]
fn what_a_ball_rolls_on_is_pushed_along() {
    let mut world = World::new();
    world.add(block("board", [0.3, 0.1, 0.005], 500.0, 0.0), standing(0.0, 0.0, 0.005, 0.0)).unwrap();
    let ball = Sphere { radius: RADIUS, density: 8000.0, friction: 0.6, rolling_friction: 0.05 };
    world.add(ball.object("ball"), standing(-0.1, 0.0, 0.01 + RADIUS, 0.0)).unwrap();
    world.place_gripper(standing(0.6, 0.5, 0.3, 0.0), 0.06);
    // Somebody draws the board away below the ball, which stays behind at first and is then carried.
    world.push("board", [0.3, 0.0, 0.0], 1.0).unwrap();
    world.settle(1.0);
    let moving = place(&world) + 0.1;
    assert!(moving > 0.3 * 2.0 / 7.0, "without rolling friction it goes 2/7 of the way: {moving} m");
    assert!(moving < 0.3, "{moving} m");
}

#[test]
fn a_rolling_ball_goes_on_from_a_snapshot_bit_for_bit() {
    let mut world = scene(0.02, 0.15);
    assert!(until(&mut world, |world| place(world) > 0.0));
    let snapshot = world.snapshot();
    let text = serde_json::to_string(&snapshot).unwrap();
    let mut others = [World::restore(&snapshot), World::restore(&serde_json::from_str::<Snapshot>(&text).unwrap())];
    world.settle(0.7);
    for other in &mut others {
        other.settle(0.7);
        assert_eq!(bits(other), bits(&world));
    }
}

#[test]
fn impossible_rolling_is_refused() {
    let mut world = World::new();
    for friction in [-0.1, 1.5, f64::NAN] {
        let ball = Sphere { radius: RADIUS, density: 1000.0, friction: 0.6, rolling_friction: friction };
        let error = world.add(ball.object("ball"), pitched(0.0, 0.1, 0.0)).unwrap_err();
        assert!(error.to_string().contains("rolling friction must be 0 to 1"), "{error}");
    }
}
