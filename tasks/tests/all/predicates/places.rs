//! `on`, `near` and `at`: where one thing is beside another.
//!
//! `on` is made by putting a thing down on another one. Near misses are above it, beside it, below it, in it, two
//! storeys above it. The oracle asks whether the other thing bears this one: let go of in a copy, the thing does not
//! fall; and when the other one is lifted in a copy, it rises. A neighbour that touches does neither. What a bin bears
//! on its floor rises with the bin, so there the oracle is the height of the lowest corner above the rim.
//!
//! `near` is made by going to a known distance, a millimetre or two to either side of the limit. The oracle is the
//! distance by its three differences.
//!
//! `at` is made by putting a thing down at a place. Near misses are not letting go, letting go too early, missing the
//! place, sliding through it. The oracle is the distance in the plane, the way in the next steps, and whether the thing
//! rises with the hand in a copy.

use situ_sim::{GripperCommand, Pose, World};

use crate::predicates::confusion::Labels;
use crate::predicates::scene::{FIRM, GRASP, HALF_OPEN, SEEDS, Scene, TIPS, WIDE, length, minus, push};

/// Half of the edge of the cubes of `stack`, metres.
const STACK_HALF: f64 = 0.025;

pub(crate) fn on() -> Labels {
    let mut labels = Labels::new("on");
    for seed in SEEDS {
        storeys(&mut labels, seed);
        tabletop(&mut labels, seed);
        plank(&mut labels, seed);
        cover(&mut labels, seed);
    }
    tray(&mut labels);
    lid(&mut labels);
    labels
}

/// Whether `b` bears `a`: see above.
fn bears(scene: &Scene, a: &str, b: &str) -> bool {
    let height = |scene: &Scene| scene.center(a)[2];
    let let_go = scene.after(|world| {
        world.command(WIDE);
        world.settle(0.5);
    });
    let lifted = scene.lifted(b, 0.03);
    height(scene) - height(&let_go) < 0.001 && height(&lifted) - height(scene) > 0.02
}

/// Whether the table bears `a`: it does not fall when the hand lets go, and its lowest point is where the table is.
fn table_bears(scene: &Scene, a: &str) -> bool {
    let let_go = scene.after(|world| {
        world.command(WIDE);
        world.settle(0.5);
    });
    let [low, _] = scene.world().bounds(a).expect("it is there");
    scene.center(a)[2] - let_go.center(a)[2] < 0.001 && low[2].abs() < 0.001
}

/// A cube on the table, in the air and on another one.
fn tabletop(labels: &mut Labels, seed: u64) {
    let mut scene = Scene::start("stack", None, seed);
    labels.truly(&scene, "on(middle, table)", "not touched yet", table_bears(&scene, "middle"));
    scene.take("middle");
    labels.truly(&scene, "on(middle, table)", "the fingers about it", table_bears(&scene, "middle"));
    scene.shift([0.0, 0.0, 0.004]);
    labels.dropped_later(&scene, "on(middle, table)", "lifted by 4 mm", table_bears(&scene, "middle"));
    scene.shift([0.0, 0.0, 0.14]);
    scene.go("base", [0.0, 0.0, 0.12], None);
    scene.go("base", [0.0, 0.0, 2.0 * STACK_HALF + GRASP + 0.001], Some(WIDE));
    scene.shift([0.0, 0.0, 0.12]);
    labels.near_miss(&scene, "on(middle, table)", "put down on another cube", table_bears(&scene, "middle"));
    labels.truly(&scene, "on(base, table)", "another cube on it", table_bears(&scene, "base"));
}

/// Whether all of `a` is above a height.
fn is_above(scene: &Scene, a: &str, height: f64) -> bool {
    let [low, _] = scene.world().bounds(a).expect("it is there");
    low[2] > height - 0.002
}

