//! The sampler of the BP-AR-HMM against oracles that share no code with it, and the method that builds on it.
//!
//! A wrong sampler still samples something. So Geweke's joint test checks its moves, the enumeration of every path
//! checks its sums, and another way to the same number checks its posterior. Recovery shows that all of it together
//! finds what was planted.

mod dynamics;
mod geweke;
mod primitive;
mod recovery;
mod states;
mod synthetic;
mod task;
