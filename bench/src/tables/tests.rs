//! The tables of a small set of records made by hand, against text that was checked by hand, and in any order.

use proptest::prelude::*;

use crate::ledger::Canonical;
use crate::record::{CostRecord, Record};
use crate::sample;
use crate::tables::{
    ALL, Heading, Publication, confidence, cost, edits, effort, endings, methods, paired, questions, retention,
    separate, teachers,
};
use crate::tally::Rate;

fn canonical() -> Canonical {
    Canonical::from(sample::records())
}

/// A heading of records whose origin nobody knows.
fn heading() -> Heading {
    let [ledgers, revision] = ["quick.jsonl", "Revision: unknown"].map(str::to_owned);
    Heading { ledgers, revision, superseded: None }
}

fn all_text(records: &Canonical) -> String {
    let tables = ALL.iter().flat_map(|publication| publication.tables(records));
    tables
        .map(|table| table.to_markdown(&heading(), "situ-bench tables quick.jsonl") + "\n" + &table.to_csv() + "\n")
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
    // Two seeds that count, one untaught and one spoilt; 1 and 2 demonstrations against 4 and 8 from scratch.
    let count = |name| field(&t1, situ, name);
    assert_eq!(["seeds", "untaught", "spoilt"].map(count), ["2", "1", "1"]);
    assert_eq!([count("before"), count("after"), count("once")], ["0.100000", "1.000000", "1.000000"]);
    assert_eq!(field(&t1, situ, "demonstrations"), "1.500000");
    assert_eq!(field(&t1, situ, "demonstrations_ratio"), "0.250000");
    assert_eq!(field(&t1, situ, "made_first"), "node-addition 1, edge-addition 1");
    // A run that did not reach the target counts the budget of 8, and makes the mean a lower bound.
    let rebuild = "quick,pour,lid,node-addition,competent,rebuild,";
    assert_eq!(field(&t1, rebuild, "demonstrations"), "4.500000");
    assert_eq!(field(&t1, rebuild, "tries"), "3.000000");
    assert_eq!(field(&t1, rebuild, "demonstrations_bound"), "≥");
    let control = "quick,pour,lid,node-addition,competent,no_update,";
    assert_eq!([field(&t1, control, "not_applicable"), field(&t1, control, "demonstrations")], ["1", ""]);
    assert!(!t1.contains("vase"), "a stage is not a run that stands alone");
}

#[test]
fn what_edits_must_say() {
    let edits = csv_of(edits::T3, 0);
    let right = |name| field(&edits, "quick,rebuild,node-addition", name);
    // One run's first correction made nothing. Together all corrections of either run added a node.
    assert_eq!([right("first_right"), right("all_right")], ["0.500000", "1.000000"]);
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
    assert_eq!([of("separate"), of("joint")], ["0.800000", "0.800000"]);
    // Two fifths less in one run, a fifth more in the other.
    assert_eq!([of("difference_low"), of("difference_high")], ["-0.200000", "0.200000"]);
    assert_eq!(of("edge_F1_joint"), "1.000000");
    assert_eq!(t2.lines().count(), 3, "all tasks and one: {t2}");
}

#[test]
fn what_methods_must_say() {
    let methods = csv_of(methods::METHODS, 0);
    let rebuild = |name| field(&methods, "quick,rebuild,node-addition,", name);
    // 1 and the budget of 8 against 1 and 2.
    assert_eq!([rebuild("demonstrations_to_situ"), rebuild("demonstrations_to_situ_bound")], ["3.000000", "≥"]);
    assert_eq!(rebuild("update_to_situ_wall"), "1.000000");
    assert_eq!(field(&methods, "quick,from_scratch,node-addition,", "update_to_situ_wall"), "", "it updates nothing");
    let control = "quick,no_update,node-addition,";
    assert_eq!(["runs", "not_applicable", "after"].map(|name| field(&methods, control, name)), ["0", "1", ""]);
}

