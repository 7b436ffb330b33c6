//! The contract of snapshots and of determinism: bits, not tolerances.
//!
//! A correction starts from the snapshot of a failure, and a published number must come out again. So a restored world
//! (from memory or from text) and a second world built by the same calls must show the same bits at every later step.
//! If this fails after the engine was changed, the engine keeps state that it does not hand over.

use crate::common::{bits, close_pitcher, grasp, lip, pouring, standing, tilt};
use situ_sim::{Beads, GripperCommand, Snapshot, World};

fn held() -> World {
    let quiet = &mut |_: &World| {};
    let mut world = pouring(&Beads::new(60), standing(-0.16, 0.0, 0.0, 0.2), standing(0.16, 0.02, 0.0, 0.0));
    grasp(&mut world, quiet);
    let bowl = world.pose("bowl").unwrap();
    world.move_hand(bowl * lip(-0.03, 0.15, 1.3), quiet);
    world
}

/// Pours the rest, drops the pitcher and pushes the bowl. Returns what every step shows.
fn go_on(world: &mut World) -> Vec<Vec<u64>> {
    let mut film = Vec::new();
    let record = &mut |world: &World| film.push(bits(world));
    tilt(world, record);
    world.push("bowl", [0.05, 0.02, 0.0], 0.3).unwrap();
    world.command(GripperCommand::Open(0.08));
    world.hold(0.7, record);
    film
}

#[test]
fn a_restored_world_goes_on_bit_for_bit() {
    let mut world = held();
    let snapshot = world.snapshot();
    let text = serde_json::to_string(&snapshot).unwrap();
    let reread: Snapshot = serde_json::from_str(&text).unwrap();
    assert!(text.len() < 2_000_000, "a snapshot of {} bytes", text.len());

    let film = go_on(&mut world);
    assert!(film.len() > 500);
    for (kind, from) in [("memory", &snapshot), ("text", &reread)] {
        let mut again = World::restore(from);
        let second = go_on(&mut again);
        let first_difference = film.iter().zip(&second).position(|(a, b)| a != b);
        assert_eq!(first_difference, None, "restored from {kind}: differs from this step on");
        assert_eq!(film.len(), second.len());
    }
}

#[test]
fn the_same_calls_give_the_same_bits() {
    let build = || {
        let mut world = held();
        close_pitcher(&mut world);
        let film = go_on(&mut world);
        (film, world)
    };
    let (film, world) = build();
    let (again, _) = build();
    assert!(film == again);
    // Something has happened: beads were poured and the bowl moved.
    assert!(world.beads_inside("pitcher") < Some(60));
}

#[test]
fn magnets_and_pushes_are_part_of_a_snapshot() {
    let mut world = pouring(&Beads::new(20), standing(-0.1, 0.0, 0.0, 0.0), standing(0.2, 0.0, 0.0, 0.0));
    close_pitcher(&mut world);
    world.push("pitcher", [0.0, 0.08, 0.0], 0.4).unwrap();
    world.settle(0.2);
    let mut again = World::restore(&world.snapshot());
    for world in [&mut world, &mut again] {
        world.settle(0.6);
        assert!((world.pose("pitcher").unwrap().translation.y - 0.08).abs() < 1e-4);
    }
    assert_eq!(bits(&world), bits(&again));
}
