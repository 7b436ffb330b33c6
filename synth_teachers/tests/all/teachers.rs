//! Teachers in physics: the expert is the script, a seed is a demonstration, a correction begins where the robot
//! failed.

use std::sync::Arc;

use situ::demonstration::Kind;
use situ::state::State;
use situ_tasks::script::{self, Ending};
use situ_tasks::{Episode, EpisodeSnapshot, Registry, Setting, World};
use situ_teachers::convert::{observe, schema};
use situ_teachers::{Count, Detour, Misaligned, Profile, Roster, Shown, Teacher, Way};

pub(crate) fn setting(task: &str, variation: Option<&str>) -> Arc<Setting> {
    Registry::builtin().unwrap().get(task).unwrap().variation(variation).unwrap()
}

pub(crate) fn demonstrate(
    profile: Profile,
    kind: Kind,
    episode: &mut Episode,
    seed: u64,
    see: &mut dyn FnMut(&World),
) -> Shown {
    let schema = schema(episode.setting()).unwrap();
    Teacher::new(profile).demonstrate("shown", kind, &schema, episode, seed, see).unwrap()
}

pub(crate) fn named(name: &str) -> Profile {
    Roster::builtin().unwrap().get(name).unwrap().clone()
}

fn expert() -> Profile {
    named("expert")
}

/// Every number of a world, as bits.
fn bits(world: &World) -> Vec<u64> {
    let poses = world.objects().filter_map(|name| world.pose(name)).chain([world.tcp()]);
    let numbers = poses.flat_map(|pose| pose.to_homogeneous().iter().copied().collect::<Vec<_>>());
    numbers
        .chain(world.beads().into_iter().flatten())
        .chain([world.opening(), world.time()])
        .map(f64::to_bits)
        .collect()
}

/// The bits of the hand at every step of what `run` does.
fn way(run: impl FnOnce(&mut dyn FnMut(&World))) -> Vec<[u64; 4]> {
    let mut way = Vec::new();
    run(&mut |world| {
        let at = world.tcp().translation.vector;
        way.push([at.x, at.y, at.z, world.opening()].map(f64::to_bits));
    });
    way
}

/// One setting: the expert goes the script's way to the last bit, and records what was reached.
fn expert_is_the_script(setting: &Arc<Setting>) {
    let label = setting.label();
    let mut scripted = Episode::start(setting, 3).unwrap();
    let mut record = None;
    let script = way(|see| record = Some(script::competent(&mut scripted, see)));
    let record = record.unwrap();
    assert_eq!(record.ending, Ending::Succeeded, "{label}");

    let mut episode = Episode::start(setting, 3).unwrap();
    let before = observe(&episode);
    let mut shown = None;
    let taught = way(|see| shown = Some(demonstrate(expert(), Kind::Original, &mut episode, 3, see)));
    let shown = shown.unwrap();
    assert!(taught == script, "{label}: the hand goes another way");
    assert_eq!(bits(episode.world()), bits(scripted.world()), "{label}");

    assert!(shown.clean, "{label}");
    assert_eq!(shown.skills, record.skills, "{label}");
    assert_eq!(shown.effort.keyframes as usize, record.keyframes, "{label}");
    assert_eq!((shown.effort.seconds, shown.effort.metres), (scripted.seconds(), scripted.path()), "{label}");
    let demonstration = shown.demonstration.unwrap();
    assert_eq!((demonstration.kind(), demonstration.carried_to_end()), (Kind::Original, true), "{label}");
    let keyframes = demonstration.keyframes();
    assert_eq!(keyframes.len(), record.keyframes, "{label}");
    // D0: a keyframe's state is the world before the motion to it, so the first is the start.
    assert_eq!(keyframes[0].state, before, "{label}");
    assert_eq!(*demonstration.final_state(), observe(&episode), "{label}");
    // What was reached, not what was commanded.
    assert_eq!(keyframes[keyframes.len() - 1].gripper_pose, episode.world().tcp(), "{label}");
}

