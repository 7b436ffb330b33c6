//! `learn`: the example in the repository, through the library and through the program; and mistakes in demonstration
//! files.
//!
//! A mistake must be answered with file, line, key and what was expected, with exit status 2, and with nothing written.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use situ::edit::Edit;
use situ::method::named;
use situ_bench::cmd::learn::learn;
use situ_bench::demonstration_file::{DemonstrationFile, render};

const ORIGINALS: [&str; 2] = ["serve-1.json", "serve-2.json"];
const CORRECTION: &str = "lid-first.json";

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/demonstrations").join(name)
}

fn read(name: &str) -> DemonstrationFile {
    DemonstrationFile::read(&example(name)).unwrap_or_else(|error| panic!("{error}"))
}

fn program(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_situ-bench")).args(arguments).current_dir(folder).output().unwrap()
}

/// A folder with the three example files.
fn copies() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ORIGINALS.iter().chain([&CORRECTION]) {
        fs::copy(example(name), folder.path().join(name)).unwrap();
    }
    folder
}

#[test]
fn the_example_adds_a_node() {
    let lesson = learn(named("situ").unwrap(), &ORIGINALS.map(read), &[read(CORRECTION)], 0).unwrap();
    let [corrected] = &lesson.corrections[..] else { panic!("one correction") };
    assert_eq!(corrected.difference.edit(), Edit::NodeAddition);
    let graph = lesson.kept.learned.graph().unwrap();
    let references: Vec<&str> = graph.nodes.iter().map(|node| &*node.reference).collect();
    assert_eq!(references, ["cup", "tray", "lid"]);
    let edges: Vec<String> = graph.edges.iter().map(|(from, to)| format!("{from} {to}")).collect();
    assert_eq!(edges, ["START z0", "START z2", "z0 z1", "z1 END", "z2 z0"]);
}

#[test]
fn the_program_learns_the_example() {
    let folder = copies();
    let words = ["learn", ORIGINALS[0], ORIGINALS[1], "--correct", CORRECTION];
    let outputs = ["--out", "model.json", "--dot", "model.dot", "--trace", "trace.csv"];
    let run = || program(&[&words[..], &outputs[..]].concat(), folder.path());
    let first = run();
    let printed = String::from_utf8(first.stdout).unwrap();
    assert!(first.status.success(), "{}", String::from_utf8_lossy(&first.stderr));
    for line in ["nodes 3", "edges 5", "correction lid-first: node-addition (nodes added 1, edges added 0, "] {
        assert!(printed.contains(line), "{line} in\n{printed}");
    }
    let text = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let dot = text("model.dot");
    assert_eq!(dot.matches("shape=box").count(), 3, "{dot}");
    assert!(dot.contains("START [") && dot.contains("END [") && dot.contains("z2 -> z0;"), "{dot}");
    let model: serde_json::Value = serde_json::from_str(&text("model.json")).unwrap();
    assert_eq!(model["method"], "situ");
    let trace = text("trace.csv");
    assert_eq!(trace.lines().count(), 1 + 2 + 1, "a header, a line a segment, and the whole update:\n{trace}");
    // The same files give the same bytes.
    let before = [text("model.json"), dot, trace];
    assert!(run().status.success());
    assert_eq!(before, [text("model.json"), text("model.dot"), text("trace.csv")]);
}

/// The example has no narration. So the methods that need one refuse it, and say so.
#[test]
fn every_method_learns_the_example() {
    const LISTENERS: [&str; 2] = ["oracle_edit", "narrated_hierarchy"];
    for method in situ::method::all() {
        let name = method.name().to_owned();
        let lesson = learn(method, &ORIGINALS.map(read), &[read(CORRECTION)], 0);
        if LISTENERS.contains(&name.as_str()) {
            let message = lesson.map(|_| ()).unwrap_err().to_string();
            assert!(message.contains("every keyframe needs a narration"), "{message}");
            continue;
        }
        let lesson = lesson.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(lesson.kept.learned.graph().unwrap().nodes.len() >= 2, "{name}");
    }
}

