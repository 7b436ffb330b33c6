//! The tests of the teachers from outside, in one program.

mod profiles;
mod teachers;
