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

use std::path::Path;

use proptest::prelude::*;
use proptest::test_runner::{TestCaseResult, TestRunner};
use situ::method::named;
use situ_bench::demonstration_file::DemonstrationFile;
use situ_bench::kept_model::KeptModel;
use situ_bench::ledger;
use situ_bench::protocol::Protocol;
use situ_tasks::Task;
use situ_teachers::Profile;

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
const DEMONSTRATIONS: [&str; 3] = [
    include_str!("../../../examples/demonstrations/serve-1.json"),
    include_str!("../../../examples/demonstrations/lid-first.json"),
    include_str!("../../../examples/poses/lid-first.json"),
];
const TEACHERS: [&str; 1] = [include_str!("../../../../synth_teachers/src/profiles.toml")];
const RECORDINGS: [&str; 2] =
    [include_str!("../../../examples/recording/saucer.csv"), include_str!("../../../examples/recording/saucer.toml")];
const REQUESTS: [&str; 1] = [include_str!("../../../examples/lines/requests.jsonl")];
const ANSWERS: [&str; 1] = [include_str!("../../../examples/lines/answers.jsonl")];
/// The published ledger.
const LEDGER: &str = include_str!("../../../../results/quick/ledger.jsonl");
/// Every so many lines of the published ledger make a small one.
const LINES_APART: usize = 23;

/// Cases of each test, where they are not soaked.
const CASES: u32 = 256;
/// The same where each is an episode.
const SESSIONS: u32 = 64;

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

/// Questions to a model.
const QUESTIONS: [&str; 3] = [
    "{\"id\": 1, \"do\": \"next\", \"last\": null, \"state\": [0.45, 0.12, 0.0, 0.0, 1.0]}",
    "{\"do\": \"keyframes\", \"place\": \"z1\", \"state\": [0, 0, 0, 0, 0], \"execution\": \"sample\", \"seed\": 3}",
    "{\"do\": \"graph\"}",
];

#[test]
fn model_files() {
    let original = |text: &str| DemonstrationFile::parse(text.to_owned(), Path::new("file")).unwrap();
    let texts = [DEMONSTRATIONS[0], include_str!("../../../examples/poses/serve-1.json")];
    let models = texts.map(|text| KeptModel::teach(named("situ").unwrap(), &[original(text)], 0).unwrap().render());
    survives(checks::model, &models.each_ref().map(String::as_str), CASES);
}

#[test]
fn questions_to_a_model() {
    for text in QUESTIONS {
        assert!(checks::question(text.as_bytes()), "{text}");
    }
    let question = prop::sample::select(QUESTIONS.to_vec());
    let mutations = prop::collection::vec(any::<(u8, prop::sample::Index, prop::sample::Index)>(), 1..=3);
    holds((question, mutations), CASES, |(text, mutations)| {
        let mutations = mutations.iter().map(|(kind, place, choice)| Mutation::of(*kind, *place, *choice));
        checks::question(&mutations.fold((*text).to_owned(), |text, mutation| mutation.apply(&text)).into_bytes());
    });
}

#[test]
fn teacher_files() {
    survives(checks::teachers, &TEACHERS, CASES);
}

#[test]
fn recordings_and_their_mappings() {
    survives(checks::recording, &RECORDINGS, CASES);
}

#[test]
fn ledgers() {
    let lines: Vec<&str> = LEDGER.split_inclusive('\n').step_by(LINES_APART).collect();
    let few: Vec<String> = lines.chunks(3).map(|lines| lines.concat()).collect();
    survives(checks::ledger, &few.iter().map(String::as_str).collect::<Vec<_>>(), CASES);
}

#[test]
fn requests_to_serve() {
    survives(checks::requests, &REQUESTS, SESSIONS);
}

#[test]
fn answers_of_methods() {
    survives(checks::answers, &ANSWERS, CASES);
}

