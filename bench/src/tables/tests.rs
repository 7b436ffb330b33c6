//! The tables of a small set of records made by hand, against text that was checked by hand, and in any order.

use std::collections::BTreeMap;

use proptest::prelude::*;
use situ::edit::Edit;
use situ::structure::{Agreement, Structure};
use situ::trace::{Branch, Counters, MatchedIn};

use super::Kind;
use crate::record::{Correction, Cost, Effort, Joint, Key, Outcome, Rate, Record, Run, Stage, StepSummary};

fn effort(demonstrations: u32, keyframes: u32) -> Effort {
    let seconds = 4.5 * f64::from(keyframes);
    Effort { demonstrations, keyframes, seconds, metres: 0.25 * f64::from(keyframes) }
}

fn correction(edit_made: Edit, applicable: u32, update_seconds: f64) -> Correction {
    let step = StepSummary {
        reference: "cup".to_owned(),
        applicable,
        model_size: 4,
        candidates: 1,
        matched_in: MatchedIn::None,
        branch: Branch::New,
    };
    Correction {
        failure: "predicate lost".to_owned(),
        last: "START".to_owned(),
        effort: effort(1, 3),
        edit_made,
        nodes_added: u32::from(edit_made == Edit::NodeAddition),
        edges_added: 0,
        nodes_modified: 0,
        nodes_merged: 0,
        steps: vec![step],
        counters: Counters {
            hmm_fits: 4,
            em_iterations: 30,
            divergences: 1,
            classifier_fits: 2,
            ..Counters::default()
        },
        after: Some(Rate { successes: 9, rollouts: 10 }),
        update_seconds,
    }
}

fn run(method: &str, seed: u64, outcome: Outcome, demonstrations: u32, made: &[Edit]) -> Record {
    let successes = if outcome == Outcome::Reached { 10 } else { 4 };
    let counts = outcome.counts();
    Record::Run(Run {
        key: Key {
            protocol: "quick".to_owned(),
            task: "pour".to_owned(),
            variation: "lid".to_owned(),
            edit: Edit::NodeAddition,
            teacher: "competent".to_owned(),
            method: method.to_owned(),
            seed,
            stage: None,
        },
        outcome,
        original: effort(2, 12),
        before: counts.then_some(Rate { successes: 1, rollouts: 10 }),
        after: counts.then_some(Rate { successes, rollouts: 10 }),
        effort: effort(demonstrations, 3 * demonstrations),
        corrections: made.iter().map(|edit| correction(*edit, 1 + seed as u32, 0.002)).collect(),
        ended: BTreeMap::from([("goal".to_owned(), successes), ("time-out".to_owned(), 10 - successes)]),
        original_rate: Some(Rate { successes: 10, rollouts: 10 }),
        retained: None,
        structure: None,
        joint: None,
        earlier: BTreeMap::new(),
    })
}

fn structure(nodes: u32, duplicates: u32, missed: u64) -> Structure {
    let agreement = |both, missed| Agreement { both, model: both, truth: both + missed };
    Structure {
        nodes,
        edges: nodes + 1,
        duplicates,
        pairs: agreement(8, 8 * missed),
        transitions: agreement(6, missed),
    }
}

/// A corrected run that is compared with the same lesson learned at once.
fn compared(seed: u64) -> Record {
    let mut record = run("situ:literal", seed, Outcome::Reached, 1, &[Edit::NodeAddition]);
    let Record::Run(run) = &mut record else { unreachable!() };
    let rate = |successes| Rate { successes, rollouts: 10 };
    run.retained = Some(rate(9));
    run.structure = Some(structure(5, 1, 1));
    let (separate, joint) = (rate(8), rate(if seed == 0 { 10 } else { 6 }));
    run.joint = Some(Joint { separate, joint, retained: rate(10), structure: Some(structure(4, 0, 0)) });
    record
}

/// The second stage of a sequence: the model that the lid left meets a vase, and does the lid no more.
fn stage() -> Record {
    let Record::Run(mut run) = run("situ", 0, Outcome::Reached, 2, &[Edit::NodeModification]) else { unreachable!() };
    run.key.variation = "vase".to_owned();
    run.key.edit = Edit::NodeModification;
    run.key.stage = Some(Stage { sequence: "kitchen".to_owned(), number: 2 });
    run.retained = Some(Rate { successes: 7, rollouts: 10 });
    run.earlier = BTreeMap::from([("lid".to_owned(), Rate { successes: 3, rollouts: 10 })]);
    Record::Run(run)
}

fn cost(method: &str, nodes: u32, seed: u64, work: u64, update_seconds: f64) -> Record {
    Record::Cost(Cost {
        protocol: "quick".to_owned(),
        series: "nodes".to_owned(),
        method: method.to_owned(),
        nodes,
        originals: 3,
        edit: Edit::EdgeAddition,
        seed,
        correction: 0,
        applicable: if method == "rebuild" { Vec::new() } else { vec![4] },
        model_size: if method == "rebuild" { Vec::new() } else { vec![nodes] },
        counters: Counters { hmm_fits: work, em_iterations: 5 * work, classifier_fits: 3, ..Counters::default() },
        edit_made: Edit::EdgeAddition,
        update_seconds,
    })
}

