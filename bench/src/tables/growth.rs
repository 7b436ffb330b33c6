//! T4: what an update of a synthetic automaton costs, how that grows, and from which size on a local update is the
//! cheaper one.

use std::collections::BTreeSet;

use situ::edit::Edit;

use super::cell::{Cell, estimate, made, median, middle, seed, some};
use super::column::{Columns, Shape};
use super::counters::{COUNTERS, MILLISECONDS_PER_SECOND, medians};
use super::method_name::{MethodName, Methods};
use super::row::{self, rows};
use super::table::{Table, Title};
use crate::ledger::Canonical;
use crate::record::{CostRecord, Record};
use crate::stats;

const SCALING: Title = Title {
    id: "t4_scaling",
    text: "T4 update cost by the size of the task model",
    note: "Synthetic automata, one planted correction each: median exact work of the update, and its time. The ratio \
        is that method's cost divided by that of `situ` on the same automata, paired by seed, with a 95 % bootstrap \
        interval. A series varies one thing: the nodes with |Z| held fixed, the nodes with |Z| left free, or the \
        original demonstrations.",
};
const SLOPES: Title = Title {
    id: "t4_slopes",
    text: "T4 growth of the update cost",
    note: "Slope of ln(cost) over the logarithm of what the series varies, by least squares over all its automata, \
        with Student's 95 % interval: 0 is a cost that does not depend on it, 1 one that grows in proportion. \
        `classifier evaluations` is the linear scan of A1.6. A dash: too few sizes, or a cost of 0.",
};
const CROSSOVER: Title = Title {
    id: "t4_crossover",
    text: "T4 crossover: the nodes below which retraining is cheaper",
    note: "The number of nodes below which full retraining is cheaper than `situ`, where the fitted power laws of the \
        two meet: in exact work and by the clock. `< n`: below the smallest automaton that was measured, `situ` is \
        cheaper at all of them; `never`: the lines do not meet above it.",
};

/// The method that others' costs are divided by.
const SITU: &str = "situ";

/// The key of a row.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Key<'a> {
    protocol: &'a str,
    series: &'a str,
    method: MethodName<'a>,
    edit: Edit,
    /// Nodes and originals, where each size has a row of its own.
    size: Option<(u32, u32)>,
}

struct Row<'a> {
    key: Key<'a>,
    costs: Vec<&'a CostRecord>,
    /// The costs of `situ` in the row's place; `None` in its own rows.
    situ: Option<Vec<&'a CostRecord>>,
}

/// The rows of all synthetic updates: one for each size, or one for all sizes.
fn all_rows<'a>(records: &'a Canonical, is_sized: bool) -> Vec<Row<'a>> {
    let methods = Methods::listed();
    let costs = records.iter().filter_map(|record| if let Record::Cost(cost) = record { Some(cost) } else { None });
    let rows: Vec<row::Row<Key, &CostRecord>> = rows(costs.map(|cost| {
        let (protocol, series, method) = (&*cost.protocol, &*cost.series, methods.name(&cost.method));
        let size = is_sized.then_some((cost.nodes, cost.originals));
        (Key { protocol, series, method, edit: cost.edit, size }, cost)
    }));
    let situ = |key: Key<'a>| {
        let wanted = Key { method: methods.name(SITU), ..key };
        let row = rows.iter().find(|row| row.key == wanted && key.method.name != SITU)?;
        Some(row.of.clone())
    };
    rows.iter().map(|row| Row { key: row.key, costs: row.of.clone(), situ: situ(row.key) }).collect()
}

fn table<'a>(title: Title, columns: Columns<'a, Row<'a>>, rows: &[Row<'a>]) -> Table {
    Table::new(title, columns, rows, rows.iter().map(|row| (row.key.protocol, row.costs.len())))
}

fn words<'a>() -> Columns<'a, Row<'a>> {
    Columns::<Row<'a>>::new()
        .text("protocol", |row| row.key.protocol)
        .text("series", |row| row.key.series)
        .text("method", |row| row.key.method.name)
        .text("edit_planted", |row| row.key.edit.name())
}

impl Row<'_> {
    /// The seed of the bootstrap of a quantity.
    fn seed(&self, quantity: &str) -> u64 {
        let Key { protocol, series, method, edit, size } = self.key;
        let (nodes, originals) = size.unwrap_or_default();
        seed(&format!("t4/scaling/{protocol}/{series}/{}/{edit}/{nodes}/{originals}", method.name), quantity)
    }

    /// The ratio of a cost to that of `situ` on the same automata.
    fn to_situ(&self, quantity: &str, of: fn(&CostRecord) -> f64) -> Cell {
        let pair = |cost: &&CostRecord| {
            let other = self.situ.as_ref()?.iter().find(|other| other.seed == cost.seed)?;
            Some((of(cost), of(other)))
        };
        let pairs: Vec<(f64, f64)> = self.costs.iter().filter_map(pair).collect();
        estimate(stats::paired_ratio(&pairs, self.seed(quantity)))
    }

    /// The slope of a cost over the quantity that the series varies.
    fn slope(&self, of: impl Fn(&CostRecord) -> f64) -> Cell {
        let size = axis(&self.costs).1;
        let points: Vec<(f64, f64)> = self.costs.iter().map(|cost| (size(cost), of(cost))).collect();
        estimate(stats::power_law(&points).map(|law| law.exponent))
    }

    /// Where the cost of `situ` meets this one.
    fn meets(&self, of: fn(&CostRecord) -> f64) -> Cell {
        some(self.situ.as_ref().and_then(|situ| crossing(situ, &self.costs, of)), Cell::Text)
    }
}

