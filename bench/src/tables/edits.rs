//! T3: which edit was needed, and which was made, the confusion matrix of each method, a row an edit needed; and how far the structure it
//! led to is what the teacher meant.

use std::collections::BTreeMap;

use situ::edit::Edit;
use situ::method::Role;
use situ::structure::Structure;

use super::{Cell, Column, MethodName, Methods, Shape, Table, column, mean, seed, share};
use crate::record::{Record, Run};

const NOTE: &str = "A row is a method and the edit that the variation needs, over all tasks, teachers and seeds whose run counts. \
`first` counts the edit that the first correction of each run made, `all` that of every correction; `right` is the share in \
which it was the edit needed, with the Wilson 95 % interval. Runs that reached the target without a correction are counted apart. \
Teaching from scratch edits nothing and has no row. Node F1 is over pairs of keyframes, which belong together where the teacher calls both the same; \
edge F1 is over transitions from skill to skill; duplicates are nodes that hold a skill which another node holds as well. \
1 is beyond a method that cuts where the object changes and sees one skill where two cubes go into one bin: the best of those is `oracle_edit`. Means over runs with 95 % \
bootstrap intervals.";

type Measure = (&'static str, fn(&Structure) -> Option<f64>);

const STRUCTURE: [Measure; 3] = [
    ("node_F1", |structure| structure.pairs.f1()),
    ("edge_F1", |structure| structure.transitions.f1()),
    ("duplicates", |structure| Some(f64::from(structure.duplicates))),
];

fn columns() -> Vec<Column> {
    const FIRST: [&str; 4] = ["first_node-addition", "first_edge-addition", "first_node-modification", "first_none"];
    const ALL: [&str; 4] = ["all_node-addition", "all_edge-addition", "all_node-modification", "all_none"];
    let text = ["protocol", "method", "edit_needed"].map(|name| column(name, Shape::Text));
    let counts = |names: [&'static str; 4]| names.map(|name| column(name, Shape::Count));
    text.into_iter()
        .chain(["runs", "uncorrected"].map(|name| column(name, Shape::Count)))
        .chain(counts(FIRST))
        .chain([column("first_right", Shape::Rate)])
        .chain(counts(ALL))
        .chain([column("all_right", Shape::Rate)])
        .chain(STRUCTURE.map(|(name, _)| column(name, Shape::Estimate(2))))
        .collect()
}

/// The table, from records in canonical order.
pub(super) fn table(records: &[Record]) -> Table {
    let methods = Methods::listed();
    let mut rows: BTreeMap<(&str, MethodName, Edit), Vec<&Run>> = BTreeMap::new();
    for record in records {
        if let Some(run) = record.single_run()
            && run.outcome.counts()
            && methods.role(&run.key.method) != Role::FromScratch
        {
            rows.entry((&run.key.protocol, methods.name(&run.key.method), run.key.edit)).or_default().push(run);
        }
    }
    let rendered = rows.iter().map(|((protocol, method, needed), runs)| {
        let made = |run: &&Run| run.corrections.iter().map(|correction| correction.edit_made).collect::<Vec<_>>();
        let first: Vec<Edit> = runs.iter().filter_map(|run| made(run).first().copied()).collect();
        let all: Vec<Edit> = runs.iter().flat_map(made).collect();
        let mut cells = [*protocol, &method.name, needed.name()].map(|word| Cell::Text(word.to_owned())).to_vec();
        cells.push(Cell::Count(runs.len()));
        cells.push(Cell::Count(runs.len() - first.len()));
        for edits in [first, all] {
            let count = |edit: &Edit| Cell::Count(edits.iter().filter(|made| *made == edit).count());
            cells.extend(Edit::ALL.iter().map(count));
            cells.push(share(edits.iter().map(|made| made == needed)));
        }
        for (name, measure) in STRUCTURE {
            let scores: Vec<f64> = runs.iter().filter_map(|run| measure(run.structure.as_ref()?)).collect();
            cells.push(mean(&scores, seed(&format!("t3/{protocol}/{}/{needed}", method.name), name)));
        }
        cells
    });
    Table {
        id: "t3",
        title: "T3 edits: needed and made",
        note: NOTE,
        columns: columns(),
        rows: rendered.collect(),
        protocols: rows.keys().map(|row| row.0.to_owned()).collect(),
        records: rows.values().map(Vec::len).sum(),
    }
}
