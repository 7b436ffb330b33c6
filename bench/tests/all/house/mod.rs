//! The rules of the house, held against its source; and the figures that say how far it keeps them.
//!
//! A reader finds their way where the files of a crate stand above each other, where a function fits a screen and takes
//! few arguments, where one name is one type, and where a comment fits a line. This test reads every file of the
//! workspace, prints the figures, and fails with a list of those who fall short. `SITU_HOUSE` names another workspace
//! to read. The table:
//!
//! ```text
//! cargo test -p situ-bench --test all house -- --nocapture
//! ```

use std::path::{Path, PathBuf};

mod circles;
mod figures;
mod functions;
mod lines;
mod modules;
mod planted;
mod tree;
mod types;

use figures::{Figures, figures, twin_names};
use tree::House;

fn workspace() -> House {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    House::read(&std::env::var_os("SITU_HOUSE").map_or(here, PathBuf::from))
}

fn table(all: &[Figures], twins: usize) -> String {
    let head = ["", "files", "code", "circles", "arguments", "long", "in tests", "comments", "prose"];
    let mut table: String = head.iter().map(|word| format!("{word:>11}")).collect();
    let row = |of: &[Figures], name: &str| {
        let sum = |count: fn(&Figures) -> usize| of.iter().map(count).sum::<usize>();
        let cells = [
            sum(|of| of.files),
            sum(|of| of.code),
            sum(|of| of.circles.len()),
            sum(|of| of.wide.len()),
            sum(|of| of.long.len()),
            sum(|of| of.long_tests.len()),
            sum(|of| of.comments.len()),
            sum(|of| of.prose.len()),
        ];
        format!("\n{name:>11}") + &cells.map(|cell| format!("{cell:>11}")).concat()
    };
    for of in all {
        table += &row(std::slice::from_ref(of), of.name.trim_start_matches("synth_"));
    }
    table + &row(all, "sum") + &format!("\npublic type names that stand more than once: {twins}")
}

/// Public type names that may stand more than once, each with its reason.
const TWIN_NAMES: [(&str, &str); 1] =
    [("Pose", "one type of nalgebra, named in two crates of which neither may know the other")];

#[test]
fn the_house_keeps_its_rules() {
    let house = workspace();
    let all = figures(&house);
    let mut twins = twin_names(&house);
    for (name, reason) in TWIN_NAMES {
        let found = twins.iter().position(|twin| twin.split(':').next() == Some(name));
        let found = found.unwrap_or_else(|| panic!("{name} stands once now, and needs no reason ({reason})"));
        twins.remove(found);
    }
    let each = |list: fn(&Figures) -> &Vec<String>| all.iter().flat_map(list).cloned().collect::<Vec<String>>();
    let circles: Vec<String> = all.iter().flat_map(|of| &of.circles).map(|(_, ties)| ties.join("\n    ")).collect();
    println!("{}", table(&all, twins.len()));
    let rules = [
        ("circles of files", circles),
        ("functions with too many arguments", each(|of| &of.wide)),
        ("functions that do not fit a screen", each(|of| &of.long)),
        ("lines with a comment that are too wide", each(|of| &of.comments)),
        ("lines of Markdown that are too wide", each(|of| &of.prose)),
        ("public type names that stand more than once", twins),
    ];
    let broken: Vec<String> = rules
        .iter()
        .filter(|(_, found)| !found.is_empty())
        .map(|(rule, found)| format!("{rule}: {}\n  {}", found.len(), found.join("\n  ")))
        .collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}
