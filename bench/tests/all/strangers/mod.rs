//! Files that strangers write: any bytes, and files of ours with something wrong in them. Each is refused with its
//! place, or can be used ([`checks`]).
//!
//! The fuzzers of `bench/fuzz` ask the same of inputs that they find themselves. Every input that failed is a case
//! here.
//!
//! ```text
//! SITU_SOAK=100 cargo test -p situ-bench --release --test all -- strangers
//! ```

#[expect(unreachable_pub, reason = "the fuzzers see them from another crate")]
mod checks;
mod mutations;

use proptest::prelude::*;
use proptest::test_runner::{TestCaseResult, TestRunner};

use crate::soak;
use mutations::Mutation;

/// Sound files of each kind but ledgers.
const TASKS: [&str; 3] = [
    include_str!("../../../../tasks/library/drawer.toml"),
    include_str!("../../../../tasks/library/pour.toml"),
    include_str!("../../../../tasks/library/press.toml"),
];
const PROTOCOLS: [&str; 3] = [
    include_str!("../../../protocols/quick.toml"),
    include_str!("../../../protocols/cost.toml"),
    include_str!("../../../protocols/paper.toml"),
];
const DEMONSTRATIONS: [&str; 2] = [
    include_str!("../../../examples/demonstrations/serve-1.json"),
    include_str!("../../../examples/demonstrations/lid-first.json"),
];
const TEACHERS: [&str; 1] = [include_str!("../../../../synth_teachers/src/profiles.toml")];
/// The published ledger.
const LEDGER: &str = include_str!("../../../../results/quick/ledger.jsonl");
/// Every so many lines of the published ledger make a small one.
const LINES_APART: usize = 23;

/// Cases of each test, where they are not soaked.
const CASES: u32 = 256;

/// Runs a check on whatever `strategy` makes.
fn holds<S: Strategy>(strategy: S, cases: u32, check: impl Fn(&S::Value)) {
    let mut runner = TestRunner::new(soak::config(cases));
    let result = runner.run(&strategy, |value| -> TestCaseResult {
        check(&value);
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}\nagain with SITU_SEED={}", soak::seed()));
}

/// Sound files are accepted, a byte-order mark before them or not. Files that are mutated up to three times pass, too.
fn survives(check: fn(&[u8]) -> bool, sound: &[&str], cases: u32) {
    for text in sound {
        assert!(check(text.as_bytes()) && check(format!("\u{feff}{text}").as_bytes()), "{text}");
    }
    let file = prop::sample::select(sound.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>());
    let mutations = prop::collection::vec(any::<(u8, prop::sample::Index, prop::sample::Index)>(), 1..=3);
    holds((file, mutations), cases, |(text, mutations)| {
        let mutations = mutations.iter().map(|(kind, place, choice)| Mutation::of(*kind, *place, *choice));
        check(&mutations.fold(text.clone(), |text, mutation| mutation.apply(&text)).into_bytes());
    });
}

#[test]
fn task_files() {
    survives(checks::task, &TASKS, CASES);
}

#[test]
fn protocols() {
    survives(checks::protocol, &PROTOCOLS, CASES);
}

#[test]
fn demonstration_files() {
    survives(checks::demonstration, &DEMONSTRATIONS, CASES);
}

#[test]
fn teacher_files() {
    survives(checks::teachers, &TEACHERS, CASES);
}

#[test]
fn ledgers() {
    let lines: Vec<&str> = LEDGER.split_inclusive('\n').step_by(LINES_APART).collect();
    let few: Vec<String> = lines.chunks(3).map(|lines| lines.concat()).collect();
    survives(checks::ledger, &few.iter().map(String::as_str).collect::<Vec<_>>(), CASES);
}

/// Bytes of no format, and the marks of all of them in any order.
#[test]
fn any_bytes() {
    let marks = ["{", "}", "[", "]", "\"", "'", ",", ":", "=", "\n", "name", "schema", "1", "-", "e9", ".", "\\", "é"];
    let marks = prop::collection::vec(prop::sample::select(marks.to_vec()), 0..60);
    let bytes =
        prop_oneof![prop::collection::vec(any::<u8>(), 0..200), marks.prop_map(|marks| marks.concat().into_bytes()),];
    holds(bytes, CASES, |bytes| {
        for check in [checks::task, checks::protocol, checks::demonstration, checks::ledger, checks::teachers] {
            check(bytes);
        }
    });
}
