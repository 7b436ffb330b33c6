//! A task model that a robot keeps: learned from poses, written, read again, corrected, asked, and its cost held to a
//! baseline.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::{Value, json};

const ONE: &str = "serve-1.json";
const TWO: &str = "serve-2.json";
const LID: &str = "lid-first.json";
const FILES: [&str; 3] = [ONE, TWO, LID];
/// The examples: by states, and by poses.
const FOLDERS: [&str; 2] = ["demonstrations", "poses"];

fn example(folder: &str, name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(folder).join(name)
}

fn copies(folder: &str) -> tempfile::TempDir {
    let copies = tempfile::tempdir().unwrap();
    for name in FILES {
        fs::copy(example(folder, name), copies.path().join(name)).unwrap();
    }
    copies
}

fn program(folder: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_situ-bench")).args(words).current_dir(folder).output().unwrap()
}

/// What a call prints that succeeds.
fn said(folder: &Path, words: &[&str]) -> String {
    let output = program(folder, words);
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The message of a call that is refused with this exit status.
fn refused(folder: &Path, words: &[&str], status: i32) -> String {
    let output = program(folder, words);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(status), "{words:?}: {message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    message
}

#[test]
fn corrected_in_parts_it_is_the_bytes_of_one_go() {
    for (folder, version) in FOLDERS.into_iter().zip(["1", "2"]) {
        for method in ["situ", "rebuild", "situ:literal"] {
            let copies = copies(folder);
            let learn = |words: &[&str]| said(copies.path(), &[&["learn"], words].concat());
            let all = learn(&[ONE, TWO, "--correct", LID, "--method", method, "--out", "all.json"]);
            assert!(all.contains(&format!("read 2 originals, 1 corrections, format version {version}\n")), "{all}");
            learn(&[ONE, TWO, "--method", method, "--out", "model.json"]);
            let corrected = learn(&["--model", "model.json", "--correct", LID, "--out", "model.json"]);
            assert!(corrected.contains("correction lid-first: node-addition"), "{corrected}");
            let text = |name: &str| fs::read_to_string(copies.path().join(name)).unwrap();
            assert!(text("model.json") == text("all.json"), "{folder}, {method}");
            // Read and written, nothing changes.
            learn(&["--model", "model.json", "--out", "again.json"]);
            assert!(text("again.json") == text("all.json"), "{folder}, {method}");
            let message = refused(copies.path(), &["learn", "--model", "model.json", "--correct", LID], 2);
            assert!(message.contains("`lid-first` is the name in model.json as well"), "{message}");
        }
    }
}

/// The answers to lines of questions.
fn answers(folder: &Path, questions: &[Value]) -> Vec<Value> {
    let mut ask = Command::new(env!("CARGO_BIN_EXE_situ-bench"))
        .args(["ask", "model.json"])
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = ask.stdin.take().unwrap();
    for question in questions {
        writeln!(input, "{question}").unwrap();
    }
    drop(input);
    let output = ask.wait_with_output().unwrap();
    assert!(output.status.success());
    String::from_utf8(output.stdout).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn a_robot_asks_what_it_has_to_know() {
    let copies = copies("poses");
    said(copies.path(), &["learn", ONE, TWO, "--correct", LID, "--out", "model.json"]);
    let shown: Value = serde_json::from_str(&fs::read_to_string(copies.path().join(LID)).unwrap()).unwrap();
    let world = &shown["keyframes"][0]["world"];
    let mut unseen = world.clone();
    unseen["objects"].as_object_mut().unwrap().remove("lid");
    let found = answers(
        copies.path(),
        &[
            json!({"id": 1, "do": "graph"}),
            json!({"id": 2, "do": "next", "last": null, "world": world}),
            json!({"id": 3, "do": "next", "last": null, "world": unseen}),
            json!({"id": "four", "do": "keyframes", "place": "z2", "world": world}),
            json!({"id": 5, "do": "keyframes", "place": "z9", "world": world}),
            json!({"id": 6, "do": "next", "last": "z0", "state": [0.0]}),
            json!({"id": 7, "do": "next", "last": null, "world": world, "state": []}),
            json!({"id": 8, "do": "nothing"}),
            json!([1]),
            json!({"id": 9, "do": "keyframes", "place": "z2", "world": unseen}),
        ],
    );
    let graph = &found[0];
    assert_eq!(graph["nodes"][2]["reference"], "lid");
    assert_eq!(graph["nodes"][2]["segments"], json!([["lid-first", 0]]));
    assert!(graph["edges"].as_array().unwrap().contains(&json!([null, "z2"])), "{graph}");
    // Where the lid is seen it comes off first; where it is not, the cup is served.
    assert_eq!((&found[1]["children"][0]["place"], &found[1]["id"]), (&json!("z2"), &json!(2)));
    assert_eq!(found[2]["children"][0]["place"], "z0");
    let keyframes = found[3]["keyframes"].as_array().unwrap();
    assert_eq!((found[3]["reference"].as_str(), &found[3]["id"]), (Some("lid"), &json!("four")));
    let first = &shown["keyframes"][0]["gripper_pose"]["position"];
    for axis in 0..3 {
        let told = keyframes[0]["in_world"]["position"][axis].as_f64().unwrap();
        assert!((told - first[axis].as_f64().unwrap()).abs() < 1e-9, "{told}, {first}");
    }
    let problem = |index: usize| found[index]["error"].as_str().unwrap();
    assert!(problem(4).contains("no place is called `z9`, expected one of z0, z1, z2"), "{}", problem(4));
    assert!(problem(5).contains("1 numbers, expected"), "{}", problem(5));
    assert!(problem(6).contains("either `state` or `world`"), "{}", problem(6));
    assert!(problem(7).contains("unknown variant `nothing`, expected one of `next`"), "{}", problem(7));
    assert!(problem(8).contains("expected an object"), "{}", problem(8));
    assert!(problem(9).contains("`lid`, which the place is about, is not in `world`"), "{}", problem(9));
    // The same questions one by one.
    let once = said(copies.path(), &["ask", "model.json", "{\"id\": 1, \"do\": \"graph\"}"]);
    assert_eq!(serde_json::from_str::<Value>(&once).unwrap(), found[0]);
    let both = ["ask", "model.json", "{\"id\": 1, \"do\": \"graph\"}", "{\"do\": \"graph\", \"of\": 1}"];
    let message = refused(copies.path(), &both, 2);
    assert!(message.contains("unknown field `of`"), "{message}");
    let all = String::from_utf8(program(copies.path(), &both).stdout).unwrap();
    assert!(all.lines().count() == 2 && all.starts_with(once.trim_end()), "what has an answer is answered: {all}");
}

/// Mistakes of a file of version 2: what it replaces (once), the key, and what the message says.
const MISTAKES: [(&str, &str, &str, &str); 11] = [
    ("\"version\": 2", "\"version\": 3", "version", "expected 1 or 2"),
    ("\"version\": 2,", "", "objects", "a key of version 2"),
    ("\"half_turn\"", "\"schema\": [], \"half_turn\"", "objects", "with a `schema`"),
    ("\"cup\", \"lid\", \"tray\"]", "\"cup\", \"tray\", \"tray\"]", "objects", "`tray` stands there twice"),
    ("\"cup\", \"lid\", \"tray\"]", "\"cup\", \"li d\", \"tray\"]", "objects", "expected a name of letters"),
    (
        "\"cup\", \"lid\", \"tray\"]",
        "\"cup\", \"lid\"]",
        "keyframes[0].world.objects",
        "`tray` is no object of the task",
    ),
    ("\"reference\": \"cup\"", "\"reference\": \"lid\"", "keyframes[0].reference", "is not in this keyframe's world"),
    ("\"hand\"", "\"wrist\"", "keyframes[0].world.wrist", "unknown field `wrist`"),
    ("\"opening\": 0.08", "\"opening\": -1", "keyframes[0].world.opening", "expected metres"),
    ("\"kind\"", "\"observe\": [\"tilt(cup)\", \"fill(cup)\"], \"kind\"", "observe[1]", "does not follow from poses"),
    ("\"kind\"", "\"observe\": [\"tilt(jug)\"], \"kind\"", "observe", "`jug` is no object of the file"),
];

#[test]
fn a_mistake_in_the_poses_is_told_with_file_line_and_key() {
    for (from, to, key, expected) in MISTAKES {
        let copies = copies("poses");
        let path = copies.path().join(ONE);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{from}");
        fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let message = refused(copies.path(), &["learn", ONE, TWO], 2);
        assert!(message.starts_with(&format!("error: {ONE}:")), "{message}");
        assert!(message.contains(&format!("key `{key}`")) && message.contains(expected), "{key}: {message}");
    }
    // Without `objects` what is seen decides the features.
    let copies = copies("poses");
    for name in FILES {
        let path = copies.path().join(name);
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, text.replacen("  \"objects\": [\"cup\", \"lid\", \"tray\"],\n", "", 1)).unwrap();
    }
    let message = refused(copies.path(), &["learn", ONE, TWO, "--correct", LID], 2);
    assert!(message.contains("name all objects of the task under `objects` in every file"), "{message}");
}

#[test]
fn a_model_that_is_none_is_refused_with_its_line() {
    let copies = copies("demonstrations");
    said(copies.path(), &["learn", ONE, TWO, "--out", "model.json"]);
    let text = fs::read_to_string(copies.path().join("model.json")).unwrap();
    for (from, to, key, expected) in [
        ("\"version\": 1", "\"version\": 2", "version", "expected 1"),
        ("\"version\": 1,", "", "version", "learn it anew"),
        ("\"method\": \"situ\"", "\"method\": \"nearest\"", "method", "cannot be read again"),
        ("\"segments\": 2", "\"pieces\": 2", "demonstrations[0].pieces", "unknown field"),
        ("\"lift\": \"QuadraticDiagonal\"", "\"lift\": \"Linear\"", "model.end.classifier", "expected finite numbers"),
        ("\"next\": 2", "\"next\": 0", "model.next", "more than the greatest node"),
        ("\"name\": \"cup_x\"", "\"name\": \"cup_y\"", "schema", "appears twice"),
    ] {
        assert!(text.contains(from), "{from}");
        fs::write(copies.path().join("other.json"), text.replacen(from, to, 1)).unwrap();
        let message = refused(copies.path(), &["ask", "other.json", "{\"do\": \"graph\"}"], 2);
        assert!(message.contains(expected), "{message}");
        let is_placed = message.starts_with("error: other.json:") && message.contains(&format!("key `{key}"));
        assert!(is_placed, "{key}: {message}");
    }
}

#[test]
fn the_cost_of_ones_own_corrections_is_held() {
    let copies = copies("demonstrations");
    said(copies.path(), &["learn", ONE, TWO, "--out", "model.json"]);
    let cost = ["cost", "--model", "model.json", "--correct", LID];
    let call = |more: &[&str]| program(copies.path(), &[&cost, more].concat());
    let minted = said(copies.path(), &[&cost[..], &["--mint"]].concat());
    for expected in
        ["| correction             | lid-first     |", "| node-addition |", "| hmm fits ", "model.cost.json"]
    {
        assert!(minted.contains(expected), "{minted}");
    }
    let text = |output: &Output| String::from_utf8_lossy(&output.stdout).into_owned();
    let same = call(&["--check"]);
    assert!(same.status.success() && text(&same).contains("unchanged    lid-first"), "{}", text(&same));
    let path = copies.path().join("model.cost.json");
    let baseline = fs::read_to_string(&path).unwrap();
    let mut value: Value = serde_json::from_str(&baseline).unwrap();
    let fits = &mut value["rows"][0]["counters"]["hmm_fits"];
    *fits = json!(fits.as_u64().unwrap() - 1);
    fs::write(&path, value.to_string()).unwrap();
    let worse = call(&["--check"]);
    assert_eq!(worse.status.code(), Some(1), "{}", text(&worse));
    assert!(text(&worse).contains("regressed    lid-first: hmm_fits"), "{}", text(&worse));
    // Of another model there is nothing to say.
    said(copies.path(), &["learn", TWO, "--out", "model.json"]);
    let other = call(&["--check"]);
    assert!(other.status.success() && text(&other).contains("of another model"), "{}", text(&other));
    let without = program(copies.path(), &["cost", "--model", "model.json"]);
    assert_eq!(without.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&without.stderr).contains("--correct"));
}

