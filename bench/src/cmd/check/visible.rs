//! `check --visible`: which variations show their change.

use std::collections::BTreeMap;
use std::sync::Arc;

use situ_tasks::{NeededEdit, Registry, Setting};

use super::layout;
use crate::cmd::terminal;
use crate::error::BenchError;
use crate::visible::{LEAST_AREA, RELABELLINGS, RESOLUTION, Visibility, Walk, visibilities};

/// The list of the variations that need an edit, from these seeds.
pub(super) fn said(
    registry: &Registry,
    settings: &[Arc<Setting>],
    seeds: &[u64],
    jobs: Option<u16>,
) -> Result<String, BenchError> {
    let changed: Vec<&Arc<Setting>> = settings.iter().filter(|setting| setting.edit != NeededEdit::None).collect();
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

    let mut table =
        layout::table(&["variation", "edit", "decision", "feature", "starts", "area", "relabelled", "shown"], 4);
    let (mut shown, mut count) = (0, 0);
    for setting in changed {
        let label = setting.label();
        let walk = |label: &str, seed| walks.get(label)?.get(seed);
        let pairs: Vec<(&Walk, &Walk)> =
            seeds.iter().filter_map(|seed| walk(&setting.task, seed).zip(walk(&label, seed))).collect();
        let found = visibilities(setting, &pairs);
        shown += usize::from(!found.is_empty() && found.iter().all(Visibility::is_shown));
        count += 1;
        found.iter().for_each(|found| {
            table.add_row(row(setting, found));
        });
    }
    Ok(format!(
        "{table}\n\nShown at every decision that differs: {shown} of {count} variations. *area*: under the curve of the \
         feature that tells the variation from the original task best, in the states that the two competent scripts \
         come to, each from the same seeds. *relabelled*: the greatest area of the best feature in {RELABELLINGS} \
         relabellings of the states. Values that differ by {RESOLUTION} of their feature's scale or less are ties. Shown: \
         {LEAST_AREA} or more, and above *relabelled*.\n"
    ))
}

fn row(setting: &Setting, found: &Visibility) -> [String; 8] {
    let decision = &found.decision;
    let next = if decision.original == decision.changed {
        format!("`{}` in another way", decision.changed)
    } else {
        format!("`{}`, not `{}`", decision.changed, decision.original)
    };
    [
        setting.label(),
        setting.edit.word().to_owned(),
        format!("after `{}`: {next}", decision.after),
        if found.area > 0.5 { format!("`{}`", found.feature) } else { "none".to_owned() },
        found.starts.to_string(),
        format!("{:.3}", found.area),
        format!("{:.3}", found.relabelled),
        if found.is_shown() { "yes" } else { "no" }.to_owned(),
    ]
}
