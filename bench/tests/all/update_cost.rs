//! The claim that updates are local, in exact counters; and the way from a measured cost to a published table.
//!
//! On synthetic automata of growing size with |Z| held fixed, the work of a SITU update must not grow with |T|, and
//! that of full retraining must. The scan of A1.6 evaluates every classifier, so `classifier_evaluations` is left out
//! and checked apart.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use situ::edit::Edit;
use situ::method;
use situ_bench::cost::Subject;
use situ_bench::ledger::Ledger;
use situ_bench::record::{CostRecord, Record};
use situ_bench::stats::power_law;
use situ_bench::synthetic::Parameters;

/// Sizes at which every object has the same number of nodes, so that the work can be exactly the same.
const SIZES: [usize; 3] = [15, 45, 135];
const SEEDS: u64 = 3;
/// The design's bound on the log–log slope of an update's work over |T| at fixed |Z|.
const LOCAL: f64 = 0.05;

fn costs(name: &str) -> Vec<CostRecord> {
    let method = method::named(name).unwrap();
    let mut costs = Vec::new();
    for nodes in SIZES {
        for seed in 0..SEEDS {
            let subject = Subject::teach(&*method, Parameters::of(nodes, seed)).unwrap();
            costs.extend(Edit::ALL.map(|edit| subject.measure("test", "nodes", edit, 0).unwrap()));
        }
    }
    costs
}

#[test]
fn the_work_of_an_update_does_not_grow_with_the_task_model() {
    let situ = costs("situ");
    let work = |costs: &[CostRecord], edit: Edit, of: &dyn Fn(&CostRecord) -> u64| {
        let points: Vec<(f64, f64)> = costs
            .iter()
            .filter(|cost| cost.edit == edit)
            .map(|cost| (f64::from(cost.nodes), of(cost) as f64))
            .collect();
        power_law(&points).map(|law| law.exponent)
    };
    for edit in Edit::ALL {
        assert!(situ.iter().filter(|cost| cost.edit == edit).all(|cost| cost.edit_made == edit), "{edit}");
        let counters = [
            ("hmm_fits", work(&situ, edit, &|cost| cost.counters.hmm_fits)),
            ("em_iterations", work(&situ, edit, &|cost| cost.counters.em_iterations)),
            ("divergences", work(&situ, edit, &|cost| 1 + cost.counters.divergences)),
            ("classifier_fits", work(&situ, edit, &|cost| cost.counters.classifier_fits)),
            // The index asks about the primitives of one object.
            ("classifier_evaluations", work(&situ, edit, &|cost| cost.counters.classifier_evaluations)),
            ("nodes_touched", work(&situ, edit, &|cost| cost.counters.nodes_touched)),
            ("segments_touched", work(&situ, edit, &|cost| cost.counters.segments_touched)),
        ];
        for (name, slope) in counters {
            let slope = slope.unwrap();
            assert!(slope.value <= LOCAL, "{edit}: {name} grows with the task model, slope {slope:?}");
        }
    }
    let printed = costs("situ:applicable");
    for edit in Edit::ALL {
        let scan = work(&printed, edit, &|cost| cost.counters.classifier_evaluations).unwrap();
        assert!(scan.value > 0.9, "{edit}: the scan of A1.6 as printed is linear, found {scan:?}");
    }
    let rebuild = costs("rebuild");
    for edit in [Edit::NodeAddition, Edit::EdgeAddition] {
        let fits = work(&rebuild, edit, &|cost| cost.counters.hmm_fits).unwrap();
        assert!(fits.value > 0.9, "full retraining fits everything, found {fits:?}");
    }
}

#[test]
fn the_program_makes_tables_of_measured_costs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cost.jsonl");
    let (mut ledger, _) = Ledger::open(&path).unwrap();
    for name in ["situ", "rebuild"] {
        for nodes in [10, 20, 40] {
            let method = method::named(name).unwrap();
            let subject = Subject::teach(&*method, Parameters::of(nodes, 1)).unwrap();
            let cost = subject.measure("test", "nodes", Edit::NodeAddition, 0).unwrap();
            ledger.append(&Record::Cost(cost)).unwrap();
        }
    }
    let program = |words: &[&str]| -> Output {
        Command::new(env!("CARGO_BIN_EXE_situ-bench")).args(words).current_dir(folder.path()).output().unwrap()
    };
    let text = |path: &Path| fs::read_to_string(path).unwrap();
    let printed = program(&["tables", "cost.jsonl", "--table", "t4"]);
    assert!(printed.status.success(), "{}", String::from_utf8_lossy(&printed.stderr));
    let printed = String::from_utf8(printed.stdout).unwrap();
    assert!(printed.contains("Made by `situ-bench tables cost.jsonl --table t4`"), "{printed}");
    assert!(program(&["tables", "cost.jsonl", "--out", "tables"]).status.success());
    assert_eq!(text(&folder.path().join("tables/t4.md")), printed);
    let mut names: Vec<_> =
        fs::read_dir(folder.path().join("tables")).unwrap().map(|file| file.unwrap().file_name()).collect();
    names.sort();
    // Only the tables that have a row: no run in physics, and one correction of each automaton.
    let tables = ["t4_crossover", "t4_scaling", "t4_slopes"];
    let files = tables.iter().flat_map(|table| [format!("{table}.csv"), format!("{table}.tex")]);
    let expected = ["t4.md".to_owned()].into_iter().chain(files);
    assert_eq!(names, expected.map(Into::into).collect::<Vec<std::ffi::OsString>>());
    let scaling = text(&folder.path().join("tables/t4_scaling.csv"));
    assert_eq!(scaling.lines().count(), 1 + 6, "{scaling}");
    // A torn last line is a warning, a bad line an error.
    let whole = text(&path);
    fs::write(&path, &whole[..whole.len() - 9]).unwrap();
    let torn = program(&["tables", "cost.jsonl"]);
    let warning = String::from_utf8(torn.stderr).unwrap();
    assert!(torn.status.success() && warning.starts_with("warning: cost.jsonl:6: "), "{warning}");
    fs::write(&path, whole.replacen("\"nodes\":20", "\"nodes\":\"20\"", 1)).unwrap();
    let bad = program(&["tables", "cost.jsonl", "--out", "others"]);
    let error = String::from_utf8(bad.stderr).unwrap();
    assert_eq!(bad.status.code(), Some(2));
    assert!(error.starts_with("error: cost.jsonl:2: key `nodes`: "), "{error}");
    assert!(!folder.path().join("others").exists(), "nothing is written where the input is bad");
}
