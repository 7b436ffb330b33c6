//! The tables of a small set of records made by hand, against text that was checked by hand, and in any order.

use proptest::prelude::*;

use crate::ledger::Canonical;
use crate::record::{CostRecord, Record};
use crate::sample;
use crate::tables::{ALL, Heading, Publication, cost, edits, effort, methods, retention, separate};

fn canonical() -> Canonical {
    Canonical::from(sample::records())
}

fn all_text(records: &Canonical) -> String {
    let [ledgers, revision] = ["quick.jsonl", "Revision: unknown"].map(str::to_owned);
    let heading = Heading { ledgers, revision, superseded: None };
    let tables = ALL.iter().flat_map(|publication| publication.tables(records));
    tables
        .map(|table| table.to_markdown(&heading, "situ-bench tables quick.jsonl") + "\n" + &table.to_csv() + "\n")
        .collect()
}

#[test]
fn the_tables_of_records_made_by_hand() {
    insta::assert_snapshot!(all_text(&canonical()));
}

/// The line of a table's CSV that has this beginning.
fn row(text: &str, start: &str) -> String {
    let row = text.lines().find(|line| line.starts_with(start));
    row.unwrap_or_else(|| panic!("no row {start} in\n{text}")).to_owned()
}

/// The field of that line in a column.
fn field(text: &str, start: &str, name: &str) -> String {
    let heads: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let index = heads.iter().position(|head| *head == name).unwrap_or_else(|| panic!("no column {name} in {heads:?}"));
    let row = row(text, start);
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(row.as_bytes());
    reader.records().next().unwrap().unwrap()[index].to_owned()
}

/// The CSV of one table of a publication.
fn csv_of(publication: Publication, index: usize) -> String {
    publication.tables(&canonical())[index].to_csv()
}

#[test]
fn what_effort_must_say() {
    let t1 = csv_of(effort::T1, 0);
    let situ = "quick,pour,lid,node-addition,competent,situ,";
    // Four seeds, one untaught and one spoilt; 1 and 2 demonstrations against 4 and 8 from scratch.
    assert!(row(&t1, situ).starts_with(&format!("{situ}4,0,1,1,2,20,")), "{t1}");
    assert_eq!(field(&t1, situ, "demonstrations"), "1.500000");
    assert_eq!(field(&t1, situ, "demonstrations_ratio"), "0.250000");
    assert_eq!(field(&t1, situ, "made_first"), "node-addition 1, edge-addition 1");
    // A run that used its budget up makes the mean a lower bound.
    let rebuild = "quick,pour,lid,node-addition,competent,rebuild,";
    assert_eq!(field(&t1, rebuild, "demonstrations"), "3.000000");
    assert_eq!(field(&t1, rebuild, "demonstrations_bound"), "≥");
    let control = "quick,pour,lid,node-addition,competent,no_update,";
    assert!(
        row(&t1, control).starts_with(&format!("{control}1,1,0,0,,")),
        "what does not apply is said, and no zero: {t1}"
    );
    assert!(!t1.contains("vase"), "a stage is not a run that stands alone");
}

#[test]
fn what_edits_must_say() {
    let edits = csv_of(edits::T3, 0);
    let right = |name| field(&edits, "quick,rebuild,node-addition", name);
    assert_eq!([right("first_right_successes"), right("first_right_n")], ["1", "2"]);
    assert_eq!([right("all_right_successes"), right("all_right_n")], ["2", "6"]);
    assert!(!edits.contains("from_scratch"), "teaching from scratch edits nothing");
    assert!(!edits.contains("situ,node-modification"), "a stage is not a run that stands alone");
    let literal = "quick,situ:literal,node-addition";
    // F1 of 8 of 16 pairs is 2/3.
    assert_eq!(field(&edits, literal, "node_F1"), "0.666667");
    assert_eq!(field(&edits, literal, "duplicates"), "1.000000");
}

#[test]
fn what_separate_and_pooled_must_say() {
    let t2 = csv_of(separate::T2, 0);
    let of = |name| field(&t2, "quick,situ:literal,node-addition,all,2,", name);
    assert_eq!([of("separate_successes"), of("joint_successes")], ["16", "16"]);
    // Two fifths less in one run, a fifth more in the other.
    assert_eq!([of("difference_low"), of("difference_high")], ["-0.200000", "0.200000"]);
    assert_eq!(of("edge_F1_joint"), "1.000000");
    assert_eq!(t2.lines().count(), 3, "all tasks and one: {t2}");
}

