//! A file with one variation laid over it.

use crate::file::{TaskFile, VariationFile};
use crate::key::KeyPath;

/// Entries of a list, each with its key.
pub(super) type Located<'a, T> = Vec<(KeyPath, &'a T)>;

/// Each entry of a list with its key.
pub(super) fn located<'a, T>(root: &KeyPath, field: &str, entries: &'a [T]) -> Located<'a, T> {
    entries.iter().enumerate().map(|(i, entry)| (root.field(field).index(i), entry)).collect()
}

/// Where entries of a name that the file does not have come.
#[derive(Clone, Copy)]
pub(super) enum New {
    /// Before the entries of the file.
    First,
    /// After them.
    Last,
}

/// The entries of a file with those of a variation: one of a known name replaces that one.
pub(super) fn laid_over<'a, T>(
    [mut merged, over]: [Located<'a, T>; 2],
    name: fn(&T) -> &String,
    new: New,
) -> Located<'a, T> {
    let mut place = 0;
    for (key, entry) in over {
        if let Some(old) = merged.iter_mut().find(|(_, old)| name(old) == name(entry)) {
            *old = (key, entry);
        } else if let New::First = new {
            merged.insert(place, (key, entry));
            place += 1;
        } else {
            merged.push((key, entry));
        }
    }
    merged
}

/// A file, and the variation that is laid over it, if one is.
pub(super) struct Layers<'a> {
    over: Option<(KeyPath, &'a VariationFile)>,
}

impl<'a> Layers<'a> {
    /// The original (no index) or one variation.
    pub(super) fn new(file: &'a TaskFile, index: Option<usize>) -> Layers<'a> {
        Layers { over: index.map(|i| (KeyPath::default().field("variation").index(i), &file.variation[i])) }
    }

    /// The variation, with its key.
    pub(super) fn over(&self) -> Option<(&KeyPath, &'a VariationFile)> {
        self.over.as_ref().map(|(key, variation)| (key, *variation))
    }

    /// The entries of a list: those of the file and those of the variation.
    pub(super) fn lists<T>(
        &self,
        field: &str,
        base: &'a [T],
        of: fn(&'a VariationFile) -> &'a Vec<T>,
    ) -> [Located<'a, T>; 2] {
        let over = self.over().map(|(key, variation)| located(key, field, of(variation)));
        [located(&KeyPath::default(), field, base), over.unwrap_or_default()]
    }

    /// What the variation says instead of the file, with its key; none where it leaves the file's.
    pub(super) fn changed<T>(
        &self,
        field: &str,
        of: fn(&'a VariationFile) -> &'a Option<T>,
    ) -> Option<(KeyPath, &'a T)> {
        self.over().and_then(|(key, variation)| Some((key.field(field), of(variation).as_ref()?)))
    }

    /// A value of the file, or of the variation where that has one, with its key.
    pub(super) fn value<T>(
        &self,
        field: &str,
        base: &'a T,
        of: fn(&'a VariationFile) -> &'a Option<T>,
    ) -> (KeyPath, &'a T) {
        self.changed(field, of).unwrap_or_else(|| (KeyPath::default().field(field), base))
    }
}
