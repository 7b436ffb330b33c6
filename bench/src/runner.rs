//! All runs of a plan: in parallel, written as they finish, resumable.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::panic::{self, AssertUnwindSafe};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;
use situ::edit::Edit;
use situ::method::{self, Method, Role};
use situ_tasks::Setting;

use crate::archive::Archive;
use crate::conditions::Conditions;
use crate::cost::Subject;
use crate::error::BenchError;
use crate::ledger::Ledger;
use crate::memo::{Memo, Room};
use crate::plan::{CostGroup, Family, Group, Plan, Sequence};
use crate::record::{Identity, Key, Outcome, Record, RunRecord};
use crate::session::Uncorrected;
use crate::spending::{RunPhase, Spending};
use crate::synthetic::Parameters;
use crate::teaching::OriginalTask;

/// Told how the runs go on.
pub trait Progress: Sync {
    /// A run begins, or ends.
    fn at(&self, what: &str);
    /// A run is finished.
    fn finished(&self);
}

/// Does the runs of a plan. The records do not depend on the number of threads; their order in the ledger does.
#[derive(Clone, Copy)]
pub struct Runner<'a> {
    /// The plan.
    pub plan: &'a Plan,
    /// Each record is added to it as its run finishes.
    pub ledger: &'a Mutex<Ledger>,
    /// The names of the runs that are not done again.
    pub done: &'a BTreeSet<Identity>,
    /// Set when the user wants to stop.
    pub interrupted: &'a AtomicBool,
    /// Where the demonstrations are written, if anywhere.
    pub archive: Option<&'a Archive>,
    /// Told how the runs go on.
    pub progress: &'a dyn Progress,
    /// Told where the time goes.
    pub spending: &'a Spending,
}

/// The runs of a group that are left.
struct Left<'a> {
    singles: Vec<(&'a Arc<Setting>, Vec<&'a dyn Method>)>,
    sequences: Vec<SequenceLeft<'a>>,
}

/// A sequence that a method has not done to its end. A stage needs the ones before it, so all of it is run again.
struct SequenceLeft<'a> {
    sequence: &'a Sequence,
    method: &'a dyn Method,
    /// The stages whose records are not in the ledger.
    stages: BTreeSet<usize>,
}

