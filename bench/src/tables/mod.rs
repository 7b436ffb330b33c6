//! Tables: projections of the ledger's records and of nothing else, so that equal records give equal bytes.
//!
//! A table is made once, as cells. Markdown, LaTeX, CSV and text for a terminal are ways to write it: where the others
//! say `18/20 [0.70, 0.97]`, CSV has a column for each of the four numbers. Columns that hold the clock come last; in
//! CSV their names end in `_wall`.
//!
//! To add a table, declare a [`Publication`] in a file of its own here, and name it in [`ALL`].

mod aligned;
mod column;
mod comparison;
mod confidence;
mod cost;
mod edits;
mod effort;
mod endings;
mod grades;
mod group;
mod growth;
mod heading;
mod headline;
mod latex;
mod measure;
mod methods;
mod paired;
mod plotted;
mod pooled;
mod questions;
mod retention;
mod rows;
mod separate;
mod sequences;
mod summary;
mod table;
mod teachers;
mod untouched;

pub use comparison::differs;
pub use heading::Heading;
pub use summary::summary;
pub use table::{Figure, Publication, Table};

/// All publications, in order: those that answer the first questions come first.
pub const ALL: [&Publication; 14] = [
    &headline::HEADLINE,
    &questions::QUESTIONS,
    &paired::PAIRED,
    &effort::T1,
    &separate::T2,
    &edits::T3,
    &cost::T4,
    &untouched::UNTOUCHED,
    &retention::T5,
    &grades::GRADES,
    &teachers::T6,
    &confidence::T7,
    &methods::METHODS,
    &endings::ENDINGS,
];

/// The publication of a protocol of update cost alone.
pub const COST: &Publication = &cost::T4;

#[cfg(test)]
mod tests;
