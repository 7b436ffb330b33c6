//! `inside` and `filled`: what a container holds.
//!
//! The rooms of the containers are written out here, from the files of the tasks, as solids of a floor, a rim and
//! walls. Whether a thing or a bead is in one follows from places and axes alone. Where nothing holds the thing, a
//! second oracle asks the walls: somebody jerks the container aside in a copy. A thing inside has to come along, and a
//! thing that lies on it stays behind.
//!
//! `inside` is made by letting things fall into containers. Near misses lie above the rim, on the cover, on the roof,
//! on a heap, beside the wall.
//!
//! `filled` is made by pouring some of the beads. With n beads in the container, the condition asks for half a bead
//! less or half a bead more.

use situ_sim::{GripperCommand, Pose, pose_at, rotation_about};

use crate::predicates::confusion::Labels;
use crate::predicates::scene::{FIRM, GRASP, HALF_OPEN, SEEDS, Scene};

/// The room inside a container, in its frame, metres.
#[derive(Clone, Copy)]
enum Room {
    /// Half of its length and width, floor, rim.
    Box([f64; 4]),
    /// Radius at the floor, lean of the walls (radians), floor, rim.
    Cup([f64; 4]),
}

const BIN: Room = Room::Box([0.07, 0.07, 0.005, 0.08]);
const LOW_BIN: Room = Room::Box([0.07, 0.07, 0.005, 0.12]);
const HALF_ROOFED_BIN: Room = Room::Box([0.07, 0.15, 0.005, 0.08]);
const DRAWER: Room = Room::Box([0.10, 0.07, 0.005, 0.05]);
const PITCHER: Room = Room::Cup([0.040, 0.0, 0.005, 0.10]);
const BOWL: Room = Room::Cup([0.055, 0.35, 0.005, 0.06]);
const VASE: Room = Room::Cup([0.06, 0.1, 0.005, 0.16]);
const FULL_BOWL: Room = Room::Cup([0.055, 0.35, 0.005, 0.068]);
const LADLE: Room = Room::Cup([0.026, 0.25, 0.003, 0.023]);

impl Room {
    /// Whether a point in the container's frame is in the room.
    fn has(self, [x, y, z]: [f64; 3]) -> bool {
        let (floor, rim, is_within_walls) = match self {
            Room::Box([half_x, half_y, floor, rim]) => (floor, rim, x.abs() <= half_x && y.abs() <= half_y),
            Room::Cup([radius, lean, floor, rim]) => {
                (floor, rim, libm::hypot(x, y) <= radius + (z - floor) * libm::tan(lean))
            }
        };
        (floor..=rim).contains(&z) && is_within_walls
    }
}

pub(crate) fn inside() -> Labels {
    let mut labels = Labels::new("inside");
    for seed in SEEDS {
        bin(&mut labels, seed);
        on_top(&mut labels, seed);
        drawer(&mut labels, seed);
    }
    bowl(&mut labels);
    labels
}

/// Whether the walls of `b` take `a` along when somebody jerks it by 15 cm: friction alone would not.
fn walls_carry(scene: &Scene, a: &str, b: &str) -> bool {
    const JERK: [f64; 3] = [0.15, 0.0, 0.0];
    let jerked = scene.bumped(b, JERK, 0.12);
    scene.center(a)[0] + 0.6 * JERK[0] < jerked.center(a)[0]
}

/// Puts a block down at a place in a frame from above, and goes away upwards.
fn let_down(scene: &mut Scene, frame: &Pose, [x, y]: [f64; 2], height: f64) {
    scene.go_in(frame, [x, y, height + 0.08], None);
    scene.go_in(frame, [x, y, height], Some(GripperCommand::Open(0.065)));
    scene.shift([0.0, 0.0, 0.10]);
}

