//! The times of the kernels that an update is made of, on the inputs whose instructions are counted.
//!
//! ```text
//! cargo bench -p situ-bench --bench kernels
//! cargo bench -p situ-bench --bench kernels -- logistic
//! ```

mod inputs;

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use situ::keyframe::logistic::Path;

use inputs::{Divergence, Fitting, Regression, Scoring, Screening};

fn kernels(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("kernels");
    group.sample_size(20).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(3));
    let fitting = Fitting::checked(0);
    group.bench_function("hmm_fit", |bencher| bencher.iter(|| fitting.run()));
    let scoring = Scoring::checked();
    group.bench_function("hmm_scoring", |bencher| bencher.iter(|| scoring.run()));
    let divergence = Divergence::checked();
    group.bench_function("divergence", |bencher| bencher.iter(|| divergence.run()));
    for (samples, features) in [(50, 13), (200, 80)] {
        for path in [Path::Primal, Path::Dual] {
            let regression = Regression::checked(samples, features, path);
            let id = BenchmarkId::new(format!("logistic_regression/{path:?}"), format!("{samples} × {features}"));
            group.bench_function(id, |bencher| bencher.iter(|| regression.run()));
        }
    }
    let screening = Screening::checked();
    group.bench_function("screening", |bencher| bencher.iter(|| screening.run()));
    group.finish();
}

criterion_group!(benches, kernels);
criterion_main!(benches);
