//! The workspace as files: what each crate holds, read once.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use syn::spanned::Spanned;

use crate::house::lines::{self, Line};

/// A file of Rust that the workspace holds.
pub(crate) struct Source {
    /// Relative to the workspace, with `/`.
    pub path: String,
    /// What each line holds.
    pub lines: Vec<Line>,
    /// What the file says.
    pub syntax: syn::File,
}

impl Source {
    /// Lines that hold code, without those of items that are built for tests alone.
    pub(crate) fn code(&self) -> usize {
        let mut tests = vec![false; self.lines.len() + 1];
        for item in self.syntax.items.iter().filter(|item| is_for_tests(attributes(item))) {
            let (first, last) = (item.span().start().line, item.span().end().line);
            tests[first..=last].fill(true);
        }
        self.lines.iter().zip(&tests[1..]).filter(|(line, tests)| line.code && !**tests).count()
    }
}

/// A crate of the workspace.
pub(crate) struct Crate {
    /// Its folder.
    pub name: String,
    /// Every file of Rust below its folder, by path.
    pub sources: BTreeMap<String, Source>,
}

impl Crate {
    /// Whether the file is of a test, a bench or an example.
    pub(crate) fn is_test(&self, path: &str) -> bool {
        !path.starts_with(&format!("{}/src/", self.name))
    }
}

/// The workspace.
pub(crate) struct House {
    /// In the order of the names.
    pub crates: Vec<Crate>,
    /// Every other text that people write: its path, and what each line holds.
    pub texts: Vec<(String, Vec<Line>)>,
}

impl House {
    /// Reads the workspace at `root`.
    pub(crate) fn read(root: &Path) -> Self {
        let mut paths = Vec::new();
        walk(root, &mut paths);
        let mut files: Vec<(String, String)> = Vec::new();
        for path in paths {
            let name = path.strip_prefix(root).expect("below the root").to_string_lossy().replace('\\', "/");
            let is_text = [".rs", ".toml", ".py", ".md"].iter().any(|ending| name.ends_with(ending));
            if is_text || name.starts_with(".ci/") {
                files.push((name, fs::read_to_string(&path).expect("a text")));
            }
        }
        files.sort();
        Self::of(files)
    }

    /// The workspace that these files make: (path, text).
    pub(crate) fn of(files: Vec<(String, String)>) -> Self {
        let mut crates: BTreeMap<String, Crate> = BTreeMap::new();
        let mut texts = Vec::new();
        for (path, text) in files {
            let lines = lines::read(&path, &text);
            if !path.ends_with(".rs") {
                texts.push((path, lines));
                continue;
            }
            let name = path.split('/').next().expect("a path has a beginning").to_owned();
            let of_crate = crates.entry(name.clone()).or_insert_with(|| Crate { name, sources: BTreeMap::new() });
            let syntax = syn::parse_file(&text).unwrap_or_else(|error| panic!("{path}: {error}"));
            of_crate.sources.insert(path.clone(), Source { path, lines, syntax });
        }
        Self { crates: crates.into_values().collect(), texts }
    }
}

/// Every file below `folder` but what was built, what was generated (`results`) and what is hidden (`.ci` counts).
fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        if path.is_file() {
            found.push(path);
        } else if (!name.starts_with('.') || name == ".ci") && name != "target" && name != "results" {
            walk(&path, found);
        }
    }
}

/// Whether an item with these attributes is built for tests alone.
pub(crate) fn is_for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let path = attribute.path();
        let condition = match &attribute.meta {
            syn::Meta::List(list) => list.tokens.to_string(),
            _ => String::new(),
        };
        path.is_ident("test") || path.is_ident("cfg") && (condition == "test" || condition.starts_with("all (test"))
    })
}

/// The attributes of an item.
pub(crate) fn attributes(item: &syn::Item) -> &[syn::Attribute] {
    use syn::Item;
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}