#[test]
fn what_methods_must_say() {
    let methods = csv_of(methods::METHODS, 0);
    let rebuild = |name| field(&methods, "quick,rebuild,node-addition,", name);
    assert_eq!([rebuild("demonstrations_to_situ"), rebuild("demonstrations_to_situ_bound")], ["2.000000", "≥"]);
    assert_eq!(rebuild("update_to_situ_wall"), "1.000000");
    assert_eq!(field(&methods, "quick,from_scratch,node-addition,", "update_to_situ_wall"), "", "it updates nothing");
    let control = "quick,no_update,node-addition,";
    assert!(row(&methods, control).starts_with(&format!("{control}1,1,1,0,0,,")), "{methods}");
}

#[test]
fn what_retention_must_say() {
    let t5 = csv_of(retention::T5, 0);
    let stage = |name| field(&t5, "quick,pour,kitchen,2,vase,node-modification,competent,situ,1,1,10,", name);
    assert_eq!([stage("original_after_successes"), stage("earlier_successes")], ["7", "3"]);
}

#[test]
fn what_cost_must_say() {
    let scaling = csv_of(cost::T4, 1);
    assert_eq!(field(&scaling, "quick,nodes,rebuild,edge-addition,100,3,", "hmm_fits_ratio"), "100.000000");
    assert_eq!(field(&scaling, "quick,nodes,rebuild,edge-addition,100,3,", "ratio_wall"), "100.000000");
    let slopes = csv_of(cost::T4, 2);
    assert_eq!(field(&slopes, "quick,nodes,rebuild,edge-addition,nodes,", "hmm_fits"), "1.000000");
    assert_eq!(field(&slopes, "quick,nodes,situ,edge-addition,nodes,", "hmm_fits"), "0.000000");
    assert_eq!(field(&slopes, "quick,nodes,situ,edge-addition,nodes,", "divergences"), "", "a cost of 0 has no slope");
    let crossover = csv_of(cost::T4, 3);
    // 6 fits at every size and 6 for each node meet at one node, and so do one millisecond and one for each node. 3
    // classifiers and 3 are parallel.
    assert_eq!(crossover.lines().nth(1), Some("quick,nodes,rebuild,edge-addition,< 10,< 10,never,< 10"));
}

#[test]
fn the_slowest_of_many_corrections() {
    let records: Vec<Record> = (0..101)
        .map(|correction| {
            let Record::Cost(one) = sample::cost("situ", 10, 1, 6, 0.001 * f64::from(1 + correction)) else {
                unreachable!()
            };
            let model_size = vec![10, 11];
            Record::Cost(CostRecord { correction, model_size, ..one })
        })
        .collect();
    let csv = cost::T4.tables(&Canonical::from(records))[4].to_csv();
    let row = "quick,nodes,situ,edge-addition,10,101,";
    let found = ["update_ms_wall", "update_p99_ms_wall", "segment_ms_wall", "segment_p99_ms_wall"];
    let found = found.map(|name| field(&csv, row, name));
    assert_eq!(found, ["51.000000", "100.000000", "25.500000", "50.000000"].map(str::to_owned), "{csv}");
}

#[test]
fn no_record_gives_empty_tables() {
    for table in ALL.iter().flat_map(|publication| publication.tables(&Canonical::default())) {
        assert!(table.is_empty() && table.to_csv().lines().count() == 1, "{}", table.id());
    }
}

#[test]
fn clocks_are_only_in_columns_named_so() {
    let records = canonical();
    let without = Canonical::from(records.iter().map(Record::without_times).collect::<Vec<_>>());
    let both = ALL.iter().flat_map(|table| table.tables(&records).into_iter().zip(table.tables(&without)));
    for (with, without) in both {
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
    fn the_order_of_the_records_does_not_matter(shuffled in Just(sample::records()).prop_shuffle()) {
        prop_assert_eq!(all_text(&Canonical::from(shuffled)), all_text(&canonical()));
    }
}
