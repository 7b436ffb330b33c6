//! Cells of tables as the lines of a chart.

use super::column::Cell;
use crate::chart::{ChartPoint, Line};

/// The lines of these cells, each with its name and place; a cell that says nothing has no point, and a line without a
/// point is left out.
pub(super) fn lines<'a>(cells: impl Iterator<Item = (&'a str, f64, Cell)>) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    for (name, x, cell) in cells {
        let Cell::Pooled(pooled, _) = cell else { continue };
        let point = ChartPoint { x, y: pooled.value, interval: pooled.units };
        match lines.iter_mut().find(|line| line.name == name) {
            Some(line) => line.points.push(point),
            None => lines.push(Line { name: name.to_owned(), points: vec![point] }),
        }
    }
    lines
}
