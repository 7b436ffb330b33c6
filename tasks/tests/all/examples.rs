//! What the task files of `tests/data` use, and the library does not: each is held to its claims as the library is
//! ([`crate::conformance`]), and each feature to what it is for.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use situ_sim::World;
use situ_tasks::script::{self, Ending};
use situ_tasks::{Episode, NeededEdit, Pose, Registry, Setting, Task};

use crate::conformance::{competent_in_time, perform, repeats_itself, start, unwatched};

const SEEDS: [u64; 2] = [1, 2];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data")
}

fn registry() -> Registry {
    Registry::default().with_dir(&folder()).unwrap_or_else(|error| panic!("{error}"))
}

fn setting(task: &str, variation: Option<&str>) -> Arc<Setting> {
    registry().get(task).and_then(|task| task.variation(variation)).unwrap_or_else(|error| panic!("{error}"))
}

fn settings() -> Vec<Arc<Setting>> {
    registry().tasks().flat_map(|task| task.settings().cloned().collect::<Vec<_>>()).collect()
}

/// The setting of a file of the folder with one piece replaced.
fn changed(task: &str, variation: Option<&str>, from: &str, to: &str) -> Arc<Setting> {
    let file = folder().join(format!("{task}.toml"));
    let text = std::fs::read_to_string(&file).expect("it is there");
    assert!(text.contains(from), "no `{from}`");
    let task = Task::parse(&text.replacen(from, to, 1), &file).unwrap_or_else(|error| panic!("{error}"));
    task.variation(variation).expect("it is there")
}

#[test]
fn the_examples_are_what_they_claim() {
    for setting in settings() {
        let label = setting.label();
        for seed in SEEDS {
            competent_in_time(&setting, seed);
            let mut episode = start(&setting, seed);
            let record = script::original(&mut episode, &mut unwatched);
            if setting.edit == NeededEdit::None {
                assert_eq!(record.ending, Ending::Succeeded, "{label} {seed}: {record:?}");
                continue;
            }
            assert_eq!(record.ending, Ending::NoSkill, "{label} {seed}: {record:?}");
            let mut episode = start(&setting, seed);
            let record = script::watched(&mut episode, &mut unwatched);
            assert_eq!(record.ending, Ending::Stopped, "{label} {seed}: {record:?}");
            let record = script::competent(&mut episode, &mut unwatched);
            assert_eq!(record.ending, Ending::Succeeded, "{label} {seed}: corrected: {record:?}");
        }
    }
}

#[test]
fn an_example_is_the_same_bits_again_and_goes_on_from_a_snapshot() {
    settings().iter().for_each(repeats_itself);
}

/// The value of a feature as the robot sees it.
fn observed(episode: &Episode, feature: &str) -> f64 {
    let place = episode.setting().schema.features.iter().position(|own| own.name == feature);
    episode.observe()[place.unwrap_or_else(|| panic!("no feature {feature}"))]
}

/// The one that is due is the nearest that is not done; one in the hand is due; where all are done, none is.
#[test]
fn a_role_is_filled_by_what_is_to_be_done_next() {
    let setting = setting("balls", Some("second"));
    for seed in 0..4 {
        let mut episode = start(&setting, seed);
        let object = |episode: &Episode| episode.view().object("ball").map(str::to_owned);
        let distance = |world: &World, name: &str| {
            (world.pose(name).expect("there").translation.vector - world.tcp().translation.vector).norm()
        };
        let mut done = BTreeSet::new();
        while done.len() < 2 {
            let near = ["ball_1", "ball_2"].into_iter().filter(|name| !done.contains(*name));
            let near = near.min_by(|a, b| distance(episode.world(), a).total_cmp(&distance(episode.world(), b)));
            let due = object(&episode).expect("a ball is left");
            assert_eq!(Some(due.as_str()), near, "seed {seed}");
            assert_eq!(episode.reference_pose("ball"), episode.reference_pose(&due));
            let apart = episode.world().pose(&due).expect("there").translation.x
                - episode.world().pose("bin").expect("there").translation.x;
            assert!((observed(&episode, "offset(ball, bin).x") - apart).abs() < 1e-6);
            for name in ["pick", "put"] {
                let skill = episode.next_skill().expect("a ball is left").clone();
                assert_eq!(skill.name, name, "seed {seed}");
                perform(&mut episode, &skill);
                // In the hand, it is due wherever it is held.
                assert!(name == "put" || object(&episode).as_ref() == Some(&due));
            }
            done.insert(due);
        }
        assert_eq!((object(&episode), observed(&episode, "seen(ball)")), (None, 0.0), "seed {seed}");
        assert_eq!(episode.reference_pose("ball"), None);
        assert!(episode.succeeded());
    }
}