/// What fuzzers and mutations have found, each with what is said of it now.
#[test]
fn what_was_found_stays_mended() {
    let long = "n".repeat(20_000);
    let refusal = |error: &dyn std::error::Error| error.to_string();
    let path = Path::new("file");
    let task = |from: &str, to: &str| refusal(&Task::parse(&TASKS[1].replacen(from, to, 1), path).unwrap_err());
    let protocol =
        |text: &str, from: &str, to: &str| refusal(&Protocol::parse(&text.replacen(from, to, 1), path).unwrap_err());
    let demonstration = |from: &str, to: &str| {
        let text = DEMONSTRATIONS[0].replacen(from, to, 1);
        refusal(&DemonstrationFile::parse(text, path).unwrap_err())
    };
    let ledger = |from: &str, to: &str| {
        let line = LEDGER.split_inclusive('\n').next().unwrap().replacen(from, to, 1);
        refusal(&ledger::contents(path, line.as_bytes()).unwrap_err())
    };
    let teacher = |text: &str| refusal(&Profile::parse(text, path).unwrap_err());
    let cost = PROTOCOLS[1];
    let said = [
        // A message repeated escape sequences and line feeds of the file, and names of any length.
        (task("analysis =", "\"\\u001b[31m\" ="), "unknown field `\\u{1b}[31m`"),
        (task("name = \"pour\"", &format!("name = \"{long}\"")), "n… expected a name of"),
        (protocol(PROTOCOLS[0], "# ", "#\0 "), "`#\\u{0} "),
        (demonstration("\"hold\"", "\"\\u001b\""), "unknown field `\\u{1b}`"),
        // Escapes are longer than what they stand for.
        (demonstration("\"hold\"", &format!("\"{}\"", "\u{7f} ".repeat(600))), "\\u{7f} \\u{7f}"),
        (ledger("\"task\":", &format!("\"{long}\":")), "unknown field `nn"),
        (teacher("[[profile]]\n\"a\\nb\" = 1\n"), "unknown field `a\\nb`"),
        // The place of a mistake was cut out of the text with its byte-order mark, in the middle of it.
        (teacher("\u{feff}y are 1.9\n"), "expected"),
        // An object out of the workshop was refused without file and line.
        (task("x = [-0.16, -0.16]", "x = [9.0, 9.0]"), "object `mat`: its pose"),
        // Each number was within its bounds, and the plan of them all was beyond every memory.
        (protocol(cost, "seeds = 3\n\n[[cost]]", "seeds = 100000\ncorrections = 9\n\n[[cost]]"), "of at most 1000000"),
        (protocol(PROTOCOLS[2], "seeds = ", "seeds = 99999 #"), "tasks × teachers × methods × seeds of at most"),
        // A name with a line feed stood in DOT and in the report.
        (demonstration("\"cup\"", "\"c\\nup\""), "no control character"),
        (ledger("\"task\":\"", "\"task\":\"\\n"), "a control character"),
        // Sums of such numbers overflowed.
        (ledger("\"budget\":", "\"budget\":1e300,\"x\":"), "expected at most 1e12"),
    ];
    for (message, expected) in said {
        assert!(message.starts_with("file:") && message.contains(expected), "{expected}: {message}");
        assert!(message.len() < 3000 && !message.chars().any(char::is_control), "{message:?}");
    }
}

/// Bytes of no format, and the marks of all of them in any order.
#[test]
fn any_bytes() {
    let marks = ["{", "}", "[", "]", "\"", "'", ",", ":", "=", "\n", "name", "schema", "1", "-", "e9", ".", "\\", "é"];
    let marks = prop::collection::vec(prop::sample::select(marks.to_vec()), 0..60);
    let bytes =
        prop_oneof![prop::collection::vec(any::<u8>(), 0..200), marks.prop_map(|marks| marks.concat().into_bytes()),];
    holds(bytes, CASES, |bytes| {
        for check in [
            checks::task,
            checks::protocol,
            checks::demonstration,
            checks::ledger,
            checks::teachers,
            checks::model,
            checks::question,
            checks::recording,
            checks::requests,
            checks::answers,
        ] {
            check(bytes);
        }
    });
}
