//! The sampler of the BP-AR-HMM against oracles that share no code with it, and what the method builds upon it.
//!
//! A sampler that is wrong still samples something. So its moves are checked by Geweke's joint test, its sums by the
//! enumeration of every path, its posterior by another route to the same number; and that all of it together finds what
//! was planted, by recovery.

#[path = "../common/mod.rs"]
mod common;
mod dynamics;
mod geweke;
mod primitive;
mod recovery;
mod states;
mod synthetic;
mod task;