/// The original task as each model of it was taught, by [`Method::original`], with the first method that has that
/// model.
type Originals<'a> = BTreeMap<&'a str, (&'a dyn Method, OriginalTask, Broken)>;

/// Each original model, and how it does on a changed task before corrections, or how that broke off.
type Befores<'o> = BTreeMap<&'o str, (&'o OriginalTask, Result<Uncorrected, Outcome>)>;

/// How a run ended that was not done to its end; `None` where it was.
type Broken = Option<Outcome>;

impl<'a> Runner<'a> {
    /// Does all runs that are not done.
    ///
    /// # Errors
    /// [`BenchError::Interrupted`] where the flag was set; an error of a run or the ledger.
    pub fn run(&self) -> Result<(), BenchError> {
        // Costs first, one after another and nothing beside them: they are timed.
        self.plan.costs.iter().try_for_each(|group| self.costs(group))?;
        let room = Room::default();
        // The longest first, so that no processor is left without work at the end.
        let mut groups: Vec<&Group> = self.plan.groups.iter().collect();
        groups.sort_by_key(|group| std::cmp::Reverse(group.family.beads()));
        groups.into_iter().par_bridge().try_for_each(|group| self.group(group, &room))
    }

    fn write(&self, record: Record) -> Result<(), BenchError> {
        let result = self.ledger.lock().unwrap_or_else(PoisonError::into_inner).append(&record);
        self.progress.finished();
        result
    }

    /// The updates of one automaton that are left.
    fn costs(&self, group: &CostGroup) -> Result<(), BenchError> {
        let Parameters { nodes, seed, .. } = group.parameters;
        let protocol = &self.plan.protocol.name;
        let identity = |edit, correction| group.identity(protocol, edit, correction);
        let all = Edit::ALL.into_iter().flat_map(|edit| (0..group.corrections).map(move |number| (edit, number)));
        let (done, left): (Vec<_>, Vec<_>) =
            all.partition(|(edit, number)| self.done.contains(&identity(*edit, *number)));
        done.iter().for_each(|_| self.progress.finished());
        if left.is_empty() {
            return Ok(());
        }
        let (series, name) = (&group.series, group.method.name());
        self.progress.at(&format!("update cost, {series}, {name}, {nodes} nodes, seed {seed}"));
        let subject = Subject::teach(&*group.method, group.parameters)?;
        for (edit, number) in left {
            if self.interrupted.load(Ordering::Relaxed) {
                return Err(BenchError::Interrupted);
            }
            self.write(Record::Cost(subject.measure(protocol, series, edit, number)?))?;
        }
        Ok(())
    }

    /// The runs of one original task, teacher and seed that are left.
    fn group(&self, group: &Group, room: &Room) -> Result<(), BenchError> {
        let memo = Memo::new(room);
        let conditions = Conditions {
            protocol: &self.plan.protocol,
            teacher: &group.teacher,
            content: &group.content,
            seed: group.seed,
            schema: &group.family.schema,
            interrupted: self.interrupted,
            archive: self.archive,
            task: &group.family.original.task,
            memo: &memo,
            spending: self.spending,
            phase: RunPhase::Teach,
            steps: &AtomicU64::new(0),
        };
        let left = self.left(&conditions, &group.family);
        if left.singles.is_empty() && left.sequences.is_empty() {
            return Ok(());
        }
        let original = &group.family.original;
        let teacher = &group.teacher.profile().name;
        self.progress.at(&format!("{}, {teacher}, seed {}: teaching", original.task, group.seed));
        let originals = originals(&conditions, original, &left)?;
        let conditions = conditions.during(RunPhase::Evaluate);
        left.singles.iter().par_bridge().try_for_each(|(setting, methods)| {
            let befores = befores(&conditions, setting, methods, &originals)?;
            // One method after another: what one has simulated, the next one need not.
            methods.iter().try_for_each(|method| {
                self.progress.at(&Identity::Run(conditions.key(setting, *method)).to_string());
                let (task, before) = &befores[method.original()];
                let run = before.as_ref().map_err(Outcome::clone).map(|before| {
                    let conditions = Conditions { steps: &AtomicU64::new(0), ..conditions };
                    contained(&conditions, || conditions.run(setting, *method, task, before))
                });
                let run = run.unwrap_or_else(|outcome| Ok(Err(outcome)))?;
                let failed = |outcome| conditions.failed(setting, *method, task, before.as_ref().ok(), outcome);
                self.write(Record::Run(run.unwrap_or_else(failed)))
            })?;
            conditions.memo.forget(&setting.label());
            Ok::<(), BenchError>(())
        })?;
        left.sequences.par_iter().try_for_each(|left| self.sequence(&conditions, left, &originals))
    }

    /// The stages of a sequence that are left. A stage that is not done to its end is the end of all after it.
    fn sequence(
        &self,
        conditions: &Conditions<'_>,
        left: &SequenceLeft<'_>,
        originals: &Originals<'_>,
    ) -> Result<(), BenchError> {
        let SequenceLeft { sequence: Sequence { name, settings }, method, stages } = left;
        let key = |index: usize| conditions.stage_key(name, index, &settings[index], *method);
        self.progress.at(&Identity::Run(key(0)).to_string());
        let (_, task, broken) = &originals[method.original()];
        let mut runs = Vec::new();
        let broken = match broken {
            Some(outcome) => Some(outcome.clone()),
            None => {
                let conditions = Conditions { steps: &AtomicU64::new(0), ..*conditions };
                contained(&conditions, || conditions.run_sequence(name, settings, *method, task, &mut runs))?.err()
            }
        };
        if let Some(outcome) = broken {
            let rest = (runs.len()..settings.len()).map(|index| {
                let run = conditions.failed(&settings[index], *method, task, None, outcome.clone());
                RunRecord { key: key(index), ..run }
            });
            runs.extend(rest.collect::<Vec<_>>());
        }
        let left = runs.into_iter().enumerate().filter(|(index, _)| stages.contains(index));
        left.map(|(_, run)| run).try_for_each(|run| self.write(Record::Run(run)))
    }

    /// The runs of a group that are left.
    fn left(&self, conditions: &Conditions<'_>, family: &'a Family) -> Left<'a> {
        let methods = || self.plan.methods.iter().map(|method| &**method);
        let singles = family.variations.iter().map(|setting| {
            let left = self.plan.methods_for(setting);
            let left = left.filter(|method| !self.is_done(conditions.key(setting, *method)));
            (setting, left.collect::<Vec<_>>())
        });
        let singles = singles.filter(|(_, left)| !left.is_empty()).collect();
        let mut sequences = Vec::new();
        for sequence in &family.sequences {
            for method in methods().filter(|method| method.role() != Role::FromScratch) {
                let stages = sequence.settings.iter().enumerate();
                let key = |index, setting| conditions.stage_key(&sequence.name, index, setting, method);
                let left = stages.filter(|(index, setting)| !self.is_done(key(*index, setting)));
                let stages: BTreeSet<usize> = left.map(|(index, _)| index).collect();
                if !stages.is_empty() {
                    sequences.push(SequenceLeft { sequence, method, stages });
                }
            }
        }
        Left { singles, sequences }
    }

    /// Whether a run is done; if so, progress is told.
    fn is_done(&self, key: Key) -> bool {
        let is_done = self.done.contains(&Identity::Run(key));
        if is_done {
            self.progress.finished();
        }
        is_done
    }
}

/// Does a part of a run. What the method refuses or makes nonsense of, a run without an end, and a panic, is how this
/// run ended; what the machine or the user does is an error.
fn contained<T>(
    conditions: &Conditions<'_>,
    part: impl FnOnce() -> Result<T, BenchError>,
) -> Result<Result<T, Outcome>, BenchError> {
    match panic::catch_unwind(AssertUnwindSafe(part)) {
        Ok(Ok(done)) => Ok(Ok(done)),
        // Whoever waited for another program has given up.
        Ok(Err(_)) if conditions.check_interrupt().is_err() => Err(BenchError::Interrupted),
        Ok(Err(error)) => match error {
            BenchError::Situ(_)
            | BenchError::Nameless { .. }
            | BenchError::Unheld { .. }
            | BenchError::Unusable { .. }
            | BenchError::Improbable { .. } => Ok(Err(Outcome::MethodError { why: error.to_string() })),
            BenchError::OutOfSteps { .. } => Ok(Err(Outcome::TimedOut { why: error.to_string() })),
            error => Err(error),
        },
        Err(thrown) => {
            let text = thrown.downcast_ref::<&str>().map(|text| (*text).to_owned());
            let text = text.or_else(|| thrown.downcast_ref::<String>().cloned());
            Ok(Err(Outcome::Panicked { why: text.unwrap_or_else(|| "no message".to_owned()) }))
        }
    }
}

/// Teaches the original task. Each model of it is evaluated once, whoever shares it.
fn originals<'a>(
    conditions: &Conditions<'_>,
    original: &Arc<Setting>,
    left: &Left<'a>,
) -> Result<Originals<'a>, BenchError> {
    let standard = method::standard();
    // Where the standard model cannot be taught, the seed is untaught for all methods.
    let task = match contained(conditions, || conditions.teach(original, &*standard))? {
        Ok(task) => task,
        Err(outcome) => OriginalTask::untaught(original, outcome.why().unwrap_or_default()),
    };
    let singles = left.singles.iter().flat_map(|(_, methods)| methods.iter().copied());
    let mut originals = Originals::new();
    for method in singles.chain(left.sequences.iter().map(|left| left.method)) {
        if let Entry::Vacant(entry) = originals.entry(method.original()) {
            let is_standard = method.original() == standard.original();
            // What one method is taught is no other's budget.
            let conditions = Conditions { steps: &AtomicU64::new(0), ..*conditions };
            let own = match is_standard {
                true => Ok(task.clone()),
                false => contained(&conditions, || conditions.taught_to(&task, method))?,
            };
            entry.insert(match own {
                Ok(task) => (method, task, None),
                Err(outcome) => (method, task.clone(), Some(outcome)),
            });
        }
    }
    Ok(originals)
}

/// Evaluates each original model on a changed task.
fn befores<'o>(
    conditions: &Conditions<'_>,
    setting: &Arc<Setting>,
    methods: &[&'o dyn Method],
    originals: &'o Originals<'_>,
) -> Result<Befores<'o>, BenchError> {
    let mut befores = Befores::new();
    for method in methods {
        if let Entry::Vacant(entry) = befores.entry(method.original()) {
            let (owner, task, broken) = &originals[method.original()];
            let before = match broken {
                Some(outcome) => Err(outcome.clone()),
                None => {
                    let conditions = Conditions { steps: &AtomicU64::new(0), ..*conditions };
                    contained(&conditions, || conditions.before(task, setting, *owner))?
                }
            };
            entry.insert((task, before));
        }
    }
    Ok(befores)
}