/// Cubes in, over and beside open bins.
fn bin(labels: &mut Labels, seed: u64) {
    for (variation, room, rim) in [(None, BIN, 0.08), (Some("low_bins"), LOW_BIN, 0.12)] {
        let mut scene = Scene::start("sort_blocks", variation, seed);
        let red = |scene: &Scene| room.has(scene.place_in("red_1", "red_bin"));
        let carried = |scene: &Scene| walls_carry(scene, "red_1", "red_bin");
        let frame = scene.frame("red_bin");
        scene.pick("red_1");
        scene.go_in(&frame, [0.0, 0.0, 0.20], None);
        labels.near_miss(&scene, "inside(red_1, red_bin)", "held high over it", red(&scene) || carried(&scene));
        scene.go_in(&frame, [0.0, 0.0, rim + GRASP + 0.003], None);
        labels.near_miss(&scene, "inside(red_1, red_bin)", "held, its middle 3 mm above the rim", red(&scene));
        scene.go_in(&frame, [0.0, 0.0, rim + GRASP - 0.003], None);
        labels.truly(&scene, "inside(red_1, red_bin)", "held, its middle 3 mm below the rim", red(&scene));
        scene.grip(GripperCommand::Open(0.065));
        scene.shift([0.0, 0.0, 0.10]);
        labels.truly(&scene, "inside(red_1, red_bin)", "let fall into it", red(&scene) && carried(&scene));
        let other = room.has(scene.place_in("red_1", "blue_bin")) || walls_carry(&scene, "red_1", "blue_bin");
        labels.near_miss(&scene, "inside(red_1, blue_bin)", "it is in the other bin", other);
        scene.pick("red_1");
        scene.shift([0.0, 0.0, 0.10]);
        labels.dropped_later(&scene, "inside(red_1, red_bin)", "taken out again, over it", red(&scene));
        let_down(&mut scene, &frame, [-0.099, 0.0], GRASP + 0.021);
        labels.dropped_later(
            &scene,
            "inside(red_1, red_bin)",
            "put down beside its wall",
            red(&scene) || carried(&scene),
        );
    }
}

/// Cubes on what closes a bin.
fn on_top(labels: &mut Labels, seed: u64) {
    let mut scene = Scene::start("sort_blocks", Some("cover"), seed);
    let frame = scene.frame("red_bin");
    scene.pick("red_1");
    let_down(&mut scene, &frame, [0.04, 0.04], 0.086 + 0.02 + GRASP + 0.001);
    let is_in = |scene: &Scene, room: Room| {
        room.has(scene.place_in("red_1", "red_bin")) || walls_carry(scene, "red_1", "red_bin")
    };
    labels.near_miss(&scene, "inside(red_1, red_bin)", "on its cover", is_in(&scene, BIN));

    let mut scene = Scene::start("sort_blocks", Some("half_roof"), seed);
    let frame = scene.frame("red_bin");
    scene.pick("red_1");
    let_down(&mut scene, &frame, [0.0, 0.0], 0.09 + 0.02 + GRASP + 0.001);
    labels.near_miss(&scene, "inside(red_1, red_bin)", "on its roof", is_in(&scene, HALF_ROOFED_BIN));
    scene.pick("red_1");
    let_down(&mut scene, &frame, [0.0, 0.09], 0.10);
    let is_in = HALF_ROOFED_BIN.has(scene.place_in("red_1", "red_bin"));
    labels.truly(&scene, "inside(red_1, red_bin)", "through the gap in its roof", is_in);

    // Two cubes fill a bin up to its rim; a third one is heaped on them.
    let mut scene = Scene::start("sort_blocks", None, seed);
    let frame = scene.frame("red_bin");
    for (block, height) in [("red_1", 0.0), ("red_2", 0.04), ("blue_1", 0.08)] {
        scene.pick(block);
        let_down(&mut scene, &frame, [0.0, 0.0], 0.005 + height + 0.02 + GRASP + 0.001);
        let (condition, is_in) = (format!("inside({block}, red_bin)"), BIN.has(scene.place_in(block, "red_bin")));
        if block == "blue_1" {
            labels.near_miss(&scene, &condition, "the third of a heap", is_in);
        } else {
            labels.truly(&scene, &condition, "one of a heap", is_in);
        }
    }
}

