//! All tests of the teachers in one program.

mod profiles;
mod teachers;
