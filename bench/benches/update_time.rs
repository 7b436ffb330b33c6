//! The time of one correction against the size of the task model: `situ` beside every method that trains on everything
//! again.
//!
//! Three things vary: the number of nodes with |Z| held fixed, the number of original demonstrations, and |Z| at one
//! number of nodes. `Learned::correct` alone is timed. The copy of the model that it works on is made and dropped
//! outside. `from_scratch` knows no earlier model: for it, teaching as many whole demonstrations as the others were
//! taught is timed. A method that takes longer than a few seconds is measured at small sizes only ([`Contender`]).
//!
//! Each case first checks the edit that the method makes, because the time of a wrong result is worth nothing.
//! The times are reported and are never a gate: the exact counters of the cost table are the verdict.
//!
//! ```text
//! cargo bench -p situ-bench --bench update_time
//! cargo bench -p situ-bench --bench update_time -- 'nodes/node-addition/.*/100$'
//! ```

use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BatchSize, BenchmarkGroup, BenchmarkId, Criterion, SamplingMode, criterion_group, criterion_main};
use situ::correction::Correction;
use situ::edit::{Edit, difference};
use situ::method::{self, Learned, Role};
use situ::place::SegmentId;
use situ_bench::synthetic::{Applicable, Automaton, Parameters};

/// A method.
struct Contender {
    name: &'static str,
    /// Whether its primitives are the nodes of the automaton, and the edit that it makes is the planted one.
    /// `bp_ar_hmm` finds primitives of its own, and so it must hold the correction and no more.
    has_the_nodes: bool,
    /// The most segments of original demonstrations, nodes times originals, at which a correction takes no longer than
    /// a few seconds.
    most_segments: usize,
}

/// `situ`, and all that train on everything again.
const CONTENDERS: [Contender; 5] = [
    Contender { name: "situ", has_the_nodes: true, most_segments: usize::MAX },
    Contender { name: "rebuild", has_the_nodes: true, most_segments: usize::MAX },
    Contender { name: "from_scratch", has_the_nodes: true, most_segments: 480 },
    Contender { name: "itmcd", has_the_nodes: true, most_segments: 120 },
    Contender { name: "bp_ar_hmm", has_the_nodes: false, most_segments: 30 },
];
/// The seed of every automaton.
const SEED: u64 = 1;
/// Samples of each case: the least that criterion allows, because a rebuild of a thousand nodes takes seconds.
const SAMPLES: usize = 10;

/// A series: its name, its edits, and its automata, each with the number that is varied.
type Series = (&'static str, &'static [Edit], [(usize, Parameters); 3]);

fn series() -> [Series; 3] {
    let demonstrations = |originals| (originals, Parameters { originals, ..Parameters::of(10, SEED) });
    let applicable = |nodes| (nodes, Parameters { applicable: Applicable::Fixed(nodes), ..Parameters::of(100, SEED) });
    [
        (
            "nodes",
            &[Edit::NodeAddition, Edit::EdgeAddition],
            [10, 100, 1000].map(|nodes| (nodes, Parameters::of(nodes, SEED))),
        ),
        ("demonstrations", &[Edit::NodeAddition], [3, 12, 48].map(demonstrations)),
        ("applicable", &[Edit::NodeAddition], [2, 5, 20].map(applicable)),
    ]
}

fn update_time(criterion: &mut Criterion) {
    for (series, edits, sizes) in series() {
        for (size, parameters) in sizes {
            let automaton = Automaton::new(parameters).expect("the parameters are in range");
            let is_timed = |one: &&Contender| parameters.nodes * parameters.originals <= one.most_segments;
            for contender in CONTENDERS.iter().filter(is_timed) {
                let method = method::named(contender.name).expect("it is listed");
                let teach = || method.teach(automaton.schema(), automaton.originals(), SEED).expect("it is learned");
                let learned = teach();
                if contender.has_the_nodes {
                    assert!(automaton.is_recovered(&learned.graph().unwrap()), "{} at {series} {size}", contender.name);
                }
                for &edit in edits {
                    let mut group = criterion.benchmark_group(format!("{series}/{edit}"));
                    group.sample_size(SAMPLES).sampling_mode(SamplingMode::Flat);
                    group.warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
                    let id = BenchmarkId::new(contender.name, size);
                    if method.role() == Role::FromScratch {
                        // It is taught a task and not an edit, so once is enough.
                        if edit == Edit::NodeAddition {
                            group.bench_function(id, |bencher| bencher.iter_with_large_drop(teach));
                        }
                    } else {
                        correct(&mut group, id, contender, &automaton, &*learned, edit);
                    }
                }
            }
        }
    }
}

/// Checks the method's edit for a correction, and times it.
fn correct(
    group: &mut BenchmarkGroup<'_, WallTime>,
    id: BenchmarkId,
    contender: &Contender,
    automaton: &Automaton,
    learned: &dyn Learned,
    edit: Edit,
) {
    let Contender { name, has_the_nodes, .. } = contender;
    let planted = automaton.plant(edit, SEED).expect("there is room for a correction");
    let before = learned.graph().unwrap();
    let last = planted.last(&before).expect("the model holds the first original");
    let correct = |mut learned: Box<dyn Learned>| {
        let trace = learned.correct(Correction::after(last, &planted.demonstration));
        (learned, trace)
    };
    let (corrected, trace) = correct(learned.boxed());
    let trace = trace.expect("the correction is learned");
    let after = corrected.graph().unwrap();
    let made = difference(&before, &after).edit();
    let demonstration = automaton.parameters().originals as u32;
    assert!(after.holders().contains_key(&SegmentId { demonstration, index: 0 }), "{name}: the correction is held");
    assert!(!has_the_nodes || made == edit, "{name}: {made} where {edit} was planted");
    let applicable: Vec<usize> = trace.steps.iter().map(|step| step.applicable.len()).collect();
    let work = trace.counters.named().map(|(counter, value)| format!("{counter} {value}"));
    println!("{edit} by {name}: {made} made, |Z| {applicable:?}, {}", work.join(", "));
    group.bench_function(id, |bencher| bencher.iter_batched(|| learned.boxed(), correct, BatchSize::PerIteration));
}

criterion_group!(benches, update_time);
criterion_main!(benches);
