//! The tests of the learner from outside, in one program, but for the one that counts allocations.

mod bp_ar_hmm;
mod common;
mod decisions;
mod direct;
mod itmcd;
mod kernels;
mod listing;
mod methods;
mod people;
mod read_again;
mod reference;
mod refinement;
mod refusals;
mod small_cases;
mod structure;
mod true_keyframes;
mod update;
mod ways;
