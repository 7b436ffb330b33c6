//! Building scenes: what is refused, and what weighs, touches and contains what.

use crate::common::{BOWL, JUG, LID, block, handle, standing};
use situ_sim::{Beads, Bin, Cover, Cup, Drawer, Handle, Interior, Lid, Magnet, Mat, Object, Pose, SimError, World};

fn cube(name: &str) -> Object {
    block(name, [0.02; 3], 1000.0, 0.6)
}

#[test]
fn scattered_beads_are_where_they_were_put_and_fall_freely() {
    let beads = Beads::new(0);
    let centers = [[0.0, 0.0, 0.2], [0.1, -0.05, 0.3]];
    let mut world = World::new();
    for bad in [[f64::NAN, 0.0, 0.1], [0.0, 9.0, 0.1]] {
        assert!(matches!(world.scatter(&beads, &[centers[0], bad]), Err(SimError::BadPose { .. })));
    }
    assert!(world.scatter(&Beads { radius: 0.0, ..beads }, &centers).is_err());
    assert!(world.beads().is_empty(), "a refused call must put nothing in");
    world.scatter(&beads, &centers).unwrap();
    world.settle(0.1);
    let fallen = 0.5 * 9.81 * 0.1 * 0.1;
    for ((pose, center), at) in world.bead_poses().iter().zip(centers).zip(world.beads()) {
        assert_eq!(<[f64; 3]>::from(pose.translation.vector), at);
        assert!((pose.translation.x, pose.translation.y) == (f64::from(center[0] as f32), f64::from(center[1] as f32)));
        // A fall in steps of 1/240 s is up to 1 / 48 longer.
        assert!((fallen..1.03 * fallen).contains(&(center[2] - at[2])), "fell {} m", center[2] - at[2]);
    }
}

#[test]
fn impossible_scenes_are_refused() {
    let mut world = World::new();
    world.add(cube("a"), standing(0.0, 0.0, 0.02, 0.0)).unwrap();
    for name in ["a", "table", "hand"] {
        let error = world.add(cube(name), Pose::identity()).unwrap_err();
        assert!(matches!(error, SimError::DuplicateName { ref object } if object == name), "{error}");
    }
    for x in [f64::NAN, f64::INFINITY, 100.0] {
        assert!(matches!(world.add(cube("b"), standing(x, 0.0, 0.0, 0.0)), Err(SimError::BadPose { .. })));
    }
    let bad = [
        block("b", [0.02, -0.02, 0.02], 1000.0, 0.6),
        block("b", [0.02, f64::NAN, 0.02], 1000.0, 0.6),
        block("b", [0.02, 9.0, 0.02], 1000.0, 0.6),
        block("b", [0.02; 3], 0.0, 0.6),
        block("b", [0.02; 3], -1.0, 0.6),
        block("b", [0.02; 3], 1000.0, f64::INFINITY),
        Cup { sides: 2, ..BOWL }.object("b"),
        Cup { sides: u32::MAX, ..BOWL }.object("b"),
        Cup { height: 0.003, ..BOWL }.object("b"),
        Cup { flare: 1.7, ..BOWL }.object("b"),
        Cup { handle: Some(Handle { center: [0.01, 0.0, 0.05], ..handle() }), ..JUG }.object("b"),
        Lid { plug_depth: 0.0, ..LID }.object("b"),
        Object { parts: Vec::new(), ..cube("b") },
    ];
    for (case, object) in bad.into_iter().enumerate() {
        let error = world.add(object, Pose::identity()).unwrap_err();
        assert!(matches!(error, SimError::BadValue { ref object, .. } if object == "b"), "case {case}: {error}");
    }
    let magnet = |a: &str, force| Magnet { a: a.into(), b: "a".into(), seat: Pose::identity(), force, range: 0.005 };
    assert!(matches!(world.magnet(magnet("b", 1.0)), Err(SimError::UnknownObject { .. })));
    assert!(matches!(world.magnet(magnet("a", f64::NAN)), Err(SimError::BadValue { .. })));
    assert!(matches!(world.fill("a", &Beads::new(3)), Err(SimError::NoInterior { .. })));
    world.add(JUG.object("cup"), standing(0.3, 0.0, 0.0, 0.0)).unwrap();
    assert!(matches!(world.fill("cup", &Beads::new(1000)), Err(SimError::DoesNotFit { asked: 1000, .. })));
    assert!(matches!(world.fill("cup", &Beads { radius: f64::NAN, ..Beads::new(1) }), Err(SimError::BadValue { .. })));
    // What was refused has left no trace.
    assert_eq!(world.objects().collect::<Vec<_>>(), ["a", "cup"]);
    assert!(world.beads().is_empty() && world.is_finite());
}

