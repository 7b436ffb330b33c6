//! What every task and every variation must keep, whatever it is about.
//!
//! A new file in the library is covered by adding it to the registry. The seeds are few, for each run is physics; the rates over many seeds
//! come from `cargo run --release -p situ-tasks --example premises -- 50`.

use std::collections::BTreeSet;
use std::sync::Arc;

use situ_sim::World;
use situ_tasks::script::{self, Ending};
use situ_tasks::{Edit, Episode, Registry, Setting, Skill};

/// Seeds of the runs that are repeated for each setting.
const SEEDS: [u64; 1] = [1];

fn settings() -> Vec<Arc<Setting>> {
    let registry = Registry::builtin().expect("the library is sound");
    let all: Vec<_> = registry.tasks().flat_map(|task| task.settings().cloned().collect::<Vec<_>>()).collect();
    assert!(all.len() >= 10, "only {} settings: the library is not whole", all.len());
    all
}

fn start(setting: &Arc<Setting>, seed: u64) -> Episode {
    Episode::start(setting, seed).unwrap_or_else(|error| panic!("{error}"))
}

fn unwatched(_: &World) {}

/// One skill, as a teacher performs it.
fn perform(episode: &mut Episode, skill: &Skill) {
    let frame = episode.reference_pose(&skill.reference).expect("the reference object is there");
    for (index, keyframe) in skill.keyframes.iter().enumerate() {
        episode.perform(&(frame * keyframe.pose), keyframe.gripper, keyframe.hold, &mut unwatched);
        episode.reached_keyframe(&skill.reference, index);
    }
}

/// Everything that can be measured of an episode, as bits.
fn bits(episode: &Episode) -> Vec<u64> {
    let world = episode.world();
    let poses = world.objects().filter_map(|name| world.pose(name)).chain([world.tcp()]);
    let mut numbers: Vec<f64> =
        poses.flat_map(|pose| pose.to_homogeneous().iter().copied().collect::<Vec<_>>()).collect();
    numbers.extend(world.beads().into_iter().flatten());
    numbers.extend(episode.observe());
    numbers.extend([episode.seconds(), episode.path(), world.hand_force(), world.opening()]);
    numbers.into_iter().map(f64::to_bits).collect()
}

#[test]
fn each_family_has_all_three_edits_and_a_control() {
    let registry = Registry::builtin().expect("the library is sound");
    for task in registry.tasks() {
        let edits: BTreeSet<Edit> = task.settings().filter(|s| s.variation.is_some()).map(|s| s.edit).collect();
        assert_eq!(edits.len(), 4, "{}: {edits:?}", task.name());
        assert!(task.settings().all(|setting| !setting.analysis.is_empty()));
        assert!(task.settings().all(|setting| setting.schema == *task.schema()), "one schema a family (D0d)");
        assert!(task.schema().len() <= 45, "{} features drown the one that matters", task.schema().len());
    }
}

#[test]
fn the_competent_script_succeeds_everywhere_and_the_original_only_where_no_edit_is_needed() {
    for setting in settings() {
        let label = setting.label();
        for seed in SEEDS {
            let mut episode = start(&setting, seed);
            assert!(!episode.succeeded(), "{label} {seed}: nothing is left to do");
            let record = script::competent(&mut episode, &mut unwatched);
            assert_eq!(record.ending, Ending::Succeeded, "{label} {seed}: {record:?}");
            assert!(episode.seconds() < 0.7 * setting.time_limit, "{label} {seed}: hardly in time");
            if setting.variation.is_none() {
                let names: Vec<&String> = setting.skills.iter().map(|skill| &skill.name).collect();
                assert_eq!(
                    record.skills.iter().collect::<Vec<_>>(),
                    names,
                    "{label} {seed}: each skill once, in the file's order"
                );
            }

            let mut episode = start(&setting, seed);
            let record = script::original(&mut episode, &mut unwatched);
            let expected = if setting.edit == Edit::None { Ending::Succeeded } else { Ending::NoSkill };
            assert_eq!(record.ending, expected, "{label} {seed}: {record:?}");
        }
    }
}

