//! The time of one step of the simulation, a control period of 1/240 s, in the world of each task family.
//!
//! A world in which the arm rests is cheap. So the timed steps are those of worlds that were copied while the competent
//! script was at work, evenly over all of it, with hand, arm, contacts and beads as they were. Each copy is stepped
//! once.
//!
//! ```text
//! cargo bench -p situ-bench --bench simulation
//! cargo bench -p situ-bench --bench simulation -- pour
//! ```

use std::sync::Arc;
use std::time::Duration;

use criterion::{BatchSize, Criterion, SamplingMode, criterion_group, criterion_main};
use situ_sim::{DT, World};
use situ_tasks::{Episode, Registry, Setting, script};

/// Moments of a script whose steps are timed.
const MOMENTS: usize = 32;
/// The seed of every start.
const SEED: u64 = 1;
/// Simulated time is a sum of steps. The error of a difference of two such sums, in seconds.
const ROUNDING: f64 = 1e-9;

/// Copies of the world at moments of the competent script.
fn moments(setting: &Arc<Setting>) -> Vec<World> {
    let run = |observer: &mut dyn FnMut(&World)| {
        let mut episode = Episode::start(setting, SEED).expect("the task has a start");
        let record = script::competent(&mut episode, observer);
        assert_eq!(record.ending, script::Ending::Succeeded, "{}: the script does what it should", setting.label());
    };
    let mut steps = 0;
    run(&mut |_| steps += 1);
    let (mut step, mut worlds) = (0, Vec::new());
    run(&mut |world| {
        if step % (steps / MOMENTS) == 0 && worlds.len() < MOMENTS {
            worlds.push(world.clone());
        }
        step += 1;
    });
    worlds
}

/// Checks that a step advances the time, leaves the numbers sound, and is the same for every copy.
fn check(world: &World) {
    let [one, other] = [(); 2].map(|()| {
        let mut copy = world.clone();
        copy.step();
        copy
    });
    assert!(one.is_finite() && (one.time() - world.time() - DT).abs() < ROUNDING);
    assert_eq!(one.tcp(), other.tcp());
    assert!(one.objects().all(|object| one.pose(object) == other.pose(object)));
}

fn simulation(criterion: &mut Criterion) {
    let registry = Registry::builtin().expect("the built-in tasks are sound");
    let mut group = criterion.benchmark_group("simulation");
    group.sample_size(20).sampling_mode(SamplingMode::Flat);
    group.warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(3));
    for task in registry.tasks() {
        let setting = task.variation(None).expect("every task has an original setting");
        let worlds = moments(&setting);
        worlds.iter().for_each(check);
        let mut next = worlds.iter().cycle();
        group.bench_function(task.name(), |bencher| {
            let step = |mut world: World| {
                world.step();
                world
            };
            bencher.iter_batched(|| next.next().expect("a cycle").clone(), step, BatchSize::PerIteration);
        });
    }
    group.finish();
}

criterion_group!(benches, simulation);
criterion_main!(benches);