#[test]
fn mass_and_friction_are_drawn_at_the_start_and_move_no_place() {
    let range = ", mass = [0.7, 1.4], friction = [0.8, 1.2] }";
    let (varied, same) = (setting("balls", None), changed("balls", None, range, " }"));
    let mut masses = BTreeSet::new();
    for seed in 0..20 {
        let [episode, other] = [&varied, &same].map(|setting| start(setting, seed));
        let mass = |episode: &Episode| episode.world().mass("ball_1").expect("it moves");
        let friction = |episode: &Episode| episode.world().object("ball_1").expect("there").parts[0].friction;
        let place = |episode: &Episode| episode.world().pose("ball_1").expect("there").translation.vector.xy();
        let (heavier, rougher) = (mass(&episode) / mass(&other), friction(&episode) / friction(&other));
        assert!((0.7..1.4).contains(&heavier) && (0.8..1.2).contains(&rougher), "{heavier}, {rougher}");
        assert!((place(&episode) - place(&other)).norm() < 1e-4, "seed {seed}: the place is another");
        masses.insert((1e3 * heavier) as u32);
    }
    assert!(masses.len() > 15 && masses.first() < Some(&850) && masses.last() > Some(&1250), "{masses:?}");
}

/// Two starts at one place, turned differently, are one to the teacher and to the learner, and are done alike.
#[test]
fn a_turned_round_thing_is_the_same_reference() {
    let text = "start = { x = [-0.18, -0.14], y = [-0.04, 0.04], z = 0.05, yaw = [-3.1, 3.1] }";
    let here = "start = { x = [-0.16, -0.16], y = [0.0, 0.0], z = 0.05, yaw = [-3.1, 3.1] }";
    let plain = |text: &str| text.replace("symmetry = {}\n", "");
    let file = folder().join("jar.toml");
    let source = std::fs::read_to_string(&file).expect("it is there").replace(text, here);
    let source = source.replace("[perception]\nposition = 0.001\nrotation = 0.01\neye = [0.0, -0.9, 0.8]\n", "");
    let original = |text: &str| Task::parse(text, &file).and_then(|task| task.variation(None)).expect("sound");
    let (round, turned) = (original(&source), original(&plain(&source)));
    let frames = |setting: &Arc<Setting>| -> Vec<_> {
        (0..5)
            .map(|seed| start(setting, seed))
            .map(|e| (e.reference_pose("jar").expect("there"), observed(&e, "offset(gripper, jar).x")))
            .collect()
    };
    let apart = |frames: &[(Pose, f64)]| {
        let (first, feature) = &frames[0];
        let turns = frames.iter().map(|(frame, _)| frame.rotation.angle_to(&first.rotation));
        let features = frames.iter().map(|(_, other)| (other - feature).abs());
        (turns.fold(0.0, f64::max), features.fold(0.0, f64::max))
    };
    let (turn, feature) = apart(&frames(&round));
    assert!(turn < 1e-3 && feature < 1e-3, "{turn} rad, {feature} m");
    let (turn, feature) = apart(&frames(&turned));
    assert!(turn > 1.0 && feature > 0.05, "without the symmetry: {turn} rad, {feature} m");
}

