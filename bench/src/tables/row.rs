//! Rows before they are written: records that share a key.

use std::collections::BTreeMap;

/// A row before it is written.
pub(super) struct Row<K, T> {
    pub(super) key: K,
    /// The members of the row, in the order of the records; never empty.
    pub(super) of: Vec<T>,
}

/// The rows, in the order of their keys.
pub(super) fn rows<K: Ord, T>(items: impl IntoIterator<Item = (K, T)>) -> Vec<Row<K, T>> {
    let mut rows: BTreeMap<K, Vec<T>> = BTreeMap::new();
    for (key, item) in items {
        rows.entry(key).or_default().push(item);
    }
    rows.into_iter().map(|(key, of)| Row { key, of }).collect()
}
