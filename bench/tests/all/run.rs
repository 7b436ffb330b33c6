//! Whole runs that take seconds. The ledger must not depend on the number of threads, an interrupted run must go on
//! where it was, and a name that nothing has must be reported.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

use crate::small;
use situ::edit::Edit;
use situ_bench::error::BenchError;
use situ_bench::external::Methods;
use situ_bench::ledger::{self, Canonical, Ledger};
use situ_bench::plan::{Filter, Plan};
use situ_bench::protocol::Protocol;
use situ_bench::record::{Identity, Outcome, Record};
use situ_bench::runner::{Progress, Runner};
use situ_bench::spending::Spending;
use situ_tasks::Registry;
use situ_teachers::Roster;

fn small_protocol() -> String {
    small::physics(r#"["situ", "rebuild", "no_update"]"#) + &small::series(r#"["situ"]"#)
}

struct Silent;

impl Progress for Silent {
    fn at(&self, _: &str) {}
    fn finished(&self) {}
}

fn plan(filter: &Filter, roster: &Roster) -> Plan {
    let protocol = Protocol::parse(&small_protocol(), Path::new("small.toml")).unwrap();
    Plan::new(protocol, filter, &Registry::builtin().unwrap(), roster, &Methods::builtin()).unwrap()
}

fn bump() -> Plan {
    plan(&Filter { variations: vec!["bump".to_owned()], ..Filter::default() }, &Roster::builtin().unwrap())
}

static SPENDING: Spending = Spending::new();

fn runner<'a>(
    plan: &'a Plan,
    ledger: &'a Mutex<Ledger>,
    done: &'a BTreeSet<Identity>,
    interrupted: &'a AtomicBool,
) -> Runner<'a> {
    Runner { plan, ledger, done, interrupted, archive: None, progress: &Silent, spending: &SPENDING }
}

/// The canonical ledger, without its times, of a run on so many threads.
pub(crate) fn run(plan: &Plan, path: &Path, threads: usize) -> Result<Vec<Record>, BenchError> {
    let (ledger, contents) = Ledger::open(path)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let stop = AtomicBool::new(false);
    pool.install(|| runner(plan, &Mutex::new(ledger), &contents.done(), &stop).run())?;
    let records = Canonical::from(ledger::read(path)?.records);
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
    // One correction added an edge. The pooled model has as many nodes and edges, and succeeds as well.
    let pooled = of("situ").pooled.as_ref().unwrap();
    assert_eq!((pooled.pooled.successes, pooled.retained.rollouts), (2, 2));
    assert_eq!((pooled.structure, of("rebuild").structure), (of("situ").structure, of("situ").structure));
    let structure = pooled.structure.unwrap();
    assert!(structure.duplicates == 0 && structure.pairs.both > 0 && structure.transitions.both > 0, "{structure:?}");
    assert_eq!((&of("rebuild").pooled, &of("no_update").structure), (&None, &None));
}

/// What a method does must not depend on the methods that run beside it, even where its model of the original task is
/// its own. An edit that it cannot make is reported, and nothing is rolled out for it.
#[test]
fn a_method_does_the_same_in_any_company() {
    let folder = tempfile::tempdir().unwrap();
    let of = |names: &[&str], file: &str| {
        let methods = names.iter().map(|name| (*name).to_owned()).collect();
        let filter = Filter { variations: vec!["bump".to_owned()], methods, ..Filter::default() };
        run(&plan(&filter, &Roster::builtin().unwrap()), &folder.path().join(file), 2).unwrap()
    };
    let alone = of(&["narrated_hierarchy"], "alone.jsonl");
    let together = of(&["keyframe_model", "narrated_hierarchy", "oracle_edit"], "together.jsonl");
    assert_eq!((alone.len(), together.len()), (1, 3));
    let runs: Vec<_> = together.iter().filter_map(Record::single_run).collect();
    let [refined, narrated, oracle] = runs[..] else { panic!("{together:?}") };
    assert_eq!(Some(narrated), alone[0].single_run());
    assert!(narrated.outcome.counts() && narrated.original_rate.unwrap().rollouts > 0);
    assert_eq!((&refined.outcome, refined.before, refined.after), (&Outcome::NotApplicable, None, None));
    assert_eq!((&oracle.outcome, oracle.corrections[0].edit_made), (&Outcome::Reached, Edit::EdgeAddition));
}

