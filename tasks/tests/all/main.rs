//! The tests of the tasks from outside, in one program.

mod conformance;
mod mistakes;
mod predicates;
mod slides;
