//! Every method beside every edit: success, demonstrations, and what an update costs against SITU's.

use std::collections::BTreeMap;

use situ::edit::Edit;

use super::cell::{Bound, Cell, median, rate, seed, share, some, spent};
use super::column::{Columns, Shape};
use super::method_name::{MethodName, Methods};
use super::publication::Publication;
use super::row::rows;
use super::table::{Table, Title};
use crate::ledger::Canonical;
use crate::record::{Key, Outcome, Record, RunRecord};
use crate::stats;

/// The publication.
pub(super) const METHODS: Publication = Publication {
    name: "methods",
    question: "What does every method reach, edit by edit, and what does its update cost against SITU's?",
    tables: |records| vec![table(records)],
};

const TITLE: Title = Title {
    id: "methods",
    text: "Methods: every method beside every edit",
    note: "A row is a method and the edit that the variation needs, over all tasks, variations, teachers and seeds. \
        Runs of a method that cannot make the edit (not applicable), untaught and spoilt runs are counted apart and \
        enter nothing else. `reached` is the share of runs that reached the target within their budget, `after` \
        success pooled over rollouts; Wilson 95 % intervals. Demonstrations are corrective, or full ones where a \
        method is taught from scratch, until the target was reached or the budget used up (restricted mean, 95 % \
        bootstrap interval over runs); ≥ marks a mean over runs some of which used it up. `to_situ` is the ratio of \
        such means, paired by cell and seed; ≥, ≤ and ~ mark runs of the method, of situ and of both that used their \
        budget up. The clock: the median over runs of the mean time of an update, and the median of its ratio to that \
        of situ in the same cell with the same seed, where both were corrected; other runs went on beside it.",
};

/// The method that others are compared with.
const SITU: &str = "situ";

/// A run but for its method.
type Partner<'a> = (&'a str, &'a str, &'a str, &'a str, u64);

fn partner(key: &Key) -> Partner<'_> {
    (&key.protocol, &key.task, &key.variation, &key.teacher, key.seed)
}

struct Row<'a> {
    protocol: &'a str,
    method: MethodName<'a>,
    edit: Edit,
    runs: Vec<&'a RunRecord>,
    /// Those of the runs that say something about the method.
    counted: Vec<&'a RunRecord>,
    /// Each of these and the run of `situ` in its place; none in the row of `situ`.
    beside: Vec<(&'a RunRecord, &'a RunRecord)>,
}

impl Row<'_> {
    /// The number of tasks, variations and teachers.
    fn cells(&self) -> usize {
        let keys = self.runs.iter().map(|run| &run.key);
        let mut cells: Vec<_> = keys.map(|key| (&key.task, &key.variation, &key.teacher)).collect();
        cells.sort_unstable();
        cells.dedup();
        cells.len()
    }

    fn outcomes(&self, is: fn(&Outcome) -> bool) -> usize {
        self.runs.iter().filter(|run| is(&run.outcome)).count()
    }

    /// The ratio of demonstrations to those of `situ`.
    fn demonstrations_to_situ(&self) -> Cell {
        let pairs: Vec<_> = self.beside.iter().map(|(run, situ)| (demonstrations(run), demonstrations(situ))).collect();
        let own = self.beside.iter().all(|(run, _)| run.is_reached());
        let bound = Bound::of(own, self.beside.iter().all(|(_, situ)| situ.is_reached()));
        some(stats::paired_ratio(&pairs, self.seed("ratio")), |ratio| Cell::Estimate(ratio, bound))
    }

    /// The ratio of the time of an update to that of `situ`.
    fn time_to_situ(&self) -> Cell {
        let ratios = self.beside.iter().filter_map(|(run, situ)| Some(update_seconds(run)? / update_seconds(situ)?));
        median(&ratios.filter(|ratio| ratio.is_finite()).collect::<Vec<_>>(), self.seed("time ratio"))
    }

    /// The seed of the bootstrap of a quantity.
    fn seed(&self, quantity: &str) -> u64 {
        seed(&format!("methods/{}/{}/{}", self.protocol, self.method.name, self.edit), quantity)
    }
}

fn columns<'a>() -> Columns<'a, Row<'a>> {
    Columns::<Row<'a>>::new()
        .text("protocol", |row| row.protocol)
        .text("method", |row| row.method.name)
        .text("edit_needed", |row| row.edit.name())
        .count("cells", Row::cells)
        .count("runs", |row| row.runs.len())
        .count("not_applicable", |row| row.outcomes(|outcome| *outcome == Outcome::NotApplicable))
        .count("untaught", |row| row.outcomes(|outcome| *outcome == Outcome::Untaught))
        .count("spoilt", |row| row.outcomes(|outcome| matches!(outcome, Outcome::Spoilt { .. })))
        .column("reached", Shape::Rate, |row| share(row.counted.iter().map(|run| run.is_reached())))
        .column("after", Shape::Rate, |row| rate(row.counted.iter().filter_map(|run| run.after)))
        .column("demonstrations", Shape::Estimate(2), |row| {
            let of = row.counted.iter().map(|run| (demonstrations(run), !run.is_reached()));
            spent(of, row.seed("demonstrations"))
        })
        .column("demonstrations_to_situ", Shape::Estimate(2), Row::demonstrations_to_situ)
        .wall("update_ms", Shape::Estimate(2), |row| {
            let milliseconds = row.counted.iter().filter_map(|run| Some(1e3 * update_seconds(run)?));
            median(&milliseconds.collect::<Vec<_>>(), row.seed("time"))
        })
        .wall("update_to_situ", Shape::Estimate(1), Row::time_to_situ)
}

fn table(records: &Canonical) -> Table {
    let methods = Methods::listed();
    let runs = || records.iter().filter_map(Record::single_run);
    let by_situ = runs().filter(|run| run.key.method == SITU && run.outcome.counts());
    let by_situ: BTreeMap<Partner, &RunRecord> = by_situ.map(|run| (partner(&run.key), run)).collect();
    let rows = rows(runs().map(|run| ((&*run.key.protocol, methods.name(&run.key.method), run.key.edit), run)));
    let rows: Vec<Row> = rows
        .into_iter()
        .map(|row| {
            let ((protocol, method, edit), runs) = (row.key, row.of);
            let counted: Vec<_> = runs.iter().copied().filter(|run| run.outcome.counts()).collect();
            let beside = counted.iter().filter(|_| method.name != SITU);
            let beside = beside.filter_map(|run| Some((*run, *by_situ.get(&partner(&run.key))?))).collect();
            Row { protocol, method, edit, runs, counted, beside }
        })
        .collect();
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.protocol, row.runs.len())))
}

fn demonstrations(run: &RunRecord) -> f64 {
    f64::from(run.effort.demonstrations)
}

/// The mean time of an update of a run; nothing of a run without one.
fn update_seconds(run: &RunRecord) -> Option<f64> {
    stats::mean(&run.corrections.iter().map(|correction| correction.update_seconds).collect::<Vec<_>>())
}