#[test]
fn a_teacher_who_comes_too_early_or_too_late_finds_another_failure() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("teachers.toml");
    let profile =
        |name: &str, rate: &str| format!("[[profile]]\nname = \"{name}\"\nanalysis = \"Errs so.\"\n{rate} = 1.0\n");
    std::fs::write(&file, profile("hasty", "begins_early") + &profile("tardy", "begins_late")).unwrap();
    let filter = Filter {
        variations: vec!["bump".to_owned()],
        methods: vec!["situ".to_owned()],
        teachers: ["expert", "hasty", "tardy"].map(str::to_owned).to_vec(),
        ..Filter::default()
    };
    let plan = plan(&filter, &Roster::builtin().unwrap().with_file(&file).unwrap());
    let records = run(&plan, &folder.path().join("ledger.jsonl"), 2).unwrap();
    let first = |teacher: &str| {
        let mut runs = records.iter().filter_map(|record| if let Record::Run(run) = record { Some(run) } else { None });
        let run = runs.find(|run| run.key.teacher == teacher).unwrap();
        (run.corrections[0].failure.clone(), run.corrections[0].last.clone())
    };
    assert_eq!(first("expert"), ("the hand is empty".to_owned(), "red_1".to_owned()));
    assert_eq!(first("hasty"), ("stopped early".to_owned(), "START".to_owned()), "before the pick that closes on air");
    let found = ("wrong outcome".to_owned(), "blue_bin".to_owned());
    assert_eq!(first("tardy"), found, "the robot went on to the end");
}

#[test]
fn a_sequence_goes_on_with_the_model_that_the_stage_before_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ledger.jsonl");
    let filter = Filter { sequences: vec!["workshop".to_owned()], ..Filter::default() };
    let plan = plan(&filter, &Roster::builtin().unwrap());
    let records = run(&plan, &path, 2).unwrap();
    // Three stages of three methods that correct or do nothing; nothing is run alone.
    assert_eq!((records.len(), plan.len()), (9, 9));
    let stages = |method: &str| {
        let runs = records.iter().filter_map(|record| if let Record::Run(run) = record { Some(run) } else { None });
        let mut runs: Vec<_> = runs.filter(|run| run.key.method == method).collect();
        runs.sort_by_key(|run| run.key.stage.as_ref().unwrap().number);
        runs
    };
    let situ = stages("situ");
    assert_eq!(situ.iter().map(|run| &*run.key.variation).collect::<Vec<_>>(), ["high_bins", "bump", "cover"]);
    assert_eq!(situ.iter().map(|run| run.earlier.len()).collect::<Vec<_>>(), [0, 1, 2]);
    assert!(situ.iter().all(|run| run.corrections.len() == 1), "{situ:#?}");
    // The cover's skills are new to the model; what it held before is still there.
    let nodes: Vec<u32> = situ.iter().map(|run| run.structure.unwrap().nodes).collect();
    assert!(nodes[2] > nodes[1] && nodes[1] >= nodes[0], "{nodes:?}");
    for run in stages("no_update") {
        assert_eq!(
            (run.corrections.len(), run.retained),
            (0, run.original_rate),
            "what is not corrected forgets nothing"
        );
    }
    // A stage in the middle that the ledger lacks is done again, and no other is.
    let text = std::fs::read_to_string(&path).unwrap();
    let lines: Vec<&str> =
        text.lines().filter(|line| !(line.contains("\"number\":2") && line.contains("\"situ\""))).collect();
    std::fs::write(&path, lines.join("\n") + "\n").unwrap();
    assert_eq!(ledger::text(&run(&plan, &path, 1).unwrap()), ledger::text(&records));
    assert_eq!(ledger::read(&path).unwrap().records.len(), 9);
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
    let result = runner(&bump(), &Mutex::new(ledger), &BTreeSet::new(), &AtomicBool::new(true)).run();
    assert!(matches!(result, Err(BenchError::Interrupted)));
    assert_eq!(ledger::read(&path).unwrap().records, []);
}