/// A tower of cubes.
fn storeys(labels: &mut Labels, seed: u64) {
    let mut scene = Scene::start("stack", None, seed);
    scene.pick("middle");
    scene.go("base", [0.0, 0.0, 0.12], None);
    scene.go("base", [0.0, 0.0, 2.0 * STACK_HALF + GRASP + 0.004], None);
    labels.near_miss(&scene, "on(middle, base)", "held 4 mm above it", bears(&scene, "middle", "base"));
    scene.go("base", [0.008, -0.006, 2.0 * STACK_HALF + GRASP + 0.001], Some(WIDE));
    labels.truly(
        &scene,
        "on(middle, base)",
        "put down on it, the fingers still about it",
        bears(&scene, "middle", "base"),
    );
    scene.shift([0.0, 0.0, 0.12]);
    labels.truly(&scene, "on(middle, base)", "put down on it", bears(&scene, "middle", "base"));
    labels.near_miss(&scene, "on(base, middle)", "it is below", bears(&scene, "base", "middle"));
    scene.pick("top");
    scene.go("middle", [0.0, 0.0, 0.12], None);
    scene.go("middle", [0.0, 0.0, 2.0 * STACK_HALF + GRASP + 0.001], Some(WIDE));
    scene.shift([0.0, 0.0, 0.12]);
    labels.truly(&scene, "on(top, middle)", "the third storey", bears(&scene, "top", "middle"));
    // It rests on the base as well, but not by itself: there is a cube between them.
    let is_next = |scene: &Scene| {
        let [low, high] = ["top", "base"].map(|name| scene.world().bounds(name).expect("there"));
        low[0][2] - high[1][2] < 0.001
    };
    labels.near_miss(&scene, "on(top, base)", "two storeys up", is_next(&scene));
    scene.pick("top");
    labels.dropped_later(&scene, "on(top, middle)", "lifted off again", bears(&scene, "top", "middle"));
    scene.go("side", [0.0, 0.0, 0.15], None);
    scene.go("side", [0.0, 0.0, STACK_HALF + GRASP + 0.001], Some(WIDE));
    scene.shift([0.0, 0.0, 0.15]);
    // Pushed off by the closed hand, the second storey falls down beside the first.
    scene.grip(FIRM);
    let frame = scene.frame("middle");
    scene.go_in(&frame, [-0.06, 0.0, 0.10], None);
    scene.go_in(&frame, [-0.06, 0.0, 0.02], None);
    scene.go_in(&frame, [0.03, 0.0, 0.02], None);
    scene.wait(0.5);
    labels.dropped_later(&scene, "on(middle, base)", "pushed off", bears(&scene, "middle", "base"));
    side_by_side(labels, seed);
}

/// Two cubes that touch.
fn side_by_side(labels: &mut Labels, seed: u64) {
    let mut scene = Scene::start("stack", None, seed);
    scene.pick("middle");
    let frame = scene.frame("base");
    let touch = |scene: &Scene| scene.world().touching("middle", "base");
    scene.go_in(&frame, [-0.055, 0.0, 0.15], None);
    scene.go_in(&frame, [-0.055, 0.0, STACK_HALF + GRASP], None);
    scene.go_in(&frame, [-0.049, 0.0, STACK_HALF + GRASP], None);
    assert!(touch(&scene), "{}: they do not touch", scene.label());
    labels.near_miss(&scene, "on(middle, base)", "held side by side, touching", bears(&scene, "middle", "base"));
    scene.grip(WIDE);
    labels.near_miss(&scene, "on(middle, base)", "put down side by side", bears(&scene, "middle", "base"));
    labels.near_miss(&scene, "on(base, middle)", "put down side by side", bears(&scene, "base", "middle"));
}

