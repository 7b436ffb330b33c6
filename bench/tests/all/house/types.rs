//! The names of public types.

use std::collections::BTreeMap;

use syn::visit::{self, Visit};

use crate::house::tree::{House, attributes, is_for_tests};

/// Every public type name that stands more than once in the workspace, with the files in which it stands.
pub(crate) fn twins(house: &House) -> BTreeMap<String, Vec<String>> {
    let mut names: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for of in &house.crates {
        for source in of.sources.values().filter(|source| !of.is_test(&source.path)) {
            let mut reader = Reader(Vec::new());
            reader.visit_file(&source.syntax);
            for name in reader.0 {
                names.entry(name).or_default().push(source.path.clone());
            }
        }
    }
    names.retain(|_, places| places.len() > 1);
    names
}

struct Reader(Vec<String>);

impl<'ast> Visit<'ast> for Reader {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        use syn::Item;
        if is_for_tests(attributes(item)) {
            return;
        }
        let (visibility, name) = match item {
            Item::Enum(item) => (&item.vis, &item.ident),
            Item::Struct(item) => (&item.vis, &item.ident),
            Item::Trait(item) => (&item.vis, &item.ident),
            Item::Type(item) => (&item.vis, &item.ident),
            Item::Mod(item) => return visit::visit_item_mod(self, item),
            _ => return,
        };
        if matches!(visibility, syn::Visibility::Public(_)) {
            self.0.push(name.to_string());
        }
    }
}