/// A block and a drawer.
fn drawer(labels: &mut Labels, seed: u64) {
    let mut scene = Scene::start("drawer", None, seed);
    let is_in = |scene: &Scene| DRAWER.has(scene.place_in("block", "drawer"));
    let frame = scene.frame("drawer");
    scene.go_in(&frame, [-0.13, 0.0, 0.17], Some(HALF_OPEN));
    scene.go_in(&frame, [-0.13, 0.0, 0.06], Some(GripperCommand::Close(10.0)));
    scene.go_in(&frame, [-0.29, 0.0, 0.06], Some(HALF_OPEN));
    scene.go_in(&frame, [-0.29, 0.0, 0.17], None);
    scene.pick("block");
    scene.shift([0.0, 0.0, 0.10]);
    scene.go("drawer", [-0.035, 0.0, 0.20], None);
    scene.go("drawer", [-0.035, 0.0, 0.05 + GRASP + 0.002], None);
    labels.near_miss(&scene, "inside(block, drawer)", "held, its middle 2 mm above the rim", is_in(&scene));
    scene.go("drawer", [-0.035, 0.0, 0.042], Some(GripperCommand::Open(0.065)));
    scene.shift([0.0, 0.0, 0.15]);
    labels.truly(&scene, "inside(block, drawer)", "put into it", is_in(&scene));
    scene.pick("block");
    labels.dropped_later(&scene, "inside(block, drawer)", "taken out again", is_in(&scene));
    scene.shift([0.0, 0.0, 0.05]);
    // The cabinet's top is 14 cm above its base, the block 18 mm to each side.
    let frame = scene.frame("cabinet");
    let_down(&mut scene, &frame, [0.0, 0.0], 0.14 + 0.018 + GRASP + 0.001);
    labels.near_miss(&scene, "inside(block, drawer)", "on the cabinet", is_in(&scene));
}

/// A lid and a bowl.
fn bowl(labels: &mut Labels) {
    let mut scene = Scene::start("pour", Some("lid"), SEEDS[0]);
    let is_in = |scene: &Scene| BOWL.has(scene.place_in("lid", "bowl"));
    // The origin of the lid is the underside of its flange, which is 4 mm thick and lies on the rim; its plug is
    // inside.
    let [x, y, z] = scene.place_in("lid", "pitcher");
    labels.near_miss(&scene, "inside(lid, pitcher)", "on it, its plug inside", PITCHER.has([x, y, z + 0.002]));
    scene.go("lid", [0.0, 0.0, 0.12], Some(HALF_OPEN));
    scene.go("lid", [0.0, 0.0, 0.020], Some(GripperCommand::Close(20.0)));
    scene.go("lid", [0.0, 0.0, 0.12], None);
    scene.go("bowl", [0.0, 0.0, 0.09], None);
    labels.near_miss(&scene, "inside(lid, bowl)", "held over it", is_in(&scene));
    scene.go("bowl", [0.0, 0.0, 0.075], Some(HALF_OPEN));
    scene.shift([0.0, 0.0, 0.10]);
    labels.truly(&scene, "inside(lid, bowl)", "let fall into it", is_in(&scene) && walls_carry(&scene, "lid", "bowl"));
}

pub(crate) fn filled() -> Labels {
    let mut labels = Labels::new("filled");
    pour(&mut labels, None, SEEDS[0], BOWL, 0.0);
    pour(&mut labels, None, SEEDS[1], BOWL, 0.0);
    pour(&mut labels, Some("vase"), SEEDS[2], VASE, 0.10);
    spill(&mut labels);
    scoop(&mut labels);
    labels
}

/// How many beads are in a room, by their places.
fn beads_in(scene: &Scene, container: &str, room: Room) -> usize {
    scene.world().beads().into_iter().filter(|bead| room.has(scene.point_in(*bead, container))).count()
}

/// How many beads rise when a container is lifted in a copy, by somebody or by the hand that holds it.
fn beads_that_rise_with(scene: &Scene, container: &str, is_held: bool) -> usize {
    /// Metres: a bowl that is lifted does not reach the pitcher over it.
    const HEIGHT: f64 = 0.04;
    let lifted = if is_held {
        scene.after(|world| {
            let target = pose_at([0.0, 0.0, HEIGHT], Default::default()) * world.tcp();
            world.move_hand(target, &mut |_| {});
        })
    } else {
        scene.lifted(container, HEIGHT)
    };
    let pairs = scene.world().beads().into_iter().zip(lifted.world().beads());
    pairs.filter(|(before, after)| after[2] - before[2] > 0.5 * HEIGHT).count()
}