/// Cost of updates by the size of the automaton.
pub(super) fn scaling(records: &Canonical) -> Table {
    let columns = words()
        .count("nodes", |row| row.key.size.unwrap_or_default().0)
        .count("originals", |row| row.key.size.unwrap_or_default().1)
        .count("automata", |row| row.costs.len())
        .text("edit_made", |row| made(row.costs.iter().map(|cost| cost.edit_made)))
        .column("|Z|", Shape::Number(1), |row| {
            let applicable = row.costs.iter().flat_map(|cost| &cost.applicable);
            middle(&applicable.map(|z| f64::from(*z)).collect::<Vec<_>>())
        });
    let columns = medians(columns, |row| row.costs.iter().map(|cost| cost.counters).collect());
    let columns = columns
        .column("hmm_fits_ratio", Shape::Estimate(1), |row| {
            row.to_situ("hmm_fits", |cost| cost.counters.hmm_fits as f64)
        })
        .wall("update_ms", Shape::Estimate(3), |row| {
            let times = row.costs.iter().map(|cost| cost.update_seconds * MILLISECONDS_PER_SECOND);
            median(&times.collect::<Vec<_>>(), row.seed("time"))
        })
        .wall("ratio", Shape::Estimate(1), |row| row.to_situ("time", |cost| cost.update_seconds));
    table(SCALING, columns, &all_rows(records, true))
}

/// The quantity that a series varies, and its value for an automaton.
fn axis(costs: &[&CostRecord]) -> (&'static str, fn(&CostRecord) -> f64) {
    let sizes: BTreeSet<u32> = costs.iter().map(|cost| cost.nodes).collect();
    if sizes.len() > 1 {
        ("nodes", |cost| f64::from(cost.nodes))
    } else {
        ("originals", |cost| f64::from(cost.originals))
    }
}

/// How the costs of updates grow.
pub(super) fn slopes(records: &Canonical) -> Table {
    let mean = |z: &[u32]| stats::mean(&z.iter().map(|z| f64::from(*z)).collect::<Vec<_>>()).unwrap_or_default();
    let columns = words().text("over", |row| axis(&row.costs).0).count("automata", |row| row.costs.len()).column(
        "|Z|",
        Shape::Estimate(2),
        move |row| row.slope(|cost| mean(&cost.applicable)),
    );
    let columns = COUNTERS.into_iter().enumerate().fold(columns, |columns, (index, name)| {
        columns.column(name, Shape::Estimate(2), move |row| row.slope(|cost| cost.counters.named()[index].1 as f64))
    });
    let columns = columns.wall("update_time", Shape::Estimate(2), |row| row.slope(|cost| cost.update_seconds));
    table(SLOPES, columns, &all_rows(records, false))
}

/// From which size on `situ` is cheaper.
pub(super) fn crossover(records: &Canonical) -> Table {
    let columns = words()
        .text("hmm_fits", |row| row.meets(|cost| cost.counters.hmm_fits as f64))
        .text("em_iterations", |row| row.meets(|cost| cost.counters.em_iterations as f64))
        .text("classifier_fits", |row| row.meets(|cost| cost.counters.classifier_fits as f64))
        .wall("update_time", Shape::Text, |row| row.meets(|cost| cost.update_seconds));
    let mut rows = all_rows(records, false);
    // A full retraining has no local update.
    rows.retain(|row| axis(&row.costs).0 == "nodes" && row.costs.iter().all(|cost| cost.applicable.is_empty()));
    let source = rows.iter().map(|row| (row.key.protocol, row.costs.len())).collect::<Vec<_>>();
    rows.retain(|row| row.situ.is_some());
    Table::new(CROSSOVER, columns, &rows, source.into_iter())
}

/// Where the power laws of two costs meet, in words; `None` where one of them has none.
fn crossing(situ: &[&CostRecord], other: &[&CostRecord], of: fn(&CostRecord) -> f64) -> Option<String> {
    let law = |costs: &[&CostRecord]| {
        let points: Vec<(f64, f64)> = costs.iter().map(|cost| (f64::from(cost.nodes), of(cost))).collect();
        stats::power_law(&points)
    };
    let (situ_law, other_law) = (law(situ)?, law(other)?);
    let least = situ.iter().chain(other).map(|cost| cost.nodes).min()?;
    let growth = other_law.exponent.value - situ_law.exponent.value;
    let apart = situ_law.log_factor - other_law.log_factor;
    if growth <= 0.0 {
        return Some("never".to_owned());
    }
    let nodes = libm::exp(apart / growth);
    Some(if nodes < f64::from(least) { format!("< {least}") } else { format!("{nodes:.0}") })
}
