//! The memory of a task model grows in proportion to its nodes and by the same for every correction, and what a copy of
//! an episode takes is what it says.
//!
//! ```text
//! cargo test -p situ-bench --release --test memory -- --ignored --nocapture  # 10,000 nodes
//! SITU_SOAK=50 cargo test -p situ-bench --release --test memory -- one_model --nocapture  # 10,000 corrections
//! ```

#[path = "../../situ/tests/all/common/soak.rs"]
#[expect(dead_code, reason = "these tests draw by themselves")]
mod soak;

use std::collections::{BTreeMap, BTreeSet};

use allocation_counter::measure;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::correction::Correction;
use situ::edit::Edit;
use situ::graph::Graph;
use situ::method::{self, Learned};
use situ::place::{Place, SegmentId};
use situ::segmentation::by_reference_object;
use situ::trace::{Counters, Trace};
use situ_bench::cost::{Subject, processor_timed};
use situ_bench::stats::{mean, power_law};
use situ_bench::synthetic::{Parameters, Planted};
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
    let last = planted.last(&copy.graph().unwrap()).unwrap();
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

/// Nodes of the model that is corrected again and again.
const NODES: usize = 20;
/// Corrections of it, where they are not soaked.
const CORRECTIONS: u32 = 200;

/// What a correction took.
struct Taken {
    /// Places that it touches, and the segments of those that are nodes.
    places: usize,
    segments: usize,
    /// Bytes that the model is larger by.
    kept: i64,
    /// Bytes that were asked for, given back or not.
    asked: u64,
    counters: Counters,
    seconds: f64,
}

/// The places whose policy or classifier a correction may fit again: those that it visits, what is compared with them,
/// and their siblings.
fn touched(graph: &Graph, trace: &Trace) -> BTreeSet<Place> {
    let visited: BTreeSet<Place> = trace.steps.iter().map(|step| Place::Node(step.node)).collect();
    let compared = trace.steps.iter().flat_map(|step| step.applicable.iter().map(|id| Place::Node(*id)));
    let origins = trace.steps.iter().map(|step| step.after);
    let parents: BTreeSet<Place> =
        graph.edges.iter().filter(|(_, to)| visited.contains(to)).map(|(from, _)| *from).chain(origins).collect();
    let siblings = graph.edges.iter().filter(|(from, _)| parents.contains(from)).map(|(_, to)| *to);
    siblings.chain(compared).chain(visited.iter().copied()).collect()
}

/// What holds of a model after a correction, whoever keeps it: the graph is sound, probabilities are such, what the
/// correction cannot reach is as it was, and the model does what it was shown, or says that it does not.
fn sound(learned: &dyn Learned, before: &Graph, after: &Graph, planted: &Planted, trace: &Trace, shown: usize) {
    let mut held: BTreeMap<SegmentId, usize> = BTreeMap::new();
    after.nodes.iter().flat_map(|node| &node.segments).for_each(|segment| *held.entry(*segment).or_default() += 1);
    assert!(held.values().all(|times| *times == 1), "a segment of two nodes");
    let segments: usize = after.lengths.iter().map(Vec::len).sum();
    assert_eq!((held.len(), after.lengths.len()), (segments, shown), "every segment has its node");
    let places: BTreeSet<Place> =
        after.nodes.iter().map(|node| Place::Node(node.id)).chain([Place::Start, Place::End]).collect();
    assert!(after.edges.iter().all(|(from, to)| places.contains(from) && places.contains(to)));
    assert!(after.edges.iter().all(|(from, to)| *from != Place::End && *to != Place::Start));
    let reached = touched(after, trace);
    let old: BTreeMap<_, _> = before.nodes.iter().map(|node| (node.id, node)).collect();
    for node in after.nodes.iter().filter(|node| !reached.contains(&Place::Node(node.id))) {
        assert_eq!(old.get(&node.id), Some(&node), "{} is out of reach", node.id);
    }
    let starts: Vec<_> = by_reference_object(&planted.demonstration).into_iter().map(|segment| segment.start).collect();
    let mut others = 0;
    for (step, state) in trace.steps.iter().zip(&starts) {
        for place in &places {
            for (child, probability) in learned.ranked(*place, state).unwrap() {
                assert!((0.0..=1.0).contains(&probability) && places.contains(&child), "{place}: {probability}");
            }
        }
        others +=
            u32::from(learned.next(step.after, state).unwrap().map(|(place, _)| place) != Some(Place::Node(step.node)));
    }
    assert!(others <= trace.obedience.aliased + trace.obedience.disobeyed, "{others}: {:?}", trace.obedience);
}

