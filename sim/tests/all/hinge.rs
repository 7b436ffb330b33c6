//! Hinges: a door, a lid and a lever turn about their axis, within their limits, and stay where friction holds them.

use situ_sim::{
    GripperCommand, Hinge, MotionEnd, Object, Panel, Pose, SimError, Slide, Snapshot, World, pose_at, rotation_about,
};

use crate::common::{apart, bits, block, standing};

const G: f64 = 9.81;
/// Half of the length, width and thickness of the rod of a pendulum, metres.
const ROD: [f64; 3] = [0.1, 0.01, 0.01];
const DENSITY: f64 = 1000.0;

/// A rod that hangs on a post by its end, drawn up by `value` radians from hanging straight down to the side of −x.
/// Value 0 is 1.5 rad to the other side.
fn pendulum(value: f64, friction: f64, damping: f64) -> World {
    let mut world = World::new();
    world.place_gripper(standing(0.8, 0.8, 0.3, 0.0), 0.06);
    world.add(block("post", [0.02, 0.02, 0.02], DENSITY, 0.5).fixed(), standing(0.0, 0.0, 0.5, 0.3)).unwrap();
    let frame = world.pose("post").unwrap();
    let hinge = Hinge {
        parent: "post".to_owned(),
        child: "rod".to_owned(),
        at: [0.0, -0.05, 0.0],
        axis: [0.0, 2.0, 0.0],
        travel: 3.0,
        value,
        friction,
        damping,
        spring: 0.0,
    };
    // Its long axis is x: turned by π/2 about y, it hangs.
    let hanging = pose_at([0.0, -0.05, -ROD[0]], rotation_about([0.0, 1.0, 0.0], std::f64::consts::FRAC_PI_2));
    let seat = hinge.turned(&hanging, -1.5);
    world.add(block("rod", ROD, DENSITY, 0.5), frame * hinge.turned(&seat, value)).unwrap();
    world.hinge(&hinge).unwrap();
    world
}

fn value(world: &World) -> f64 {
    world.hinge_value("rod").unwrap()
}

fn mass() -> f64 {
    8.0 * ROD[0] * ROD[1] * ROD[2] * DENSITY
}

/// Moment of inertia about the hinge at the rod's end: that about the middle, and the mass at half of the length.
fn inertia() -> f64 {
    mass() * ((ROD[0] * ROD[0] + ROD[2] * ROD[2]) / 3.0 + ROD[0] * ROD[0])
}

#[test]
fn a_rod_swings_with_the_period_of_a_pendulum() {
    let swing = 0.2;
    let mut world = pendulum(1.5 + swing, 0.0, 0.0);
    assert!((value(&world) - 1.5 - swing).abs() < 1e-5);
    // From the turning point down and up again: the times at which it passes the lowest point.
    let mut passes = Vec::new();
    let mut before = value(&world) - 1.5;
    for _ in 0..4 * 240 {
        world.step();
        let now = value(&world) - 1.5;
        if before.signum() != now.signum() {
            passes.push(world.time() - now / (now - before) / 240.0);
        }
        before = now;
    }
    let period = 2.0 * (passes[passes.len() - 1] - passes[0]) / (passes.len() - 1) as f64;
    // The period of a physical pendulum, with the first term of the amplitude.
    let small = std::f64::consts::TAU * libm::sqrt(inertia() / (mass() * G * ROD[0]));
    let expected = small * (1.0 + swing * swing / 16.0);
    assert!((period / expected - 1.0).abs() < 0.01, "{period} s, and not {expected} s");
    assert!(passes.len() >= 9, "it swings on: {passes:?}");
}

#[test]
fn a_hinge_keeps_its_axis_and_its_limits() {
    // Heavy friction apart, it falls against the end of its range from either side.
    for (start, end) in [(0.0, 3.0), (3.0, 0.0)] {
        let mut world = pendulum(start, 0.0, 0.0);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for _ in 0..3 * 240 {
            world.step();
            (least, most) = (least.min(value(&world)), most.max(value(&world)));
            let frame = world.pose("post").unwrap().inverse() * world.pose("rod").unwrap();
            let expected = pose_at(
                [0.0, -0.05, 0.0],
                rotation_about([0.0, 1.0, 0.0], value(&world) - 1.5 + std::f64::consts::FRAC_PI_2),
            ) * Pose::translation(ROD[0], 0.0, 0.0);
            let (off, turned) = apart(&expected, &frame);
            assert!(off < 2e-3 && turned < 0.02, "{off} m, {turned} rad off the axis at {}", value(&world));
        }
        assert!(least > -0.05 && most < 3.05, "{least} to {most}");
        assert!((end - 1.5_f64).signum() * (if end > 1.5 { most } else { least } - 1.5) > 1.2, "it swings across");
    }
    assert_eq!(pendulum(0.0, 0.0, 0.0).hinge_value("post"), None);
    assert_eq!(pendulum(0.0, 0.0, 0.0).hinge_travel("rod"), Some(3.0));
}

