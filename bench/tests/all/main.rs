//! The tests of the harness in one program, but for the one that counts allocations.

mod check;
mod cost;
mod dependencies;
mod house;
mod learn;
mod readme;
mod run;
mod show;
mod tutorial;
mod update_cost;
