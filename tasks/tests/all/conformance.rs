//! What every task and every variation must keep, whatever it is about.
//!
//! A new file in the library is covered by adding it to the registry. There are few seeds, because each run is physics.
//! The rates over many seeds come from `cargo run --release -- check --seeds 50`.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use situ_sim::World;
use situ_tasks::script::{self, Ending, ScriptRecord};
use situ_tasks::{
    Episode, Event, Happening, KeyframeCommand, MotionEnd, NeededEdit, Plant, REST_SPEED, Registry, Setting, Skill,
};

/// The original and the variations of each of the ten tasks.
const SETTINGS: usize = 79;
/// The settings, of those that need an edit, in which the arm finds no plan for what the original program wants.
const WITHOUT_PLAN: [&str; 2] = ["press/tall", "lunch/bottle"];
/// The settings among these in which that happens before a watching teacher stops the robot.
const WATCHED_WITHOUT_PLAN: [&str; 1] = ["press/tall"];

/// Seeds of the runs that are repeated for each setting.
const SEEDS: [u64; 1] = [1];

fn settings() -> Vec<Arc<Setting>> {
    let registry = Registry::builtin().expect("the library is sound");
    let all: Vec<_> = registry.tasks().flat_map(|task| task.settings().cloned().collect::<Vec<_>>()).collect();
    assert_eq!(all.len(), SETTINGS, "the library has grown or shrunk");
    all
}

pub(crate) fn start(setting: &Arc<Setting>, seed: u64) -> Episode {
    Episode::start(setting, seed).unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) fn unwatched(_: &World) {}

/// How the original program ends where an edit is needed: as `usual`, unless the arm finds no plan in the setting.
fn ending(label: &str, without_plan: &[&str], usual: Ending) -> Ending {
    if without_plan.contains(&label) { Ending::NoPlan } else { usual }
}

/// One skill, as a teacher performs it.
pub(crate) fn perform(episode: &mut Episode, skill: &Skill) {
    let frame = episode.true_reference_pose(&skill.reference).expect("the reference object is there");
    for (index, keyframe) in skill.keyframes.iter().enumerate() {
        episode.perform(&(frame * keyframe.pose), keyframe.gripper, keyframe.hold, &mut unwatched);
        episode.reached_keyframe(&skill.reference, index);
    }
}

/// Everything that can be measured of an episode, as bits.
pub(crate) fn bits(episode: &Episode) -> Vec<u64> {
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
        let edits: BTreeSet<NeededEdit> = task.settings().filter(|s| s.variation.is_some()).map(|s| s.edit).collect();
        // A task of graded changes is no family: it has sizes of one edit, and a control.
        let is_graded = task.settings().any(|setting| setting.graded);
        assert_eq!(edits.len(), if is_graded { 2 } else { 4 }, "{}: {edits:?}", task.name());
        assert!(task.settings().all(|setting| !setting.analysis.is_empty()));
        assert!(task.settings().all(|setting| setting.schema == *task.schema()), "one schema a family (D0d)");
        // A table with many things on it has many features. Of these the longest has most.
        assert!(task.schema().len() <= 80, "{} features drown the one that matters", task.schema().len());
    }
}

/// A program of skills, run to its end.
type Script = fn(&mut Episode, &mut dyn FnMut(&World)) -> ScriptRecord;

/// What a skill does: a round that the file has several times has several names for the same.
fn what(skill: &Skill) -> (&str, &[KeyframeCommand]) {
    (&skill.reference, &skill.keyframes)
}

fn done<'a>(setting: &'a Setting, name: &str) -> (&'a str, &'a [KeyframeCommand]) {
    what(setting.skills.iter().find(|skill| skill.name == name).expect("a skill of the setting"))
}