/// Two methods of corrections and teaching from scratch, one untaught and one spoilt run, a stage; costs at three sizes.
pub(crate) fn sample() -> Vec<Record> {
    use Edit::{EdgeAddition, NodeAddition, None};
    let mut records = vec![
        run("situ", 0, Outcome::Reached, 1, &[NodeAddition]),
        run("situ", 1, Outcome::Reached, 2, &[EdgeAddition, NodeAddition]),
        run("situ", 2, Outcome::Spoilt { why: "NaN".to_owned() }, 0, &[]),
        run("situ", 3, Outcome::Untaught, 0, &[]),
        run("rebuild", 0, Outcome::Reached, 1, &[NodeAddition]),
        run("rebuild", 1, Outcome::Censored, 5, &[None, None, None, None, NodeAddition]),
        run("from_scratch", 0, Outcome::Reached, 4, &[]),
        run("from_scratch", 1, Outcome::Reached, 8, &[]),
        run("from_scratch", 3, Outcome::Untaught, 0, &[]),
        run("no_update", 0, Outcome::NotApplicable, 0, &[]),
        compared(0),
        compared(1),
        stage(),
    ];
    for nodes in [10, 100, 1000] {
        for seed in [0, 1] {
            records.push(cost("situ", nodes, seed, 6, 0.001));
            records.push(cost("rebuild", nodes, seed, 6 * u64::from(nodes), 0.001 * f64::from(nodes)));
        }
    }
    records
}

fn all_text(records: &[Record]) -> String {
    let tables = Kind::ALL.iter().flat_map(|kind| kind.tables(records));
    tables.map(|table| table.to_markdown("situ-bench tables quick.jsonl") + "\n" + &table.to_csv() + "\n").collect()
}

#[test]
fn the_tables_of_records_made_by_hand() {
    insta::assert_snapshot!(all_text(&sample()));
}

/// The line of a table's CSV that begins so.
fn row(text: &str, start: &str) -> String {
    let row = text.lines().find(|line| line.starts_with(start));
    row.unwrap_or_else(|| panic!("no row {start} in\n{text}")).to_owned()
}

/// What that line has in a column.
fn field(text: &str, start: &str, name: &str) -> String {
    let heads: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let index = heads.iter().position(|head| *head == name).unwrap_or_else(|| panic!("no column {name} in {heads:?}"));
    let row = row(text, start);
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(row.as_bytes());
    reader.records().next().unwrap().unwrap()[index].to_owned()
}

