//! Tables and intervals as all checks print them.

use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};

use crate::stats;
use crate::tally::Rate;

/// A share with its interval.
pub(super) fn with_interval(rate: Rate) -> String {
    let (low, high) = stats::wilson(rate.successes, rate.rollouts.max(1));
    format!("{}/{} [{low:.3}, {high:.3}]", rate.successes, rate.rollouts)
}

/// A table whose first columns are text and whose other columns are numbers.
pub(super) fn table(heads: &[&str], text: usize) -> Table {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN).set_header(heads.to_vec());
    table.column_iter_mut().skip(text).for_each(|column| column.set_cell_alignment(CellAlignment::Right));
    table
}
