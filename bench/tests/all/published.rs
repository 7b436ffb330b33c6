//! Every published folder is what the present code makes.
//!
//! CI makes the whole of `quick` anew; the other folders take hours. So of each folder one cell is drawn and one seed
//! of it is run again: the record must be the published one, but for the times. Its counters are exact and its
//! successes depend on every bit of the physics, so that no change of the code passes unseen which matters to that
//! cell. The hash of the ledger draws it, from the cheaper half of the runs that were corrected and of the costs:
//! nobody chooses it, and a folder that is made anew has another one. A folder that is superseded is skipped and
//! named. Where this test fails, make the folder anew, or say with `situ-bench supersede` why it must wait. Planted
//! differences are found: a counter, and a folder that another program's physics made.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

use situ_bench::digest;
use situ_bench::external::Methods;
use situ_bench::ledger::{self, Ledger};
use situ_bench::manifest::{self, Manifest};
use situ_bench::plan::{Filter, Plan};
use situ_bench::protocol::{CostSeries, Protocol};
use situ_bench::record::{CostRecord, Record, RunRecord};
use situ_bench::runner::{Progress, Runner};
use situ_bench::spending::Spending;
use situ_tasks::{Plant, Registry};
use situ_teachers::Roster;

use crate::provenance::printed;
use crate::small;

struct Silent;

impl Progress for Silent {
    fn at(&self, _: &str) {}
    fn finished(&self) {}
}

/// What became of a folder.
#[derive(Debug, PartialEq, Eq)]
enum Found {
    /// The drawn record, which was made again.
    Same(String),
    /// The folder has been overtaken, and why.
    Superseded(String),
    /// The record that was published, and what is made now.
    Different(String),
}

/// The record that is made again: the hash of them all draws it from the cheaper half.
fn drawn(records: Vec<Record>, registry: &Registry) -> Record {
    let hash = digest::hash(ledger::text(&records));
    let draw = usize::from_str_radix(&hash[..8], 16).expect("hexadecimal digits");
    let has_beads = |run: &RunRecord| {
        let task = registry.get(&run.key.task).unwrap();
        task.variation(Some(&run.key.variation)).unwrap().beads.is_some()
    };
    // What is cheap is no heap of beads. A run that was corrected says the most, and one in physics more than a cost.
    let cost = |record: &Record| match record {
        Record::Run(run) => {
            let simulated = run.original.seconds + run.effort.seconds;
            (u8::from(run.corrections.is_empty() || has_beads(run)), simulated)
        }
        Record::Cost(cost) => (2, f64::from(cost.nodes * cost.originals)),
    };
    let alone = |record: &Record| matches!(record, Record::Cost(_)) || record.single_run().is_some();
    let mut records: Vec<Record> = records.into_iter().filter(alone).collect();
    records.sort_by(|one, other| cost(one).partial_cmp(&cost(other)).expect("numbers"));
    let best = cost(records.first().expect("a ledger of some records")).0;
    records.retain(|record| cost(record).0 == best);
    let half = records.len().div_ceil(2);
    records.swap_remove(draw % half)
}

/// The part of a protocol that makes this run and no other.
fn of_run(protocol: Protocol, run: &RunRecord) -> (Protocol, Filter) {
    let key = run.key.clone();
    let filter = Filter {
        tasks: vec![key.task],
        variations: vec![key.variation],
        methods: vec![key.method],
        teachers: vec![key.teacher],
        ..Filter::default()
    };
    (Protocol { first_seed: key.seed, seeds: 1, ..protocol }, filter)
}

/// The part of a protocol that measures this automaton and no other.
fn of_cost(protocol: Protocol, cost: &CostRecord) -> (Protocol, Filter) {
    let series = protocol.cost.iter().find(|series| series.series == cost.series).expect("a series of the protocol");
    let series = CostSeries {
        methods: vec![cost.method.clone()],
        nodes: vec![cost.nodes],
        originals: vec![cost.originals],
        seeds: 1,
        ..series.clone()
    };
    (Protocol { tasks: Vec::new(), cost: vec![series], first_seed: cost.seed, ..protocol }, Filter::default())
}

