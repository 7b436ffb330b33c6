//! All tests of the tasks in one program.

mod conformance;
mod mistakes;
mod predicates;
mod slides;
