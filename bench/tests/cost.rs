//! The verb `cost`: the baseline that it mints is one that it agrees with, and a work that grew is a failure that says where.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const PROTOCOL: &str = r#"
name = "small"
analysis = "The update cost of the smallest automaton: a test."
tasks = []
teachers = ["novice"]
methods = ["situ"]
seeds = 1
target = 0.9
rollouts = 1
confidence = 0.3
execution = "sample"

[budget]
least_originals = 3
originals = 3
corrections = 1
from_scratch = 1

[[cost]]
series = "nodes"
methods = ["situ", "rebuild"]
nodes = [10]
seeds = 1
"#;

fn cost(folder: &Path, more: &[&str]) -> Output {
    let words = ["cost", "--protocol", "small.toml", "--baseline", "baseline.json", "--without-instructions"];
    Command::new(env!("CARGO_BIN_EXE_situ-bench")).args(words).args(more).current_dir(folder).output().unwrap()
}

#[test]
fn what_was_minted_is_agreed_with_and_what_grew_is_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("small.toml"), PROTOCOL).unwrap();
    let said = |output: &Output| String::from_utf8_lossy(&output.stdout).into_owned();

    let missing = cost(folder, &["--check"]);
    assert_eq!(missing.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&missing.stderr).contains("baseline.json"));

    let minted = cost(folder, &["--mint"]);
    assert!(minted.status.success(), "{}", String::from_utf8_lossy(&minted.stderr));
    let baseline = fs::read_to_string(folder.join("baseline.json")).unwrap();
    let checked = cost(folder, &["--check"]);
    assert!(checked.status.success());
    assert!(said(&checked).contains("improved 0, regressed 0, unchanged 8, incomparable 0"), "{}", said(&checked));
    assert!(said(&checked).contains("T4 crossover") && said(&checked).contains("valgrind"), "{}", said(&checked));

    // One iteration of EM fewer in the baseline is one more now.
    let line = baseline.lines().find(|line| line.contains("\"em_iterations\"")).unwrap();
    let number: u64 = line.trim().trim_start_matches("\"em_iterations\": ").trim_end_matches(',').parse().unwrap();
    let less = baseline.replacen(&number.to_string(), &(number - 1).to_string(), 1);
    assert_ne!(less, baseline);
    fs::write(folder.join("baseline.json"), less).unwrap();
    let checked = cost(folder, &["--check"]);
    assert_eq!(checked.status.code(), Some(1));
    assert!(said(&checked).contains(&format!("em_iterations {} → {number}", number - 1)), "{}", said(&checked));

    // A protocol without a cost series has nothing to measure.
    fs::write(folder.join("small.toml"), PROTOCOL.split("[[cost]]").next().unwrap().replace("[]", "[\"pour\"]"))
        .unwrap();
    let refused = cost(folder, &[]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("no cost series"));
}
