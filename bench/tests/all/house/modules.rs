//! The modules of a crate: which file holds each one, what it defines, and what it names of others.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};

use crate::house::tree::{Crate, attributes, is_for_tests};

/// A name that is handed on more often than this is handed on in a ring.
const HANDS: usize = 16;

/// A name that a `use` brings into a module.
pub(crate) struct Import {
    /// From the module that says so: `crate`, `self`, `super` or a child first.
    pub path: Vec<String>,
    /// What the module calls it; nothing where all of a module comes in.
    pub name: Option<String>,
    /// Others may take it from here.
    pub handed_on: bool,
}

/// A module.
#[derive(Default)]
pub(crate) struct Module {
    /// The module that holds it; the root holds itself.
    pub parent: usize,
    /// The file in which it stands.
    pub file: String,
    /// Its modules.
    pub children: BTreeMap<String, usize>,
    /// What it defines.
    pub items: BTreeSet<String>,
    /// What it brings in.
    pub imports: Vec<Import>,
    /// Every path of its code, but those of `use`.
    pub paths: BTreeSet<Vec<String>>,
}

/// The modules of a crate, without those of its tests.
pub(crate) struct Modules {
    /// The root first.
    pub all: Vec<Module>,
}

impl Modules {
    /// The modules below a root file (`lib.rs` or `main.rs`); `None` where there is no such file.
    pub(crate) fn read(of: &Crate, root: &str) -> Option<Self> {
        let source = of.sources.get(root)?;
        let mut reader = Reader { of, all: vec![Module { file: root.to_owned(), ..Module::default() }], at: 0 };
        reader.visit_file(&source.syntax);
        Some(Self { all: reader.all })
    }

    /// The files in which they stand.
    pub(crate) fn files(&self) -> BTreeSet<&str> {
        self.all.iter().map(|module| module.file.as_str()).collect()
    }

    /// The module that defines what a path in `module` names, and the name; `None` where it is not of this crate.
    pub(crate) fn resolve(&self, module: usize, path: &[String]) -> Option<(usize, String)> {
        self.follow(module, path, 0)
    }

    fn follow(&self, module: usize, path: &[String], depth: usize) -> Option<(usize, String)> {
        let mut at = match path.first()?.as_str() {
            "crate" => 0,
            "self" => module,
            "super" => self.all[module].parent,
            child => *self.all[module].children.get(child)?,
        };
        let mut rest = &path[1..];
        while rest.first().is_some_and(|word| word == "super") {
            (at, rest) = (self.all[at].parent, &rest[1..]);
        }
        self.descend(at, path.last()?, rest, depth)
    }

    fn descend(&self, at: usize, last: &str, rest: &[String], depth: usize) -> Option<(usize, String)> {
        let module = &self.all[at];
        let Some(word) = rest.first() else { return Some((at, last.to_owned())) };
        if module.items.contains(word) {
            return Some((at, word.clone()));
        }
        let child = module.children.get(word);
        if let (Some(child), true) = (child, rest.len() > 1) {
            return self.descend(*child, last, &rest[1..], depth);
        }
        let handed = module.imports.iter().filter(|import| import.name.as_ref() == Some(word));
        for import in handed.filter(|_| depth < HANDS) {
            let mut path = import.path.clone();
            path.extend_from_slice(&rest[1..]);
            if let Some(found) = self.follow(at, &path, depth + 1) {
                return Some(found);
            }
        }
        if let Some(child) = child {
            return Some((*child, word.clone()));
        }
        let everything = module.imports.iter().filter(|import| import.name.is_none() && import.handed_on);
        for import in everything.filter(|_| depth < HANDS) {
            let mut path = import.path.clone();
            path.extend_from_slice(rest);
            if let Some((found, name)) = self.follow(at, &path, depth + 1)
                && self.all[found].items.contains(&name)
            {
                return Some((found, name));
            }
        }
        Some((at, word.clone()))
    }

    /// Whether `module` is `above` or stands below it.
    pub(crate) fn is_below(&self, mut module: usize, above: usize) -> bool {
        while module != above && module != 0 {
            module = self.all[module].parent;
        }
        module == above
    }
}

/// Walks a file, and the files of its modules.
struct Reader<'a> {
    of: &'a Crate,
    all: Vec<Module>,
    at: usize,
}

