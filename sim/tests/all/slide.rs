//! Slides: a drawer and a button go along their axis, within their limits, and stay where friction holds them.

use crate::common::{bits, block, pitched, standing};
use situ_sim::{GripperCommand, Guard, MotionEnd, Pose, SimError, Slide, Snapshot, World};

const TRAVEL: f64 = 0.15;

/// A slab that slides along −x of a fixed block turned by `yaw`, with a fin to take it by.
fn scene(yaw: f64, slide: Slide) -> World {
    let mut world = World::new();
    world.set_solver_iterations(16);
    world.add(block("case", [0.1, 0.08, 0.04], 1000.0, 0.5).fixed(), standing(0.1, 0.0, 0.04, yaw)).unwrap();
    let fin = block("fin", [0.03, 0.006, 0.02], 1000.0, 0.8);
    world.add(fin, world.pose("case").unwrap() * Pose::translation(-0.14, 0.0, 0.02)).unwrap();
    world.slide(&slide).unwrap();
    world
}

fn slide(friction: f64) -> Slide {
    let (parent, child) = ("case".to_owned(), "fin".to_owned());
    Slide { parent, child, axis: [-2.0, 0.0, 0.0], travel: TRAVEL, value: 0.0, friction, damping: 0.0, spring: 0.0 }
}

/// Takes the fin with a squeeze of `force` newtons and pulls by `way` metres. Returns the largest force on the hand
/// meanwhile, in newtons.
fn pull(world: &mut World, force: f64, way: f64) -> (MotionEnd, f64) {
    let frame = world.pose("fin").unwrap();
    world.place_gripper(frame * Pose::translation(0.0, 0.0, 0.1), 0.05);
    world.move_hand(frame, &mut |_| {});
    world.command(GripperCommand::Close(force));
    world.hold(0.5, &mut |_| {});
    let mut hardest: f64 = 0.0;
    let end = world.move_hand(frame * Pose::translation(-way, 0.0, 0.0), &mut |world| {
        hardest = hardest.max(world.hand_force());
    });
    (end, hardest)
}

/// How far the fin is off the axis of its slide, in metres and radians.
fn off_axis(world: &World) -> (f64, f64) {
    let place = world.pose("case").unwrap().inverse() * world.pose("fin").unwrap();
    let value = world.slide_value("fin").unwrap();
    crate::common::apart(&Pose::translation(-0.14 - value, 0.0, 0.02), &place)
}

#[test]
fn a_slide_keeps_its_axis_and_its_limits() {
    for yaw in [0.0, 0.4, 2.0] {
        let mut world = scene(yaw, slide(3.0));
        world.settle(1.0);
        assert!(world.slide_value("fin").unwrap().abs() < 1e-5, "gravity across the axis moves nothing");
        let (end, force) = pull(&mut world, 20.0, 0.10);
        assert_eq!(end, MotionEnd::Reached);
        let value = world.slide_value("fin").unwrap();
        assert!((value - 0.10).abs() < 2e-3, "pulled by 10 cm, it opened by {value} m");
        assert!((1.0..8.0).contains(&force), "3 N of friction feel like {force} N");
        let (off, turned) = off_axis(&world);
        assert!(off < 5e-4 && turned < 5e-3, "{off} m, {turned} rad off the axis");
        // The hand pulls further than the slide goes: the pads slip along the fin, and the slide stays within its
        // range.
        pull(&mut world, 20.0, 0.10);
        let value = world.slide_value("fin").unwrap();
        assert!((value - TRAVEL).abs() < 2e-3, "at the end of its range it is at {value} m");
        assert!(off_axis(&world).0 < 1e-3);
        // It stays where it is let go: no creep.
        world.command(GripperCommand::Open(0.06));
        world.hold(0.5, &mut |_| {});
        let before = world.slide_value("fin").unwrap();
        world.settle(5.0);
        assert!((world.slide_value("fin").unwrap() - before).abs() < 1e-5);
    }
    assert_eq!(scene(0.0, slide(1.0)).slide_value("case"), None);
}

#[test]
fn friction_holds_against_less_and_lets_go_for_more_than_its_force() {
    // A weight of 0.063 kg (0.615 N) on a vertical slide.
    for (friction, falls) in [(0.50, true), (0.58, true), (0.65, false), (0.80, false)] {
        let mut world = World::new();
        world.add(block("post", [0.02, 0.02, 0.3], 1000.0, 0.5).fixed(), standing(0.0, 0.0, 0.3, 0.0)).unwrap();
        let weight = block("weight", [0.02, 0.02, 0.0196], 1000.0, 0.5);
        world.add(weight, standing(0.05, 0.0, 0.4, 0.0)).unwrap();
        let (parent, child, axis) = ("post".to_owned(), "weight".to_owned(), [0.0, 0.0, -1.0]);
        let slide = Slide { parent, child, axis, travel: 0.3, value: 0.0, friction, damping: 0.0, spring: 0.0 };
        world.slide(&slide).unwrap();
        world.settle(2.0);
        let value = world.slide_value("weight").unwrap();
        let away = if falls { value > 0.05 } else { value < 1e-4 };
        assert!(away, "friction of {friction} N: moved by {value} m in 2 s");
    }
}

