//! What is learned from demonstrations that people gave on real arms.
//!
//! The recordings are not part of this repository. `SITU_RECORDED` names their folder; where it is not set, nothing is
//! tested, and a line says so.

use std::path::{Path, PathBuf};

use situ::method::named;
use situ_bench::cmd::learn::{Learning, learn};
use situ_bench::demonstration_file::DemonstrationFile;

/// The folder of the recordings.
fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("SITU_RECORDED").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: SITU_RECORDED does not name the folder of the recordings");
    }
    folder
}

fn learned(folder: &Path, originals: &[&str], corrections: &[&str]) -> Learning {
    let read = |names: &[&str]| -> Vec<DemonstrationFile> {
        names.iter().map(|name| DemonstrationFile::read(&folder.join(format!("{name}.json"))).unwrap()).collect()
    };
    learn(named("situ").unwrap(), &read(originals), &read(corrections), 0).unwrap()
}

#[test]
fn a_cube_in_a_box_on_a_yumi_is_two_primitives() {
    let Some(folder) = folder() else { return };
    let shown = ["cube_in_box-1", "cube_in_box-2", "cube_in_box-3"];
    let graph = learned(&folder.join("yumi_cube_in_box"), &shown, &[]).kept.learned.graph().unwrap();
    assert_eq!((graph.nodes.len(), graph.edges.len()), (2, 3));
}

#[test]
fn a_pour_on_a_sawyer_is_one_primitive_and_the_first_repair_modifies_it() {
    let Some(folder) = folder() else { return };
    let poor = ["poor-1", "poor-2", "poor-3"];
    for repair in ["good-0", "good-3", "constrained"] {
        let learning = learned(&folder.join("sawyer_pour"), &poor, &[repair]);
        let graph = learning.kept.learned.graph().unwrap();
        assert_eq!((graph.nodes.len(), graph.edges.len(), graph.nodes[0].paths.len()), (1, 2, 2), "{repair}");
        let made = &learning.corrections[0].difference;
        assert!(made.nodes_added.is_empty() && made.edges_added.is_empty(), "{repair}: {made:?}");
        assert_eq!(made.nodes_modified.len(), 1, "{repair}");
    }
}