/// Something is to be done, and the competent script does it in good time.
pub(crate) fn competent_in_time(setting: &Arc<Setting>, seed: u64) -> ScriptRecord {
    let (label, mut episode) = (setting.label(), start(setting, seed));
    assert!(!episode.succeeded(), "{label} {seed}: nothing is left to do");
    let record = script::competent(&mut episode, &mut unwatched);
    assert_eq!(record.ending, Ending::Succeeded, "{label} {seed}: {record:?}");
    assert!(episode.seconds() < 0.7 * setting.time_limit, "{label} {seed}: hardly in time");
    record
}

#[test]
fn the_competent_script_succeeds_everywhere_and_the_original_only_where_no_edit_is_needed() {
    for setting in settings() {
        let label = setting.label();
        for seed in SEEDS {
            let record = competent_in_time(&setting, seed);
            if setting.variation.is_none() {
                assert_eq!(
                    record.skills.iter().map(|name| done(&setting, name)).collect::<Vec<_>>(),
                    setting.skills.iter().take(record.skills.len()).map(what).collect::<Vec<_>>(),
                    "{label} {seed}: what is done is what the file says, in its order"
                );
            }

            let mut episode = start(&setting, seed);
            let record = script::original(&mut episode, &mut unwatched);
            match setting.edit {
                NeededEdit::None => assert_eq!(record.ending, Ending::Succeeded, "{label} {seed}: {record:?}"),
                // It may be too small to be needed.
                _ if setting.graded => {}
                _ => assert_eq!(
                    record.ending,
                    ending(&label, &WITHOUT_PLAN, Ending::NoSkill),
                    "{label} {seed}: {record:?}"
                ),
            }
        }
    }
}

/// A hand that was stopped hard used to go on pressing, with the force of the abort, on what it had met. Every later
/// motion aborted at its first step. Each of these originals runs into something; not all of them hard enough for an
/// abort.
#[test]
fn a_hand_that_ran_into_something_can_leave() {
    let registry = Registry::builtin().expect("the library is sound").with_plant(Plant::Hand);
    // The last numbers are the aborts of the original program, with three seeds.
    let collisions = [
        ("sort_blocks", "high_bins", [4, 3, 4]),
        ("drawer", "pin", [1, 1, 1]),
        ("drawer", "stiff", [1, 1, 1]),
        ("drawer", "low_handle", [1, 1, 1]),
        ("stack", "tall_base", [1, 1, 1]),
        ("press", "shutter", [0, 0, 0]),
    ];
    for (task, variation, aborts) in collisions {
        let setting = registry.get(task).and_then(|task| task.variation(Some(variation))).expect("it is there");
        for (seed, aborted) in (0..).zip(aborts) {
            let mut episode = start(&setting, seed);
            let record = script::original(&mut episode, &mut unwatched);
            assert_eq!(record.aborted, aborted, "{task}/{variation} {seed}");
            let mut up = episode.world().tcp();
            up.translation.z += 0.15;
            let end = episode.perform(&up, None, 0.2, &mut unwatched);
            assert_eq!(end, MotionEnd::Reached, "{task}/{variation} {seed}");
            assert!(episode.world().hand_force() < 10.0, "{task}/{variation} {seed}: it still presses");
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
            if setting.edit == NeededEdit::None && setting.interventions.is_empty() {
                assert_eq!(record.ending, Ending::Succeeded, "{label} {seed}: there is nothing to stop");
                continue;
            }
            assert_eq!(
                record.ending,
                ending(&label, &WATCHED_WITHOUT_PLAN, Ending::Stopped),
                "{label} {seed}: {record:?}"
            );
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
            let mut look = |world: &World| {
                let state = setting.schema.observe(setting.view(world));
                assert_eq!(state.len(), names.len());
                for (i, value) in state.into_iter().enumerate() {
                    assert!(value.is_finite(), "{}: {} is {value}", setting.label(), names[i]);
                    low[i] = low[i].min(value);
                    high[i] = high[i].max(value);
                }
            };
            // Some things change only where something goes wrong, some only from one start to another.
            let scripts: [(u64, Script); 3] = [(3, script::competent), (3, script::original), (4, script::competent)];
            for (seed, script) in scripts {
                let (mut episode, mut steps) = (start(setting, seed), 0);
                let mut every_quarter_second = |world: &World| {
                    steps += 1;
                    if steps % 60 == 1 {
                        look(world);
                    }
                };
                script(&mut episode, &mut every_quarter_second);
                look(episode.world());
            }
        }
        // Of three numbers one will do: what stays on the table keeps its height.
        let mut ranges: BTreeMap<&str, f64> = BTreeMap::new();
        for (i, feature) in task.schema().features.iter().enumerate() {
            let what = feature.name.rsplit_once('.').map_or(&*feature.name, |(what, _)| what);
            let range = ranges.entry(what).or_default();
            *range = range.max((high[i] - low[i]) / feature.scale);
        }
        for (what, range) in ranges {
            // Scripts let nothing fall, so what stands may do no more than shake.
            let least = if what.starts_with("tilt(") { 0.0 } else { 0.05 };
            assert!(range > least, "{}: {what} varies by {range} scales only", task.name());
        }
    }
}