#[test]
fn masses_are_those_of_the_shapes() {
    let mut world = World::new();
    let handle = Some(Handle { struts: Vec::new(), ..handle() });
    let cover = Cover { half: [0.06, 0.05], thickness: 0.004, knob: [0.008; 3], density: 400.0, friction: 0.4 };
    let bin = Bin { inner: [0.14, 0.10], height: 0.06, wall: 0.005, density: 800.0, friction: 0.4 };
    let drawer = Drawer {
        inner: [0.20, 0.14],
        height: 0.05,
        wall: 0.005,
        panel: [0.005, 0.09, 0.04],
        fin: [0.03, 0.006, 0.018],
        fin_z: 0.05,
        density: 700.0,
        friction: 0.5,
    };
    let drawer_volume =
        0.205 * 0.15 * 0.005 + (0.005 * 0.15 + 2.0 * 0.20 * 0.005) * 0.045 + 0.01 * 0.18 * 0.08 + 0.06 * 0.012 * 0.036;
    let objects = [
        (drawer.object("drawer"), 700.0 * drawer_volume, 1e-3),
        (cube("cube"), 1000.0 * 0.04 * 0.04 * 0.04, 1e-3),
        (cover.object("cover"), 400.0 * (0.12 * 0.10 * 0.004 + 0.016 * 0.016 * 0.016), 1e-3),
        // The closed form is that of a box with a smaller box taken out. Our walls start a little above the base and
        // run into the floor.
        (bin.object("bin"), 800.0 * (0.15 * 0.11 * 0.06 - 0.14 * 0.10 * 0.055), 0.15),
        // A hollow cylinder with a floor, and a bar.
        (
            Cup { handle, ..JUG }.object("cup"),
            1500.0 * (std::f64::consts::PI * (0.045 * 0.045 * 0.1 - 0.04 * 0.04 * 0.095) + 0.016 * 0.016 * 0.07),
            0.10,
        ),
    ];
    for (k, (object, mass, tolerance)) in objects.into_iter().enumerate() {
        let name = object.name.clone();
        world.add(object, standing(0.0, -0.4 + 0.2 * k as f64, 0.02, 0.0)).unwrap();
        world.step();
        let got = world.mass(&name).unwrap();
        assert!((got / mass - 1.0).abs() < tolerance, "{name} weighs {got} kg instead of {mass} kg");
    }
    assert_eq!(world.mass("nothing"), None);
}

