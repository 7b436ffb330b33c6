//! Parts that long verbs share: threads, a progress bar, and the interrupt.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;

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

/// Does a piece of work for each thing, on so many threads and behind a progress bar that shows the labels. The results
/// are in the order of the things. The work is told of the flag of the user's interrupt.
///
/// # Errors
/// The error of a piece of work; [`BenchError::Stopped`] where the user wants to stop.
pub(super) fn each<T: Sync, R: Send>(
    jobs: Option<u16>,
    things: &[T],
    label: impl Fn(&T) -> String + Sync,
    work: impl Fn(&T, &AtomicBool) -> Result<R, BenchError> + Sync,
) -> Result<Vec<R>, BenchError> {
    let interrupted = interrupt_flag();
    let bar = ProgressBar::new(things.len() as u64).with_style(progress_style());
    let done = threads(jobs)?.install(|| {
        let done = things.par_iter().map(|thing| {
            if interrupted.load(Ordering::Relaxed) {
                return Err(BenchError::Stopped);
            }
            bar.set_message(label(thing));
            let result = work(thing, &interrupted);
            bar.inc(1);
            result
        });
        done.collect()
    });
    bar.finish_and_clear();
    done
}
