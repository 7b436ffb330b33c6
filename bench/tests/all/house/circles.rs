//! Which file of a crate knows which other, and the circles among them.

use std::collections::{BTreeMap, BTreeSet};

use crate::house::modules::Modules;
use crate::house::tree::Crate;

/// From a file to the files that it knows, with the names that it takes of each.
pub(crate) type Graph = BTreeMap<String, BTreeMap<String, BTreeSet<String>>>;

/// The files of a crate and what they import. A `mod` is no import, nor is a child's name that a module only hands on.
pub(crate) fn graph(of: &Crate) -> Graph {
    let mut graph = Graph::new();
    for root in ["lib.rs", "main.rs"] {
        if let Some(modules) = Modules::read(of, &format!("{}/src/{root}", of.name)) {
            add(&modules, &mut graph);
        }
    }
    graph
}

fn add(modules: &Modules, graph: &mut Graph) {
    for (number, module) in modules.all.iter().enumerate() {
        let mut tie = |target: usize, name: String| {
            let file = &modules.all[target].file;
            if *file != module.file {
                graph.entry(module.file.clone()).or_default().entry(file.clone()).or_default().insert(name);
            }
        };
        let first_words: BTreeSet<&String> = module.paths.iter().filter_map(|path| path.first()).collect();
        for import in &module.imports {
            let Some((target, name)) = modules.resolve(number, &import.path) else { continue };
            let used = import.name.as_ref().is_some_and(|name| first_words.contains(name));
            if !import.handed_on || used || !modules.is_below(target, number) {
                tie(target, name);
            }
        }
        for path in module.paths.iter().filter(|path| path.len() > 1) {
            if let Some((target, name)) = modules.resolve(number, path) {
                tie(target, name);
            }
        }
    }
}

/// Sets of files that know each other in a circle, and each tie: "from -> to: names".
pub(crate) fn circles(graph: &Graph) -> Vec<(BTreeSet<String>, Vec<String>)> {
    let reached: BTreeMap<&String, BTreeSet<&String>> =
        graph.keys().map(|file| (file, reachable(graph, file))).collect();
    let mutual = |one: &String, other: &String| {
        reached[one].contains(other) && reached.get(other).is_some_and(|back| back.contains(one))
    };
    let sets: BTreeSet<BTreeSet<String>> = graph
        .keys()
        .map(|file| graph.keys().filter(|other| mutual(file, other)).cloned().collect())
        .filter(|set: &BTreeSet<String>| set.len() > 1)
        .collect();
    sets.into_iter().map(|set| (ties(graph, &set), set)).map(|(ties, set)| (set, ties)).collect()
}

fn reachable<'a>(graph: &'a Graph, from: &String) -> BTreeSet<&'a String> {
    let mut reached = BTreeSet::new();
    let mut open: Vec<&String> = graph[from].keys().collect();
    while let Some(file) = open.pop() {
        if reached.insert(file) {
            open.extend(graph.get(file).into_iter().flat_map(BTreeMap::keys));
        }
    }
    reached
}

fn ties(graph: &Graph, set: &BTreeSet<String>) -> Vec<String> {
    let mut ties = Vec::new();
    for from in set {
        for (to, names) in graph[from].iter().filter(|(to, _)| set.contains(*to)) {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            ties.push(format!("{from} -> {to}: {}", names.join(", ")));
        }
    }
    ties
}
