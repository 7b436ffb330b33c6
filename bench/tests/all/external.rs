//! External methods: the examples in Python do what they should, and whatever a program does, its run is recorded as
//! that, the sweep goes on, and nothing is left running.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use situ_bench::ledger;
use situ_bench::record::{Outcome, Record, RunRecord};

use crate::small;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

/// Whether the examples can be run at all.
fn has_python() -> bool {
    let found = Command::new("python3").arg("--version").output().is_ok_and(|output| output.status.success());
    if !found {
        println!("skipped: there is no python3 here");
    }
    found
}

/// A file of methods in a folder: the faulty one with each of these faults, under its name.
fn methods(folder: &Path, faults: &[&str], more: &str) -> PathBuf {
    let (tests, sources) = (root().join("python/tests/faulty.py"), root().join("python/src"));
    let entry = |fault: &&str| {
        format!(
            "[[method]]\nname = \"{fault}\"\ncommand = [\"python3\", {tests:?}, \"{fault}\"]\n\
             env = {{ PYTHONPATH = {sources:?} }}\n{more}\n"
        )
    };
    let path = folder.join("methods.toml");
    fs::write(&path, faults.iter().map(entry).collect::<String>()).unwrap();
    path
}

/// Runs methods on one variation.
fn run(folder: &Path, file: &Path, methods: &[&str], more: &[&str]) -> Output {
    let protocol = folder.join("small.toml");
    let text =
        small::physics("[\"nearest\"]").replace("joint = [\"situ\"]\n", "").replace("target = 0.5", "target = 1.0");
    fs::write(&protocol, text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_situ-bench"));
    command
        .args(["run", "--variation", "bump", "--out", "made", "--protocol"])
        .arg(&protocol)
        .arg("--methods")
        .arg(file);
    for method in methods {
        command.args(["--method", method]);
    }
    command.args(more).current_dir(folder).output().unwrap()
}

fn records(folder: &Path) -> Vec<RunRecord> {
    let records = ledger::read(&folder.join("made/ledger.jsonl")).unwrap().records;
    let without_times = records.iter().map(Record::without_times);
    without_times.filter_map(|record| if let Record::Run(run) = record { Some(run) } else { None }).collect()
}

fn of<'a>(runs: &'a [RunRecord], name: &str) -> &'a RunRecord {
    runs.iter().find(|run| run.key.method == name).unwrap_or_else(|| panic!("no run of {name}"))
}

