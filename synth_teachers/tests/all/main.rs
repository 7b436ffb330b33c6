//! The tests of the teachers from outside, in one program.

mod grasps;
mod profiles;
mod teachers;