#[test]
fn a_spring_draws_back_and_a_damper_takes_its_time() {
    // It starts at 10 cm. With k = 4 N/m and c = 8 N·s/m it decays with c/k = 2 s, since the mass (29 g) is too small
    // to matter.
    let mut world = scene(0.3, Slide { value: 0.1, damping: 8.0, spring: 4.0, ..slide(0.0) });
    assert!((world.slide_value("fin").unwrap() - 0.1).abs() < 1e-6);
    world.settle(2.0);
    let value = world.slide_value("fin").unwrap();
    assert!((value - 0.1 * libm::exp(-1.0)).abs() < 1e-3, "after one time constant it is at {value} m");
}

#[test]
fn a_slide_that_is_pushed_goes_on_from_a_snapshot_bit_for_bit() {
    let mut world = scene(0.2, Slide { damping: 20.0, ..slide(3.0) });
    pull(&mut world, 15.0, 0.04);
    let snapshot = world.snapshot();
    let text = serde_json::to_string(&snapshot).unwrap();
    let mut others =
        [World::restore(&snapshot), World::restore(&serde_json::from_str::<Snapshot>(&text).unwrap()), world.clone()];
    let go_on = |world: &mut World| {
        let end = world.move_hand(world.tcp() * pitched(-0.05, 0.0, 0.0), &mut |_| {});
        world.command(GripperCommand::Open(0.06));
        world.push("case", [0.0, 0.05, 0.0], 0.4).unwrap();
        world.settle(0.6);
        (end, world.slide_value("fin").map(f64::to_bits), bits(world))
    };
    let first = go_on(&mut world);
    for other in &mut others {
        assert_eq!(go_on(other), first);
    }
    // The fin has come along with its case.
    assert!(off_axis(&world).0 < 1e-3);
}

#[test]
fn the_guard_is_what_it_was_set_to() {
    // Fingers push a slide in by 5 cm against 45 N of friction.
    let push = |guard: Option<Guard>| {
        let mut world = scene(0.0, Slide { value: 0.1, ..slide(45.0) });
        guard.iter().for_each(|guard| world.set_guard(*guard).unwrap());
        let touch = world.pose("fin").unwrap() * Pose::translation(-0.041, 0.0, 0.0);
        world.place_gripper(touch, 0.0);
        let end = world.move_hand(touch * Pose::translation(0.051, 0.0, 0.0), &mut |_| {});
        (end, world.slide_value("fin").unwrap())
    };
    let (end, value) = push(None);
    assert!(matches!(end, MotionEnd::Guarded { force } if (30.0..45.0).contains(&force)), "{end:?}");
    assert!(value > 0.08, "stopped, it was pushed to {value} m all the same");
    assert_eq!(push(Some(Guard::default())), (end, value));
    let (end, value) = push(Some(Guard { rise: 60.0, abort: 150.0 }));
    assert_eq!(end, MotionEnd::Reached);
    assert!((value - 0.05).abs() < 2e-3, "pushed by 5 cm to {value} m");
    assert!(matches!(push(Some(Guard { rise: 40.0, abort: 40.0 })).0, MotionEnd::Aborted { .. }));
}

#[test]
fn impossible_slides_and_guards_are_refused() {
    let mut world = World::new();
    world.add(block("case", [0.1; 3], 1000.0, 0.5).fixed(), standing(0.1, 0.0, 0.1, 0.0)).unwrap();
    world.add(block("fin", [0.02; 3], 1000.0, 0.5), standing(-0.1, 0.0, 0.1, 0.0)).unwrap();
    let before = bits(&world);
    for wrong in [
        Slide { axis: [0.0; 3], ..slide(1.0) },
        Slide { axis: [f64::NAN, 0.0, 1.0], ..slide(1.0) },
        Slide { travel: 0.0, ..slide(1.0) },
        Slide { value: 0.2, ..slide(1.0) },
        Slide { damping: -1.0, ..slide(1.0) },
        Slide { spring: f64::INFINITY, ..slide(1.0) },
        slide(-1.0),
    ] {
        assert!(matches!(world.slide(&wrong), Err(SimError::BadValue { object, .. }) if object == "fin"), "{wrong:?}");
    }
    let named = |parent: &str, child: &str| Slide { parent: parent.to_owned(), child: child.to_owned(), ..slide(1.0) };
    assert!(matches!(world.slide(&named("case", "door")), Err(SimError::UnknownObject { .. })));
    for (parent, child) in [("fin", "case"), ("fin", "fin")] {
        assert!(matches!(world.slide(&named(parent, child)), Err(SimError::NoSlide { .. })));
    }
    for (rise, abort) in [(0.0, 10.0), (20.0, 10.0), (f64::NAN, 10.0), (10.0, f64::INFINITY)] {
        assert!(world.set_guard(Guard { rise, abort }).is_err());
    }
    assert_eq!(before, bits(&world));
    world.slide(&slide(1.0)).unwrap();
    assert!(matches!(world.slide(&slide(1.0)), Err(SimError::NoSlide { .. })), "it slides already");
}
