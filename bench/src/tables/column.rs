//! Columns: a name, a shape, and the cell of each row.

use super::cell::Cell;

/// The content of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// Words.
    Text,
    /// A whole number.
    Count,
    /// A number with this many decimals in Markdown.
    Number(usize),
    /// k of n, with the Wilson 95 % interval.
    Rate,
    /// A number with its 95 % interval, and this many decimals in Markdown.
    Estimate(usize),
}

/// The head of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Head {
    pub(super) name: &'static str,
    pub(super) shape: Shape,
    /// Whether it holds the clock: the same run then gives other numbers.
    pub(super) wall: bool,
}

/// A column of a table whose rows are made of `R`.
pub(super) struct Column<'a, R> {
    pub(super) head: Head,
    pub(super) cell: Box<dyn Fn(&R) -> Cell + 'a>,
}

/// The columns of a table whose rows are made of `R`, from left to right.
pub(super) struct Columns<'a, R>(pub(super) Vec<Column<'a, R>>);

impl<'a, R> Columns<'a, R> {
    /// No column yet.
    pub(super) fn new() -> Self {
        Self(Vec::new())
    }

    /// And a column that does not hold the clock.
    pub(super) fn column<C: Into<Cell>>(self, name: &'static str, shape: Shape, cell: impl Fn(&R) -> C + 'a) -> Self {
        self.and(Head { name, shape, wall: false }, cell)
    }

    /// And a column that holds the clock.
    pub(super) fn wall<C: Into<Cell>>(self, name: &'static str, shape: Shape, cell: impl Fn(&R) -> C + 'a) -> Self {
        self.and(Head { name, shape, wall: true }, cell)
    }

    /// And a column of words.
    pub(super) fn text<C: Into<Cell>>(self, name: &'static str, cell: impl Fn(&R) -> C + 'a) -> Self {
        self.column(name, Shape::Text, cell)
    }

    /// And a column of whole numbers.
    pub(super) fn count<C: Into<Cell>>(self, name: &'static str, cell: impl Fn(&R) -> C + 'a) -> Self {
        self.column(name, Shape::Count, cell)
    }

    fn and<C: Into<Cell>>(mut self, head: Head, cell: impl Fn(&R) -> C + 'a) -> Self {
        self.0.push(Column { head, cell: Box::new(move |row| cell(row).into()) });
        self
    }
}
