//! The one place that measures cost by the clock.

use std::time::Instant;

use situ::correction::Correction;
use situ::edit::{Edit, difference};
use situ::error::SituError;
use situ::method::{Learned, Method};
use situ::random::stream;
use situ::trace::Trace;

use crate::error::BenchError;
use crate::record::CostRecord;
use crate::synthetic::{Automaton, Parameters};
use crate::tally::count;

/// Runs `work`; returns its result, and the wall-clock seconds that it took.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// Runs `work`; returns its result, and the processor seconds of this thread that it took. Where the system does not
/// count those, they are the wall clock's.
pub fn processor_timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    #[cfg(unix)]
    let now = || {
        let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
    };
    #[cfg(not(unix))]
    let now = {
        let start = Instant::now();
        move || start.elapsed().as_secs_f64()
    };
    let before = now();
    let result = work();
    (result, now() - before)
}

/// One correction, by itself in a function that is never inlined. Callgrind counts what happens between its call and
/// its return.
///
/// # Errors
/// Where the method refuses the correction.
#[inline(never)]
pub fn corrected(learned: &mut dyn Learned, correction: Correction<'_>) -> Result<Trace, SituError> {
    learned.correct(correction)
}

/// The subject of measured updates: a synthetic automaton, and the task model that a method learned of it.
pub struct Subject {
    method: String,
    automaton: Automaton,
    learned: Box<dyn Learned>,
}

impl Subject {
    /// Makes an automaton and teaches it to a method. The time of that is not part of any cost.
    ///
    /// # Errors
    /// Where the parameters are out of range; [`BenchError::Argument`] where the method learned another automaton.
    pub fn teach(method: &dyn Method, parameters: Parameters) -> Result<Self, BenchError> {
        let automaton = Automaton::new(parameters)?;
        let learned = method.teach(automaton.schema(), automaton.originals(), parameters.seed)?;
        if !automaton.is_recovered(&learned.graph()?) {
            let Parameters { nodes, seed, .. } = parameters;
            let problem =
                format!("the originals of the automaton of {nodes} nodes, seed {seed}, did not teach that automaton");
            return Err(BenchError::Argument(problem));
        }
        Ok(Self { method: method.name().to_owned(), automaton, learned })
    }

    /// The automaton.
    pub fn automaton(&self) -> &Automaton {
        &self.automaton
    }

    /// The task model before any correction.
    pub fn learned(&self) -> &dyn Learned {
        &*self.learned
    }

    /// The cost of one correction of this edit, as a record of a series of a protocol. Where the correction begins is
    /// drawn from the seed of the automaton and the number of the correction. The model stays as it was.
    ///
    /// # Errors
    /// Where the correction cannot be learned.
    pub fn measure(&self, protocol: &str, series: &str, edit: Edit, correction: u32) -> Result<CostRecord, BenchError> {
        let Parameters { nodes, originals, seed, .. } = *self.automaton.parameters();
        let place = if correction == 0 { seed } else { stream(seed, &format!("correction {correction}")) };
        let planted = self.automaton.plant(edit, place)?;
        let before = self.learned.graph()?;
        let last = planted.last(&before);
        let last =
            last.ok_or_else(|| BenchError::Argument(format!("`{}` holds no segment of an original", self.method)))?;
        let mut learned = self.learned.boxed();
        let (trace, update_seconds) =
            timed(|| corrected(&mut *learned, Correction::after(last, &planted.demonstration)));
        let trace = trace?;
        Ok(CostRecord {
            protocol: protocol.to_owned(),
            series: series.to_owned(),
            method: self.method.clone(),
            nodes: count(nodes),
            originals: count(originals),
            edit,
            seed,
            correction,
            applicable: trace.steps.iter().map(|step| count(step.applicable.len())).collect(),
            model_size: trace.steps.iter().map(|step| count(step.model_size)).collect(),
            counters: trace.counters,
            edit_made: difference(&before, &learned.graph()?).edit(),
            update_seconds,
        })
    }
}
