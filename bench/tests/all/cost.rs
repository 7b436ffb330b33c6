//! The verb `cost`: it agrees with the baseline that it has minted. Where work grew, it fails and says where.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::small;

/// The methods whose updates are measured.
const METHODS: &str = r#"["situ", "rebuild"]"#;

/// The protocol's runs must be those of the folder `published`, and so must its tables, all but the times.
#[test]
fn a_run_is_checked_against_published_records_and_tables() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("small.toml"), small::costs(METHODS)).unwrap();
    let run = |more: &[&str]| {
        let words = ["run", "--protocol", "small.toml", "--out"];
        Command::new(env!("CARGO_BIN_EXE_situ-bench")).args(words).args(more).current_dir(folder).output().unwrap()
    };
    let said = |output: Output| String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
    assert!(run(&["published"]).status.success());
    let checked = run(&["again", "--check", "published"]);
    assert!(checked.status.success(), "the times differ and nothing else: {}", said(checked));

    let change = |file: &str, from: &str, to: &str| {
        let path = folder.join("published").join(file);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{file} has no {from}:\n{text}");
        fs::write(path, text.replacen(from, to, 1)).unwrap();
    };
    change("t4_scaling.csv", "small,nodes,situ,edge-addition,10,3,1,", "small,nodes,situ,edge-addition,10,3,2,");
    let checked = run(&["changed", "--check", "published"]);
    assert_eq!(checked.status.code(), Some(1));
    let message = said(checked);
    assert!(message.contains("1 tables differ from the checked folder, the first: t4_scaling.csv"), "{message}");
    change("ledger.jsonl", "\"nodes\":10", "\"nodes\":11");
    let checked = run(&["other", "--check", "published"]);
    assert_eq!(checked.status.code(), Some(1));
    let message = said(checked);
    assert!(
        message.contains("2 records differ from the checked folder, the first: small, nodes, cost of"),
        "{message}"
    );
}

fn cost(folder: &Path, more: &[&str]) -> Output {
    let words = ["cost", "--protocol", "small.toml", "--baseline", "baseline.json", "--without-instructions"];
    Command::new(env!("CARGO_BIN_EXE_situ-bench")).args(words).args(more).current_dir(folder).output().unwrap()
}

#[test]
fn what_was_minted_is_agreed_with_and_what_grew_is_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("small.toml"), small::costs(METHODS)).unwrap();
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
    assert!(said(&checked).contains("t4.md: ") && said(&checked).contains("valgrind"), "{}", said(&checked));

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
    fs::write(
        folder.join("small.toml"),
        small::costs(METHODS).split("[[cost]]").next().unwrap().replace("[]", "[\"pour\"]"),
    )
    .unwrap();
    let refused = cost(folder, &[]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("no cost series"));
}