/// Every tag that is opened is closed, and each primitive is a leaf.
#[test]
fn a_behaviour_tree_is_the_automaton() {
    let copies = copies("demonstrations");
    said(copies.path(), &["learn", ONE, TWO, "--correct", LID, "--tree", "tree.xml"]);
    let xml = fs::read_to_string(copies.path().join("tree.xml")).unwrap();
    let mut open = Vec::new();
    for tag in xml.split('<').skip(1).filter(|tag| !tag.starts_with(['?', '!'])) {
        let (tag, _) = tag.split_once('>').expect("a tag ends");
        let name = tag.trim_start_matches('/').split([' ', '/']).next().unwrap();
        match (tag.starts_with('/'), tag.ends_with('/')) {
            (true, _) => assert_eq!(open.pop(), Some(name), "{xml}"),
            (false, false) => open.push(name),
            (false, true) => {}
        }
    }
    assert!(open.is_empty(), "{open:?}");
    for leaf in ["place=\"z0\" reference=\"cup\"", "place=\"z1\" reference=\"tray\"", "place=\"z2\" reference=\"lid\""]
    {
        assert_eq!(xml.matches(&format!("<ExecutePrimitive {leaf} ways=\"1\"/>")).count(), 1, "{leaf}");
    }
    assert!(xml.contains("<ChooseNext after=\"START\" among=\"z0;z2\" next=\"{next}\"/>"), "{xml}");
    assert!(xml.contains("<ChooseNext after=\"z1\" among=\"END\" next=\"{next}\"/>"), "{xml}");
}

