//! What the rules of the house are held against: a crate's figures, and who falls short.

use std::collections::BTreeSet;

use crate::house::circles::{circles, graph};
use crate::house::functions::{Function, functions};
use crate::house::modules::Modules;
use crate::house::tree::{Crate, House};
use crate::house::types::twins;

/// Columns of a line with a comment, its indentation included.
pub(crate) const COLUMNS: usize = 120;
/// Arguments of a function, without `self`.
pub(crate) const ARGUMENTS: usize = 6;
/// Lines of a function, from `fn` to the closing brace.
pub(crate) const LINES: usize = 60;

/// The figures of a crate. Each list says who falls short.
#[derive(Default)]
pub(crate) struct Figures {
    /// The crate's folder.
    pub name: String,
    /// Files of its source.
    pub files: usize,
    /// Lines of its source that hold code, without those of tests.
    pub code: usize,
    /// Circles of files: those in it, and what ties them.
    pub circles: Vec<(BTreeSet<String>, Vec<String>)>,
    /// Functions with more than [`ARGUMENTS`] arguments.
    pub wide: Vec<String>,
    /// Functions with more than [`LINES`] lines.
    pub long: Vec<String>,
    /// The same among the functions of tests.
    pub long_tests: Vec<String>,
    /// Lines with a comment and more than [`COLUMNS`] columns.
    pub comments: Vec<String>,
    /// Lines of prose in Markdown with more than [`COLUMNS`] columns.
    pub prose: Vec<String>,
}

/// The figures of every crate, and at the end those of the texts that stand in no crate.
pub(crate) fn figures(house: &House) -> Vec<Figures> {
    let mut all: Vec<Figures> = house.crates.iter().map(of_crate).collect();
    let mut elsewhere = Figures { name: "elsewhere".to_owned(), ..Figures::default() };
    for (path, lines) in &house.texts {
        let name = path.split('/').next().expect("a path has a beginning");
        let figures = all.iter_mut().find(|figures| figures.name == name).unwrap_or(&mut elsewhere);
        let list = if path.ends_with(".md") { &mut figures.prose } else { &mut figures.comments };
        list.extend(too_wide(path, lines));
    }
    all.push(elsewhere);
    all
}

fn of_crate(of: &Crate) -> Figures {
    let mut figures = Figures { name: of.name.clone(), circles: circles(&graph(of)), ..Figures::default() };
    let roots = ["lib.rs", "main.rs"].map(|root| Modules::read(of, &format!("{}/src/{root}", of.name)));
    let files: BTreeSet<&str> = roots.iter().flatten().flat_map(Modules::files).collect();
    figures.files = files.len();
    for source in of.sources.values() {
        let of_tests = !files.contains(source.path.as_str());
        figures.comments.extend(too_wide(&source.path, &source.lines));
        let functions = functions(source, of_tests);
        let short = |too: fn(&&Function) -> bool, tests: bool| {
            let found = functions.iter().filter(too).filter(move |function| function.of_tests == tests);
            found.map(|function| {
                format!("{} ({} lines, {} arguments)", function.place, function.lines, function.arguments)
            })
        };
        figures.wide.extend(short(|function| function.arguments > ARGUMENTS, false));
        figures.wide.extend(short(|function| function.arguments > ARGUMENTS, true));
        figures.long.extend(short(|function| function.lines > LINES, false));
        figures.long_tests.extend(short(|function| function.lines > LINES, true));
        if !of_tests {
            figures.code += source.code();
        }
    }
    figures
}

fn too_wide(path: &str, lines: &[crate::house::lines::Line]) -> Vec<String> {
    let wide = lines.iter().enumerate().filter(|(_, line)| line.comment && line.columns > COLUMNS);
    wide.map(|(number, line)| format!("{path}:{} ({} columns)", number + 1, line.columns)).collect()
}

/// The public type names that stand more than once: "Name: file, file".
pub(crate) fn twin_names(house: &House) -> Vec<String> {
    twins(house).iter().map(|(name, places)| format!("{name}: {}", places.join(", "))).collect()
}