/// Random corrections of one model, one after another.
fn corrected(count: u32) -> Vec<Taken> {
    let situ = method::named("situ").unwrap();
    let subject = Subject::teach(&*situ, Parameters::of(NODES, soak::seed())).unwrap();
    let (mut learned, mut rng) = (subject.learned().boxed(), ChaCha8Rng::seed_from_u64(soak::seed()));
    let mut before = learned.graph().unwrap();
    let mut taken = Vec::new();
    for number in 0..count {
        let edit = Edit::ALL[rng.random_range(0..Edit::ALL.len())];
        let planted = subject.automaton().plant(edit, rng.random()).unwrap();
        let correction = Correction::after(planted.last(&before).unwrap(), &planted.demonstration);
        let mut trace = None;
        let (bytes, seconds) =
            processor_timed(|| measure(|| trace = Some(learned.correct(correction).expect("it can be learned"))));
        let (trace, after) = (trace.unwrap(), learned.graph().unwrap());
        sound(
            &*learned,
            &before,
            &after,
            &planted,
            &trace,
            subject.automaton().originals().len() + 1 + number as usize,
        );
        let touched = touched(&after, &trace);
        let nodes = after.nodes.iter().filter(|node| touched.contains(&Place::Node(node.id)));
        taken.push(Taken {
            places: touched.len(),
            segments: nodes.map(|node| node.segments.len()).sum(),
            kept: bytes.bytes_current,
            asked: bytes.bytes_total,
            counters: trace.counters,
            seconds,
        });
        before = after;
    }
    taken
}

/// The mean over some corrections.
fn mean_of(taken: &[Taken], of: impl Fn(&Taken) -> f64) -> f64 {
    mean(&taken.iter().map(of).collect::<Vec<_>>()).expect("some corrections")
}

/// Prints means over tenths of the corrections, and how the work grows with the segments. The clock decides nothing.
fn print(taken: &[Taken]) {
    println!("corrections, segments, bytes kept, bytes asked for, segments read, classifier fits, milliseconds");
    let tenth = taken.len().div_ceil(10);
    for (index, part) in taken.chunks(tenth).enumerate() {
        let until = index * tenth + part.len();
        let [segments, kept] = [mean_of(part, |one| one.segments as f64), mean_of(part, |one| one.kept as f64)];
        let asked = mean_of(part, |one| one.asked as f64);
        let read = mean_of(part, |one| one.counters.segments_touched as f64);
        let fits = mean_of(part, |one| one.counters.classifier_fits as f64);
        let milliseconds = mean_of(part, |one| 1e3 * one.seconds);
        println!("{until}, {segments:.0}, {kept:.0}, {asked:.0}, {read:.0}, {fits:.1}, {milliseconds:.2}");
    }
    for (what, of) in [
        ("bytes asked for", (|one| one.asked as f64) as fn(&Taken) -> f64),
        ("segments read", |one| one.counters.segments_touched as f64),
        ("processor seconds", |one| one.seconds),
    ] {
        let points: Vec<_> = taken.iter().map(|one| (one.segments as f64, of(one))).collect();
        let law = power_law(&points).expect("work at segments of many numbers");
        println!("{what} over segments: an exponent of {:.2}", law.exponent.value);
    }
}

/// A correction that comes late keeps no more bytes than an early one, and its work is at most linear in the segments
/// of the nodes that it touches. Bytes that are asked for stand for time: they are exact, and no kernel of more than
/// linear work does without memory of its size.
#[test]
fn one_model_takes_any_number_of_corrections() {
    println!("SITU_SEED={}", soak::seed());
    let taken = corrected(CORRECTIONS * soak::times());
    print(&taken);
    let tenth = taken.len() / 10;
    // The first corrections add nodes.
    let (early, late) = (&taken[tenth..2 * tenth], &taken[taken.len() - tenth..]);
    let grown = mean_of(late, |one| one.segments as f64) / mean_of(early, |one| one.segments as f64);
    assert!(grown > 2.0, "the nodes hold {grown} times the segments: nothing was shown");
    let [early_kept, late_kept] =
        [&taken[tenth..taken.len() / 2], &taken[taken.len() / 2..]].map(|part| mean_of(part, |one| one.kept as f64));
    assert!(late_kept < 1.25 * early_kept, "{early_kept} bytes a correction, later {late_kept}");
    let [early_work, late_work] =
        [early, late].map(|part| mean_of(part, |one| one.asked as f64) / mean_of(part, |one| one.segments as f64));
    assert!(late_work < 1.25 * early_work, "{early_work} bytes asked for a segment, later {late_work}");
    for one in &taken {
        assert!(one.counters.segments_touched <= 2 * one.segments as u64, "{:?}", one.counters);
        // Obedience (decision D22) may take samples away one by one, with a fit after each: as many as the nodes have.
        let most = 3 * one.places + one.segments;
        assert!(one.counters.classifier_fits <= most as u64, "{} places: {:?}", one.places, one.counters);
    }
    let many = taken.iter().filter(|one| one.counters.classifier_fits > 3 * one.places as u64).count();
    println!("{many} corrections made more than three fits for each place that they touch");
    assert!(100 * many <= taken.len(), "{many} of {} corrections", taken.len());
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