/// A plank that is longer than it is wide: its corners are far from its middle, and nothing can lie on it beside its
/// long side.
fn plank(labels: &mut Labels, seed: u64) {
    /// Half of the plank's width, metres.
    const HALF_WIDTH: f64 = 0.05;
    let mut scene = Scene::start("stack", Some("post"), seed);
    let frame = scene.frame("base");
    scene.pick("middle");
    scene.go_in(&frame, [0.08, HALF_WIDTH + STACK_HALF + 0.006, 0.12], None);
    scene.go_in(&frame, [0.08, HALF_WIDTH + STACK_HALF + 0.006, STACK_HALF + 0.01 + GRASP], None);
    scene.go_in(&frame, [0.08, HALF_WIDTH + STACK_HALF - 0.0005, STACK_HALF + 0.01 + GRASP], None);
    assert!(scene.world().touching("middle", "base"), "{}: they do not touch", scene.label());
    labels.near_miss(&scene, "on(middle, base)", "held beside it, touching", bears(&scene, "middle", "base"));
    scene.go_in(&frame, [0.08, HALF_WIDTH + STACK_HALF + 0.01, STACK_HALF + 0.01 + GRASP], None);
    scene.go_in(&frame, [0.08, 0.0, 0.12], None);
    scene.go_in(&frame, [0.08, 0.0, 2.0 * STACK_HALF + GRASP + 0.001], Some(WIDE));
    scene.shift([0.0, 0.0, 0.12]);
    labels.truly(&scene, "on(middle, base)", "put down beside the post", bears(&scene, "middle", "base"));
    labels.near_miss(&scene, "on(middle, post)", "put down beside it", bears(&scene, "middle", "post"));
    scene.pick("top");
    scene.go_in(&frame, [0.0, 0.0, 0.15], None);
    scene.go_in(&frame, [0.0, 0.0, 0.03 + 2.0 * STACK_HALF + GRASP + 0.001], Some(WIDE));
    scene.shift([0.0, 0.0, 0.12]);
    labels.truly(&scene, "on(top, post)", "put down on the post", bears(&scene, "top", "post"));
}

/// A cover on a bin, and cubes on the cover and in the bin.
fn cover(labels: &mut Labels, seed: u64) {
    /// The height of the bin's rim and of the upper face of the cover, metres.
    const RIM: f64 = 0.08;
    const UPPER: f64 = 0.086;
    let mut scene = Scene::start("sort_blocks", Some("cover"), seed);
    labels.truly(&scene, "on(cover, red_bin)", "laid on it", bears(&scene, "cover", "red_bin"));
    scene.pick("red_1");
    scene.go("red_bin", [0.05, 0.04, 0.17], None);
    scene.go("red_bin", [0.05, 0.04, UPPER + 0.02 + GRASP + 0.001], Some(WIDE));
    scene.shift([0.0, 0.0, 0.10]);
    labels.truly(&scene, "on(red_1, cover)", "put down on it", bears(&scene, "red_1", "cover"));
    labels.near_miss(&scene, "on(cover, red_1)", "it is below", bears(&scene, "cover", "red_1"));
    scene.pick("red_1");
    labels.dropped_later(&scene, "on(red_1, cover)", "lifted off again", bears(&scene, "red_1", "cover"));
    scene.go("blue_bin", [0.0, 0.0, 0.17], None);
    scene.go("blue_bin", [0.0, 0.0, 0.10], Some(GripperCommand::Open(0.065)));
    scene.shift([0.0, 0.0, 0.10]);
    labels.near_miss(&scene, "on(red_1, blue_bin)", "let fall into it", is_above(&scene, "red_1", RIM));
    scene.go("cover", [0.0, 0.0, 0.12], Some(HALF_OPEN));
    scene.go("cover", [0.0, 0.0, 0.022], Some(GripperCommand::Close(20.0)));
    scene.shift([0.0, 0.0, 0.005]);
    labels.dropped_later(&scene, "on(cover, red_bin)", "lifted by 5 mm", bears(&scene, "cover", "red_bin"));
    scene.shift([0.0, 0.0, 0.10]);
    scene.go("side", [0.0, 0.0, 0.20], None);
    scene.go("side", [0.0, 0.0, 0.023], Some(HALF_OPEN));
    labels.dropped_later(&scene, "on(cover, red_bin)", "put aside", bears(&scene, "cover", "red_bin"));
}

