//! The list of the variations that show their change, as it was committed before results were looked at.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use crate::visible::Visibility;

/// The list that `situ-bench check --visible` made of the built-in tasks.
static COMMITTED: LazyLock<ShownList> = LazyLock::new(|| {
    ShownList::from_csv(include_str!("../../results/tasks/shown.csv")).expect("made by `check --visible`")
});

/// A row of the list: a decision that differs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShownRow {
    /// The task.
    pub task: String,
    /// The variation.
    pub variation: String,
    /// The edit that it needs.
    pub edit: String,
    /// The skill that has ended before the decision; `start` where none has.
    pub after: String,
    /// What the original script does next; `end` where it is done.
    pub original: String,
    /// What the variation's script does next. The same name is another way to do it.
    pub changed: String,
    /// The feature that tells the two tasks apart best; empty where none does at all.
    pub feature: String,
    /// From how many starts both scripts came to the decision.
    pub starts: usize,
    /// The feature's area under the curve, 0.5 to 1.
    pub area: f64,
    /// The greatest area of the best feature in all relabellings.
    pub relabelled: f64,
    /// Whether the change is shown at this decision.
    pub shown: bool,
}

impl ShownRow {
    /// The row of a decision.
    pub fn new(task: &str, variation: &str, edit: &str, found: &Visibility) -> Self {
        let decision = &found.decision;
        Self {
            task: task.to_owned(),
            variation: variation.to_owned(),
            edit: edit.to_owned(),
            after: decision.after.clone(),
            original: decision.original.clone(),
            changed: decision.changed.clone(),
            feature: if found.area > 0.5 { found.feature.clone() } else { String::new() },
            starts: found.starts,
            area: rounded(found.area),
            relabelled: rounded(found.relabelled),
            shown: found.is_shown(),
        }
    }
}

/// To the six decimals that lists have.
fn rounded(value: f64) -> f64 {
    (1e6 * value).round() / 1e6
}

/// The list as comma-separated values.
pub fn to_csv(rows: &[ShownRow]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.iter().for_each(|row| writer.serialize(row).expect("a row of text and numbers"));
    String::from_utf8(writer.into_inner().expect("in memory")).expect("text is UTF-8")
}

/// Which variations show their change: those that show it at every decision that differs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShownList {
    shown: BTreeMap<(String, String), bool>,
}

impl ShownList {
    /// The list of these rows.
    pub fn new<'a>(rows: impl IntoIterator<Item = &'a ShownRow>) -> Self {
        let mut list = Self::default();
        for row in rows {
            *list.shown.entry((row.task.clone(), row.variation.clone())).or_insert(true) &= row.shown;
        }
        list
    }

    /// Reads a list of decisions, as [`to_csv`] writes it.
    ///
    /// # Errors
    /// Where a row is not as [`ShownRow`] says.
    pub fn from_csv(text: &str) -> Result<Self, csv::Error> {
        let rows = csv::Reader::from_reader(text.as_bytes()).deserialize().collect::<Result<Vec<ShownRow>, _>>()?;
        Ok(Self::new(&rows))
    }

    /// The list that was committed.
    pub fn committed() -> &'static Self {
        &COMMITTED
    }

    /// Whether the variation shows its change. `None` where it is on no list, as tasks of one's own are.
    pub fn is_shown(&self, task: &str, variation: &str) -> Option<bool> {
        self.shown.get(&(task.to_owned(), variation.to_owned())).copied()
    }

    /// How many variations show their change, and how many there are.
    pub fn count(&self) -> (usize, usize) {
        (self.shown.values().filter(|shown| **shown).count(), self.shown.len())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use situ_tasks::{NeededEdit, Registry};

    use super::*;

    #[test]
    fn the_committed_list_has_every_variation_that_needs_an_edit_and_no_other() {
        let registry = Registry::builtin().unwrap();
        let settings = registry.tasks().flat_map(|task| task.settings());
        let needed = settings.filter(|setting| setting.edit != NeededEdit::None && !setting.graded);
        let names = needed.filter_map(|setting| Some((setting.task.clone(), setting.variation.clone()?)));
        let listed: BTreeSet<_> = ShownList::committed().shown.keys().cloned().collect();
        assert_eq!(listed, names.collect());
    }
}