impl Reader<'_> {
    /// The files in which a module `name` of the present one may stand.
    fn places(&self, name: &str) -> [String; 2] {
        let file = &self.all[self.at].file;
        let (folder, stem) = file.rsplit_once('/').expect("a file stands in a folder");
        let folder = match stem {
            "lib.rs" | "main.rs" | "mod.rs" => folder.to_owned(),
            _ => format!("{folder}/{}", stem.trim_end_matches(".rs")),
        };
        [format!("{folder}/{name}.rs"), format!("{folder}/{name}/mod.rs")]
    }

    fn import(&mut self, tree: &syn::UseTree, path: &mut Vec<String>, handed_on: bool) {
        let (taken, name) = match tree {
            syn::UseTree::Path(tree) => {
                path.push(tree.ident.to_string());
                self.import(&tree.tree, path, handed_on);
                path.pop();
                return;
            }
            syn::UseTree::Group(tree) => {
                tree.items.iter().for_each(|item| self.import(item, path, handed_on));
                return;
            }
            syn::UseTree::Name(tree) => (Some(tree.ident.to_string()), Some(tree.ident.to_string())),
            syn::UseTree::Rename(tree) => (Some(tree.ident.to_string()), Some(tree.rename.to_string())),
            _ => (None, None),
        };
        let mut path = path.clone();
        let own = taken.as_deref() == Some("self");
        let name = if own && name.as_deref() == Some("self") { path.last().cloned() } else { name };
        path.extend(taken.filter(|_| !own));
        self.all[self.at].imports.push(Import { path, name, handed_on });
    }

    fn path(&mut self, words: Vec<String>) {
        self.all[self.at].paths.insert(words);
    }

    /// Paths in what a macro is given.
    fn tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                TokenTree::Ident(word) => {
                    if colons != 2 && !path.is_empty() {
                        let done = std::mem::take(&mut path);
                        self.path(done);
                    }
                    path.push(word.to_string());
                    colons = 0;
                }
                TokenTree::Punct(mark) if mark.as_char() == ':' => colons += 1,
                other => {
                    if !path.is_empty() {
                        let done = std::mem::take(&mut path);
                        self.path(done);
                    }
                    colons = 0;
                    if let TokenTree::Group(group) = other {
                        self.tokens(group.stream());
                    }
                }
            }
        }
        if !path.is_empty() {
            self.path(path);
        }
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        use syn::Item;
        if is_for_tests(attributes(item)) {
            return;
        }
        let name = match item {
            Item::Const(item) => Some(&item.ident),
            Item::Enum(item) => Some(&item.ident),
            Item::Fn(item) => Some(&item.sig.ident),
            Item::Macro(item) => item.ident.as_ref(),
            Item::Static(item) => Some(&item.ident),
            Item::Struct(item) => Some(&item.ident),
            Item::Trait(item) => Some(&item.ident),
            Item::Type(item) => Some(&item.ident),
            _ => None,
        };
        if let Some(name) = name {
            self.all[self.at].items.insert(name.to_string());
        }
        visit::visit_item(self, item);
    }

    fn visit_impl_item(&mut self, item: &'ast syn::ImplItem) {
        if !matches!(item, syn::ImplItem::Fn(item) if is_for_tests(&item.attrs)) {
            visit::visit_impl_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        let name = item.ident.to_string();
        let within = item.content.is_some();
        let file = if within {
            self.all[self.at].file.clone()
        } else {
            let places = self.places(&name);
            places.iter().find(|place| self.of.sources.contains_key(*place)).expect("a module has a file").clone()
        };
        let (parent, child) = (self.at, self.all.len());
        self.all.push(Module { parent, file: file.clone(), ..Module::default() });
        self.all[parent].children.insert(name, child);
        self.at = child;
        if within {
            visit::visit_item_mod(self, item);
        } else {
            let of = self.of;
            self.visit_file(&of.sources[&file].syntax);
        }
        self.at = parent;
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        let handed_on = !matches!(item.vis, syn::Visibility::Inherited);
        self.import(&item.tree, &mut Vec::new(), handed_on);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.path(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, of: &'ast syn::Macro) {
        self.path(of.path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        self.tokens(of.tokens.clone());
    }

    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}
}
