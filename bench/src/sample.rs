//! A small set of records made by hand, for tests.

use std::collections::BTreeMap;

use situ::edit::Edit;
use situ::structure::{Agreement, Structure};
use situ::trace::{Branch, Counters, MatchedIn, Obedience};

use crate::calibration::{BranchCalibration, ConfidenceBin};
use crate::correction_record::{CorrectionRecord, StepSummary};
use crate::held_out::HeldOut;
use crate::record::{CostRecord, Key, Outcome, Pooled, Record, RunRecord, Stage};
use crate::tally::{Rate, TotalEffort};

/// So many successes of ten.
fn rate(successes: u32) -> Rate {
    Rate { successes, once: successes, rollouts: 10 }
}

fn effort(demonstrations: u32, keyframes: u32) -> TotalEffort {
    let seconds = 4.5 * f64::from(keyframes);
    let metres = 0.25 * f64::from(keyframes);
    TotalEffort { demonstrations, tries: demonstrations, keyframes, seconds, metres, foreseen: 0 }
}

fn correction(edit_made: Edit, applicable: u32, update_seconds: f64) -> CorrectionRecord {
    let step = StepSummary {
        reference: "cup".to_owned(),
        applicable,
        model_size: 4,
        candidates: 1,
        matched_in: MatchedIn::None,
        branch: Branch::New,
        retrieved: Some(applicable > 1),
    };
    CorrectionRecord {
        failure: "predicate lost".to_owned(),
        last: "START".to_owned(),
        effort: effort(1, 3),
        shows_change: true,
        edit_made,
        nodes_added: u32::from(edit_made == Edit::NodeAddition),
        edges_added: u32::from(edit_made == Edit::EdgeAddition),
        nodes_modified: u32::from(edit_made == Edit::NodeModification),
        edges_back: 0,
        nodes_merged: 0,
        obedience: Obedience::default(),
        steps: vec![step],
        counters: Counters {
            hmm_fits: 4,
            em_iterations: 30,
            divergences: 1,
            classifier_fits: 2,
            ..Counters::default()
        },
        decided_by: rate(9),
        update_seconds,
    }
}

fn run(method: &str, seed: u64, outcome: Outcome, demonstrations: u32, made: &[Edit]) -> Record {
    let successes = if outcome == Outcome::Reached { 10 } else { 4 };
    let counts = outcome.counts();
    Record::Run(RunRecord {
        key: Key {
            protocol: "quick".to_owned(),
            task: "pour".to_owned(),
            variation: "lid".to_owned(),
            edit: Edit::NodeAddition,
            teacher: "competent".to_owned(),
            method: method.to_owned(),
            seed,
            stage: None,
            content: "0123456789abcdef".to_owned(),
        },
        outcome,
        self_loop: false,
        grade: None,
        budget: 8,
        target: 0.9,
        original: effort(2, 12),
        before: counts.then_some(rate(1)),
        after: counts.then_some(rate(successes)),
        effort: effort(demonstrations, 3 * demonstrations),
        corrections: made.iter().map(|edit| correction(*edit, 1 + seed as u32, 0.002)).collect(),
        ended: BTreeMap::from([("goal".to_owned(), successes), ("time-out".to_owned(), 10 - successes)]),
        original_rate: Some(rate(10)),
        retained: None,
        structure: None,
        pooled: None,
        calibration: counts.then(|| calibration(successes)),
        held_out: counts.then_some(HeldOut { segments: 4, explained: 3, keyframes: 10, log_likelihood: -25.0 }),
        earlier: BTreeMap::new(),
    })
}

/// Ten choices of probability 0.9, so many of them right.
fn calibration(right: u32) -> BranchCalibration {
    let mut bins = vec![ConfidenceBin::default(); 10];
    bins[9] = ConfidenceBin { choices: 10, right, probability: 9.0 };
    BranchCalibration { squares: 0.01 * f64::from(right) + 0.81 * f64::from(10 - right), bins }
}

fn structure(nodes: u32, duplicates: u32, missed: u64) -> Structure {
    let agreement = |both, missed| Agreement { both, model: both, truth: both + missed };
    Structure {
        nodes,
        edges: nodes + 1,
        duplicates,
        skills: nodes - duplicates,
        pairs: agreement(8, 8 * missed),
        transitions: agreement(6, missed),
    }
}

/// A corrected run that is compared with the pooled model.
fn compared(seed: u64) -> Record {
    let mut record = run("situ:literal", seed, Outcome::Reached, 1, &[Edit::NodeAddition]);
    let Record::Run(run) = &mut record else { unreachable!() };
    run.retained = Some(rate(9));
    run.structure = Some(structure(5, 1, 1));
    run.after = Some(rate(8));
    let pooled = rate(if seed == 0 { 10 } else { 6 });
    run.pooled = Some(Pooled { pooled, retained: rate(10), structure: Some(structure(4, 0, 0)), held_out: None });
    record
}

/// The second stage of a sequence. The model that the lid left meets a vase, and no longer does the lid.
fn stage() -> Record {
    let Record::Run(mut run) = run("situ", 0, Outcome::Reached, 2, &[Edit::NodeModification]) else { unreachable!() };
    run.key.variation = "vase".to_owned();
    run.key.edit = Edit::NodeModification;
    run.key.stage = Some(Stage { sequence: "kitchen".to_owned(), number: 2 });
    run.retained = Some(rate(7));
    run.earlier = BTreeMap::from([("lid".to_owned(), rate(3))]);
    Record::Run(run)
}

pub(crate) fn cost(method: &str, nodes: u32, seed: u64, work: u64, update_seconds: f64) -> Record {
    Record::Cost(CostRecord {
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

/// Two methods of corrections and teaching from scratch, one untaught and one spoilt run, a stage; costs at three
/// sizes.
pub(crate) fn records() -> Vec<Record> {
    use Edit::{EdgeAddition, NodeAddition, None};
    let mut records = vec![
        run("situ", 0, Outcome::Reached, 1, &[NodeAddition]),
        run("situ", 1, Outcome::Reached, 2, &[EdgeAddition, NodeAddition]),
        run("situ", 2, Outcome::Spoilt { why: "NaN".to_owned() }, 0, &[]),
        run("situ", 3, Outcome::Untaught { why: "2 of 10 rollouts after 6 demonstrations".to_owned() }, 0, &[]),
        run("rebuild", 0, Outcome::Reached, 1, &[NodeAddition]),
        run("rebuild", 1, Outcome::Censored, 5, &[None, None, None, None, NodeAddition]),
        run("from_scratch", 0, Outcome::Reached, 4, &[]),
        run("from_scratch", 1, Outcome::Reached, 8, &[]),
        run("from_scratch", 3, Outcome::Untaught { why: "2 of 10 rollouts after 6 demonstrations".to_owned() }, 0, &[]),
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
