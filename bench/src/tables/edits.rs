//! T3: which edit was needed and which was made, the confusion matrix of each method with one row for each edit needed;
//! and how far the structure that it led to is what the teacher meant.

use std::collections::BTreeSet;

use situ::edit::Edit;
use situ::method::Role;
use situ::structure::Structure;
use situ::trace::Obedience;

use super::column::{Columns, Shape};
use super::measure::{mean, of_runs, share_of, units, variations};
use super::rows::{self, MethodKey, method_columns, method_key, role, rows};
use super::table::{NO_FIGURES, Publication, Table, Title};
use crate::correction_record::CorrectionRecord;
use crate::ledger::Canonical;
use crate::record::{Record, RunRecord};

/// The publication.
pub(super) const T3: Publication = Publication {
    name: "t3",
    question: "Which edit did the task need, which did the method make, and is the structure what the teacher meant?",
    tables: |records| vec![table(records)],
    figures: NO_FIGURES,
};

const TITLE: Title = Title {
    id: "t3",
    text: "T3 edits: needed and made",
    note: "A row is a method and the edit that the variation needs, over all tasks, teachers and seeds whose run \
        counts. `first` counts the set of edits that the first correction made which shows what changed, `all` the set \
        that all corrections of a run made together. An edit is what a correction changed on the whole: what it added \
        and merged away again is none, and neither is a way back along which something was shown again that was added \
        or modified. `several` are sets of two or more. `nearest` can add nodes only. `right` is the share in which \
        the set was the edit needed and nothing else. `uncorrected` are runs without a correction, whether they \
        reached the target or not. Teaching from scratch and the control edit nothing and have no row. What was shown \
        must be what is chosen where it was shown: `retired` counts the samples that were taken away for that, \
        `aliased` the segments that a later one of the same correction contradicts in a state that looks alike, \
        `disobeyed` those in whose state something else is chosen all the same. Node F1 is over pairs of keyframes, \
        which belong together where the teacher calls both the same; edge F1 is over transitions from skill to skill; \
        duplicates are nodes whose skill an earlier node holds. 1 is beyond a method that cuts where an object is \
        named and sees one skill where two cubes go into one bin: the best of those is `oracle_edit`. Means over runs. \
        Two 95 % bootstrap intervals each: by units (family × seed) and by variations.",
};

/// Protocol, method, and the edit that the variation needs.
type Row<'a> = rows::Row<MethodKey<'a>, &'a RunRecord>;

/// The set of edits of a run that is counted; `None` where there is none.
type Counted = fn(&RunRecord) -> Option<BTreeSet<Edit>>;

/// Columns of edits made, in the order of [`Edit::ALL`], of several, and of the share that was right.
type Made = ([&'static str; 4], [&'static str; 2], Counted);

const MADE: [Made; 2] = [
    (
        ["first_node-addition", "first_edge-addition", "first_node-modification", "first_none"],
        ["first_several", "first_right"],
        |run| run.first_to_show().map(CorrectionRecord::edits),
    ),
    (
        ["all_node-addition", "all_edge-addition", "all_node-modification", "all_none"],
        ["all_several", "all_right"],
        |run| Some(run.edits()).filter(|edits| !edits.is_empty()),
    ),
];

/// Where the model was made to obey, or does not.
type Obeyed = (&'static str, fn(&Obedience) -> u32);

const OBEDIENCE: [Obeyed; 3] = [
    ("retired", |obedience| obedience.retired),
    ("aliased", |obedience| obedience.aliased),
    ("disobeyed", |obedience| obedience.disobeyed),
];

type Measure = (&'static str, fn(&Structure) -> Option<f64>);

const STRUCTURE: [Measure; 3] = [
    ("node_F1", |structure| structure.pairs.f1()),
    ("edge_F1", |structure| structure.transitions.f1()),
    ("duplicates", |structure| Some(f64::from(structure.duplicates))),
];

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let columns = method_columns::<Row<'a>>(|row| row.key)
        .count("runs", |row| row.of.len())
        .count("units", |row| units(row.of.iter().copied()))
        .count("variations", |row| variations(row.of.iter().copied()))
        .count("uncorrected", |row| row.of.iter().filter(|run| run.corrections.is_empty()).count());
    let columns = MADE.into_iter().fold(columns, |columns, (names, [several, right], counted)| {
        let sets = move |row: &Row| row.of.iter().filter_map(|run| counted(run)).collect::<Vec<_>>();
        let columns = names.into_iter().zip(Edit::ALL).fold(columns, |columns, (name, edit)| {
            let only = BTreeSet::from([edit]);
            columns.count(name, move |row| sets(row).into_iter().filter(|made| *made == only).count())
        });
        columns.count(several, move |row| sets(row).into_iter().filter(|made| made.len() > 1).count()).column(
            right,
            Shape::Pooled(2),
            move |row| {
                let needed = BTreeSet::from([row.key.2]);
                let pair = |run| Some((f64::from(u8::from(counted(run)? == needed)), 1.0));
                share_of(&of_runs(row.of.iter().copied(), pair))
            },
        )
    });
    let columns = OBEDIENCE.into_iter().fold(columns, |columns, (name, count)| {
        let of_run =
            move |run: &&RunRecord| run.corrections.iter().map(|given| count(&given.obedience) as usize).sum::<usize>();
        columns.count(name, move |row: &Row| row.of.iter().map(of_run).sum::<usize>())
    });
    STRUCTURE.into_iter().fold(columns, |columns, (name, measure)| {
        columns.column(name, Shape::Pooled(2), move |row| {
            mean(row.of.iter().copied(), |run| measure(run.structure.as_ref()?))
        })
    })
}

fn table(records: &Canonical) -> Table {
    let runs = records.iter().filter_map(Record::single_run);
    let counted = runs.filter(|run| run.outcome.counts() && role(&run.key.method) == Role::Correct);
    let rows: Vec<Row> = rows(counted.map(|run| (method_key(run), run)));
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.key.0, row.of.len())))
}
