//! The instructions of the kernels and of whole updates, counted by gungraun under valgrind's callgrind, and the gate
//! on them.
//!
//! Each is counted by itself and once, without the code that makes its input and checks its result. The counts are held
//! against `results/baselines/instructions.json` as [`situ_bench::gate`] says: the bench fails where a
//! count is more than 2 % above it. Every run also tries whether the gate would see a change: one more iteration of EM
//! must be a regression of the fit. Nothing is counted, and a message says so, without valgrind or without gungraun's
//! runner in the version of `Cargo.lock`.
//!
//! ```text
//! cargo install --locked --version =0.20.0 gungraun-runner
//! cargo bench -p situ-bench --bench instructions
//! cargo bench -p situ-bench --bench instructions -- '*::updates::*'
//! cargo bench -p situ-bench --bench instructions -- --mint
//! ```

#![expect(missing_docs, reason = "the macros of gungraun make items that have none")]

mod inputs;

use std::collections::BTreeMap;
use std::env;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

use gungraun::prelude::*;
use situ::correction::Correction;
use situ::edit::Edit;
use situ::keyframe::hmm::HmmFit;
use situ::keyframe::logistic::{self, LogisticFit};
use situ::method::{self, Learned};
use situ::place::{NodeId, Place};
use situ::trace::Trace;
use situ_bench::cost::{Subject, corrected};
use situ_bench::error::BenchError;
use situ_bench::files;
use situ_bench::gate::valgrind::{self, counted};
use situ_bench::gate::{InstructionBaseline, Origin, Verdict};
use situ_bench::synthetic::{Parameters, Planted};

use inputs::{Divergence, Fitting, Regression, Scoring, Screening};

/// Nodes of the automaton that is corrected.
const NODES: usize = 30;
/// The seed of the automaton.
const SEED: u64 = 1;
/// The baseline, seen from the root of the workspace.
const BASELINE: &str = "results/baselines/instructions.json";
/// Takes the baseline anew.
const MINT: &str = "--mint";
/// The runner of gungraun's benches.
const RUNNER: &str = "gungraun-runner";
/// The environment variable that is set where this program has started itself, to count.
const COUNTING: &str = "SITU_COUNTING";
/// A bench, and the same with a known slowdown.
const SLOWDOWN: (&str, &str) = ("kernels::hmm_fit::twenty_iterations", "kernels::hmm_fit::one_more");

// Each function returns its input as well, so that freeing the input is not counted.

#[library_benchmark]
#[bench::twenty_iterations(args = (0), setup = Fitting::checked)]
#[bench::one_more(args = (1), setup = Fitting::checked)]
fn hmm_fit(fitting: Fitting) -> (HmmFit, Fitting) {
    (fitting.run(), fitting)
}

#[library_benchmark]
#[bench::log_likelihood(setup = Scoring::checked)]
fn hmm_scoring(scoring: Scoring) -> (f64, Scoring) {
    (scoring.run(), scoring)
}

#[library_benchmark]
#[bench::cross_likelihood(setup = Divergence::checked)]
fn divergence(divergence: Divergence) -> (f64, Divergence) {
    (divergence.run(), divergence)
}

#[library_benchmark(setup = Regression::checked)]
#[bench::primal_50_13(50, 13, logistic::Path::Primal)]
#[bench::dual_50_13(50, 13, logistic::Path::Dual)]
#[bench::primal_200_80(200, 80, logistic::Path::Primal)]
#[bench::dual_200_80(200, 80, logistic::Path::Dual)]
fn logistic_regression(regression: Regression) -> (LogisticFit, Regression) {
    (regression.run(), regression)
}

#[library_benchmark]
#[bench::thousand(setup = Screening::checked)]
fn screening(screening: Screening) -> (Vec<NodeId>, Screening) {
    (screening.run(), screening)
}

/// A model that was taught, and a correction of it.
struct Update {
    learned: Box<dyn Learned>,
    last: Place,
    planted: Planted,
}

/// A correction after which the model has changed by this edit and nothing else.
fn update_of(edit: Edit) -> Update {
    let method = method::named("situ").expect("it is listed");
    let subject = Subject::teach(&*method, Parameters::of(NODES, SEED)).expect("the automaton is learned");
    let made = subject.measure("instructions", "nodes", edit, 0).expect("the correction is learned").edit_made;
    assert_eq!(made, edit, "the edit that was planted is made");
    let planted = subject.automaton().plant(edit, SEED).expect("there is room for a correction");
    let last = planted.last(&subject.learned().graph().unwrap()).expect("the first original visits every node");
    Update { learned: subject.learned().boxed(), last, planted }
}

#[library_benchmark(setup = update_of)]
#[bench::node_addition(Edit::NodeAddition)]
#[bench::edge_addition(Edit::EdgeAddition)]
#[bench::node_modification(Edit::NodeModification)]
fn correction(mut update: Update) -> (Trace, Update) {
    let shown = Correction::after(update.last, &update.planted.demonstration);
    (corrected(&mut *update.learned, shown).expect("it was learned before"), update)
}