#[test]
fn the_originals_say_what_stands_out() {
    let copies = copies("demonstrations");
    let learn = |words: &[&str]| said(copies.path(), &[&["learn"], words].concat());
    let two = learn(&[ONE, TWO]);
    assert!(
        two.contains("right in 6 of 6 choices;\n    0 more are of primitives that no other original shows"),
        "{two}"
    );
    assert!(two.contains("primitives of one segment: 0 of 2\n"), "{two}");
    assert!(two.contains("keyframes that are alone: 0\n"), "{two}");
    assert!(learn(&[ONE]).contains("one original: show the task once more"));
    assert!(!learn(&[ONE, TWO, "--without-diagnosis"]).contains("what the originals say"));
    // A third one with a detour beside the way to the cup.
    let mut third: Value = serde_json::from_str(&fs::read_to_string(copies.path().join(ONE)).unwrap()).unwrap();
    third["name"] = json!("detour");
    let keyframes = third["keyframes"].as_array_mut().unwrap();
    let mut beside = keyframes[0].clone();
    beside["gripper_pose"]["position"][1] = json!(0.25);
    keyframes.insert(1, beside);
    fs::write(copies.path().join("detour.json"), third.to_string()).unwrap();
    let three = learn(&[ONE, TWO, "detour.json"]);
    assert!(three.contains("detour, keyframes[1]: 0.128 m"), "{three}");
}