/// A block on a tray in a drawer.
fn tray(labels: &mut Labels) {
    for seed in SEEDS {
        let mut scene = Scene::start("drawer", Some("full_front"), seed);
        let frame = scene.frame("drawer");
        scene.go_in(&frame, [-0.13, 0.0, 0.17], Some(HALF_OPEN));
        scene.go_in(&frame, [-0.13, 0.0, 0.06], Some(GripperCommand::Close(10.0)));
        scene.go_in(&frame, [-0.31, 0.0, 0.06], Some(HALF_OPEN));
        scene.go_in(&frame, [-0.31, 0.0, 0.17], None);
        scene.pick("block");
        scene.shift([0.0, 0.0, 0.10]);
        scene.go("drawer", [-0.035, 0.0, 0.20], None);
        scene.go("drawer", [-0.035, 0.0, 0.10], Some(GripperCommand::Open(0.065)));
        scene.shift([0.0, 0.0, 0.10]);
        labels.truly(&scene, "on(block, tray)", "put down on it", bears(&scene, "block", "tray"));
        // The drawer's rim is 5 cm above its base.
        let rim = scene.center("drawer")[2] + 0.05;
        labels.near_miss(&scene, "on(tray, drawer)", "it is in it", is_above(&scene, "tray", rim));
    }
}

/// A lid on a pitcher.
fn lid(labels: &mut Labels) {
    let mut scene = Scene::start("pour", Some("lid"), SEEDS[0]);
    labels.truly(&scene, "on(lid, pitcher)", "laid on it", bears(&scene, "lid", "pitcher"));
    scene.go("lid", [0.0, 0.0, 0.12], Some(HALF_OPEN));
    scene.go("lid", [0.0, 0.0, 0.020], Some(GripperCommand::Close(20.0)));
    scene.shift([0.0, 0.0, 0.02]);
    labels.dropped_later(&scene, "on(lid, pitcher)", "lifted by 2 cm", bears(&scene, "lid", "pitcher"));
}

pub(crate) fn near() -> Labels {
    let mut labels = Labels::new("near");
    for seed in SEEDS {
        fingers(&mut labels, seed, "sort_blocks", "red_1");
        fingers(&mut labels, seed, "press", "green_cap");
        spot(&mut labels, seed);
        neighbours(&mut labels, seed);
    }
    labels
}

/// The gripper to either side of a limit.
fn fingers(labels: &mut Labels, seed: u64, task: &str, object: &str) {
    /// Limit and millimetre to either side, metres.
    const LIMIT: f64 = 0.10;
    const STEP: f64 = 0.001;
    let near = format!("near(gripper, {object}, {LIMIT})");
    let mut scene = Scene::start(task, None, seed);
    let frame = scene.frame(object);
    let apart = |scene: &Scene| length(minus(scene.world().tcp().translation.vector.into(), scene.center(object)));
    // From above, from the side of the hand's start, and aslant: unit vectors.
    for direction in [[0.0, 0.0, 1.0], [-0.6, 0.0, 0.8], [-0.64, 0.48, 0.6]] {
        scene.go_in(&frame, direction.map(|part| part * (LIMIT + STEP)), Some(FIRM));
        labels.near_miss(&scene, &near, "the gripper 1 mm too far away", apart(&scene) <= LIMIT);
        scene.go_in(&frame, direction.map(|part| part * (LIMIT - STEP)), None);
        labels.truly(&scene, &near, "the gripper 1 mm within", apart(&scene) <= LIMIT);
    }
    // Over it to the millimetre in the plane, but high up.
    scene.go_in(&frame, [0.0, 0.0, 0.15], None);
    labels.dropped_later(&scene, &near, "the gripper has gone up", apart(&scene) <= LIMIT);
}

