//! Each measuring condition against states with a known label: physics was made to produce them.
//!
//! ```text
//! cargo test -p situ-tasks --test all predicates -- --nocapture
//! ```
//!
//! prints the table of counts as Markdown.
//!
//! A benchmark whose measure of success is wrong measures nothing. So each of the nine conditions that measure the
//! world (`held`, `on`, `inside`, `filled`, `upright`, `near`, `at`, `open`, `pressed`) meets at least 40 states, over
//! several start seeds and task families. They are of three kinds: *true*; *near miss*, as close to the meaning or to
//! the limit as physics allows; *dropped later*, true once and then undone. At least ten are of each kind. Precision
//! and recall have to be 1.0. A mistake is listed with the condition, the task, the seed and how the state was made.
//!
//! The label is how the state was made. No label shares code with the conditions. Where a state can be confirmed, an
//! oracle confirms it. It tries something in a copy of the world (does the thing rise with the hand? with its support?
//! do the walls take it along?), or computes with places and axes, and with dimensions that are written out here from
//! the files of the tasks. Label and oracle have to agree as well.
//!
//! What it has caught:
//! - `held` was true of a cube that both finger tips pressed on from above, of the base that the tips stood on while
//!   they held something else, and of a button that closed fingers pushed. Two forces are a grasp only if the thing is
//!   between the fingers.
//! - `on` was true of a cube that was held beside a plank and touched its side: the circle about a plank reaches far
//!   beyond its long sides.
//! - `inside` was true of the lid that lies on a pitcher: contacts give, and its origin sank 7 µm below the rim.

mod confusion;
mod containers;
mod grasping;
mod places;
mod scene;
mod slides;

use situ_tasks::Predicate;

use crate::predicates::confusion::Labels;
use crate::predicates::scene::{FIRM, SEEDS, Scene};

#[test]
fn each_condition_agrees_with_the_labels() {
    let conditions: [fn() -> Labels; 9] = [
        grasping::held,
        places::on,
        containers::inside,
        containers::filled,
        grasping::upright,
        places::near,
        places::at,
        slides::open,
        slides::pressed,
    ];
    let all = conditions.map(|label| label());
    println!("{}", confusion::table(&all));
    let complaints: Vec<String> = all.iter().flat_map(Labels::complaints).collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// `not`, `all`, `any` and `at_least` are logic: their truth table, over one condition that holds and one that does
/// not.
#[test]
fn logic() {
    let scene = Scene::start("sort_blocks", None, SEEDS[0]);
    let expect = |text: &str, value: bool| {
        let predicate = Predicate::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(scene.holds(&predicate), value, "{text}");
    };
    let (yes, no) = ("upright(red_1)", "held(red_1)");
    for (value, part) in [(true, yes), (false, no)] {
        expect(part, value);
        expect(&format!("not({part})"), !value);
        expect(&format!("not(not({part}))"), value);
        expect(&format!("all({part})"), value);
        expect(&format!("any({part})"), value);
    }
    for (a, b) in [(true, true), (true, false), (false, true), (false, false)] {
        let [first, second] = [a, b].map(|value| if value { yes } else { no });
        expect(&format!("all({first}, {second})"), a && b);
        expect(&format!("any({first}, {second})"), a || b);
        expect(&format!("not(all({first}, {second}))"), !a || !b);
        expect(&format!("not(any({first}, {second}))"), !a && !b);
        expect(&format!("at_least(1, {first}, {second})"), a || b);
        expect(&format!("at_least(2, {first}, {second})"), a && b);
        expect(&format!("at_least(2, {first}, {second}, {first})"), a);
    }
    expect("all()", true);
    expect("any()", false);
    // What is not there fulfils nothing.
    for absent in [
        "upright(ghost)",
        "on(red_1, ghost)",
        "on(ghost, table)",
        "near(gripper, ghost, 9)",
        "open(red_1, 0.01)",
        "filled(side, 0)",
    ] {
        expect(absent, false);
        expect(&format!("not({absent})"), true);
    }
}

#[test]
fn the_goal_wants_the_pitcher_back() {
    let mut scene = Scene::start("pour", None, 11);
    let skills = scene.episode().setting().skills.clone();
    let is_filled = Predicate::parse("filled(bowl, 0.8)").expect("a condition");
    for (i, skill) in skills.iter().enumerate() {
        assert!(!scene.episode().succeeded(), "before {}", skill.name);
        scene.perform(skill);
        assert_eq!(scene.holds(&is_filled), i >= 1, "after {}", skill.name);
    }
    assert!(scene.episode().succeeded());
    // And it is lost again when somebody takes the pitcher away.
    scene.go("pitcher", [-0.08, 0.0, 0.06], Some(FIRM));
    scene.go("pitcher", [-0.08, 0.0, 0.20], None);
    assert!(!scene.episode().succeeded());
}