library_benchmark_group!(
    name = kernels,
    benchmarks = [hmm_fit, hmm_scoring, divergence, logistic_regression, screening]
);
library_benchmark_group!(name = updates, benchmarks = correction);

/// Gungraun's part: the program starts the runner, which starts the program again under valgrind, once for each bench.
mod harness {
    use gungraun::{Callgrind, LibraryBenchmarkConfig};

    use super::{kernels, updates};

    gungraun::main!(
        config = LibraryBenchmarkConfig::default().tool(Callgrind::with_args(["--cache-sim=no"]));
        library_benchmark_groups = kernels, updates
    );

    pub(super) fn run() {
        main();
    }
}

fn main() -> ExitCode {
    let words: Vec<String> = env::args().skip(1).collect();
    if words.first().is_some_and(|word| word == "--gungraun-run") || env::var_os(COUNTING).is_some() {
        harness::run();
        return ExitCode::SUCCESS;
    }
    let wanted = runner();
    let found = Command::new(RUNNER).arg("--version").output().map(|output| output.stdout).unwrap_or_default();
    if !valgrind::is_possible() || String::from_utf8_lossy(&found).trim() != wanted {
        println!("Instructions were not counted: valgrind or {wanted} is not here.");
        return ExitCode::SUCCESS;
    }
    match gate(words) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_status())
        }
    }
}

/// The name and version of the runner that the crate needs, as the runner prints them.
fn runner() -> String {
    let locked = include_str!("../../Cargo.lock");
    let version = locked.split_once("name = \"gungraun\"\nversion = \"").and_then(|(_, rest)| rest.split_once('"'));
    format!("{RUNNER} {}", version.expect("the lock file has the crate").0)
}

/// Counts and judges, or mints. Returns whether nothing regressed and the gate would have seen a regression.
fn gate(mut words: Vec<String>) -> Result<bool, BenchError> {
    let baseline = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(BASELINE);
    let all = words.len();
    words.retain(|word| word != MINT);
    let mints = words.len() < all;
    let is_whole = words.iter().all(|word| word.starts_with('-'));
    if mints && !is_whole {
        return Err(BenchError::Argument(format!("`{MINT}`: expected no pattern: the baseline is of all benches")));
    }
    let origin = Origin::here();
    let expected = (!mints).then(|| InstructionBaseline::read(&baseline)).transpose()?;
    let mut counts = BTreeMap::new();
    let mut is_sound = true;
    count(&words, &mut |bench, now| {
        match &expected {
            _ if bench == SLOWDOWN.1 => {}
            None => println!("{bench}: {now} instructions"),
            Some(expected) => {
                let (verdict, why) = expected.judge(&origin, &bench, now);
                println!("{verdict:<12} {bench}: {why}");
                is_sound &= verdict != Verdict::Regressed;
            }
        }
        counts.insert(bench, now);
    })?;
    let slowed = counts.remove(SLOWDOWN.1);
    match counts.get(SLOWDOWN.0).zip(slowed) {
        Some((plain, slowed)) => {
            let plain = InstructionBaseline::new(origin.clone(), BTreeMap::from([(SLOWDOWN.0.to_owned(), *plain)]));
            let (verdict, why) = plain.judge(&origin, SLOWDOWN.0, slowed);
            println!("one more iteration of EM is {verdict}: {why}");
            is_sound &= verdict == Verdict::Regressed;
        }
        None if is_whole => return Err(BenchError::Valgrind { problem: "the fits were not counted".to_owned() }),
        None => {}
    }
    let known = expected.iter().flat_map(|expected| expected.instructions.keys());
    for bench in known.filter(|bench| is_whole && !counts.contains_key(*bench)) {
        println!("{:<12} {bench}: in the baseline, and not counted", Verdict::Incomparable);
    }
    if mints {
        files::write_all(&[(baseline, InstructionBaseline::new(origin, counts).to_json())])?;
        println!("The baseline is {BASELINE}.");
    }
    Ok(is_sound)
}

/// Runs gungraun in a process of its own and gives the instructions of each bench to `each` as they come.
fn count(words: &[String], each: &mut dyn FnMut(String, u64)) -> Result<(), BenchError> {
    let refuse = |problem: String| BenchError::Valgrind { problem };
    let refused = |error: std::io::Error| refuse(error.to_string());
    let mut counting = Command::new(env::current_exe().map_err(refused)?)
        .args(words)
        .arg("--output-format=json")
        .env(COUNTING, "yes")
        .stdout(Stdio::piped())
        .spawn()
        .map_err(refused)?;
    let lines = BufReader::new(counting.stdout.take().expect("it is piped")).lines();
    for line in lines {
        let (bench, instructions) = counted(&line.map_err(refused)?)?;
        each(bench, instructions);
    }
    let status = counting.wait().map_err(refused)?;
    if status.success() { Ok(()) } else { Err(refuse(format!("gungraun failed: {status}"))) }
}
