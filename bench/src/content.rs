//! What a run is made of, as a hash: the names of a run say which it is, and its content what these names stood for.
//!
//! The content of a run in physics is the first 16 digits of the SHA-256 of this text, of which every line ends with a
//! line feed:
//!
//! ```text
//! settings HASH
//! plant NAME
//! task HASH
//! teacher HASH
//! ```
//!
//! The hashes are of the files of the task and the teacher, and of what the protocol says about each of its runs: its
//! text as canonical TOML, without comments, without its name and prose, and without the keys that choose which runs
//! there are. So a protocol that gets more seeds has the same runs as before, and more; one with another budget has
//! others. The text of a task that uses meshes is that of its file and a line of comment for each mesh, with the
//! SHA-256 of the mesh's file ([`situ_tasks::Registry::text`]). The content of an update of a synthetic automaton is
//! its names: they say all of it.

use situ_tasks::Plant;

use crate::digest::hash;
use crate::protocol::Protocol;

/// The keys of a protocol that say nothing about a single run.
const CHOOSING: [&str; 10] =
    ["name", "analysis", "tasks", "variations", "teachers", "methods", "sequences", "grade", "seeds", "first_seed"];

/// The digits of a content: a hundred million runs have one chance in a thousand of two that are equal.
const DIGITS: usize = 16;

/// The content of the runs of a task and a teacher under a protocol, by the texts of their files.
pub fn of(protocol: &Protocol, plant: Plant, task: &str, teacher: &str) -> String {
    let plant = match plant {
        Plant::Arm => "arm",
        Plant::Hand => "hand",
    };
    let lines = [
        ("settings", hash(settings(protocol))),
        ("plant", plant.to_owned()),
        ("task", hash(task)),
        ("teacher", hash(teacher)),
    ];
    let text: String = lines.iter().map(|(name, value)| format!("{name} {value}\n")).collect();
    hash(text)[..DIGITS].to_owned()
}

/// What a protocol says about each of its runs.
fn settings(protocol: &Protocol) -> String {
    let mut table: toml::Table = protocol.source.parse().expect("the protocol was read from it");
    CHOOSING.into_iter().chain(["cost"]).for_each(|key| drop(table.remove(key)));
    // The tables of this library are in the order of their keys.
    toml::to_string(&table).expect("what was read can be written")
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn the_content_is_of_what_a_run_is_made_of() {
        let quick = Protocol::find("quick").unwrap();
        let edited = |from: &str, to: &str| {
            assert!(quick.source.contains(from), "{from}");
            Protocol::parse(&quick.source.replace(from, to), Path::new("edited.toml")).unwrap()
        };
        let content = |protocol: &Protocol| of(protocol, Plant::Arm, "task", "teacher");
        let own = content(&quick);
        assert_eq!(own.len(), DIGITS);
        // Which runs there are, and what is said about them, is no part of a run.
        for same in [edited("seeds = 1\n", "seeds = 3\n"), edited("name = \"quick\"", "# Two.\nname = \"other\"")] {
            assert_eq!(content(&same), own);
        }
        let target = format!("target = {:?}", quick.target);
        for other in [edited(&target, "target = 0.5"), edited("[budget]", "[budget]\nsteps = 1000")] {
            assert_ne!(content(&other), own);
        }
        let others = [
            of(&quick, Plant::Hand, "task", "teacher"),
            of(&quick, Plant::Arm, "task\n", "teacher"),
            of(&quick, Plant::Arm, "task", "teacher\n"),
        ];
        assert!(others.iter().all(|other| *other != own));
    }
}