#[test]
fn friction_holds_against_less_and_lets_go_for_more_than_its_torque() {
    // Level, the weight turns with m g l; 0.0785 N·m.
    let torque = mass() * G * ROD[0];
    let level = 1.5 - std::f64::consts::FRAC_PI_2 + 0.1;
    let torque = torque * libm::cos(0.1);
    for (part, falls) in [(0.9, true), (0.97, true), (1.03, false), (1.2, false)] {
        let mut world = pendulum(level, part * torque, 0.0);
        world.settle(1.5);
        let way = (value(&world) - level).abs();
        assert!(if falls { way > 0.05 } else { way < 1e-3 }, "friction of {part} of the torque: turned by {way} rad");
    }
}

#[test]
fn a_damper_takes_its_time() {
    // So strong that the inertia does not matter: c dθ/dt = − m g l sin θ,
    // or tan(θ/2) = tan(θ₀/2) e^(− m g l t / c).
    let (damping, seconds, from) = (0.1, 1.0, 1.0);
    let mut world = pendulum(1.5 + from, 0.0, damping);
    world.settle(seconds);
    let rate = mass() * G * ROD[0] / damping;
    let expected = 2.0 * libm::atan(libm::tan(0.5 * from) * libm::exp(-rate * seconds));
    assert!((value(&world) - 1.5 - expected).abs() < 0.02, "{} rad, and not {expected}", value(&world) - 1.5);
}

/// A box that stands fast, with a lid that turns about its far edge, the bar towards −x.
fn chest() -> (World, Hinge) {
    with_lid(block("chest", [0.065, 0.065, 0.04], 1000.0, 0.5).fixed())
}

/// A chest with its lid.
fn with_lid(chest: Object) -> (World, Hinge) {
    let mut world = World::new();
    world.add(chest, standing(0.1, 0.0, 0.04, 0.2)).unwrap();
    let panel = Panel {
        half: [0.065, 0.065, 0.004],
        bar_at: [-0.05, 0.0, 0.020],
        bar: [0.008, 0.006, 0.016],
        density: 500.0,
        friction: 0.8,
    };
    let frame = world.pose("chest").unwrap();
    world.add(panel.object("lid"), frame * Pose::translation(0.0, 0.0, 0.045)).unwrap();
    let (parent, child) = ("chest".to_owned(), "lid".to_owned());
    let (at, axis) = ([0.065, 0.0, 0.041], [0.0, 1.0, 0.0]);
    let hinge = Hinge { parent, child, at, axis, travel: 1.8, value: 0.0, friction: 0.08, damping: 0.0, spring: 0.0 };
    world.hinge(&hinge).unwrap();
    (world, hinge)
}

/// Takes the bar of the lid and follows its arc up to an angle.
fn open(world: &mut World, hinge: &Hinge, angle: f64) -> Vec<MotionEnd> {
    let (frame, lid) = (world.pose("chest").unwrap(), world.pose("lid").unwrap());
    let grasp = lid * Pose::translation(-0.05, 0.0, 0.024);
    world.place_gripper(grasp * Pose::translation(0.0, 0.0, 0.1), 0.05);
    let mut ends = vec![world.move_hand(grasp, &mut |_| {})];
    world.command(GripperCommand::Close(20.0));
    world.hold(0.5, &mut |_| {});
    let steps = libm::ceil(angle / 0.2) as u32;
    for step in 1..=steps {
        let on_arc = hinge.turned(&(frame.inverse() * grasp), angle * f64::from(step) / f64::from(steps));
        ends.push(world.move_hand(frame * on_arc, &mut |_| {}));
    }
    ends
}

#[test]
fn a_lid_is_opened_by_its_bar_and_stays_open() {
    let (mut world, hinge) = chest();
    let ends = open(&mut world, &hinge, 1.2);
    assert!(ends.iter().all(|end| *end == MotionEnd::Reached), "{ends:?}");
    let angle = world.hinge_value("lid").unwrap();
    assert!((angle - 1.2).abs() < 0.06, "opened by 1.2 rad, it is at {angle}");
    world.command(GripperCommand::Open(0.06));
    world.hold(0.5, &mut |_| {});
    let before = world.hinge_value("lid").unwrap();
    world.settle(3.0);
    assert!((world.hinge_value("lid").unwrap() - before).abs() < 2e-3, "it does not stay");
}

#[test]
fn a_hinge_that_is_turned_goes_on_from_a_snapshot_bit_for_bit() {
    let (mut world, hinge) = chest();
    open(&mut world, &hinge, 0.5);
    let go_on = |world: &mut World| {
        world.move_hand(world.tcp() * Pose::translation(0.01, 0.0, 0.03), &mut |_| {});
        world.command(GripperCommand::Open(0.06));
        world.settle(0.6);
        (world.hinge_value("lid").map(f64::to_bits), bits(world))
    };
    // While it is held, when its chest begins to be pushed, on the way, and some time later.
    for (seconds, push) in [(0.0, false), (0.0, true), (0.1, false), (0.5, false)] {
        if push {
            world.push("chest", [0.0, 0.05, 0.0], 0.4).unwrap();
        }
        world.settle(seconds);
        let snapshot = world.snapshot();
        let text = serde_json::to_string(&snapshot).unwrap();
        let read: Snapshot = serde_json::from_str(&text).unwrap();
        let [first, others @ ..] =
            [world.clone(), World::restore(&snapshot), World::restore(&read)].map(|mut world| go_on(&mut world));
        assert!(others.iter().all(|other| *other == first), "{seconds}");
    }
}

