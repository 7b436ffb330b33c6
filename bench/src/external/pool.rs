//! The processes of one external method. Each holds one model at a time.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde_json::{Map, Value, json};

use super::file::Described;
use super::interrupt::Interrupt;
use super::log::Log;
use super::process::{Fault, Process};
use super::told::Told;

/// The version of the questions and answers.
const PROTOCOL: u32 = 1;
/// How often somebody who waits for a process looks up.
const LOOK: Duration = Duration::from_millis(50);

/// A process, what it says that it is, and which model it holds.
struct Worker {
    process: Process,
    hello: Map<String, Value>,
    holds: Option<u64>,
}

/// The processes that nobody asks at the moment, the one that was asked longest ago first; and how many there are.
#[derive(Default)]
struct Workers {
    idle: VecDeque<Worker>,
    count: usize,
}

/// The processes of a method.
pub(super) struct Pool {
    pub(super) described: Described,
    pub(super) log: Arc<Log>,
    interrupt: Interrupt,
    workers: Mutex<Workers>,
    freed: Condvar,
}

/// A worker that goes back to its pool when it is no longer asked, or is given up.
struct Taken<'a> {
    pool: &'a Pool,
    worker: Option<Worker>,
}

impl Drop for Taken<'_> {
    fn drop(&mut self) {
        let mut workers = self.pool.workers();
        match self.worker.take() {
            Some(worker) => workers.idle.push_back(worker),
            None => workers.count -= 1,
        }
        drop(workers);
        self.pool.freed.notify_one();
    }
}

impl Pool {
    pub(super) fn new(described: Described, interrupt: Interrupt) -> Self {
        let log = Arc::new(Log::new(&described.name));
        Self { described, log, interrupt, workers: Mutex::default(), freed: Condvar::new() }
    }

    fn workers(&self) -> MutexGuard<'_, Workers> {
        self.workers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The most processes that there may be at once.
    pub(super) fn most(&self) -> usize {
        self.described.processes.unwrap_or_else(rayon::current_num_threads).max(1)
    }

    /// Asks what the method is.
    ///
    /// # Errors
    /// [`Fault`].
    pub(super) fn hello(&self) -> Result<Map<String, Value>, Fault> {
        let taken = self.take(None)?;
        Ok(taken.worker.as_ref().map(|worker| worker.hello.clone()).unwrap_or_default())
    }

    /// A new process, greeted.
    fn start(&self) -> Result<Worker, Fault> {
        let mut process = Process::start(&self.described, &self.log).map_err(Fault::Broken)?;
        let question = question(json!({"do": "hello", "protocol": PROTOCOL}));
        let hello = process.ask(&question, self.described.limits.start, &self.interrupt)?;
        Ok(Worker { process, hello, holds: None })
    }

    /// Asks a process that holds this model.
    ///
    /// # Errors
    /// [`Fault`].
    pub(super) fn asked<T>(
        &self,
        told: &Told,
        ask: impl FnOnce(&mut Asked<'_>) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        let mut taken = self.take(Some(told.id))?;
        let worker = taken.worker.as_mut().expect("it is given back in the end");
        let result = match worker.holds {
            Some(id) if id == told.id => Ok(()),
            _ => {
                worker.holds = None;
                let result = self.tell(&mut worker.process, told);
                worker.holds = result.is_ok().then_some(told.id);
                result
            }
        };
        let result = result.and_then(|()| ask(&mut Asked { pool: self, worker }));
        if let Err(Fault::Broken(_)) = result {
            taken.worker = None;
        }
        result
    }

    /// Tells a process all that makes a model.
    fn tell(&self, process: &mut Process, told: &Told) -> Result<(), Fault> {
        if let Some(Some(model)) = told.saved.get() {
            let load = question(json!({"do": "load", "model": model}));
            return process.ask(&load, self.described.limits.teach, &self.interrupt).map(|_| ());
        }
        let (teach, correct) = (self.described.limits.teach, self.described.limits.correct);
        for (index, question) in told.questions().into_iter().enumerate() {
            process.ask(question, if index == 0 { teach } else { correct }, &self.interrupt)?;
        }
        Ok(())
    }

    /// Makes a model: asks the first question about it of a process that holds none or one of others.
    ///
    /// # Errors
    /// [`Fault`].
    pub(super) fn made(&self, question: &Map<String, Value>) -> Result<(Map<String, Value>, Mark<'_>), Fault> {
        let mut taken = self.take(None)?;
        let worker = taken.worker.as_mut().expect("it is given back in the end");
        worker.holds = None;
        match worker.process.ask(question, self.described.limits.teach, &self.interrupt) {
            Ok(answer) => Ok((answer, Mark(taken))),
            Err(fault) => {
                if let Fault::Broken(_) = fault {
                    taken.worker = None;
                }
                Err(fault)
            }
        }
    }

    /// Takes a process: one that holds this model if there is one, else one that holds none, else a new one, else the
    /// one that was asked longest ago.
    fn take(&self, id: Option<u64>) -> Result<Taken<'_>, Fault> {
        let mut workers = self.workers();
        loop {
            let holds = |wanted: Option<u64>| move |worker: &Worker| worker.holds == wanted;
            let index = id.and_then(|id| workers.idle.iter().position(holds(Some(id))));
            let index = index.or_else(|| workers.idle.iter().position(holds(None)));
            let is_full = workers.count >= self.most();
            if let Some(index) = index.or_else(|| (is_full && !workers.idle.is_empty()).then_some(0)) {
                let worker = workers.idle.remove(index);
                return Ok(Taken { pool: self, worker });
            }
            if !is_full {
                workers.count += 1;
                drop(workers);
                let mut taken = Taken { pool: self, worker: None };
                taken.worker = Some(self.start()?);
                return Ok(taken);
            }
            if self.interrupt.is_set() {
                return Err(Fault::Broken("interrupted".to_owned()));
            }
            workers = self.freed.wait_timeout(workers, LOOK).unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

/// A process that was just told the first of a model; it holds the model as soon as that has a number.
pub(super) struct Mark<'a>(Taken<'a>);

impl Mark<'_> {
    pub(super) fn holds(mut self, told: &Told) {
        if let Some(worker) = self.0.worker.as_mut() {
            worker.holds = Some(told.id);
        }
    }
}

/// A process that holds the model that is asked about.
pub(super) struct Asked<'a> {
    pool: &'a Pool,
    worker: &'a mut Worker,
}

impl Asked<'_> {
    /// Asks a question that changes nothing.
    ///
    /// # Errors
    /// [`Fault`].
    pub(super) fn ask(&mut self, question: &Map<String, Value>) -> Result<Map<String, Value>, Fault> {
        self.worker.process.ask(question, self.pool.described.limits.ask, &self.pool.interrupt)
    }

    /// Folds a correction in. Until it is said what the model then is, the process holds none that anybody knows.
    ///
    /// # Errors
    /// [`Fault`].
    pub(super) fn correct(&mut self, question: &Map<String, Value>) -> Result<Map<String, Value>, Fault> {
        let held = self.worker.holds.take();
        let answer = self.worker.process.ask(question, self.pool.described.limits.correct, &self.pool.interrupt);
        if let Err(Fault::Refused(_)) = answer {
            self.worker.holds = held;
        }
        answer
    }

    /// The process now holds this model.
    pub(super) fn holds(&mut self, told: &Told) {
        self.worker.holds = Some(told.id);
    }
}

/// The fields of a question.
pub(super) fn question(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(fields) => fields,
        _ => Map::new(),
    }
}
