//! T4: what an update of a synthetic automaton costs, how that grows, and from which size on a local update is the cheaper one.

use std::collections::{BTreeMap, BTreeSet};

use situ::edit::Edit;
use situ::trace::Counters;

use super::cost::{COUNTERS, MILLISECONDS_PER_SECOND, counter_columns, medians};
use super::{Cell, Column, MethodName, Methods, Shape, Table, column, estimate, made, median, number, seed, wall};
use crate::record::{Cost, Record};
use crate::stats;

/// The method that others' costs are divided by.
const SITU: &str = "situ";

const SCALING: &str = "Synthetic automata, one planted correction each: median exact work of the update, and its time. The ratio is that \
method's cost divided by that of `situ` on the same automata, paired by seed, with a 95 % bootstrap interval. A series varies one thing: the nodes with \
|Z| held fixed, the nodes with |Z| left free, or the original demonstrations.";
const SLOPES: &str = "Slope of ln(cost) over the logarithm of what the series varies, by least squares over all its automata, with Student's 95 % \
interval: 0 is a cost that does not depend on it, 1 one that grows in proportion. `classifier evaluations` is the linear scan of A1.6. A dash: too \
few sizes, or a cost of 0.";
const CROSSOVER: &str = "The number of nodes below which full retraining is cheaper than `situ`, where the fitted power laws of the two meet: in \
exact work and by the clock. `< n`: below the smallest automaton that was measured, `situ` is cheaper at all of them; `never`: the lines do not meet \
above it.";

/// Protocol, series, method, edit, and in sized tables nodes and originals.
type Row<'a> = (&'a str, &'a str, MethodName, Edit, (u32, u32));

fn rows<'a>(records: &'a [Record], methods: &Methods, sized: bool) -> BTreeMap<Row<'a>, Vec<&'a Cost>> {
    let mut rows: BTreeMap<Row, Vec<&Cost>> = BTreeMap::new();
    for record in records {
        if let Record::Cost(cost) = record {
            let size = if sized { (cost.nodes, cost.originals) } else { (0, 0) };
            let row = (&*cost.protocol, &*cost.series, methods.name(&cost.method), cost.edit, size);
            rows.entry(row).or_default().push(cost);
        }
    }
    rows
}

fn words((protocol, series, method, edit, _): &Row) -> Vec<Cell> {
    [*protocol, *series, &method.name, edit.name()].map(|word| Cell::Text(word.to_owned())).to_vec()
}

fn word_columns() -> impl Iterator<Item = Column> {
    ["protocol", "series", "method", "edit_planted"].into_iter().map(|name| column(name, Shape::Text))
}

fn finished(
    id: &'static str,
    title: &'static str,
    note: &'static str,
    columns: Vec<Column>,
    rows: &BTreeMap<Row, Vec<&Cost>>,
    cells: Vec<Vec<Cell>>,
) -> Table {
    Table {
        id,
        title,
        note,
        columns,
        rows: cells,
        protocols: rows.keys().map(|row| row.0.to_owned()).collect(),
        records: rows.values().map(Vec::len).sum(),
    }
}

/// Cost of updates by the size of the automaton, from records in canonical order.
pub(super) fn scaling(records: &[Record]) -> Table {
    let methods = Methods::listed();
    let rows = rows(records, &methods, true);
    let rendered = rows.iter().map(|(row, costs)| {
        let (protocol, series, method, edit, (nodes, originals)) = row;
        let label = format!("t4/scaling/{protocol}/{series}/{}/{edit}/{nodes}/{originals}", method.name);
        let counters: Vec<Counters> = costs.iter().map(|cost| cost.counters).collect();
        let times: Vec<f64> = costs.iter().map(|cost| cost.update_seconds * MILLISECONDS_PER_SECOND).collect();
        let applicable: Vec<f64> = costs.iter().flat_map(|cost| &cost.applicable).map(|z| f64::from(*z)).collect();
        let own = method.name == SITU;
        let situ = (!own).then(|| rows.get(&(*protocol, *series, methods.name(SITU), *edit, row.4))).flatten();
        let ratio = |quantity, of: fn(&Cost) -> f64| {
            let pairs: Vec<(f64, f64)> = costs
                .iter()
                .filter_map(|cost| {
                    let other = situ?.iter().find(|other| other.seed == cost.seed)?;
                    Some((of(cost), of(other)))
                })
                .collect();
            estimate(stats::paired_ratio(&pairs, seed(&label, quantity)))
        };
        let mut cells = words(row);
        cells.extend([*nodes as usize, *originals as usize, costs.len()].map(Cell::Count));
        cells.push(made(costs.iter().map(|cost| cost.edit_made)));
        cells.push(number(stats::median(&applicable)));
        cells.extend(medians(&counters));
        cells.push(ratio("hmm_fits", |cost| cost.counters.hmm_fits as f64));
        cells.push(median(&times, seed(&label, "time")));
        cells.push(ratio("time", |cost| cost.update_seconds));
        cells
    });
    let columns = word_columns()
        .chain(["nodes", "originals", "automata"].map(|name| column(name, Shape::Count)))
        .chain([column("edit_made", Shape::Text), column("|Z|", Shape::Number(1))])
        .chain(counter_columns(Shape::Number(1)))
        .chain([column("hmm_fits_ratio", Shape::Estimate(1))])
        .chain([wall("update_ms", Shape::Estimate(3)), wall("ratio", Shape::Estimate(1))]);
    let title = "T4 update cost by the size of the task model";
    finished("t4_scaling", title, SCALING, columns.collect(), &rows, rendered.collect())
}

