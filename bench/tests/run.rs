//! Whole runs, small enough for seconds: the ledger must not depend on the number of threads, an interrupted run must go on
//! where it was, names that nothing has must be told.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

use situ_bench::error::BenchError;
use situ_bench::ledger::{self, Ledger};
use situ_bench::protocol::Protocol;
use situ_bench::record::{Outcome, Record};
use situ_bench::runner::{Filter, Plan, Progress};
use situ_tasks::Registry;

const PROTOCOL: &str = r#"
name = "small"
analysis = "One family, one expert, few rollouts: a test."
tasks = ["sort_blocks"]
teachers = ["expert"]
methods = ["situ", "rebuild", "no_update"]
seeds = 1
target = 0.5
rollouts = 2
confidence = 0.3
execution = "sample"

[budget]
least_originals = 2
originals = 2
corrections = 1
from_scratch = 1

[cost]
methods = ["situ"]
nodes = [10]
seeds = 1
"#;

struct Silent;

impl Progress for Silent {
    fn at(&self, _: &str) {}
    fn finished(&self) {}
}

fn plan(filter: &Filter) -> Plan {
    let protocol = Protocol::parse(PROTOCOL, Path::new("small.toml")).unwrap();
    Plan::new(protocol, filter, &Registry::builtin().unwrap(), 1).unwrap()
}

fn bump() -> Plan {
    plan(&Filter { variations: vec!["bump".to_owned()], ..Filter::default() })
}

/// The canonical ledger, without its times, of a run on so many threads.
fn run(plan: &Plan, path: &Path, threads: usize) -> Result<Vec<Record>, BenchError> {
    let (ledger, contents) = Ledger::open(path)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let stop = AtomicBool::new(false);
    pool.install(|| plan.run(&Mutex::new(ledger), &contents.done(), &stop, None, &Silent))?;
    let records = ledger::canonical(ledger::read(path)?.records);
    Ok(records.iter().map(Record::without_times).collect())
}

#[test]
fn one_thread_and_two_write_the_same_records() {
    let folder = tempfile::tempdir().unwrap();
    let plan = bump();
    let one = run(&plan, &folder.path().join("one.jsonl"), 1).unwrap();
    let two = run(&plan, &folder.path().join("two.jsonl"), 2).unwrap();
    assert_eq!(one.len(), plan.len());
    assert_eq!(ledger::text(&one), ledger::text(&two));
    // The records say something: the uncorrected model fails, the corrected one was corrected by one demonstration.
    let runs: Vec<_> =
        one.iter().filter_map(|record| if let Record::Run(run) = record { Some(run) } else { None }).collect();
    let of = |method: &str| *runs.iter().find(|run| run.key.method == method).unwrap();
    assert_eq!(of("no_update").outcome, Outcome::Censored);
    assert_eq!(of("no_update").after.unwrap().successes, 0);
    assert_eq!(of("situ").corrections.len(), 1);
    assert_eq!(of("situ").outcome, Outcome::Reached);
}

#[test]
fn what_is_in_the_ledger_is_not_run_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ledger.jsonl");
    let plan = bump();
    let whole = run(&plan, &path, 2).unwrap();
    // As an interrupt leaves it: some lines, the last one torn.
    let text = std::fs::read_to_string(&path).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    std::fs::write(&path, format!("{}\n{}", lines[0], &lines[1][..lines[1].len() / 2])).unwrap();
    assert_eq!(ledger::text(&run(&plan, &path, 2).unwrap()), ledger::text(&whole));
    let before = std::fs::read_to_string(&path).unwrap();
    run(&plan, &path, 2).unwrap();
    assert_eq!(before, std::fs::read_to_string(&path).unwrap(), "a finished ledger is left as it is");
}

#[test]
fn an_interrupt_leaves_a_good_ledger() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ledger.jsonl");
    let (ledger, _) = Ledger::open(&path).unwrap();
    let result = bump().run(&Mutex::new(ledger), &BTreeSet::new(), &AtomicBool::new(true), None, &Silent);
    assert!(matches!(result, Err(BenchError::Interrupted)));
    assert_eq!(ledger::read(&path).unwrap().records, []);
}

#[test]
fn bad_names_and_protocols_exit_with_2_and_say_what_would_be_right() {
    let folder = tempfile::tempdir().unwrap();
    let protocol = folder.path().join("bad.toml");
    std::fs::write(&protocol, PROTOCOL.replace("target = 0.5", "target = 1.5")).unwrap();
    let protocol = protocol.to_str().unwrap();
    let cases: [(&[&str], &[&str]); 6] = [
        (&["run", "--task", "pours"], &["pours", "pour", "sort_blocks"]),
        (&["run", "--variation", "lids"], &["lids", "vase", "high_bins"]),
        (&["run", "--method", "magic"], &["magic", "situ:literal", "from_scratch"]),
        (&["run", "--teacher", "genius"], &["genius", "expert", "novice"]),
        (&["run", "--protocol", "slow"], &["slow", "quick", "paper"]),
        (&["run", "--protocol", protocol], &["bad.toml:8", "target", "above 0 and at most 1"]),
    ];
    for (arguments, words) in cases {
        let output =
            Command::new(env!("CARGO_BIN_EXE_situ-bench")).args(arguments).current_dir(folder.path()).output().unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        for word in words {
            assert!(error.contains(word), "{arguments:?}: `{word}` is not in: {error}");
        }
    }
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(left.len(), 1, "nothing is written");
}