#[test]
fn what_is_rendered_is_read_back() {
    let original = read(ORIGINALS[0]);
    let text = render(&original.demonstration, &original.schema, &original.before);
    let again = DemonstrationFile::parse(text.clone(), original.path()).unwrap();
    assert_eq!(
        (&again.demonstration, &again.schema, &again.before),
        (&original.demonstration, &original.schema, &original.before)
    );
    assert_eq!(render(&again.demonstration, &again.schema, &again.before), text);
}

#[test]
fn a_quaternion_that_is_nearly_a_unit_is_made_one() {
    let text = fs::read_to_string(example(FIRST)).unwrap();
    let near = text.replacen("[0.0, 1.0, 0.0, 0.0]", "[0.0, 1.0009, 0.0, 0.0]", 1);
    let near = DemonstrationFile::parse(near, &example(FIRST)).unwrap();
    assert_eq!(near.demonstration, read(FIRST).demonstration);
}

/// A mistake: the file, the text it replaces (once), the line it then stands in, and what the message must say.
struct Mistake {
    file: &'static str,
    from: &'static str,
    to: &'static str,
    key: &'static str,
    expected: &'static str,
}

const fn mistake(
    file: &'static str,
    from: &'static str,
    to: &'static str,
    key: &'static str,
    expected: &'static str,
) -> Mistake {
    Mistake { file, from, to, key, expected }
}

const FIRST: &str = ORIGINALS[0];
const SECOND: &str = ORIGINALS[1];

const MISTAKES: [Mistake; 20] = [
    mistake(FIRST, "\"kind\": \"original\"", "\"kind\": \"whole\"", "kind", "expected `original` or `corrective`"),
    mistake(FIRST, "\"after\": null", "\"after\": 3", "after", "expected null or {\"demonstration\": name"),
    mistake(
        FIRST,
        "\"after\": null",
        "\"after\": null, \"interrupted\": {\"demonstration\": \"serve-2\", \"segment\": 0}",
        "interrupted",
        "begins at START",
    ),
    mistake(
        CORRECTION,
        "\"after\": null",
        "\"after\": null, \"interrupted\": {\"demonstration\": \"serve-1\", \"segment\": 9}",
        "interrupted.segment",
        "9, expected 0 to",
    ),
    mistake(FIRST, "\"carried_to_end\": true", "\"carried\": true", "carried", "expected one of `version`, `name`"),
    mistake(FIRST, "{\"open\": 0.08}", "{\"opened\": 0.08}", "keyframes[0].gripper", "expected `open` or `close`"),
    mistake(FIRST, "{\"open\": 0.08}", "1.5", "keyframes[0].gripper", "expected an opening from 0"),
    mistake(
        FIRST,
        "[1.0, 0.0, 0.0, 0.0]",
        "[0.0, 0.0, 0.0, 0.0]",
        "keyframes[0].reference_pose.quaternion",
        "expected length 1",
    ),
    mistake(
        FIRST,
        "[0.0, 1.0, 0.0, 0.0]",
        "[0.0, 1.01, 0.0, 0.0]",
        "keyframes[0].gripper_pose.quaternion",
        "expected length 1",
    ),
    mistake(FIRST, "\"state\": [", "\"state\": [0.1, ", "keyframes[0].state", "6 numbers, expected 5"),
    mistake(FIRST, "\"state\": [", "\"state\": [NaN, ", "keyframes[0].state", "expected"),
    mistake(FIRST, "\"state\": [", "\"state\": [1e999, ", "keyframes[0].state[0]", "number out of range"),
    mistake(FIRST, "\"final_state\": [", "\"final_state\": [0.0, ", "final_state", "6 numbers, expected 5"),
    mistake(FIRST, "\"scale\": 0.3}", "\"scale\": 0.0}", "schema[2].scale", "0, expected a scale of"),
    mistake(FIRST, "\"hold\": 0.5", "\"hold\": -0.5", "keyframes[1].hold", "expected 0 to 1000000 seconds"),
    mistake(SECOND, "\"scale\": 0.3}", "\"scale\": 0.4}", "schema[2]", "expected the schema of serve-1.json"),
    mistake(SECOND, "\"name\": \"serve-2\"", "\"name\": \"serve-1\"", "name", "expected another"),
    mistake(SECOND, "\"kind\": \"original\"", "\"kind\": \"corrective\"", "kind", "expected \"original\""),
    mistake(
        CORRECTION,
        "\"after\": null",
        "\"after\": {\"demonstration\": \"serve-3\", \"segment\": 0}",
        "after.demonstration",
        "expected one of `serve-1`, `serve-2`",
    ),
    mistake(
        CORRECTION,
        "\"after\": null",
        "\"after\": {\"demonstration\": \"serve-2\", \"segment\": 2}",
        "after.segment",
        "2, expected 0 to 1",
    ),
];

