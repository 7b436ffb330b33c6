//! `check --visible`: which variations show their change, as a table for people and as a list for programs.

use std::collections::BTreeMap;
use std::sync::Arc;

use situ_tasks::{NeededEdit, Registry, Setting};

use super::layout;
use crate::cmd::terminal;
use crate::error::BenchError;
use crate::shown::{ShownList, ShownRow};
use crate::visible::{LEAST_AREA, RELABELLINGS, RESOLUTION, Walk, visibilities};

/// What was found of the variations that need an edit, from these seeds: in words, and row by row.
pub(super) fn said(
    registry: &Registry,
    settings: &[Arc<Setting>],
    seeds: &[u64],
    jobs: Option<u16>,
) -> Result<(String, Vec<ShownRow>), BenchError> {
    // A graded change may be too small to be needed.
    let is_changed = |setting: &&Arc<Setting>| setting.edit != NeededEdit::None && !setting.graded;
    let changed: Vec<&Arc<Setting>> = settings.iter().filter(is_changed).collect();
    let mut walked: BTreeMap<String, Arc<Setting>> = BTreeMap::new();
    for setting in &changed {
        walked.insert(setting.label(), Arc::clone(setting));
        walked.insert(setting.task.clone(), registry.get(&setting.task)?.variation(None)?);
    }
    let starts: Vec<(&String, &Arc<Setting>, u64)> =
        walked.iter().flat_map(|(label, setting)| seeds.iter().map(move |seed| (label, setting, *seed))).collect();
    let walk = |(_, setting, seed): &(_, &Arc<Setting>, u64), _: &_| Walk::of(setting, *seed);
    let done = terminal::each(jobs, &starts, |(label, ..)| (*label).clone(), walk)?;
    let mut walks: BTreeMap<&str, BTreeMap<u64, Walk>> = BTreeMap::new();
    for ((label, _, seed), walk) in starts.iter().zip(done) {
        walk.and_then(|walk| walks.entry(label.as_str()).or_default().insert(*seed, walk));
    }

    let mut rows = Vec::new();
    for setting in changed {
        let label = setting.label();
        let walk = |label: &str, seed| walks.get(label)?.get(seed);
        let pairs: Vec<(&Walk, &Walk)> =
            seeds.iter().filter_map(|seed| walk(&setting.task, seed).zip(walk(&label, seed))).collect();
        let variation = setting.variation.as_deref().unwrap_or_default();
        let found = visibilities(setting, &pairs);
        rows.extend(found.iter().map(|found| ShownRow::new(&setting.task, variation, setting.edit.word(), found)));
    }
    Ok((in_words(&rows), rows))
}

fn in_words(rows: &[ShownRow]) -> String {
    let mut table =
        layout::table(&["variation", "edit", "decision", "feature", "starts", "area", "relabelled", "shown"], 4);
    rows.iter().for_each(|row| {
        table.add_row(cells(row));
    });
    let (shown, count) = ShownList::new(rows).count();
    format!(
        "{table}\n\nShown at every decision that differs: {shown} of {count} variations. *area*: under the curve of the \
         feature that tells the variation from the original task best, in the states that the two competent scripts \
         come to, each from the same seeds. *relabelled*: the greatest area of the best feature in {RELABELLINGS} \
         relabellings of the states. Values that differ by {RESOLUTION} of their feature's scale or less are ties. Shown: \
         {LEAST_AREA} or more, and above *relabelled*.\n"
    )
}

fn cells(row: &ShownRow) -> [String; 8] {
    let next = if row.original == row.changed {
        format!("`{}` in another way", row.changed)
    } else {
        format!("`{}`, not `{}`", row.changed, row.original)
    };
    [
        format!("{}/{}", row.task, row.variation),
        row.edit.clone(),
        format!("after `{}`: {next}", row.after),
        if row.feature.is_empty() { "none".to_owned() } else { format!("`{}`", row.feature) },
        row.starts.to_string(),
        format!("{:.3}", row.area),
        format!("{:.3}", row.relabelled),
        if row.shown { "yes" } else { "no" }.to_owned(),
    ]
}