#[test]
fn an_episode_is_the_same_bits_again_and_goes_on_from_a_snapshot() {
    settings().iter().for_each(repeats_itself);
}

/// The same seed gives the same bits, and an episode goes on from a snapshot in the middle of the work.
pub(crate) fn repeats_itself(setting: &Arc<Setting>) {
    let label = setting.label();
    let (mut first, mut second) = (start(setting, 4), start(setting, 4));
    assert_eq!(bits(&first), bits(&second), "{label}: the start");
    assert_ne!(bits(&first), bits(&start(setting, 5)), "{label}: another seed is another start");
    let skill = first.next_skill().expect("something is to be done").clone();
    for episode in [&mut first, &mut second] {
        perform(episode, &skill);
    }
    let mut third = Episode::restore(&first.snapshot());
    for episode in [&mut first, &mut second, &mut third] {
        let skill = episode.next_skill().expect("there is more to do").clone();
        perform(episode, &skill);
        assert!(episode.observe().iter().all(|value| value.is_finite()), "{label}");
    }
    assert_eq!(bits(&first), bits(&second), "{label}: the same again");
    assert_eq!(bits(&first), bits(&third), "{label}: from the snapshot");
}

#[test]
fn what_a_variation_does_not_change_starts_where_it_does_in_the_original() {
    let registry = Registry::builtin().expect("the library is sound");
    for task in registry.tasks() {
        let original = start(&task.variation(None).expect("the original"), 6);
        for setting in task.settings().filter(|setting| setting.variation.is_some()) {
            let varied = start(setting, 6);
            // This leaves out what the variation itself puts elsewhere: the cap of a button whose housing has another
            // shape, a drawer that is ajar.
            let region = |setting: &Setting, name: &str| {
                let placed = setting.objects.iter().find(|placed| placed.body.name == name);
                let slide = setting.slides.iter().find(|slide| slide.child == name);
                placed.map(|p| (p.start.on.clone(), p.start.x, p.start.y, slide.map(|slide| slide.value)))
            };
            let stays = |name: &&str| region(setting, name) == region(original.setting(), name);
            assert!(original.world().objects().filter(stays).count() >= 2, "{}: all is moved", setting.label());
            for name in original.world().objects().filter(stays) {
                let (a, b) = (original.world().pose(name).expect("there"), varied.world().pose(name).expect("there"));
                let apart = (a.translation.vector - b.translation.vector).xy().norm();
                assert!(apart < 2e-3, "{}: {name} is {apart} m away from its place in the original", setting.label());
            }
        }
    }
}

/// Performs the competent program up to the given keyframe of the event's reference. Returns before the episode is told
/// that this keyframe has been reached.
fn up_to(episode: &mut Episode, event: &Event) {
    loop {
        let skill = episode.next_skill().expect("the event is on the way").clone();
        let frame = episode.reference_pose(&skill.reference).expect("the reference object is there");
        for (index, keyframe) in skill.keyframes.iter().enumerate() {
            episode.perform(&(frame * keyframe.pose), keyframe.gripper, keyframe.hold, &mut unwatched);
            if skill.reference == event.reference && index == event.keyframe {
                return;
            }
        }
    }
}

