//! The tests of the tasks from outside, in one program.

mod conformance;
mod examples;
mod mistakes;
mod predicates;
mod slides;
