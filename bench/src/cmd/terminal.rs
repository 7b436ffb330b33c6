//! Parts that long verbs share: threads, signs of life, and the interrupt.

use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;

use crate::error::BenchError;
use crate::files;

/// How long work that was interrupted may go on to its next end.
const PATIENCE: Duration = Duration::from_millis(1500);
/// How often a program that no terminal shows gives a sign of life.
const SIGN: Duration = Duration::from_secs(60);
/// Threads for each processor, at the most. More only cost memory.
const THREADS: usize = 8;

/// Says something to the user. A standard error that takes nothing more is no failure.
pub fn say(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// A flag that the user's interrupt sets. Work that does not heed it in time is cut off between two writes: no file is
/// left half written, and every finished run is in its ledger. A second handler in one process, as in tests, is
/// refused, and the first one stays. Where the work is cut off, `last` is done and `error` is said.
pub(super) fn interrupt_flag(error: BenchError, last: impl Fn() + Clone + Send + 'static) -> Arc<AtomicBool> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = interrupted.clone();
    let (text, status) = (format!("error: {error}"), error.exit_status());
    let _ = ctrlc::set_handler(move || {
        if !flag.swap(true, Ordering::Relaxed) {
            let (text, last) = (text.clone(), last.clone());
            thread::spawn(move || {
                thread::sleep(PATIENCE);
                let _between_writes = files::held();
                last();
                say(&text);
                std::process::exit(status.into());
            });
        }
    });
    interrupted
}

/// What is left to do, shown as a bar in a terminal, and as a line now and then where there is none.
pub(super) struct Signs {
    bar: ProgressBar,
    begun: Instant,
    /// How much is done, and when that was last said.
    said: Mutex<(u64, Instant)>,
    is_shown: bool,
}

impl Signs {
    /// Signs of so many pieces of work.
    pub(super) fn of(pieces: usize) -> Self {
        let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed} {wide_msg}");
        let bar = ProgressBar::new(pieces as u64).with_style(style.expect("the template is a constant"));
        let now = Instant::now();
        Self { bar, begun: now, said: Mutex::new((0, now)), is_shown: io::stderr().is_terminal() }
    }

    /// What is being done.
    pub(super) fn at(&self, what: &str) {
        self.bar.set_message(what.to_owned());
        self.sign(0);
    }

    /// A piece is done.
    pub(super) fn finished(&self) {
        self.bar.inc(1);
        self.sign(1);
    }

    /// All is done.
    pub(super) fn end(&self) {
        self.bar.finish_and_clear();
    }

    fn sign(&self, more: u64) {
        let Ok(mut said) = self.said.lock() else { return };
        said.0 += more;
        if self.is_shown || said.1.elapsed() < SIGN {
            return;
        }
        said.1 = Instant::now();
        let (done, all) = (said.0, self.bar.length().unwrap_or(0));
        let minutes = self.begun.elapsed().as_secs_f64() / 60.0;
        // Nobody knows how long the rest takes before anything is done.
        let left = match done {
            0 => String::new(),
            _ => format!(", some {:.0} min left", minutes * all.saturating_sub(done) as f64 / done as f64),
        };
        say(&format!("{done} of {all} done in {minutes:.0} min{left}"));
    }
}

/// So many threads. One for each processor where no number is given; a number that only costs memory is made smaller.
pub(super) fn threads(jobs: Option<u16>) -> Result<rayon::ThreadPool, BenchError> {
    let processors = thread::available_parallelism().map_or(1, usize::from);
    let most = THREADS * processors;
    let wanted = jobs.map_or(0, usize::from);
    if wanted > most {
        say(&format!("warning: --jobs {wanted}: {most} threads are used, {THREADS} for each processor"));
    }
    rayon::ThreadPoolBuilder::new()
        .num_threads(wanted.min(most))
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
    let interrupted = interrupt_flag(BenchError::Stopped, || ());
    let signs = Signs::of(things.len());
    let done = threads(jobs)?.install(|| {
        let done = things.par_iter().map(|thing| {
            if interrupted.load(Ordering::Relaxed) {
                return Err(BenchError::Stopped);
            }
            signs.at(&label(thing));
            let result = work(thing, &interrupted);
            signs.finished();
            result
        });
        done.collect()
    });
    signs.end();
    done
}