#[test]
fn what_retention_must_say() {
    let alone = |name| field(&csv_of(retention::T5, 0), "quick,pour,lid,node-addition,competent,situ:literal,2,", name);
    assert_eq!([alone("before"), alone("original_after")], ["0.100000", "0.900000"]);
    let stages = csv_of(retention::T5, 1);
    let stage = |name| field(&stages, "quick,pour,kitchen,2,vase,node-modification,competent,situ,1,", name);
    // The vase is kept, with all rollouts; the original and the lid, with 7 and 3 of 10, are not.
    assert_eq!([stage("original"), stage("kept")], ["0.700000", "0.333333"]);
    let ageing = csv_of(retention::T5, 2);
    let second = |name| field(&ageing, "quick,competent,situ,2,1,", name);
    assert_eq!([second("after"), second("kept"), second("segments")], ["1.000000", "0.333333", "0.000000"]);
}

/// The first stage succeeds in 8 of 10 and later in 3, the second in 10.
#[test]
fn what_sequences_must_say() {
    let Some(Record::Run(second)) = sample::records().into_iter().find(|record| record.single_run().is_none()) else {
        panic!("a stage is among the records")
    };
    let mut first = second.clone();
    let stage = first.key.stage.as_mut().unwrap();
    stage.number = 1;
    first.key.variation = "lid".to_owned();
    first.earlier.clear();
    first.after = Some(Rate { successes: 8, once: 8, rollouts: 10 });
    let alone = Canonical::from(vec![Record::Run(second.clone())]);
    assert_eq!(retention::T5.tables(&alone).len(), 2, "a sequence with a stage missing has no score");
    let records = Canonical::from(vec![Record::Run(first), Record::Run(second)]);
    let csv = retention::T5.tables(&records)[2].to_csv();
    let score = |name| field(&csv, "quick,competent,situ,all,all,1,", name);
    assert_eq!(["FWT", "NBT", "AUC"].map(score), ["0.900000", "0.500000", "0.775000"], "{csv}");
}

#[test]
fn what_the_questions_must_say() {
    let scratch = csv_of(questions::QUESTIONS, 0);
    let of = |name| field(&scratch, "quick,competent,situ,all,2,2,1,", name);
    // 3 demonstrations of 3 keyframes each against 12.
    assert_eq!([of("demonstrations"), of("keyframes"), of("success")], ["0.250000", "0.250000", "0.000000"]);
    assert_eq!(of("demonstrations_low"), "0.250000");
    assert!(!scratch.contains("variations_low"), "one variation has no interval: {scratch}");
    let rebuild = |name| field(&scratch, "quick,competent,rebuild,all,", name);
    assert_eq!([rebuild("demonstrations"), rebuild("demonstrations_bound")], ["0.750000", "≥"]);
    let joint = csv_of(questions::QUESTIONS, 1);
    assert_eq!(field(&joint, "quick,competent,situ:literal,all,2,", "original"), "-0.100000");
    let text = questions::QUESTIONS.tables(&canonical())[0].to_markdown(&heading(), "x");
    let sentence =
        "`situ`, competent, every edit (2 runs, 2 units, 1 variations): corrections took 0.25 [0.25, 0.25] times";
    assert!(text.contains(sentence), "{text}");
}

#[test]
fn what_paired_must_say() {
    let paired = csv_of(paired::PAIRED, 0);
    let of = |name| field(&paired, "quick,competent,rebuild,2,2,", name);
    // One unit ties and one gains 6 of 10: the sign of one difference can show nothing.
    assert_eq!([of("success"), of("p_success"), of("least_p")], ["0.300000", "1.000000", "1.000000"]);
    assert_eq!([of("demonstrations"), of("fits")], ["-3.000000", "0.000000"]);
    let text = paired::PAIRED.tables(&canonical())[0].to_markdown(&heading(), "x");
    let sentence =
        "- `situ` against `rebuild`, competent, success: no difference is shown: 0.30 [0.00, 0.60], Holm 1.0000.";
    assert!(text.contains(sentence), "{text}");
    assert_eq!(of("improvement"), "0.750000", "10 and 10 against 10 and 4: two of four pairs are ties, two are won");
}

