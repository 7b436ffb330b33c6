//! Parts that long verbs share: threads, a progress bar, and the interrupt.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::ProgressStyle;

use crate::error::BenchError;

/// A flag that the user's interrupt sets. A second handler in one process, as in tests, is refused, and the first one
/// stays.
pub(super) fn interrupt_flag() -> Arc<AtomicBool> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = interrupted.clone();
    let _ = ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed));
    interrupted
}

/// How a progress bar looks.
pub(super) fn progress_style() -> ProgressStyle {
    ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed} ({eta} left) {wide_msg}")
        .expect("the template is a constant that the tests draw")
}

/// So many threads. One for each processor where no number is given.
pub(super) fn threads(jobs: Option<u16>) -> Result<rayon::ThreadPool, BenchError> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(jobs.map_or(0, usize::from))
        .build()
        .map_err(|error| BenchError::Argument(format!("no threads: {error}")))
}