#[test]
fn bad_names_and_protocols_exit_with_2_and_say_what_would_be_right() {
    let folder = tempfile::tempdir().unwrap();
    let protocol = folder.path().join("bad.toml");
    std::fs::write(&protocol, small_protocol().replace("target = 0.5", "target = 1.5")).unwrap();
    let protocol = protocol.to_str().unwrap();
    let apart = folder.path().join("apart.toml");
    std::fs::write(&apart, small_protocol().replace("joint = [\"situ\"]", "joint = [\"narrated_hierarchy\"]")).unwrap();
    let cases: [(&[&str], &[&str]); 8] = [
        (&["run", "--task", "pours"], &["pours", "pour", "sort_blocks"]),
        (&["run", "--variation", "lids"], &["lids", "vase", "high_bins"]),
        (&["run", "--sequence", "workshops"], &["workshops", "kitchen", "workshop"]),
        (&["run", "--method", "magic"], &["magic", "situ:literal", "from_scratch"]),
        (&["run", "--teacher", "genius"], &["genius", "expert", "novice"]),
        (&["run", "--protocol", "slow"], &["slow", "quick", "paper"]),
        (&["run", "--protocol", apart.to_str().unwrap()], &["narrated_hierarchy", "situ:literal", "oracle_edit"]),
        (&["run", "--protocol", protocol], &["bad.toml:9", "target", "above 0 and at most 1"]),
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
    assert_eq!(left.len(), 2, "nothing is written");
}

/// Every name in the protocols that come with the program is known.
#[test]
fn the_built_in_protocols_can_be_run() {
    for name in Protocol::names() {
        let (registry, roster) = (Registry::builtin().unwrap(), Roster::builtin().unwrap());
        let plan =
            Plan::new(Protocol::find(name).unwrap(), &Filter::default(), &registry, &roster, &Methods::builtin());
        assert!(!plan.unwrap_or_else(|error| panic!("{name}: {error}")).is_empty());
    }
    let roster = Roster::builtin().unwrap();
    let every: BTreeSet<String> = roster.profiles().iter().map(|profile| profile.name.clone()).collect();
    let named = ["teachers", "grades"].map(|name| Protocol::find(name).unwrap().teachers).concat().into_iter();
    assert_eq!(named.collect::<BTreeSet<String>>(), every, "every profile is in `teachers`, or one of `grades`");
}

/// A run without the arm is another protocol. It has a name of its own in every record, and does not go on with the
/// ledger of the other.
#[test]
fn a_run_without_the_arm_has_a_name_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("small.toml"), small_protocol().replace("\"sort_blocks\"", "\"press\"")).unwrap();
    let run = |more: &[&str]| {
        let words =
            ["run", "--protocol", "small.toml", "--variation", "bump", "--method", "no_update", "--out", "runs"];
        let mut command = Command::new(env!("CARGO_BIN_EXE_situ-bench"));
        command.args(words).args(more).current_dir(folder.path()).output().unwrap()
    };
    let output = run(&["--plant", "hand"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let records = ledger::read(&folder.path().join("runs/ledger.jsonl")).unwrap().records;
    let names: BTreeSet<_> =
        records.iter().filter_map(Record::single_run).map(|run| run.key.protocol.as_str()).collect();
    assert_eq!(names, BTreeSet::from(["small-hand"]));
    let output = run(&["--resume"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && said.contains("made by another protocol"), "{said}");
    assert!(run(&["--resume", "--plant", "hand"]).status.success());
}
