//! wip
pub mod criterion;
pub mod starhmm;