/// Every setting of every task, on two threads.
#[test]
fn an_expert_is_the_script_bit_for_bit() {
    let registry = Registry::builtin().unwrap();
    let settings: Vec<Arc<Setting>> = registry.tasks().flat_map(|task| task.settings().cloned()).collect();
    let (even, odd): (Vec<_>, Vec<_>) = settings.iter().enumerate().partition(|(index, _)| index % 2 == 0);
    std::thread::scope(|scope| {
        for half in [even, odd] {
            scope.spawn(move || half.into_iter().for_each(|(_, setting)| expert_is_the_script(setting)));
        }
    });
}

/// The first red cube is bumped and the hand closes on air: the robot as it is when the teacher stops it.
fn failed() -> EpisodeSnapshot {
    let mut episode = Episode::start(&setting("sort_blocks", Some("bump")), 1).unwrap();
    let record = script::watched(&mut episode, &mut |_| ());
    assert_eq!((record.ending, record.skills.len()), (Ending::Stopped, 1));
    episode.snapshot()
}

#[test]
fn a_correction_begins_where_the_robot_failed_and_ends_where_its_teacher_stops() {
    let snapshot = failed();
    let state: State = observe(&Episode::restore(&snapshot));
    let correct = |profile: Profile| {
        let mut episode = Episode::restore(&snapshot);
        let shown = demonstrate(profile, Kind::Corrective, &mut episode, 4, &mut |_| ());
        (shown, bits(episode.world()))
    };
    let (whole, end) = correct(expert());
    let (again, same) = correct(expert());
    assert_eq!((&again.demonstration, &end), (&whole.demonstration, &same), "the snapshot is as it was");
    let demonstration = whole.demonstration.unwrap();
    assert!(whole.clean && whole.skills[0] == "pick_red_1", "{:?}", whole.skills);
    assert_eq!((demonstration.kind(), demonstration.carried_to_end()), (Kind::Corrective, true));
    assert_eq!(demonstration.keyframes()[0].state, state, "D0: the world that the robot left");
    assert_eq!(&*demonstration.keyframes()[0].reference, "red_1");
    let before = Episode::restore(&snapshot);
    let mut after = Episode::restore(&snapshot);
    script::competent(&mut after, &mut |_| ());
    assert_eq!(whole.effort.seconds, after.seconds() - before.seconds(), "the robot's own time is not the teacher's");
    assert_eq!(bits(after.world()), end);

    // One who stops as soon as the robot knows how to go on shows the first skill alone, and no end.
    let (early, _) = correct(Profile { stops_early: 1.0, ..expert() });
    let shorter = early.demonstration.unwrap();
    assert_eq!((early.clean, early.skills.as_slice()), (true, &["pick_red_1".to_owned()][..]));
    assert_eq!((shorter.kind(), shorter.carried_to_end()), (Kind::Corrective, false));
    assert_eq!(shorter.keyframes(), &demonstration.keyframes()[..3]);
    assert_eq!(*shorter.final_state(), demonstration.keyframes()[3].state);
}

/// Where what went wrong lies on the tray or on the post, it has to be taken up first, by a skill that the robot knows.
/// One who stopped after that would have corrected nothing.
#[test]
fn one_who_stops_early_has_shown_what_changed() {
    let cases = [
        ("stack", "post", ["pick_middle", "place_middle", "pick_top"]),
        ("drawer", "full_front", ["pick", "place", "close"]),
    ];
    for (task, variation, skills) in cases {
        let setting = setting(task, Some(variation));
        for seed in 1..=4 {
            let mut episode = Episode::start(&setting, seed).unwrap();
            assert_eq!(script::watched(&mut episode, &mut |_| ()).ending, Ending::Stopped, "{task}, seed {seed}");
            let brief = Profile { stops_early: 1.0, ..expert() };
            let shown = demonstrate(brief, Kind::Corrective, &mut episode, seed, &mut |_| ());
            assert!(shown.clean && shown.demonstration.is_some(), "{task}, seed {seed}");
            assert_eq!(shown.skills, skills, "{task}, seed {seed}");
        }
    }
}

