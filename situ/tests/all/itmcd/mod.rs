//! The method `itmcd`: its model (STARHMM) against brute force and planted truths, its criterion against numbers
//! computed by hand, and its choice of an edit on block sorting.

mod blocks;
mod criterion;
mod random_model;
mod sorting;
mod starhmm;
