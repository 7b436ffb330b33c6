//! The memory of a task model grows in proportion to its nodes, and what a copy of an episode takes is what it says.
//!
//! ```text
//! cargo test -p situ-bench --release --test memory -- --ignored --nocapture     # ten thousand nodes
//! ```

use allocation_counter::measure;
use situ::correction::Correction;
use situ::edit::Edit;
use situ::method;
use situ_bench::cost::Subject;
use situ_bench::synthetic::Parameters;
use situ_tasks::{Episode, Registry};

const MEGABYTE: f64 = 1e6;

/// Bytes: the most while the automaton is taught, those of the model, and the most beside the model while a correction
/// is folded in.
fn bytes(nodes: usize) -> [u64; 3] {
    let situ = method::named("situ").unwrap();
    let mut subject = None;
    let taught = measure(|| subject = Some(Subject::teach(&*situ, Parameters::of(nodes, 1)).unwrap()));
    let subject = subject.unwrap();
    let mut copy = None;
    let model = measure(|| copy = Some(subject.learned().boxed()));
    let mut copy = copy.unwrap();
    let planted = subject.automaton().plant(Edit::NodeAddition, 1).unwrap();
    let last = planted.last(&copy.graph()).unwrap();
    let corrected = measure(|| {
        copy.correct(Correction::after(last, &planted.demonstration)).unwrap();
    });
    let found = [taught.bytes_max, model.bytes_max, corrected.bytes_max];
    let [taught, model, corrected] = found.map(|bytes| bytes as f64 / MEGABYTE);
    println!(
        "{nodes} nodes: {taught:.2} MB at most while taught, a model of {model:.2} MB, {corrected:.3} MB more in an \
         update"
    );
    found
}

#[test]
fn memory_grows_with_the_nodes_and_an_update_needs_no_more_in_a_greater_model() {
    let ([_, small, in_small], [_, great, in_great]) = (bytes(20), bytes(200));
    let growth = great as f64 / small as f64;
    assert!((8.0..12.0).contains(&growth), "ten times the nodes take {growth} times the memory");
    assert!(in_great < 2 * in_small, "{in_great} bytes for an update, {in_small} in the smaller model");
}

/// The memo of a run keeps copies of episodes up to so many bytes, by what they say themselves.
#[test]
fn a_copy_of_an_episode_takes_about_what_it_says() {
    let registry = Registry::builtin().unwrap();
    for task in registry.tasks() {
        let episode = Episode::start(&task.variation(None).unwrap(), 1).unwrap();
        let mut copy = None;
        let taken = measure(|| copy = Some(episode.clone())).bytes_current as f64;
        let said = episode.bytes() as f64;
        println!("{}: {said} bytes said, {taken} taken", task.name());
        assert!((0.7..1.3).contains(&(said / taken)), "{}: {said} bytes said, {taken} taken", task.name());
    }
}

#[test]
#[ignore = "ten thousand nodes: a minute"]
fn ten_thousand_nodes() {
    let [taught, ..] = bytes(10_000);
    assert!(taught < 2_000_000_000, "{taught} bytes");
}
