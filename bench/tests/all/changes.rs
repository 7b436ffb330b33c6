//! Many changes, and changes of many sizes: sequences that come back, and robots that are corrected whether they fail
//! or not.

use std::fs;
use std::path::Path;

use situ::edit::Edit;
use situ_bench::external::Methods;
use situ_bench::plan::{Filter, Plan};
use situ_bench::protocol::Protocol;
use situ_bench::record::{Record, RunRecord};
use situ_tasks::Registry;
use situ_teachers::Roster;

use crate::run::run;

/// A protocol of the task of graded changes, of one expert and few rollouts.
fn protocol(task: &str, methods: &str, more: &str) -> String {
    format!(
        r#"
name = "small"
analysis = "Few rollouts: a test."
tasks = ["{task}"]
teachers = ["expert"]
methods = {methods}
seeds = 1
target = 0.5
rollouts = 2
confidence = 0.3
execution = "sample"
{more}
[budget]
least_originals = 2
originals = 2
demonstrations = 1
"#
    )
}

fn runs(text: &str, registry: &Registry, ledger: &Path) -> Vec<RunRecord> {
    let protocol = Protocol::parse(text, Path::new("small.toml")).unwrap();
    let (roster, methods) = (Roster::builtin().unwrap(), Methods::builtin());
    let plan = Plan::new(protocol, &Filter::default(), registry, &roster, &methods).unwrap();
    let records = run(&plan, ledger, 2).unwrap();
    assert_eq!(records.len(), plan.len());
    let run = |record| if let Record::Run(run) = record { Some(run) } else { None };
    records.into_iter().filter_map(run).collect()
}

/// A change goes and comes back. The listing as printed does not learn it; each visit corrects it, from another start.
#[test]
fn a_sequence_comes_back_from_other_starts() {
    let folder = tempfile::tempdir().unwrap();
    let back = "\n[[sequence]]\nname = \"back\"\nanalysis = \"It comes back.\"\n\
                variations = [\"aside_8\", \"original\", \"aside_8\"]\n";
    let text = Registry::builtin().unwrap().text("tray").unwrap().replacen("\"tray\"", "\"mine\"", 1);
    fs::write(folder.path().join("mine.toml"), text + back).unwrap();
    let registry = Registry::builtin().unwrap().with_dir(folder.path()).unwrap();
    let more = "variations = \"none\"\nsequences = [\"back\"]\n";
    let text = protocol("mine", r#"["situ:literal", "no_update"]"#, more);
    let records = runs(&text, &registry, &folder.path().join("ledger.jsonl"));
    let of = |method: &str| {
        let mut stages: Vec<&RunRecord> = records.iter().filter(|run| run.key.method == method).collect();
        stages.sort_by_key(|run| run.key.stage.as_ref().unwrap().number);
        stages
    };
    let stages = of("situ:literal");
    assert_eq!(stages.iter().map(|run| &*run.key.variation).collect::<Vec<_>>(), ["aside_8", "original", "aside_8"]);
    // The original is `retained`, and this stage's own task is `after`: neither is among the earlier ones.
    let earlier: Vec<Vec<&str>> = stages.iter().map(|run| run.earlier.keys().map(String::as_str).collect()).collect();
    assert_eq!(earlier, [vec![], vec!["aside_8"], vec![]]);
    assert!(stages.iter().all(|run| run.kept().1 == 2), "the original and the change, each once");
    assert_eq!(stages[1].success_on("aside_8"), stages[1].earlier.get("aside_8").copied());
    assert_eq!(stages[1].success_on("original"), stages[1].after);
    assert_eq!(stages[1].after, stages[1].retained, "one task, from the same fresh starts");
    let [first, second] = [stages[0], stages[2]].map(|run| run.corrections[0].effort);
    assert_ne!(first.metres, second.metres, "the same correction was given twice");
    // Who is not corrected does on both occasions as it did: what is published is from the same starts.
    let idle = of("no_update");
    assert_eq!(idle[0].after, idle[2].after);
}

const GRADES: &str = r#"
corrections = "once"

[[grade]]
series = "displacement, m"
changes = true
teachers = ["expert"]
point = [{ size = 0.08, variation = "aside_8" }]

[[grade]]
series = "none"
changes = false
point = [{ size = 0.0, variation = "same", teacher = "expert" }]
"#;

/// A robot that does not fail is corrected, too, once; what no series names is not run.
#[test]
fn a_graded_robot_is_corrected_once() {
    let folder = tempfile::tempdir().unwrap();
    let registry = Registry::builtin().unwrap();
    let text = protocol("tray", r#"["situ"]"#, GRADES);
    let records = runs(&text, &registry, &folder.path().join("ledger.jsonl"));
    assert_eq!(records.len(), 2);
    let of = |variation: &str| records.iter().find(|run| run.key.variation == variation).unwrap();
    let (same, aside) = (of("same"), of("aside_8"));
    assert_eq!((same.before.unwrap().successes, aside.before.unwrap().successes), (2, 0));
    assert_eq!((same.corrections.len(), aside.corrections.len()), (1, 1));
    assert!(!same.edits().contains(&Edit::NodeModification) && aside.edits().contains(&Edit::NodeModification));
    let grades = [same, aside].map(|run| run.grade.clone().unwrap());
    assert_eq!(grades.each_ref().map(|grade| (grade.size, grade.changes)), [(0.0, false), (0.08, true)]);
}

#[test]
fn a_series_that_means_nothing_is_refused() {
    let faults = [
        ("series = \"none\"", "series = \"displacement, m\"", "no other series"),
        ("size = 0.08", "size = -1", "0 or more"),
        ("teachers = [\"expert\"]\npoint", "point", "`teacher`, or `teachers`"),
        ("teacher = \"expert\"", "teacher = \"novice\"", "one of the protocol's `teachers`"),
        ("variation = \"same\"", "variation = \"aside_8\"", "each once"),
    ];
    for (from, to, expected) in faults {
        assert_eq!(GRADES.matches(from).count(), 1, "{from}");
        let text = protocol("tray", r#"["situ"]"#, &GRADES.replace(from, to));
        let error = Protocol::parse(&text, Path::new("small.toml")).unwrap_err().to_string();
        assert!(error.contains(expected) && error.contains("small.toml:") && error.contains("grade["), "{error}");
    }
}