/// Half a bead less than what is there, and half a bead more. `was` is what was there before, if it was more.
fn to_the_bead(labels: &mut Labels, scene: &Scene, container: &str, count: usize, was: Option<usize>) {
    let all = scene.world().beads().len() as f64;
    let filled = |beads: f64| format!("filled({container}, {})", beads / all);
    let enough = |beads: f64| count as f64 >= beads;
    if count > 0 {
        let beads = count as f64 - 0.5;
        labels.truly(scene, &filled(beads), &format!("{count} beads in it"), enough(beads));
    }
    if count < all as usize {
        let beads = count as f64 + 0.5;
        labels.near_miss(scene, &filled(beads), &format!("{count} beads in it, one too few"), enough(beads));
    }
    if let Some(was) = was.filter(|was| *was > count) {
        let beads = was as f64 - 0.5;
        labels.dropped_later(scene, &filled(beads), &format!("{count} beads left of {was}"), enough(beads));
    }
}

/// The pitcher is tilted further and further over a bowl, and held upright again each time.
fn pour(labels: &mut Labels, variation: Option<&str>, seed: u64, room: Room, higher: f64) {
    let mut scene = Scene::start("pour", variation, seed);
    // The pitcher's lip is 12 cm before and 4 cm above the fingers.
    let lip = Pose::translation(-0.12, 0.0, -0.04);
    let bowl = scene.frame("bowl");
    scene.go("pitcher", [-0.08, 0.0, 0.17], Some(HALF_OPEN));
    scene.go("pitcher", [-0.08, 0.0, 0.06], Some(FIRM));
    scene.go("pitcher", [-0.08, 0.0, 0.22 + higher], None);
    let (mut in_pitcher, mut in_bowl) = (None, None);
    for angle in [0.0, 1.77, 1.80, 1.83, 1.86, 1.90, 2.0] {
        for (height, turn, seconds) in [(0.22, 0.0, 0.0), (0.14, angle, 0.5), (0.22, 0.0, 0.5)] {
            let pose = pose_at([-0.03, 0.0, height + higher], rotation_about([0.0, 1.0, 0.0], turn));
            scene.move_to(&(bowl * pose * lip), None);
            scene.wait(seconds);
        }
        let count = beads_in(&scene, "pitcher", PITCHER);
        assert_eq!(count, beads_that_rise_with(&scene, "pitcher", true), "{}: beads in the pitcher", scene.label());
        if in_pitcher != Some(count) {
            to_the_bead(labels, &scene, "pitcher", count, in_pitcher);
        }
        in_pitcher = Some(count);
        let count = beads_in(&scene, "bowl", room);
        assert_eq!(count, beads_that_rise_with(&scene, "bowl", false), "{}: beads in the bowl", scene.label());
        if in_bowl != Some(count) {
            to_the_bead(labels, &scene, "bowl", count, None);
        }
        in_bowl = Some(count);
    }
}

/// A full pitcher is emptied on the table.
fn spill(labels: &mut Labels) {
    let mut scene = Scene::start("pour", None, SEEDS[1]);
    let all = beads_in(&scene, "pitcher", PITCHER);
    to_the_bead(labels, &scene, "pitcher", all, None);
    scene.go("pitcher", [-0.08, 0.0, 0.17], Some(HALF_OPEN));
    scene.go("pitcher", [-0.08, 0.0, 0.06], Some(FIRM));
    scene.shift([0.0, 0.0, 0.20]);
    scene.turn([0.0, 1.0, 0.0], 2.2);
    scene.wait(1.0);
    to_the_bead(labels, &scene, "pitcher", beads_in(&scene, "pitcher", PITCHER), Some(all));
}

/// A ladle dips into a bowl and is emptied into another one.
fn scoop(labels: &mut Labels) {
    let mut scene = Scene::start("scoop", None, SEEDS[0]);
    let skills = scene.episode().setting().skills.clone();
    let (mut in_ladle, mut in_bowl) = (0, beads_in(&scene, "bowl_a", FULL_BOWL));
    for skill in &skills {
        scene.perform(skill);
        scene.wait(0.5);
        for (container, room, was) in
            [("ladle", LADLE, Some(&mut in_ladle)), ("bowl_a", FULL_BOWL, Some(&mut in_bowl)), ("bowl_b", BOWL, None)]
        {
            let count = beads_in(&scene, container, room);
            to_the_bead(labels, &scene, container, count, was.as_deref().copied());
            if let Some(was) = was {
                *was = count;
            }
        }
    }
}