/// What a series varies, and by how much each of its automata has of it.
fn axis(costs: &[&Cost]) -> (&'static str, fn(&Cost) -> f64) {
    let sizes: BTreeSet<u32> = costs.iter().map(|cost| cost.nodes).collect();
    if sizes.len() > 1 {
        ("nodes", |cost| f64::from(cost.nodes))
    } else {
        ("originals", |cost| f64::from(cost.originals))
    }
}

/// How the costs of updates grow, from records in canonical order.
pub(super) fn slopes(records: &[Record]) -> Table {
    let methods = Methods::listed();
    let rows = rows(records, &methods, false);
    let rendered = rows.iter().map(|(row, costs)| {
        let (name, size) = axis(costs);
        let slope = |of: &dyn Fn(&Cost) -> f64| {
            let points: Vec<(f64, f64)> = costs.iter().map(|cost| (size(cost), of(cost))).collect();
            estimate(stats::power_law(&points).map(|law| law.exponent))
        };
        let mean = |z: &[u32]| stats::mean(&z.iter().map(|z| f64::from(*z)).collect::<Vec<_>>()).unwrap_or_default();
        let mut cells = words(row);
        cells.push(Cell::Text(name.to_owned()));
        cells.push(Cell::Count(costs.len()));
        cells.push(slope(&|cost| mean(&cost.applicable)));
        cells.extend((0..COUNTERS.len()).map(|index| slope(&|cost| cost.counters.named()[index].1 as f64)));
        cells.push(slope(&|cost| cost.update_seconds));
        cells
    });
    let columns = word_columns()
        .chain([column("over", Shape::Text), column("automata", Shape::Count), column("|Z|", Shape::Estimate(2))])
        .chain(counter_columns(Shape::Estimate(2)))
        .chain([wall("update_time", Shape::Estimate(2))]);
    let title = "T4 growth of the update cost";
    finished("t4_slopes", title, SLOPES, columns.collect(), &rows, rendered.collect())
}

/// From which size on `situ` is cheaper, from records in canonical order.
pub(super) fn crossover(records: &[Record]) -> Table {
    let methods = Methods::listed();
    let mut rows = rows(records, &methods, false);
    let costs = rows.clone();
    // A full retraining has no local update.
    rows.retain(|_, costs| axis(costs).0 == "nodes" && costs.iter().all(|cost| cost.applicable.is_empty()));
    let rendered = rows.iter().filter_map(|(row, others)| {
        let situ = costs.get(&(row.0, row.1, methods.name(SITU), row.3, row.4))?;
        let meet = |of: fn(&Cost) -> f64| crossing(situ, others, of).map_or(Cell::Nothing, Cell::Text);
        let mut cells = words(row);
        cells.push(meet(|cost| cost.counters.hmm_fits as f64));
        cells.push(meet(|cost| cost.counters.em_iterations as f64));
        cells.push(meet(|cost| cost.counters.classifier_fits as f64));
        cells.push(meet(|cost| cost.update_seconds));
        Some(cells)
    });
    let counted = ["hmm_fits", "em_iterations", "classifier_fits"].map(|name| column(name, Shape::Text));
    let columns = word_columns().chain(counted).chain([wall("update_time", Shape::Text)]);
    let title = "T4 crossover: the nodes below which retraining is cheaper";
    let cells: Vec<Vec<Cell>> = rendered.collect();
    finished("t4_crossover", title, CROSSOVER, columns.collect(), &rows, cells)
}

/// Where the power laws of two costs meet, in words; `None` where one of them has none.
fn crossing(situ: &[&Cost], other: &[&Cost], of: fn(&Cost) -> f64) -> Option<String> {
    let law = |costs: &[&Cost]| {
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