/// Makes one record of a folder again.
fn found(folder: &Path) -> Found {
    let path = folder.join("ledger.jsonl");
    let manifest = Manifest::read(&manifest::beside(&path)).unwrap();
    let manifest = manifest.unwrap_or_else(|| panic!("{}: no manifest", folder.display()));
    if let Some(why) = manifest.superseded {
        return Found::Superseded(why);
    }
    let plant = if manifest.plant == "hand" { Plant::Hand } else { Plant::Arm };
    let registry = Registry::builtin().unwrap().with_plant(plant);
    let published = drawn(ledger::read(&path).unwrap().records, &registry).without_times();
    let protocol = Protocol::find(folder.join("protocol.toml").to_str().unwrap()).unwrap();
    let protocol = if plant == Plant::Hand { protocol.without_arm() } else { protocol };
    let (protocol, filter) = match &published {
        Record::Run(run) => of_run(protocol, run),
        Record::Cost(cost) => of_cost(protocol, cost),
    };
    let plan = Plan::new(protocol, &filter, &registry, &Roster::builtin().unwrap(), &Methods::builtin()).unwrap();
    let temporary = tempfile::tempdir().unwrap();
    let again = temporary.path().join("ledger.jsonl");
    let (ledger, contents) = Ledger::open(&again).unwrap();
    let runner = Runner {
        plan: &plan,
        ledger: &Mutex::new(ledger),
        done: &contents.done(),
        interrupted: &AtomicBool::new(false),
        archive: None,
        progress: &Silent,
        spending: &Spending::new(),
    };
    runner.run().unwrap();
    let has_content = published.has_content();
    let made = ledger::read(&again).unwrap().records.into_iter().map(|record| record.without_times());
    let made = made.map(|record| if has_content { record } else { record.without_content() });
    let made = made.into_iter().find(|record| record.identity() == published.identity());
    let name = published.identity().to_string();
    if made.as_ref() == Some(&published) {
        return Found::Same(name);
    }
    let now = made.map_or_else(|| "nothing".to_owned(), |made| ledger::text(&[made]));
    Found::Different(format!("{name}: published\n{}and now\n{now}", ledger::text(&[published])))
}

/// The folders of results that hold a ledger, and those in them, in the order of their names.
fn published() -> Vec<PathBuf> {
    let inside = |folder: &Path| -> Vec<PathBuf> {
        let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        paths.filter(|path| path.is_dir()).collect()
    };
    let mut folders = inside(&results());
    folders.extend(folders.clone().iter().flat_map(|folder| inside(folder)));
    folders.retain(|folder| folder.join("ledger.jsonl").exists());
    folders.sort();
    folders
}

fn results() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../results")
}

#[test]
fn every_published_folder_is_what_the_present_code_makes() {
    let folders = published();
    assert!(folders.len() >= 6, "{folders:?}");
    let mut different = Vec::new();
    for folder in folders {
        let name = folder.strip_prefix(results()).unwrap().display().to_string();
        match found(&folder) {
            Found::Same(record) => println!("{name}: made again, the same: {record}"),
            Found::Superseded(why) => println!("{name}: skipped, superseded: {why}"),
            Found::Different(records) => different.push(format!("results/{name}: {records}")),
        }
    }
    assert!(different.is_empty(), "make them anew, or supersede them:\n{}", different.join("\n"));
}

/// Adds one to every number behind these words in the folder's ledger: nobody knows which record will be drawn.
fn plant(folder: &Path, words: &str) {
    let path = folder.join("ledger.jsonl");
    let text = fs::read_to_string(&path).unwrap();
    let mut pieces = text.split(words);
    let mut planted = pieces.next().unwrap().to_owned();
    let before = planted.len();
    for piece in pieces {
        let digits = piece.find(|sign: char| !sign.is_ascii_digit()).unwrap();
        let number: u64 = piece[..digits].parse().unwrap();
        planted += &format!("{words}{}{}", number + 1, &piece[digits..]);
    }
    assert!(planted.len() > before, "no {words} in {text}");
    fs::write(path, planted).unwrap();
}

#[test]
fn a_planted_difference_is_found() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let situ = r#"["situ"]"#;
    let (costs, physics) = (small::costs(situ), small::physics(situ));
    for (name, protocol, more) in [("costs", costs, &[][..]), ("physics", physics, &["--variation", "bump"])] {
        let file = format!("{name}.toml");
        fs::write(folder.join(&file), protocol).unwrap();
        printed(folder, &[&["run", "--protocol", &file, "--out", name], more].concat());
        let made = folder.join(name);
        let same = found(&made);
        assert!(matches!(same, Found::Same(_)), "{same:?}");
        plant(&made, "\"em_iterations\":");
        let different = found(&made);
        assert!(matches!(&different, Found::Different(why) if why.contains("em_iterations")), "{different:?}");
    }
    let physics = folder.join("physics");
    printed(folder, &["supersede", "physics", "--because", "For a test."]);
    assert_eq!(found(&physics), Found::Superseded("For a test.".to_owned()));
}
