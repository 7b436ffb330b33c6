//! The gate of update cost: the work of updates and kernels now, against their work when it was last meant to change.
//!
//! Two baselines are files below `results/baselines`. [`work`] holds the exact counters of the cost suite, and the
//! instructions of its smaller updates; `situ-bench cost --check` compares with it. [`instructions`] holds the
//! instructions of kernels and of whole updates; the bench `instructions` compares with it. Counters depend on the
//! input alone, so any difference is a verdict. Instructions depend on the toolchain, the target and the processor's
//! vectors besides; they are compared where these are the same, by [`verdict::TOLERANCE`]. The clock is in no baseline.

mod baseline_file;
pub mod callgrind;
pub mod gungraun;
pub mod instructions;
pub mod origin;
pub mod verdict;
pub mod work;