#[test]
fn a_seed_is_a_demonstration() {
    let snapshot = failed();
    // Every mistake at once; one skill is enough to see it.
    let clumsy = Profile { spurious: 0.5, missing: 0.5, stops_early: 1.0, ..named("novice") };
    let show = |seed| {
        let mut episode = Episode::restore(&snapshot);
        demonstrate(clumsy.clone(), Kind::Corrective, &mut episode, seed, &mut |_| ())
    };
    let (one, again, other) = (show(1), show(1), show(2));
    assert_eq!(one.demonstration, again.demonstration);
    assert_eq!((one.effort, one.tally, &one.skills), (again.effort, again.tally, &again.skills));
    assert_ne!(one.demonstration, other.demonstration);
    for shown in [one, other] {
        let happened = |way| shown.tally.of(way).happened;
        let recorded = shown.tally.of(Way::Spurious).chances + happened(Way::Spurious) - happened(Way::Missing);
        assert_eq!(shown.demonstration.unwrap().keyframes().len() as u32, recorded);
        assert_eq!(shown.effort.keyframes, recorded);
    }
}

/// What each way of erring leaves in the demonstration of one pick: three keyframes on `red_1`.
#[test]
fn each_way_of_erring_is_seen_in_the_demonstration() {
    let snapshot = failed();
    let show = |profile: Profile| {
        let mut episode = Episode::restore(&snapshot);
        let brief = Profile { stops_early: 1.0, ..profile };
        demonstrate(brief, Kind::Corrective, &mut episode, 1, &mut |_| ())
    };
    let expert = show(expert());
    let right = expert.demonstration.unwrap();
    let poses = |shown: &Shown| -> Vec<_> {
        shown.demonstration.iter().flat_map(|shown| shown.keyframes()).map(|keyframe| keyframe.gripper_pose).collect()
    };
    let always = Count { happened: 3, chances: 3 };

    let explorer = show(Profile { detour: Detour { rate: 1.0, reach: 0.1 }, ..named("expert") });
    assert!(explorer.clean && explorer.tally.of(Way::Detour) == always);
    assert_eq!(explorer.effort.keyframes, 6, "each keyframe has an excursion before it");
    assert!(explorer.effort.metres > expert.effort.metres + 0.3, "{} m", explorer.effort.metres);

    let axiswise = show(Profile { one_axis: 1.0, ..named("expert") });
    assert!(axiswise.clean && axiswise.tally.of(Way::OneAxis) == always);
    let seen = poses(&axiswise);
    assert!(seen.len() > 3);
    for pair in seen.windows(2) {
        let way = (pair[1].translation.vector - pair[0].translation.vector).abs();
        assert!(way.iter().filter(|axis| **axis > 0.011).count() <= 1, "{way:?}: one axis at a time");
    }

    let misaligned = show(Profile { misaligned: Misaligned { rate: 1.0, turn: 15.0 }, ..named("expert") });
    assert!(misaligned.clean && misaligned.tally.of(Way::Misaligned) == Count { happened: 1, chances: 1 });
    for (turned, straight) in poses(&misaligned).iter().zip(right.keyframes()) {
        let turn = turned.rotation.angle_to(&straight.gripper_pose.rotation).to_degrees();
        assert!((turn - 15.0).abs() < 0.1, "{turn}");
    }

    let misnaming = show(Profile { wrong_reference: 1.0, ..named("expert") });
    assert!(misnaming.clean && misnaming.tally.of(Way::WrongReference).happened == 1);
    let misnamed = misnaming.demonstration.unwrap();
    let world = Episode::restore(&snapshot);
    for (wrong, right) in misnamed.keyframes().iter().zip(right.keyframes()) {
        assert_ne!(wrong.reference, right.reference);
        assert_eq!(wrong.reference, misnamed.keyframes()[0].reference, "one name a skill");
        assert_eq!(Some(wrong.reference_pose), world.reference_pose(&wrong.reference), "that object's own frame");
        assert_eq!(wrong.gripper_pose, right.gripper_pose, "the hand does the right thing");
    }
}