#[test]
fn a_watching_teacher_stops_the_original_where_an_edit_is_needed_and_can_go_on_from_there() {
    for setting in settings() {
        let label = setting.label();
        for seed in SEEDS {
            let mut episode = start(&setting, seed);
            let record = script::watched(&mut episode, &mut unwatched);
            if setting.edit == Edit::None {
                assert_eq!(record.ending, Ending::Succeeded, "{label} {seed}: there is nothing to stop");
                continue;
            }
            assert_eq!(record.ending, Ending::Stopped, "{label} {seed}: {record:?}");
            let record = script::competent(&mut episode, &mut unwatched);
            assert_eq!(record.ending, Ending::Succeeded, "{label} {seed}: corrected: {record:?}");
        }
    }
}

#[test]
fn observations_are_finite_and_every_feature_varies_within_its_family() {
    let registry = Registry::builtin().expect("the library is sound");
    for task in registry.tasks() {
        let names: Vec<&str> = task.schema().features.iter().map(|feature| feature.name.as_str()).collect();
        assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "a name is given twice");
        assert!(task.schema().features.iter().all(|feature| feature.scale > 0.0));
        let mut low = vec![f64::INFINITY; names.len()];
        let mut high = vec![f64::NEG_INFINITY; names.len()];
        for setting in task.settings() {
            let mut steps = 0;
            let mut look = |world: &World| {
                steps += 1;
                if steps % 60 != 1 {
                    return;
                }
                let state = setting.schema.observe(world);
                assert_eq!(state.len(), names.len());
                for (i, value) in state.into_iter().enumerate() {
                    assert!(value.is_finite(), "{}: {} is {value}", setting.label(), names[i]);
                    low[i] = low[i].min(value);
                    high[i] = high[i].max(value);
                }
            };
            script::competent(&mut start(setting, 3), &mut look);
        }
        for (i, feature) in task.schema().features.iter().enumerate() {
            let range = (high[i] - low[i]) / feature.scale;
            assert!(range > 0.05, "{}: {} varies by {range} scales only", task.name(), feature.name);
        }
    }
}

#[test]
fn an_episode_is_the_same_bits_again_and_goes_on_from_a_snapshot() {
    for setting in settings() {
        let label = setting.label();
        let (mut first, mut second) = (start(&setting, 4), start(&setting, 4));
        assert_eq!(bits(&first), bits(&second), "{label}: the start");
        assert_ne!(bits(&first), bits(&start(&setting, 5)), "{label}: another seed is another start");

        // One skill, then a snapshot in the middle of the work.
        let skill = first.next_skill().expect("something is to be done").clone();
        for episode in [&mut first, &mut second] {
            perform(episode, &skill);
        }
        let mut third = Episode::restore(&first.snapshot());
        for episode in [&mut first, &mut second, &mut third] {
            let skill = episode.next_skill().expect("there is more to do").clone();
            perform(episode, &skill);
        }
        assert_eq!(bits(&first), bits(&second), "{label}: the same again");
        assert_eq!(bits(&first), bits(&third), "{label}: from the snapshot");
    }
}

#[test]
fn what_a_variation_does_not_change_starts_where_it_does_in_the_original() {
    let registry = Registry::builtin().expect("the library is sound");
    for task in registry.tasks() {
        let original = start(&task.variation(None).expect("the original"), 6);
        for setting in task.settings().filter(|setting| setting.variation.is_some()) {
            let varied = start(setting, 6);
            for name in original.world().objects() {
                let (a, b) = (original.world().pose(name).expect("there"), varied.world().pose(name).expect("there"));
                let apart = (a.translation.vector - b.translation.vector).xy().norm();
                assert!(apart < 2e-3, "{}: {name} is {apart} m away from its place in the original", setting.label());
            }
        }
    }
}

#[test]
fn an_event_happens_once() {
    let registry = Registry::builtin().expect("the library is sound");
    for task in registry.tasks() {
        let setting = task.variation(Some("bump")).expect("every family is bumped");
        let event = setting.events.first().expect("the bump").clone();
        let mut episode = start(&setting, 8);
        let place = |episode: &Episode| episode.world().pose(&event.push).expect("there").translation.vector;
        let before = place(&episode);
        episode.reached_keyframe(&event.reference, event.keyframe + 1);
        assert_eq!(place(&episode), before, "another keyframe is not the moment");
        episode.reached_keyframe(&event.reference, event.keyframe);
        let moved = (place(&episode) - before).norm();
        let wanted = nalgebra::Vector3::from(event.by).norm();
        assert!((moved - wanted).abs() < 0.01, "moved by {moved}, not {wanted}");
        let after = place(&episode);
        episode.reached_keyframe(&event.reference, event.keyframe);
        assert!((place(&episode) - after).norm() < 1e-3, "twice");
    }
}
