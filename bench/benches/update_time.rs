//! The time of one correction against the size of the task model: `situ` beside full retraining.
//!
//! Each case first checks that the method makes of the planted correction what it should: a time of a wrong result is worth
//! nothing. What is timed is `Learned::correct` alone; the copy of the model that it works on is made and dropped outside.
//! The times are reported and never a gate: the exact counters of the cost table are the verdict.
//!
//! ```text
//! cargo bench -p situ-bench --bench update_time
//! cargo bench -p situ-bench --bench update_time -- 'node-addition/.*/100$'
//! ```

use std::time::Duration;

use criterion::{BatchSize, BenchmarkId, Criterion, SamplingMode, criterion_group, criterion_main};
use situ::correction::Correction;
use situ::edit::Edit;
use situ::method;
use situ_bench::cost::Subject;
use situ_bench::synthetic::Parameters;

/// Nodes of the automata.
const SIZES: [usize; 3] = [10, 100, 1000];
/// The methods, side by side.
const METHODS: [&str; 2] = ["situ", "rebuild"];
/// The edits that both methods make.
const EDITS: [Edit; 2] = [Edit::NodeAddition, Edit::EdgeAddition];
/// The seed of every automaton.
const SEED: u64 = 1;
/// Samples a case: the least that criterion allows, for a rebuild of a thousand nodes takes long.
const SAMPLES: usize = 10;

fn update_time(criterion: &mut Criterion) {
    for nodes in SIZES {
        for name in METHODS {
            let method = method::named(name).expect("a listed method");
            let subject = Subject::teach(&*method, Parameters::of(nodes, SEED)).expect("the automaton is learned");
            for edit in EDITS {
                let cost = subject.measure("update_time", "nodes", edit, 0).expect("the correction is learned");
                assert_eq!(cost.edit_made, edit, "{name} at {nodes} nodes: a wrong result is not timed");
                let work = cost.counters.named().map(|(counter, value)| format!("{counter} {value}"));
                println!("{edit}, {name} at {nodes} nodes: |Z| {:?}, {}", cost.applicable, work.join(", "));
                let planted = subject.automaton().plant(edit, SEED).expect("a correction");
                let last = planted.last(&subject.learned().graph()).expect("a node");
                let mut group = criterion.benchmark_group(format!("{edit}"));
                group.sample_size(SAMPLES).sampling_mode(SamplingMode::Flat);
                group.warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
                group.bench_function(BenchmarkId::new(name, nodes), |bencher| {
                    let correct = |mut learned: Box<dyn method::Learned>| {
                        let trace = learned.correct(Correction::after(last, &planted.demonstration));
                        (learned, trace)
                    };
                    bencher.iter_batched(|| subject.learned().boxed(), correct, BatchSize::PerIteration);
                });
                group.finish();
            }
        }
    }
}

criterion_group!(benches, update_time);
criterion_main!(benches);
