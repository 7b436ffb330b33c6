//! The tests of the harness from outside, in one program, but for the one that counts allocations.

mod check;
mod cost;
mod dependencies;
mod house;
mod learn;
mod provenance;
mod published;
mod readme;
mod recorded;
mod run;
mod show;
mod small;
mod tutorial;
mod update_cost;
