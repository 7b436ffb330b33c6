//! Graded changes: from which size on a method sees a modification, and where it sees one that is not there.

use std::cmp::Ordering;
use std::collections::BTreeSet;

use situ::edit::Edit;
use situ::method;

use super::column::{Cell, Columns, Shape};
use super::measure::{of_runs, share_of, success};
use super::plotted::lines;
use super::rows::{self, MethodName, rows};
use super::table::{Figure, Publication, Table, Title};
use crate::chart::{Chart, ChartAxis, ChartPanel};
use crate::grade::Grade;
use crate::ledger::Canonical;
use crate::record::{Record, RunRecord};

/// The publication.
pub(super) const GRADES: Publication = Publication {
    name: "grades",
    question: "From which size of a change on is it seen as a modification, and where is one seen that is not there?",
    tables: |records| vec![table(records)],
    figures: |records| vec![figure(records)],
};

const TITLE: Title = Title {
    id: "grades",
    text: "Graded changes: when a modification is seen",
    note: "Each robot is corrected once, whether it fails or not. `fails`: rollouts of the original model on the \
        changed task that failed, from fresh starts; where it is 0, nothing had to be changed. `seen`: corrections \
        after which a node was modified; where the series changes nothing in the world, each of these is wrong. \
        `added`: corrections after which there were more nodes, or more edges between known ones. `after` and \
        `original`: success on the changed and the original task after the one correction. 95 % bootstrap intervals over \
        units (family × seed), Wilson's where all agree. Fewer runs than seeds: the teacher could not teach the original task, or could not show the change.",
};

/// A size of a series; sizes in their order.
#[derive(Clone, Copy, PartialEq)]
struct Size<'a>(&'a Grade);

impl Eq for Size<'_> {}

impl PartialOrd for Size<'_> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Size<'_> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.series.cmp(&other.0.series).then(self.0.size.total_cmp(&other.0.size))
    }
}

/// Protocol, method, teacher and size. A series of teachers has another one at each size.
type GradeKey<'a> = (&'a str, bool, MethodName<'a>, Option<&'a str>, Size<'a>);

type Row<'a> = rows::Row<GradeKey<'a>, &'a RunRecord>;

/// Whether a method can modify a node. One that is not listed can.
fn can_modify(name: &str) -> bool {
    let method = method::all();
    method
        .iter()
        .find(|method| method.name() == name)
        .is_none_or(|method| method.edits().contains(&Edit::NodeModification))
}

fn graded(records: &Canonical) -> Vec<Row<'_>> {
    let runs = records.iter().filter_map(Record::single_run).filter(|run| run.outcome.counts());
    let placed = runs.filter_map(|run| {
        let grade = run.grade.as_ref()?;
        let teacher = grade.changes.then_some(&*run.key.teacher);
        let key = (&*run.key.protocol, !grade.changes, MethodName::of(&run.key.method), teacher, Size(grade));
        Some((key, run))
    });
    rows(placed)
}

/// The share of runs of which something holds after the correction.
fn corrections(row: &Row<'_>, is_so: fn(&RunRecord) -> bool) -> Cell {
    let of = |run: &RunRecord| (!run.corrections.is_empty()).then(|| (f64::from(u8::from(is_so(run))), 1.0));
    share_of(&of_runs(row.of.iter().copied(), of))
}

fn seen(row: &Row<'_>) -> Cell {
    if can_modify(row.key.2.name) { corrections(row, modifies) } else { Cell::Nothing }
}

/// Whether nothing changes, the series, and who shows it.
type PanelKey<'a> = (bool, &'a str, Option<&'a str>);

fn panel_key<'a>(row: &Row<'a>) -> PanelKey<'a> {
    (row.key.1, &row.key.4.0.series, row.key.3)
}

/// What is seen, against the size: a panel for each series and teacher, a line for each method.
fn figure(records: &Canonical) -> Figure {
    let rows = graded(records);
    let keys: BTreeSet<PanelKey<'_>> = rows.iter().map(panel_key).collect();
    let panel = |own: &PanelKey<'_>| {
        let of_panel = || rows.iter().filter(|row| panel_key(row) == *own);
        let sizes: BTreeSet<Size<'_>> = of_panel().map(|row| row.key.4).collect();
        let labels = sizes.iter().map(|size| size.0.size).collect();
        let points = of_panel().map(|row| (row.key.2.name, row.key.4.0.size, seen(row)));
        let title = own.2.unwrap_or("nothing changes").to_owned();
        let (x, y) = (ChartAxis::log(own.1, Some(labels)), ChartAxis::shares("modification seen"));
        ChartPanel { title, x, y, lines: lines(points) }
    };
    let columns = keys.iter().filter_map(|(_, _, teacher)| *teacher).collect::<BTreeSet<_>>().len();
    let title = "From which size of a change on it is seen as a modification; and where nothing changes, how often one \
        is seen as the teacher errs more and more.";
    let panels = keys.iter().map(panel).collect();
    Figure { id: "grades", chart: Chart { title: title.to_owned(), columns: columns.max(2), panels } }
}

fn table(records: &Canonical) -> Table {
    let rows = graded(records);
    let columns = Columns::<Row>::new()
        .text("protocol", |row| row.key.0)
        .text("series", |row| &*row.key.4.0.series)
        .text("changes", |row| if row.key.1 { "no" } else { "yes" })
        .text("teacher", |row| row.key.3.unwrap_or("graded"))
        .text("method", |row| row.key.2.name)
        .text("size", |row| Cell::Text(row.key.4.0.size.to_string()))
        .count("runs", |row| row.of.len())
        .column("fails", Shape::Pooled(2), |row| {
            let failed = |run: &RunRecord| {
                run.before.map(|rate| (f64::from(rate.rollouts - rate.successes), f64::from(rate.rollouts)))
            };
            share_of(&of_runs(row.of.iter().copied(), failed))
        })
        .column("seen", Shape::Pooled(2), seen)
        .column("added", Shape::Pooled(2), |row| corrections(row, adds))
        .column("after", Shape::Pooled(2), |row| success(row.of.iter().copied(), |run| run.after))
        .column("original", Shape::Pooled(2), |row| success(row.of.iter().copied(), |run| run.retained));
    Table::new(TITLE, columns, &rows, rows.iter().map(|row| (row.key.0, row.of.len())))
}

fn modifies(run: &RunRecord) -> bool {
    run.edits().contains(&Edit::NodeModification)
}

fn adds(run: &RunRecord) -> bool {
    let edits = run.edits();
    edits.contains(&Edit::NodeAddition) || edits.contains(&Edit::EdgeAddition)
}