#[test]
fn an_event_happens_once_where_the_file_says() {
    let mut kinds = BTreeSet::new();
    for setting in settings() {
        for event in &setting.events {
            let label = setting.label();
            let mut episode = start(&setting, 8);
            let object = event.happening.object();
            let place = |episode: &Episode| episode.world().pose(object).expect("there").translation.vector;
            let at_start = place(&episode);
            let other = setting.objects.iter().map(|placed| &placed.body.name).find(|name| **name != event.reference);
            episode.reached_keyframe(other.expect("another object"), event.keyframe);
            episode.reached_keyframe(&event.reference, event.keyframe + 1);
            assert_eq!((episode.events_fired(), place(&episode)), (0, at_start), "{label}: that is not the moment");

            up_to(&mut episode, event);
            let before = place(&episode);
            let command = episode.world().gripper();
            episode.reached_keyframe(&event.reference, event.keyframe);
            assert_eq!(episode.events_fired(), 1, "{label}");
            assert_eq!(episode.world().gripper(), command, "{label}: the command in force is that of the file");
            match &event.happening {
                Happening::Push { by, .. } => {
                    kinds.insert("push");
                    let (moved, wanted) = ((place(&episode) - before).norm(), nalgebra::Vector3::from(*by).norm());
                    assert!((moved - wanted).abs() < 0.01, "{label}: moved by {moved}, not {wanted}");
                }
                Happening::Drop { .. } => {
                    kinds.insert("drop");
                    assert!(before.z - place(&episode).z > 0.02, "{label}: it has not fallen");
                    assert!((place(&episode) - at_start).z.abs() < 2e-3, "{label}: it does not lie as it did");
                    let world = episode.world();
                    let lies = world.objects().chain(["table"]).any(|other| world.touching(object, other));
                    assert!(lies, "{label}: it hangs in the air");
                    assert!(episode.world().speed(object).is_some_and(|speed| speed < REST_SPEED), "{label}: it moves");
                    assert!(episode.world().opening() < 1e-3, "{label}: the hand is not closed on air");
                }
            }

            // Not again, though the same keyframe is reached once more, with the thing in the hand or under it.
            let after = place(&episode);
            episode.reached_keyframe(&event.reference, event.keyframe);
            assert!((place(&episode) - after).norm() < 1e-3, "{label}: twice");
            let skill = episode.next_skill().expect("there is more to do").clone();
            perform(&mut episode, &skill);
            assert_eq!(episode.events_fired(), 1, "{label}: twice");
            assert!(episode.holds(&skill.until), "{label}: the same once more, undisturbed, does not do");
        }
    }
    assert_eq!(kinds.len(), 2, "not every kind of event is in the library: {kinds:?}");
}

/// A drop waits until the thing hangs free. At a keyframe at which it still stands on the table, the hand would only
/// grasp it again.
#[test]
fn what_still_stands_on_the_table_does_not_drop() {
    let registry = Registry::builtin().expect("the library is sound");
    let setting = registry.get("stack").and_then(|task| task.variation(Some("drop"))).expect("a drop");
    let event = &setting.events[0];
    let mut episode = start(&setting, 8);
    let skill = setting.skills.iter().find(|skill| skill.reference == event.reference).expect("a pick");
    let frame = episode.reference_pose(&skill.reference).expect("there");
    let object = event.happening.object();
    for (index, keyframe) in skill.keyframes.iter().enumerate() {
        episode.perform(&(frame * keyframe.pose), keyframe.gripper, keyframe.hold, &mut unwatched);
        // As a model would that has learned one keyframe more: the grasp is its keyframe 2, the lift its keyframe 3.
        episode.reached_keyframe(&skill.reference, index + 1);
        let is_lifted = index + 1 == skill.keyframes.len();
        assert_eq!(episode.events_fired(), usize::from(is_lifted), "after keyframe {}", index + 1);
    }
    assert!(episode.world().touching(object, "table"));
}
