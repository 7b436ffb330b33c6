//! Why runs came to nothing: untaught, given up, spoilt.

use std::collections::BTreeSet;

use super::column::Columns;
use super::rows::{self, MethodName, rows};
use super::table::{NO_FIGURES, Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::{Outcome, Record, RunRecord};

/// The publication.
pub(super) const ENDINGS: Publication = Publication {
    name: "endings",
    question: "Why were runs untaught, given up or spoilt?",
    tables: |records| vec![table(records)],
    figures: NO_FIGURES,
};

const TITLE: Title = Title {
    id: "endings",
    text: "Runs that came to nothing, and why",
    note: "Untaught: the original task was never learned, so no method that starts from it has a run; one row for all \
        of them, and `runs` are seeds. Given up: the teacher could not show the way; such a run counts its budget. \
        Spoilt: the physics was no longer sound, which is no failure of the method. Method error, timed out, panicked: \
        the run was not done to its end; it counts its budget and no success.",
};

/// Protocol, task, variation, teacher, method, ending and the reason.
type Key<'a> = (&'a str, &'a str, &'a str, &'a str, Option<MethodName<'a>>, &'static str, &'a str);

/// Where a run came to nothing, its row.
fn key(run: &RunRecord) -> Option<Key<'_>> {
    let key = &run.key;
    let own = |ending, why| {
        let method = Some(MethodName::of(&key.method));
        Some((&*key.protocol, &*key.task, &*key.variation, &*key.teacher, method, ending, why))
    };
    match &run.outcome {
        Outcome::Untaught { why } => {
            Some((&key.protocol, &key.task, "all", &key.teacher, None, "untaught", why.as_str()))
        }
        Outcome::GaveUp { why } => own("gave up", why.as_str()),
        Outcome::Spoilt { why } => own("spoilt", why.as_str()),
        Outcome::MethodError { why } => own("method error", why.as_str()),
        Outcome::TimedOut { why } => own("timed out", why.as_str()),
        Outcome::Panicked { why } => own("panicked", why.as_str()),
        Outcome::Reached | Outcome::Censored | Outcome::NotApplicable => None,
    }
}

fn table(records: &Canonical) -> Table {
    let runs = records.iter().filter_map(|record| if let Record::Run(run) = record { Some(run) } else { None });
    let rows: Vec<rows::Row<Key<'_>, &RunRecord>> = rows(runs.filter_map(|run| Some((key(run)?, run))));
    let columns = Columns::<rows::Row<Key<'_>, &RunRecord>>::new()
        .text("protocol", |row| row.key.0)
        .text("task", |row| row.key.1)
        .text("variation", |row| row.key.2)
        .text("teacher", |row| row.key.3)
        .text("method", |row| row.key.4.map_or("all", |method| method.name))
        .text("ending", |row| row.key.5)
        .text("why", |row| row.key.6)
        .count("runs", |row| {
            if row.key.4.is_some() {
                return row.of.len();
            }
            row.of.iter().map(|run| run.key.seed).collect::<BTreeSet<_>>().len()
        });
    Table::new(TITLE, columns, &rows, rows.iter().map(|row| (row.key.0, row.of.len())))
}
