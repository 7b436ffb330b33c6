//! Prints, for every task and variation, how often the competent script, the original script, and the original script
//! corrected by the competent one from where a watching teacher stops it, succeed.
//!
//! `cargo run --release -p situ-tasks --example premises -- [SEEDS] [FILTER]`

use std::collections::BTreeMap;
use std::error::Error;

use situ_tasks::script::{self, Ending, Record};
use situ_tasks::{Episode, Registry, Setting};
use std::sync::Arc;

type Script = fn(&mut Episode, &mut dyn FnMut(&situ_sim::World)) -> Record;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let seeds: u64 = arguments.next().map_or(Ok(10), |text| text.parse())?;
    let filter = arguments.next().unwrap_or_default();
    println!("setting script success/seeds | seconds  metres  keyframes  guarded aborted | failed seeds");
    for task in Registry::builtin()?.tasks() {
        for setting in task.settings().filter(|setting| setting.label().contains(&filter)) {
            report(setting, "competent", seeds, script::competent)?;
            report(setting, "original", seeds, script::original)?;
            report(setting, "corrected", seeds, corrected)?;
        }
    }
    Ok(())
}

/// The original script until a watching teacher stops it, then the competent one from there.
fn corrected(episode: &mut Episode, observer: &mut dyn FnMut(&situ_sim::World)) -> Record {
    let first = script::watched(episode, observer);
    if first.ending != Ending::Stopped {
        return first;
    }
    let mut second = script::competent(episode, observer);
    second.keyframes += first.keyframes;
    second.guarded += first.guarded;
    second.aborted += first.aborted;
    second
}

/// One line: means over the seeds.
fn report(setting: &Arc<Setting>, name: &str, seeds: u64, script: Script) -> Result<(), Box<dyn Error>> {
    let (mut successes, mut seconds, mut metres) = (0, 0.0, 0.0);
    let (mut keyframes, mut guarded, mut aborted) = (0, 0, 0);
    let mut failed: BTreeMap<String, Vec<u64>> = BTreeMap::new();
    for seed in 0..seeds {
        let mut episode = Episode::start(setting, seed)?;
        let record = script(&mut episode, &mut |_| {});
        if record.ending == Ending::Succeeded {
            successes += 1;
        } else {
            failed.entry(format!("{:?} after {}", record.ending, record.skills.len())).or_default().push(seed);
        }
        seconds += episode.seconds();
        metres += episode.path();
        keyframes += record.keyframes;
        guarded += record.guarded;
        aborted += record.aborted;
    }
    let n = seeds.max(1) as f64;
    println!(
        "{:24} {name:9} {successes:3}/{seeds} | {:5.1} s {:5.2} m {:5.1} k {:4.1} g {:4.1} a | {failed:?}",
        setting.label(),
        seconds / n,
        metres / n,
        keyframes as f64 / n,
        guarded as f64 / n,
        aborted as f64 / n,
    );
    Ok(())
}