#[test]
fn what_confidence_must_say() {
    let t7 = csv_of(confidence::T7, 0);
    let of = |name| field(&t7, "quick,rebuild,node-addition,2,", name);
    // 14 of 20 choices are right, all said to be with 0.9.
    assert_eq!([of("choices"), of("accuracy"), of("ECE")], ["20", "0.700000", "0.200000"]);
    assert_eq!(of("Brier"), "0.250000", "14 squares of 0.1 and 6 of 0.9 over 20");
    assert_eq!([of("explained"), of("likelihood")], ["0.750000", "-2.500000"]);
    let physics = csv_of(cost::T4, 0);
    let right = |name| field(&physics, "quick,situ,node-addition,", name);
    assert_eq!([right("held"), right("A1.6_right")], ["3", "0.666667"]);
}

#[test]
fn runs_that_came_to_nothing_say_why() {
    let csv = csv_of(endings::ENDINGS, 0);
    let why = "2 of 10 rollouts after 6 demonstrations";
    assert_eq!(field(&csv, "quick,pour,all,competent,all,untaught,", "why"), why, "once for all methods");
    assert_eq!(field(&csv, "quick,pour,lid,competent,situ,spoilt,", "why"), "NaN");
    assert_eq!(csv.lines().count(), 3, "{csv}");
}

#[test]
fn what_teachers_must_say() {
    let t6 = csv_of(teachers::T6, 0);
    let of = |name| field(&t6, "quick,situ:literal,competent,", name);
    // 5 nodes for 4 skills.
    assert_eq!([of("runs"), of("primitives_a_skill")], ["2", "1.250000"]);
    assert!(!t6.contains("no_update"), "what does not apply has no row: {t6}");
}

#[test]
fn what_cost_must_say() {
    let scaling = csv_of(cost::T4, 1);
    assert_eq!(field(&scaling, "quick,nodes,rebuild,edge-addition,100,3,", "hmm_fits_ratio"), "100.000000");
    assert_eq!(field(&scaling, "quick,nodes,rebuild,edge-addition,100,3,", "ratio_wall"), "100.000000");
    let slopes = csv_of(cost::T4, 2);
    assert_eq!(field(&slopes, "quick,nodes,rebuild,edge-addition,nodes,", "hmm_fits"), "1.000000");
    assert_eq!(field(&slopes, "quick,nodes,situ,edge-addition,nodes,", "hmm_fits"), "0.000000");
    assert!(!slopes.contains("divergences"), "a cost of 0 has no slope: {slopes}");
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
    let csv = cost::T4.tables(&Canonical::from(records)).pop().unwrap().to_csv();
    let row = "quick,nodes,situ,edge-addition,10,101,";
    let found = ["update_ms_wall", "update_p99_ms_wall", "segment_ms_wall", "segment_p99_ms_wall"];
    let found = found.map(|name| field(&csv, row, name));
    assert_eq!(found, ["51.000000", "100.000000", "25.500000", "50.000000"].map(str::to_owned), "{csv}");
}

#[test]
fn no_table_is_empty_and_no_column_says_nothing() {
    assert_eq!(ALL.iter().flat_map(|publication| publication.files(&Canonical::default(), &heading())).count(), 0);
    for table in ALL.iter().flat_map(|publication| publication.tables(&canonical())) {
        let csv = table.to_csv();
        let mut reader = csv::Reader::from_reader(csv.as_bytes());
        let heads: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        assert!(!rows.is_empty(), "{}", table.id());
        for (index, head) in heads.iter().enumerate() {
            assert!(rows.iter().any(|row| !matches!(&row[index], "" | "0")), "{} of {}", head, table.id());
        }
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
