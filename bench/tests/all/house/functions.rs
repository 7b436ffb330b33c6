//! How long the functions are, and how many arguments they take.

use syn::spanned::Spanned;
use syn::visit::{self, Visit};

use crate::house::tree::{Source, attributes, is_for_tests};

/// A function with its size.
pub(crate) struct Function {
    /// `file:line name`.
    pub place: String,
    /// Lines from `fn` to the closing brace.
    pub lines: usize,
    /// Arguments without `self`.
    pub arguments: usize,
    /// It is of a test.
    pub of_tests: bool,
}

/// The functions of a file.
pub(crate) fn functions(source: &Source, of_tests: bool) -> Vec<Function> {
    let mut reader = Reader { path: &source.path, of_tests, found: Vec::new() };
    reader.visit_file(&source.syntax);
    reader.found
}

struct Reader<'a> {
    path: &'a str,
    of_tests: bool,
    found: Vec<Function>,
}

impl Reader<'_> {
    fn add(&mut self, signature: &syn::Signature, end: usize, attributes: &[syn::Attribute]) {
        let first = signature.fn_token.span.start().line;
        self.found.push(Function {
            place: format!("{}:{first} {}", self.path, signature.ident),
            lines: end + 1 - first,
            arguments: signature.inputs.iter().filter(|input| matches!(input, syn::FnArg::Typed(_))).count(),
            of_tests: self.of_tests || is_for_tests(attributes),
        });
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        let before = self.of_tests;
        self.of_tests |= is_for_tests(attributes(item));
        visit::visit_item(self, item);
        self.of_tests = before;
    }

    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        self.add(&function.sig, function.block.span().end().line, &function.attrs);
        visit::visit_item_fn(self, function);
    }

    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        self.add(&function.sig, function.block.span().end().line, &function.attrs);
        visit::visit_impl_item_fn(self, function);
    }

    fn visit_trait_item_fn(&mut self, function: &'ast syn::TraitItemFn) {
        self.add(&function.sig, function.span().end().line, &function.attrs);
        visit::visit_trait_item_fn(self, function);
    }
}