/// A cube near a mark on a plank.
fn spot(labels: &mut Labels, seed: u64) {
    /// The limit, and the place along the plank to either side of it: the cube's middle is 25 mm above the mark.
    const LIMIT: f64 = 0.045;
    const WITHIN: f64 = 0.0355;
    const BEYOND: f64 = 0.0395;
    let near = format!("near(middle, spot, {LIMIT})");
    let mut scene = Scene::start("stack", Some("post"), seed);
    let frame = scene.frame("spot");
    let apart = |scene: &Scene| length(minus(scene.center("middle"), scene.center("spot")));
    scene.pick("middle");
    for (x, y, is_within) in [(0.0, WITHIN, true), (0.0, BEYOND, false), (WITHIN, 0.0, true), (BEYOND, 0.0, false)] {
        scene.go_in(&frame, [x, y, 0.12], None);
        scene.go_in(&frame, [x, y, STACK_HALF + GRASP + 0.0005], Some(WIDE));
        if is_within {
            labels.truly(&scene, &near, "put down within", apart(&scene) <= LIMIT);
        } else {
            labels.near_miss(&scene, &near, "put down too far away", apart(&scene) <= LIMIT);
        }
        scene.grip(FIRM);
        scene.shift([0.0, 0.0, 0.08]);
        if is_within {
            labels.dropped_later(&scene, &near, "lifted again", apart(&scene) <= LIMIT);
        } else {
            labels.near_miss(&scene, &near, "lifted again", apart(&scene) <= LIMIT);
        }
    }
}

/// Two cubes, one of which is bumped by a known way along the line from the other.
fn neighbours(labels: &mut Labels, seed: u64) {
    let scene = Scene::start("sort_blocks", None, seed);
    for (a, b) in [("blue_1", "red_1"), ("red_1", "side")] {
        let apart = |scene: &Scene| length(minus(scene.center(a), scene.center(b)));
        let line = minus(scene.center(a), scene.center(b));
        let away = |way: f64| line.map(|part| part * way / length(line));
        // 2 mm more than they are apart, in whole millimetres so that the condition can be read.
        let limit = libm::ceil(1e3 * apart(&scene) + 2.0) / 1e3;
        let near = format!("near({a}, {b}, {limit})");
        labels.truly(&scene, &near, "2 mm within", apart(&scene) <= limit);
        let bumped = scene.bumped(a, away(0.004), 0.2);
        labels.dropped_later(&bumped, &near, "bumped 4 mm away", apart(&bumped) <= limit);
    }
}

pub(crate) fn at() -> Labels {
    let mut labels = Labels::new("at");
    for seed in SEEDS {
        let mut scene = Scene::start("sort_blocks", None, seed);
        scene.pick("red_1");
        put_down(&mut labels, &mut scene, "red_1", "side", 0.02);
        let mut scene = Scene::start("stack", None, seed);
        scene.pick("middle");
        put_down(&mut labels, &mut scene, "middle", "side", STACK_HALF);
        socket(&mut labels, seed);
    }
    mat(&mut labels);
    labels
}

/// The oracle of `at`: near in the plane, at rest, and left behind by the hand.
fn lies_at(scene: &Scene, object: &str, place: &str, limit: f64) -> bool {
    /// The speed below which a thing stands still, m/s.
    const AT_REST: f64 = 0.05;
    let [x, y, _] = minus(scene.center(object), scene.center(place));
    libm::hypot(x, y) <= limit && scene.speed(object) <= AT_REST && !scene.rises_with_the_hand(object)
}

