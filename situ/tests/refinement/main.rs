//! The methods that refine single primitives: each rule against what was published or can be had by brute force, and
//! all of them under the automaton that they must leave as it was.
//!
//! A bound that is published (the regret of coactive learning) is held at every step of every draw; a direction that is
//! published (one weight at a time against all at once) over many draws, with its spread, the figures printed
//! (`-- --nocapture`). Where a method has an exact answer (the plan, the regression), it is compared with one that
//! shares no code.

#[path = "../common/mod.rs"]
mod common;

mod coactive;
mod fixture;
mod gmr;
mod keyframe_model;
mod one_at_a_time;
mod plan;
mod structure;