#[test]
fn what_the_tables_must_say() {
    let text = |kind: Kind, index: usize| kind.tables(&sample())[index].to_csv();
    let t1 = text(Kind::Effort, 0);
    let situ = "quick,pour,lid,node-addition,competent,situ,";
    // Four seeds, one untaught and one spoilt; 1 and 2 demonstrations against 4 and 8 from scratch.
    assert!(row(&t1, situ).starts_with(&format!("{situ}4,0,1,1,2,20,")), "{t1}");
    assert_eq!(field(&t1, situ, "demonstrations"), "1.500000");
    assert_eq!(field(&t1, situ, "demonstrations_ratio"), "0.250000");
    assert_eq!(field(&t1, situ, "made_first"), "node-addition 1, edge-addition 1");
    // A run that used its budget up makes the mean a lower bound.
    let rebuild = "quick,pour,lid,node-addition,competent,rebuild,";
    assert_eq!(
        (field(&t1, rebuild, "demonstrations"), field(&t1, rebuild, "demonstrations_bound")),
        ("3.000000".into(), "≥".into())
    );
    let control = "quick,pour,lid,node-addition,competent,no_update,";
    assert!(
        row(&t1, control).starts_with(&format!("{control}1,1,0,0,,")),
        "what does not apply is said, and no zero: {t1}"
    );
    let edits = text(Kind::Edits, 0);
    let right = |name| field(&edits, "quick,rebuild,node-addition", name);
    assert_eq!((right("first_right_successes"), right("first_right_n")), ("1".into(), "2".into()));
    assert_eq!((right("all_right_successes"), right("all_right_n")), ("2".into(), "6".into()));
    assert!(!edits.contains("from_scratch"), "teaching from scratch edits nothing");
    assert!(
        !t1.contains("vase") && !edits.contains("situ,node-modification"),
        "a stage is not a run that stands alone"
    );
    let literal = "quick,situ:literal,node-addition";
    // F1 of 8 of 16 pairs is 2/3.
    assert_eq!(
        (field(&edits, literal, "node_F1"), field(&edits, literal, "duplicates")),
        ("0.666667".into(), "1.000000".into())
    );
    let t2 = text(Kind::Separate, 0);
    let literal = "quick,situ:literal,node-addition,all,2,";
    assert_eq!(
        (field(&t2, literal, "separate_successes"), field(&t2, literal, "joint_successes")),
        ("16".into(), "16".into())
    );
    // Two fifths less in one run, a fifth more in the other.
    assert_eq!(
        (field(&t2, literal, "difference_low"), field(&t2, literal, "difference_high")),
        ("-0.200000".into(), "0.200000".into())
    );
    assert_eq!(field(&t2, literal, "edge_F1_joint"), "1.000000");
    assert_eq!(t2.lines().count(), 3, "all tasks and one: {t2}");
    let methods = text(Kind::Methods, 0);
    let rebuild = "quick,rebuild,node-addition,";
    assert_eq!(
        (field(&methods, rebuild, "demonstrations_to_situ"), field(&methods, rebuild, "demonstrations_to_situ_bound")),
        ("2.000000".into(), "≥".into())
    );
    assert_eq!(field(&methods, rebuild, "update_to_situ_wall"), "1.000000");
    assert_eq!(field(&methods, "quick,from_scratch,node-addition,", "update_to_situ_wall"), "", "it updates nothing");
    assert!(
        row(&methods, "quick,no_update,node-addition,").starts_with("quick,no_update,node-addition,1,1,1,0,0,,"),
        "{methods}"
    );
    let t5 = text(Kind::Retention, 0);
    let stage = "quick,pour,kitchen,2,vase,node-modification,competent,situ,1,1,10,";
    assert_eq!(
        (field(&t5, stage, "original_after_successes"), field(&t5, stage, "earlier_successes")),
        ("7".into(), "3".into())
    );
    let scaling = text(Kind::Cost, 1);
    assert_eq!(field(&scaling, "quick,nodes,rebuild,edge-addition,100,3,", "hmm_fits_ratio"), "100.000000");
    assert_eq!(field(&scaling, "quick,nodes,rebuild,edge-addition,100,3,", "ratio_wall"), "100.000000");
    let slopes = text(Kind::Cost, 2);
    assert_eq!(field(&slopes, "quick,nodes,rebuild,edge-addition,nodes,", "hmm_fits"), "1.000000");
    assert_eq!(field(&slopes, "quick,nodes,situ,edge-addition,nodes,", "hmm_fits"), "0.000000");
    assert_eq!(field(&slopes, "quick,nodes,situ,edge-addition,nodes,", "divergences"), "", "a cost of 0 has no slope");
    let crossover = text(Kind::Cost, 3);
    // 6 fits at every size against 6 a node meet at one node; 3 classifiers against 3 are parallel; a millisecond against one a node, too.
    assert_eq!(crossover.lines().nth(1), Some("quick,nodes,rebuild,edge-addition,< 10,< 10,never,< 10"));
}

#[test]
fn the_slowest_of_many_corrections() {
    let records: Vec<Record> = (0..101)
        .map(|correction| {
            let Record::Cost(one) = cost("situ", 10, 1, 6, 0.001 * f64::from(1 + correction)) else { unreachable!() };
            let model_size = vec![10, 11];
            Record::Cost(Cost { correction, model_size, ..one })
        })
        .collect();
    let csv = Kind::Cost.tables(&records)[4].to_csv();
    let row = "quick,nodes,situ,edge-addition,10,101,";
    let found = ["update_ms_wall", "update_p99_ms_wall", "segment_ms_wall", "segment_p99_ms_wall"];
    let found = found.map(|name| field(&csv, row, name));
    assert_eq!(found, ["51.000000", "100.000000", "25.500000", "50.000000"].map(str::to_owned), "{csv}");
}

#[test]
fn no_record_gives_empty_tables() {
    for table in Kind::ALL.iter().flat_map(|kind| kind.tables(&[])) {
        assert!(table.is_empty() && table.to_csv().lines().count() == 1, "{}", table.id());
    }
}

#[test]
fn clocks_are_only_in_columns_named_so() {
    let without: Vec<Record> = sample().iter().map(Record::without_times).collect();
    for (with, without) in
        Kind::ALL.iter().flat_map(|kind| kind.tables(&sample()).into_iter().zip(kind.tables(&without)))
    {
        let (with, without) = (with.to_csv(), without.to_csv());
        let exact = |text: &str| {
            let mut reader = csv::Reader::from_reader(text.as_bytes());
            let keep: Vec<bool> = reader.headers().unwrap().iter().map(|name| !name.ends_with("_wall")).collect();
            assert!(keep.is_sorted_by(|left, right| left >= right), "columns of the clock come last");
            let rows = reader.records().map(|row| {
                row.unwrap().iter().zip(&keep).filter(|pair| *pair.1).map(|pair| pair.0.to_owned()).collect::<Vec<_>>()
            });
            rows.collect::<Vec<_>>()
        };
        assert_eq!(exact(&with), exact(&without));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, ..ProptestConfig::default() })]

    /// The bytes of a table do not depend on the order in which runs finished.
    #[test]
    fn the_order_of_the_records_does_not_matter(shuffled in Just(sample()).prop_shuffle()) {
        prop_assert_eq!(all_text(&shuffled), all_text(&sample()));
    }
}