/// A block is brought to a mark.
fn put_down(labels: &mut Labels, scene: &mut Scene, object: &str, place: &str, half: f64) {
    const LIMIT: f64 = 0.05;
    let at = format!("at({object}, {place}, {LIMIT})");
    let lies = |scene: &Scene| lies_at(scene, object, place, LIMIT);
    let frame: Pose = scene.frame(place);
    let low = half + GRASP + 0.0005;
    scene.go_in(&frame, [0.0, 0.0, 0.20], None);
    scene.wait(0.3);
    labels.near_miss(scene, &at, "held over the place, still", lies(scene));
    let falling = scene.after(|world: &mut World| {
        world.command(WIDE);
        world.settle(0.15);
    });
    labels.near_miss(&falling, &at, "falling onto the place", lies(&falling));
    scene.go_in(&frame, [0.0, 0.0, low], None);
    labels.near_miss(scene, &at, "stands at the place, not let go", lies(scene));
    scene.grip(WIDE);
    labels.truly(scene, &at, "let go at the place, the fingers about it", lies(scene));
    scene.grip(FIRM);
    labels.dropped_later(scene, &at, "taken again", lies(scene));
    scene.shift([0.0, 0.0, 0.10]);
    labels.dropped_later(scene, &at, "lifted again", lies(scene));
    for (x, y, is_within) in [(LIMIT - 0.003, 0.0, true), (LIMIT + 0.003, 0.0, false), (-0.04, 0.04, false)] {
        scene.go_in(&frame, [x, y, 0.10], None);
        scene.go_in(&frame, [x, y, low], Some(WIDE));
        scene.shift([0.0, 0.0, 0.10]);
        if is_within {
            labels.truly(scene, &at, "put down 3 mm within", lies(scene));
            let away = scene.bumped(object, [0.0, 0.08, 0.0], 0.5);
            labels.dropped_later(&away, &at, "bumped away", lies(&away));
        } else {
            labels.near_miss(scene, &at, "put down just beside the place", lies(scene));
        }
        scene.take(object);
    }
    scene.go_in(&frame, [0.0, 0.0, low], Some(WIDE));
    scene.shift([0.0, 0.0, 0.10]);
    labels.truly(scene, &at, "put down in the middle", lies(scene));
    scene.grip(FIRM);
    scene.go_in(&frame, [0.0, 0.0, 2.0 * half + TIPS - 0.0005], None);
    labels.truly(scene, &at, "pressed on from above with closed fingers", lies(scene));
    scene.shift([0.0, 0.0, 0.10]);
    // At the half of a push it goes 1.875 times as fast as on the average.
    for (average, is_slow) in [(0.02, true), (0.04, false), (0.15, false)] {
        let seconds = 0.04 / average;
        let sliding = scene.after(|world| {
            push(world, object, [0.04, 0.0, 0.0], seconds);
            world.settle(0.5 * seconds);
        });
        if is_slow {
            labels.truly(&sliding, &at, "creeps at 4 cm/s, which counts as still", lies(&sliding));
        } else {
            labels.near_miss(&sliding, &at, "slides through the place", lies(&sliding));
        }
    }
}

/// What stands in a socket is pulled out.
fn socket(labels: &mut Labels, seed: u64) {
    for (task, variation, object, [above, grasp]) in
        [("drawer", "pin", "pin", [0.14, 0.045]), ("press", "shutter", "shutter", [0.22, 0.146])]
    {
        let mut scene = Scene::start(task, Some(variation), seed);
        let at = format!("at({object}, socket, 0.01)");
        let lies = |scene: &Scene| lies_at(scene, object, "socket", 0.01);
        labels.truly(&scene, &at, "stands in its socket", lies(&scene));
        scene.go(object, [0.0, 0.0, above], Some(HALF_OPEN));
        scene.go(object, [0.0, 0.0, grasp], Some(GripperCommand::Close(20.0)));
        scene.shift([0.0, 0.0, 0.01]);
        labels.dropped_later(&scene, &at, "lifted by 1 cm in its socket", lies(&scene));
        scene.shift([0.0, 0.0, 0.12]);
        labels.dropped_later(&scene, &at, "pulled out, over its socket", lies(&scene));
    }
}

/// A full pitcher is put back on its mat.
fn mat(labels: &mut Labels) {
    let mut scene = Scene::start("pour", None, SEEDS[0]);
    let frame = scene.frame("mat");
    let lies = |scene: &Scene, limit| lies_at(scene, "pitcher", "mat", limit);
    scene.go("pitcher", [-0.08, 0.0, 0.17], Some(HALF_OPEN));
    scene.go("pitcher", [-0.08, 0.0, 0.06], Some(FIRM));
    scene.go_in(&frame, [-0.08, 0.0, 0.16], None);
    labels.near_miss(&scene, "at(pitcher, mat, 0.08)", "held over the mat", lies(&scene, 0.08));
    scene.go_in(&frame, [-0.08, 0.10, 0.10], None);
    scene.go_in(&frame, [-0.08, 0.10, 0.062], Some(HALF_OPEN));
    labels.near_miss(&scene, "at(pitcher, mat, 0.09)", "put down 10 cm beside the mat", lies(&scene, 0.09));
    labels.truly(&scene, "at(pitcher, mat, 0.11)", "put down 10 cm beside the mat", lies(&scene, 0.11));
}
