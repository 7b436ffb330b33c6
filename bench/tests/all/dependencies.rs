//! Which crate of this workspace may know which, held against what Cargo says.
//!
//! The learning crate must be usable without the table, a task without a learner, and nothing may lean on the harness.
//! Dependencies of tests and builds count as well, because they would be a way around the rule.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use cargo_metadata::MetadataCommand;

/// Each crate of the workspace and the crates of the workspace that it names.
fn direct() -> BTreeMap<String, BTreeSet<String>> {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("../Cargo.toml");
    let metadata =
        MetadataCommand::new().manifest_path(manifest).no_deps().exec().expect("cargo describes the workspace");
    let packages = metadata.workspace_packages();
    let names: BTreeSet<String> = packages.iter().map(|package| package.name.to_string()).collect();
    let known = |package: &cargo_metadata::Package| {
        let dependencies = package.dependencies.iter().map(|dependency| dependency.name.clone());
        dependencies.filter(|name| names.contains(name)).collect()
    };
    packages.iter().map(|package| (package.name.to_string(), known(package))).collect()
}

fn reachable(direct: &BTreeMap<String, BTreeSet<String>>, from: &str) -> BTreeSet<String> {
    let mut reached = BTreeSet::new();
    let mut open = vec![from.to_owned()];
    while let Some(name) = open.pop() {
        for next in &direct[&name] {
            if reached.insert(next.clone()) {
                open.push(next.clone());
            }
        }
    }
    reached
}

#[test]
fn the_workspace_is_the_five_crates() {
    let names: Vec<String> = direct().into_keys().collect();
    assert_eq!(names, ["situ", "situ-bench", "situ-sim", "situ-tasks", "situ-teachers"]);
}

#[test]
fn nobody_knows_whom_it_must_not() {
    let direct = direct();
    let forbidden = [
        ("situ", "situ-sim", "the learner knows no physics"),
        ("situ", "situ-tasks", "the learner knows no task"),
        ("situ", "situ-teachers", "the learner knows no teacher"),
        ("situ-tasks", "situ", "a task knows no learner"),
        ("situ-tasks", "situ-teachers", "a task knows no teacher"),
        ("situ-sim", "situ-tasks", "the table knows no task"),
        ("situ-sim", "situ", "the table knows no learner"),
        ("situ-sim", "situ-teachers", "the table knows no teacher"),
        ("situ", "situ-bench", "nothing leans on the harness"),
        ("situ-sim", "situ-bench", "nothing leans on the harness"),
        ("situ-tasks", "situ-bench", "nothing leans on the harness"),
        ("situ-teachers", "situ-bench", "nothing leans on the harness"),
    ];
    for (from, to, why) in forbidden {
        assert!(!reachable(&direct, from).contains(to), "{from} reaches {to}: {why}");
    }
}

#[test]
fn a_teacher_stands_between_learner_and_task() {
    let direct = direct();
    for to in ["situ", "situ-tasks"] {
        assert!(direct["situ-teachers"].contains(to), "situ-teachers does not name {to}");
    }
    assert!(direct["situ-tasks"].contains("situ-sim"));
}