#[test]
fn noise_is_that_of_the_file_and_two_looks_at_one_picture_agree() {
    let setting = setting("jar", None);
    let (mut errors, mut turns) = (Vec::new(), Vec::new());
    for seed in 0..60 {
        let mut episode = start(&setting, seed);
        for _ in 0..2 {
            let (seen, real) =
                (episode.reference_pose("mat").expect("seen"), episode.true_reference_pose("mat").expect("there"));
            assert_eq!(episode.reference_pose("mat"), Some(seen));
            assert_eq!(episode.observe(), episode.clone().observe());
            errors.extend((seen.translation.vector - real.translation.vector).iter().copied());
            turns.push((seen.rotation * real.rotation.inverse()).scaled_axis().z);
            // A motion later there is another picture.
            let here = episode.world().tcp();
            episode.perform(&here, None, 0.05, &mut unwatched);
            assert_ne!(episode.reference_pose("mat"), Some(seen));
        }
    }
    // 360 positions and 120 turns: the deviation of a sample is within a fifth of that of the file.
    let deviation = |values: &[f64]| libm::sqrt(values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64);
    assert!((deviation(&errors) / 0.001 - 1.0).abs() < 0.2, "{}", deviation(&errors));
    assert!((deviation(&turns) / 0.01 - 1.0).abs() < 0.2, "{}", deviation(&turns));
}

#[test]
fn what_is_hidden_is_where_it_was_seen_last() {
    let setting = setting("jar", Some("screen"));
    let mut episode = start(&setting, 3);
    let skill = episode.next_skill().expect("a pick").clone();
    let before = episode.world().pose("jar").expect("there").translation.vector;
    let frame = episode.true_reference_pose("jar").expect("there");
    episode.perform(&(frame * skill.keyframes[0].pose), None, 0.0, &mut unwatched);
    episode.reached_keyframe("jar", 0);
    assert_eq!(episode.events_fired(), 2);
    let real = episode.true_reference_pose("jar").expect("there").translation.vector;
    assert!((real - before).xy().norm() > 0.2, "it has been drawn away");
    let believed = episode.reference_pose("jar").expect("it was seen").translation.vector;
    assert!((believed - before).norm() < 0.006, "it is taken to be at {believed}, and was at {before}");
    // Somebody who looks over the screen sees it.
    let above = changed("jar", Some("screen"), "eye = [0.0, -0.9, 0.8]", "eye = [-0.16, 0.3, 1.2]");
    let mut episode = start(&above, 3);
    episode.perform(&(frame * skill.keyframes[0].pose), None, 0.0, &mut unwatched);
    episode.reached_keyframe("jar", 0);
    let seen = episode.reference_pose("jar").expect("seen").translation.vector;
    assert!((seen - episode.true_reference_pose("jar").expect("there").translation.vector).norm() < 0.006);
    // What was behind the screen from the beginning has never been seen.
    let behind =
        changed("jar", Some("screen"), "x = [-0.18, -0.14], y = [-0.04, 0.04]", "x = [-0.16, -0.16], y = [0.2, 0.2]");
    let episode = start(&behind, 3);
    assert_eq!((episode.reference_pose("jar"), observed(&episode, "seen(jar)")), (None, 0.0));
    assert!(episode.true_reference_pose("jar").is_some());
}

/// The text of a task says which meshes it is made of, so that a hash of it covers them.
#[test]
fn the_text_of_a_task_covers_its_meshes() {
    let copy = |mesh: &dyn Fn(String) -> String| {
        let copied = tempfile::tempdir().expect("a folder");
        for name in ["figure.toml", "figure.obj"] {
            let text = std::fs::read_to_string(folder().join(name)).expect("it is there");
            let text = if name.ends_with("obj") { mesh(text) } else { text };
            std::fs::write(copied.path().join(name), text).expect("written");
        }
        let registry = Registry::default().with_dir(copied.path()).expect("sound");
        (registry.text("figure").expect("known").to_owned(), registry.get("figure").expect("known").meshes().clone())
    };
    let (own, meshes) = copy(&|text| text);
    assert!(own.contains(&format!("\n# mesh figure.obj {}\n", meshes["figure.obj"])), "{own}");
    assert_eq!(copy(&|text| text).0, own);
    assert_ne!(copy(&|text| format!("# a remark\n{text}")).0, own, "another file is another task");
    assert_ne!(copy(&|text| text.replace("70.0000", "71.0000")).0, own);
    assert_eq!(
        registry().text("balls").map(str::len),
        std::fs::read_to_string(folder().join("balls.toml")).ok().map(|t| t.len())
    );
}