#[test]
fn things_rest_touch_and_contain_as_they_look() {
    let mut world = World::new();
    world.place_gripper(standing(-0.3, 0.0, 0.3, 0.0), 0.05);
    world.add(cube("low"), standing(0.0, 0.0, 0.02, 0.0)).unwrap();
    world.add(cube("high"), standing(0.005, 0.0, 0.061, 0.0)).unwrap();
    world.add(cube("apart"), standing(0.2, 0.0, 0.02, 0.0)).unwrap();
    world.add(Mat { half: [0.05; 2] }.object("mat"), standing(0.2, 0.0, 0.0, 0.0)).unwrap();
    world.add(BOWL.object("bowl"), standing(0.0, 0.3, 0.0, 0.0)).unwrap();
    world.fill("bowl", &Beads::new(40)).unwrap();
    world.settle(0.5);
    assert!(world.touching("low", "high") && world.touching("high", "low"));
    assert!(world.touching("low", "table") && !world.touching("high", "table"));
    assert!(!world.touching("low", "apart") && !world.touching("low", "hand"));
    assert!(!world.touching("apart", "mat"), "a mark on the table is not in the way");
    let height = world.pose("high").unwrap().translation.z;
    assert!((height - 0.06).abs() < 2e-4, "a stack neither sinks nor floats: {height}");

    // A count by hand agrees: all beads lie low, within the bowl's rim.
    let centers = world.beads();
    let rim = 0.055 + 0.055 * libm::tan(0.35);
    assert!(centers.iter().all(|c| libm::hypot(c[0], c[1] - 0.3) < rim && (0.009..0.06).contains(&c[2])));
    assert_eq!((centers.len(), world.beads_inside("bowl")), (40, Some(40)));
    assert_eq!((world.beads_inside("low"), world.beads_inside("nothing")), (None, None));
}

#[test]
fn an_interior_is_what_the_walls_leave() {
    let cone = Interior::Cone { bottom_radius: 0.05, top_radius: 0.07, floor: 0.005, height: 0.065 };
    for (point, inside) in [
        ([0.0, 0.0, 0.006], true),
        ([0.0, 0.0, 0.004], false),
        ([0.0, 0.0, 0.064], true),
        ([0.0, 0.0, 0.066], false),
        ([0.059, 0.0, 0.035], true),
        ([0.0, -0.061, 0.035], false),
        ([0.055, 0.0, 0.006], false),
        ([f64::NAN, 0.0, 0.03], false),
    ] {
        assert_eq!(cone.contains(point, 0.0), inside, "{point:?}");
    }
    assert!(cone.contains([0.0, 0.0, 0.07], 0.01));
    let room = Interior::Box { half_x: 0.05, half_y: 0.02, floor: 0.005, height: 0.065 };
    assert!(room.contains([0.049, -0.019, 0.03], 0.0) && !room.contains([0.019, -0.021, 0.03], 0.0));
}

#[test]
fn what_is_inside_something_else_is_found() {
    let mut world = World::new();
    world.place_gripper(standing(0.0, 0.0, 0.3, 0.0), 0.06);
    world.add(cube("a"), standing(0.0, 0.0, 0.02, 0.0)).unwrap();
    world.add(Mat { half: [0.1; 2] }.object("mat"), standing(0.0, 0.0, 0.0, 0.0)).unwrap();
    world.add(cube("b"), standing(0.04, 0.0, 0.02, 0.0)).unwrap();
    assert_eq!(world.overlap(1e-4), None, "side by side, on a mark");
    world.add(cube("c"), standing(0.0, 0.035, 0.02, 0.0)).unwrap();
    let found = world.overlap(1e-4).unwrap();
    assert_eq!((found.a.as_str(), found.b.as_str()), ("a", "c"));
    assert!((found.depth - 0.005).abs() < 1e-5, "{}", found.depth);
    assert_eq!(world.overlap(0.006), None, "as much as is allowed");
    world.add(cube("sunk"), standing(0.3, 0.0, 0.013, 0.0)).unwrap();
    let found = world.overlap(1e-4).unwrap();
    assert_eq!((found.a.as_str(), found.b.as_str()), ("table", "sunk"));
    world.add(cube("held"), standing(-0.3, 0.0, 0.3, 0.0)).unwrap();
    assert_eq!(world.overlap(0.008), None);
    world.place_gripper(standing(-0.3, 0.0, 0.3, 0.0), 0.0);
    let found = world.overlap(1e-4).unwrap();
    assert_eq!((found.a.as_str(), found.b.as_str()), ("held", "hand"));
}