/// The example in Python, by one process and by two, saved or told again, from a model of its own or of another, is the
/// one in Rust: number for number.
#[test]
fn the_nearest_neighbour_in_python_gives_the_ledger_of_that_in_rust() {
    if !has_python() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let example = root().join("python/examples/methods.toml");
    for (more, jobs) in [("processes = 1", "1"), ("processes = 2", "2")] {
        let _ = fs::remove_dir_all(folder.path().join("made"));
        let file = methods(folder.path(), &["none", "unsaved", "heir", "modest"], more);
        let own = example.to_str().unwrap();
        let names = ["nearest", "nearest_python", "none", "unsaved", "heir", "modest"];
        let output = run(folder.path(), &file, &names, &["--methods", own, "--jobs", jobs]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let runs = records(folder.path());
        let expected = of(&runs, "nearest");
        assert!(!expected.corrections.is_empty(), "it is corrected");
        for name in &names[1..] {
            let mut own = of(&runs, name).clone();
            own.key.method = expected.key.method.clone();
            assert_eq!(own, *expected, "{name}, {jobs} threads");
        }
    }
}

#[test]
fn whatever_a_program_does_is_recorded_and_the_sweep_goes_on() {
    if !has_python() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let expected = [
        ("refuse", "it does not like"),
        ("crash", "its last words: "),
        ("exit", "it has ended"),
        ("hang", "asked `correct`: no answer within 5 s"),
        ("late", "asked `next`: no answer within 5 s"),
        ("nan", "asked `next`: expected a line of JSON, which has no NaN"),
        ("improbable", "the answer to `next`: probability 1.5: expected 0 to 1"),
        ("nowhere", "the answer to `next`: `nowhere` is no node of the last `graph`"),
        ("unsorted", "the answer to `next`: expected the likeliest first"),
        ("graph", "the answer to `graph`: an edge to or from `p77`"),
        ("counter", "counters: "),
        ("edit", "unknown variant `somersault`"),
        ("keyframes", "keyframes, expected at most"),
    ];
    let faults: Vec<&str> = expected.iter().map(|(fault, _)| *fault).collect();
    let file = methods(folder.path(), &faults, "correct = 5.0\nask = 5.0");
    let all: Vec<&str> = faults.iter().copied().chain(["nearest"]).collect();
    let output = run(folder.path(), &file, &all, &["--jobs", "2"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let runs = records(folder.path());
    assert_eq!(runs.len(), all.len());
    for (fault, words) in expected {
        let outcome = &of(&runs, fault).outcome;
        assert!(matches!(outcome, Outcome::MethodError { why } if why.contains(words)), "{fault}: {outcome:?}");
    }
    assert!(
        matches!(of(&runs, "crash").outcome, Outcome::MethodError { ref why } if why.contains("a mistake of mine"))
    );
    assert!(!matches!(of(&runs, "nearest").outcome, Outcome::MethodError { .. }), "the sound one is as ever");
    let log = fs::read_to_string(folder.path().join("made/logs/crash.log")).unwrap();
    assert!(log.contains("about to crash") && log.contains("Traceback"), "{log}");
    assert_eq!(still_running(folder.path()), Vec::<String>::new());
}

/// Processes whose command names this folder's parent of faults, or that a fault has started.
#[cfg(target_os = "linux")]
fn still_running(_: &Path) -> Vec<String> {
    let processes = fs::read_dir("/proc").unwrap().filter_map(Result::ok);
    let commands = processes.filter_map(|entry| fs::read(entry.path().join("cmdline")).ok());
    let text = commands.map(|command| String::from_utf8_lossy(&command).replace('\0', " "));
    text.filter(|command| command.contains("faulty.py hang") || command.trim() == "sleep 1000").collect()
}

#[cfg(not(target_os = "linux"))]
fn still_running(_: &Path) -> Vec<String> {
    Vec::new()
}

/// The page's own example does what every method owes, and so does the one in the examples; a faulty one does not.
#[test]
fn the_example_of_the_page_does_what_every_method_owes() {
    if !has_python() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let page = fs::read_to_string(root().join("docs/methods.md")).unwrap();
    let block =
        |kind: &str| page.split(&format!("```{kind}\n")).nth(1).unwrap().split("```").next().unwrap().to_owned();
    let code = block("python");
    assert!(code.lines().filter(|line| !line.trim().is_empty()).count() <= 30, "it is short");
    fs::write(folder.path().join("mine.py"), code).unwrap();
    let sources = root().join("python/src").display().to_string();
    fs::write(folder.path().join("mine.toml"), block("toml").replace("bench/python/src", &sources)).unwrap();
    let check = |file: &Path, name: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_situ-bench"));
        command.args(["check", "--method", name, "--methods"]).arg(file).current_dir(folder.path()).output().unwrap()
    };
    let example = root().join("python/examples/methods.toml");
    for (file, name) in [(folder.path().join("mine.toml"), "mine"), (example, "nearest_python")] {
        let output = check(&file, name);
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && said.contains("A call takes"), "{said}");
    }
    let faults = methods(folder.path(), &["nan", "crash", "graph", "deaf"], "");
    for (fault, finding) in [
        ("nan", "wrong: it learns from corrections: a correction that needs node-addition: nan: asked `next`"),
        ("crash", "wrong: it learns from corrections: a correction that needs node-addition: crash: asked `correct`"),
        ("graph", "the answer to `graph`: an edge to or from `p77`"),
        ("deaf", "wrong: a correction changes what it answers: a correction that needs node-addition: every answer"),
    ] {
        let output = check(&faults, fault);
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.code() == Some(1) && said.contains(finding), "{said}\nexpected {finding}");
    }
}

#[test]
fn a_program_that_does_not_say_what_it_is_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [
        ("[\"no-such-program\"]", "methods.toml:3: `method[0].command`: `mine`: `no-such-program` cannot be started"),
        ("[\"true\"]", "`mine`: asked `hello`: it has ended"),
        ("[\"echo\", \"hello\"]", "expected a line of JSON"),
        ("[\"echo\", \"{\\\"id\\\": 1}\"]", "the answer to `hello`: missing field `summary`"),
        ("[\"sh\", \"-c\", \"echo oh dear >&2; exec sleep 9\"]", "no answer within 0.5 s; its last words: oh dear"),
    ];
    for (command, words) in cases {
        let file = folder.path().join("methods.toml");
        fs::write(&file, format!("[[method]]\nname = \"mine\"\ncommand = {command}\nstart = 0.5\n")).unwrap();
        let output = run(folder.path(), &file, &["mine"], &[]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(words), "{command}: {said}\nexpected {words}");
        assert!(!folder.path().join("made").exists(), "nothing is left behind");
    }
    // A check of tasks asks no method.
    let mut command = Command::new(env!("CARGO_BIN_EXE_situ-bench"));
    let output = command.args(["check", "pour", "--methods", "methods.toml"]).current_dir(&folder).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && said.contains("--methods: no method takes part"), "{said}");
}