/// The commands of the page about one's own robot, in its order.
#[test]
fn the_commands_of_the_page_run() {
    const PAGE: &str = include_str!("../../docs/robot.md");
    let copies = copies("poses");
    let commands: Vec<&str> = PAGE.lines().filter_map(|line| line.strip_prefix("situ-bench ")).collect();
    for command in &commands {
        let words: Vec<&str> = match command.split_once('\'') {
            Some((words, quoted)) => words.split_whitespace().chain([quoted.trim_end_matches('\'')]).collect(),
            None => command.split_whitespace().collect(),
        };
        said(copies.path(), &words);
    }
    assert_eq!(commands.len(), 6, "{commands:?}");
}

/// A correction that does not lead back to what is known would be done for ever, and `learn` says so.
#[test]
fn a_correction_that_begins_again_is_told() {
    let copies = copies("demonstrations");
    let path = copies.path().join(LID);
    let mut shown: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    // After the cup was taken, the lid is taken off and the cup is taken again; but the state says that it is still on.
    shown["final_state"] = shown["keyframes"][0]["state"].clone();
    shown["after"] = json!({"demonstration": "serve-1", "segment": 0});
    fs::write(&path, shown.to_string()).unwrap();
    let again = said(copies.path(), &["learn", ONE, TWO, "--correct", LID, "--out", "model.json"]);
    let state = &shown["final_state"];
    let ask = json!({"do": "next", "last": "z0", "state": state}).to_string();
    let told: Value = serde_json::from_str(&said(copies.path(), &["ask", "model.json", &ask])).unwrap();
    assert_eq!(told["children"][0]["place"], "z2", "the model goes back: {told}");
    assert!(again.contains("careful: in the state in which it ends, the model would do z2 again"), "{again}");
    assert!(!said(copies.path(), &["learn", ONE, TWO]).contains("careful"));
}

/// A program of one's own is told again what its model was told.
#[test]
fn a_model_of_another_program_is_told_again() {
    let copies = copies("demonstrations");
    let methods = Path::new(env!("CARGO_MANIFEST_DIR")).join("python/examples/methods.toml");
    let own = ["--methods", methods.to_str().unwrap()];
    let learn = |words: &[&str]| said(copies.path(), &[&["learn"], words, &own].concat());
    let text = |name: &str| fs::read_to_string(copies.path().join(name)).unwrap();
    learn(&[ONE, TWO, "--correct", LID, "--method", "nearest_python", "--out", "all.json"]);
    learn(&[ONE, TWO, "--method", "nearest_python", "--out", "model.json"]);
    learn(&["--model", "model.json", "--correct", LID, "--out", "model.json"]);
    assert!(text("model.json") == text("all.json"));
    let message = refused(copies.path(), &["ask", "model.json", "{\"do\": \"graph\"}"], 2);
    assert!(message.contains("no method is called `nearest_python`"), "{message}");
}