/// The chest stood where it was, and once it had been pushed its lid went round and round, through its limits.
#[test]
fn what_is_pushed_takes_its_lid_along_and_its_hinge_holds_as_before() {
    let chest = || block("chest", [0.065, 0.065, 0.04], 1000.0, 0.5);
    for (chest, angle, by) in [
        (chest().fixed(), 0.0, [0.0, 0.1, 0.0]),
        (chest().fixed(), 0.9, [-0.08, 0.0, 0.0]),
        (chest(), 0.0, [0.05, -0.05, 0.0]),
        (chest(), 0.9, [0.0, 0.1, 0.0]),
    ] {
        let (mut world, hinge) = with_lid(chest);
        if angle > 0.0 {
            open(&mut world, &hinge, angle);
            world.command(GripperCommand::Open(0.06));
            world.hold(0.5, &mut |_| {});
            world.place_gripper(standing(-0.3, 0.3, 0.4, 0.0), 0.06);
        }
        let (before, value_before) = (world.pose("chest").unwrap(), world.hinge_value("lid").unwrap());
        world.push("chest", by, 0.5).unwrap();
        let mut worst = 0.0_f64;
        world.hold(0.6, &mut |world| {
            let place = world.pose("chest").unwrap().inverse() * world.pose("lid").unwrap();
            let value = world.hinge_value("lid").unwrap();
            let (off, turned) = apart(&hinge.turned(&Pose::translation(0.0, 0.0, 0.045), value), &place);
            worst = worst.max(off).max(turned).max((value - value_before).abs());
        });
        assert!(worst < 5e-3, "{by:?}: {worst} off the axis or from the angle");
        let moved = world.pose("chest").unwrap().translation.vector - before.translation.vector;
        assert!((moved - nalgebra::Vector3::from(by)).norm() < 2e-3, "{by:?}: moved by {moved}");
        // Friction holds it where it is, and at the end of its range its stop.
        if angle > 0.0 {
            world.settle(2.0);
            assert!((world.hinge_value("lid").unwrap() - value_before).abs() < 5e-3, "{by:?}: it does not stay");
        } else {
            let ends = open(&mut world, &hinge, 1.2);
            assert!(ends.iter().all(|end| *end == MotionEnd::Reached), "{by:?}: {ends:?}");
            world.command(GripperCommand::Open(0.06));
            world.settle(2.0);
            let value = world.hinge_value("lid").unwrap();
            assert!((value - 1.2).abs() < 0.06, "{by:?}: opened by 1.2 rad, it is at {value}");
        }
    }
}

#[test]
fn impossible_hinges_are_refused() {
    let (mut world, hinge) = chest();
    world.add(block("door", [0.02; 3], 1000.0, 0.5), standing(-0.1, 0.2, 0.1, 0.0)).unwrap();
    let door = Hinge { child: "door".to_owned(), ..hinge.clone() };
    for wrong in [
        Hinge { axis: [0.0; 3], ..door.clone() },
        Hinge { axis: [f64::NAN, 0.0, 1.0], ..door.clone() },
        Hinge { at: [0.0, 3.0, 0.0], ..door.clone() },
        Hinge { travel: 0.0, ..door.clone() },
        Hinge { travel: 3.5, ..door.clone() },
        Hinge { value: 2.0, ..door.clone() },
        Hinge { friction: -1.0, ..door.clone() },
        Hinge { damping: f64::INFINITY, ..door.clone() },
        Hinge { spring: -1.0, ..door.clone() },
    ] {
        assert!(matches!(world.hinge(&wrong), Err(SimError::BadValue { object, .. }) if object == "door"), "{wrong:?}");
    }
    let named =
        |parent: &str, child: &str| Hinge { parent: parent.to_owned(), child: child.to_owned(), ..hinge.clone() };
    assert!(matches!(world.hinge(&named("chest", "gate")), Err(SimError::UnknownObject { .. })));
    for (parent, child) in [("door", "chest"), ("door", "door"), ("chest", "lid")] {
        assert!(matches!(world.hinge(&named(parent, child)), Err(SimError::NoHinge { .. })), "{parent}, {child}");
    }
    let slide = Slide {
        parent: "chest".to_owned(),
        child: "lid".to_owned(),
        axis: [1.0, 0.0, 0.0],
        travel: 0.1,
        value: 0.0,
        friction: 1.0,
        damping: 0.0,
        spring: 0.0,
    };
    assert!(matches!(world.slide(&slide), Err(SimError::NoSlide { .. })), "it turns already");
    world.hinge(&door).unwrap();
    assert!(matches!(world.push("door", [0.0, 0.1, 0.0], 1.0), Err(SimError::NoPush { .. })));
}