#[test]
fn a_mistake_is_answered_with_file_line_key_and_expectation() {
    for Mistake { file, from, to, key, expected } in MISTAKES {
        let folder = copies();
        let path = folder.path().join(file);
        let text = fs::read_to_string(&path).unwrap();
        let line = 1 + text[..text.find(from).unwrap()].matches('\n').count();
        fs::write(&path, text.replacen(from, to, 1)).unwrap();
        refused(&folder, &format!("error: {file}:{line}: key `{key}"), expected);
    }
}

#[test]
fn what_is_missing_cut_off_or_not_there_is_refused() {
    let change = |file: &str, change: &dyn Fn(String) -> String| {
        let folder = copies();
        let path = folder.path().join(file);
        fs::write(&path, change(fs::read_to_string(&path).unwrap())).unwrap();
        folder
    };
    // The message for a key that is not there stands where its object ends.
    let lines = fs::read_to_string(example(FIRST)).unwrap().lines().count();
    let without = |line: &'static str| {
        move |text: String| text.lines().filter(|other| !other.contains(line)).collect::<Vec<_>>().join("\n")
    };
    let folder = change(FIRST, &without("\"after\""));
    refused(&folder, &format!("error: {FIRST}:{}: key `.`", lines - 1), "missing field `after`");
    let empty = |text: String| {
        let (head, tail) = (text.find("\"keyframes\": [").unwrap() + 14, text.find("  ],\n  \"final_state\"").unwrap());
        text[..head].to_owned() + &text[tail..]
    };
    refused(&change(FIRST, &empty), &format!("error: {FIRST}:13: key `keyframes`"), "expected at least one keyframe");
    refused(&change(FIRST, &|text| text[..200].to_owned()), &format!("error: {FIRST}:"), "EOF");
    refused(
        &change(FIRST, &|text| text + "{}"),
        &format!("error: {FIRST}:{}: key `.`", lines + 1),
        "trailing characters",
    );
    let gone = copies();
    fs::remove_file(gone.path().join(SECOND)).unwrap();
    refused(&gone, &format!("error: {SECOND}: cannot be read"), "");
}

/// The program refuses with this message, exit status 2, and writes nothing.
fn refused(folder: &tempfile::TempDir, start: &str, expected: &str) {
    let count = || fs::read_dir(folder.path()).unwrap().count();
    let before = count();
    let words =
        ["learn", FIRST, SECOND, "--correct", CORRECTION, "--out", "m.json", "--dot", "m.dot", "--trace", "t.csv"];
    let output = program(&words, folder.path());
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.starts_with(start), "expected `{start}…`, found {message}");
    assert!(message.contains(expected), "expected `…{expected}…`, found {message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(output.stdout.is_empty());
    assert_eq!(count(), before, "something was written: {message}");
}

#[test]
fn bad_arguments_have_exit_status_2() {
    let folder = copies();
    for (words, expected) in [
        (vec!["learn"], "required"),
        (vec!["learn", FIRST, "--method", "situation"], "expected one of situ, situ:literal"),
        (vec!["learn", FIRST, "--out", FIRST], "expected another file"),
        (vec!["learn", FIRST, "--out", "a", "--dot", "a"], "expected two names"),
        (vec!["learn", FIRST, "--seed", "one"], "--seed"),
        (vec!["tables", "none.jsonl"], "none.jsonl: cannot be read"),
        (vec!["list", "everything"], "methods"),
    ] {
        let output = program(&words, folder.path());
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains(expected), "{words:?}: {message}");
        assert_eq!(output.status.code(), Some(2), "{words:?}: {message}");
    }
    let nowhere = program(&["learn", FIRST, "--out", "nowhere/model.json"], folder.path());
    assert_eq!(nowhere.status.code(), Some(1), "a folder that is not there is the machine's failure");
}
