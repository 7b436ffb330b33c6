//! The methods that refine single primitives. Each rule is tested against what was published or what brute force finds,
//! and all of them with the automaton that they must not change.
//!
//! A published bound (the regret of coactive learning) is tested at every step of every draw. A published direction
//! (one weight at a time against all at once) is tested over many draws, with its spread. If a method has an exact
//! answer (the plan, the regression), it is compared with an implementation that shares no code.

mod coactive;
mod fixture;
mod gmr;
mod keyframe_model;
mod one_at_a_time;
mod plan;
mod structure;
