//! All runs of a protocol: in parallel, written as they finish, resumable.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use rayon::prelude::*;
use situ::demonstration::Schema;
use situ::edit::Edit;
use situ::method::{self, KEYFRAME_AUTOMATON, Method, Role};
use situ_tasks::{Registry, Setting};
use situ_teachers::{Roster, Teacher, convert};

use crate::archive::Archive;
use crate::conditions::Conditions;
use crate::cost::Subject;
use crate::error::BenchError;
use crate::ledger::Ledger;
use crate::protocol::Protocol;
use crate::record::{Identity, Key, Record, count};
use crate::synthetic::Parameters;
use crate::teaching::OriginalTask;

/// Which of a protocol's runs to do: of each list all that it names, everything where it is empty.
#[derive(Clone, Debug, Default)]
pub struct Filter {
    /// Task families.
    pub tasks: Vec<String>,
    /// Variations; where sequences are named, no others than these are run alone.
    pub variations: Vec<String>,
    /// Sequences of variations; where variations are named, no others than these are run.
    pub sequences: Vec<String>,
    /// Methods; one that the protocol does not name is added.
    pub methods: Vec<String>,
    /// Teacher profiles; one that the protocol does not name is added.
    pub teachers: Vec<String>,
}

/// What is to be run, every name looked up.
pub struct Plan {
    protocol: Protocol,
    groups: Vec<Group>,
    methods: Vec<Box<dyn Method>>,
    costs: Vec<CostGroup>,
}

/// Measurements of update cost that share an automaton.
struct CostGroup {
    series: String,
    method: Box<dyn Method>,
    parameters: Parameters,
    corrections: u32,
}

/// Runs that share an original model.
struct Group {
    original: Arc<Setting>,
    variations: Vec<Arc<Setting>>,
    sequences: Vec<(String, Vec<Arc<Setting>>)>,
    teacher: Teacher,
    seed: u64,
    schema: Arc<Schema>,
}

/// Told how the runs go on.
pub trait Progress: Sync {
    /// A run begins, or ends.
    fn at(&self, what: &str);
    /// A run is finished.
    fn finished(&self);
}

fn chosen<'a>(
    what: &'static str,
    wanted: &'a [String],
    default: &'a [String],
    known: &[String],
) -> Result<&'a [String], BenchError> {
    let names = if wanted.is_empty() { default } else { wanted };
    match names.iter().find(|name| !known.contains(name)) {
        Some(name) => Err(BenchError::unknown(what, name, known.iter().map(String::as_str))),
        None => Ok(names),
    }
}

impl Plan {
    /// Looks every name up.
    ///
    /// # Errors
    /// A name that nothing has, with the known ones.
    pub fn new(
        protocol: Protocol,
        filter: &Filter,
        registry: &Registry,
        roster: &Roster,
        first_seed: u64,
    ) -> Result<Self, BenchError> {
        let known: Vec<String> = registry.names().map(str::to_owned).collect();
        let tasks = chosen("task", &filter.tasks, &protocol.tasks, &known)?;
        let known: Vec<String> = method::all().iter().map(|method| method.name().to_owned()).collect();
        let methods = chosen("method", &filter.methods, &protocol.methods, &known)?;
        let methods: Vec<Box<dyn Method>> = methods.iter().filter_map(|name| method::named(name)).collect();
        let comparable: Vec<String> = method::all()
            .iter()
            .filter(|method| method.role() == Role::Correct && method.original() == KEYFRAME_AUTOMATON)
            .map(|method| method.name().to_owned())
            .collect();
        chosen("method of keyframe automata", &protocol.joint, &[], &comparable)?;
        let teachers = if filter.teachers.is_empty() { &protocol.teachers } else { &filter.teachers };
        let (mut variations_known, mut sequences_known) = (Vec::new(), Vec::new());
        let mut groups = Vec::new();
        for task in tasks {
            let task = registry.get(task)?;
            variations_known.extend(task.variations().map(str::to_owned));
            let wanted = |name: &str| match filter.variations.as_slice() {
                [] => filter.sequences.is_empty(),
                names => names.iter().any(|wanted| wanted == name),
            };
            let variations = task.variations().filter(|name| wanted(name)).map(|name| task.variation(Some(name)));
            let variations = variations.collect::<Result<Vec<_>, _>>()?;
            sequences_known.extend(task.sequences().iter().map(|sequence| sequence.name.clone()));
            let wanted = |name: &String| match filter.sequences.as_slice() {
                [] => protocol.sequences && filter.variations.is_empty(),
                names => names.contains(name),
            };
            let sequences = task.sequences().iter().filter(|sequence| wanted(&sequence.name)).map(|sequence| {
                let settings = sequence.variations.iter().map(|name| task.variation(Some(name)));
                Ok((sequence.name.clone(), settings.collect::<Result<Vec<_>, _>>()?))
            });
            let sequences = sequences.collect::<Result<Vec<_>, BenchError>>()?;
            if variations.is_empty() && sequences.is_empty() {
                continue;
            }
            let original = task.variation(None)?;
            let schema = Arc::new(convert::schema(&original)?);
            for teacher in teachers {
                let teacher = Teacher::new(roster.get(teacher)?.clone());
                for seed in first_seed..first_seed.saturating_add(protocol.seeds) {
                    groups.push(Group {
                        original: Arc::clone(&original),
                        variations: variations.clone(),
                        sequences: sequences.clone(),
                        teacher: teacher.clone(),
                        seed,
                        schema: Arc::clone(&schema),
                    });
                }
            }
        }
        chosen("variation", &filter.variations, &[], &variations_known)?;
        chosen("sequence", &filter.sequences, &[], &sequences_known)?;
        let whole = [&filter.tasks, &filter.variations, &filter.sequences, &filter.teachers];
        let whole = whole.iter().all(|names| names.is_empty());
        let mut costs = Vec::new();
        for series in protocol.cost.iter().filter(|_| whole) {
            let known: Vec<String> = method::all().iter().map(|method| method.name().to_owned()).collect();
            for name in chosen("method", &[], &series.methods, &known)? {
                if !filter.methods.is_empty() && !filter.methods.contains(name) {
                    continue;
                }
                for (nodes, originals) in series
                    .nodes
                    .iter()
                    .flat_map(|nodes| series.originals.iter().map(move |originals| (nodes, originals)))
                {
                    for seed in first_seed..first_seed.saturating_add(series.seeds) {
                        let Some(method) = method::named(name) else { continue };
                        let parameters = series.parameters(*nodes, *originals, seed);
                        let (series, corrections) = (series.series.clone(), series.corrections);
                        costs.push(CostGroup { series, method, parameters, corrections });
                    }
                }
            }
        }
        Ok(Self { protocol, groups, methods, costs })
    }

    /// The number of records that the plan makes.
    pub fn len(&self) -> usize {
        let in_sequence = self.methods.iter().filter(|method| method.role() != Role::FromScratch).count();
        let runs = self.groups.iter().map(|group| {
            let stages: usize = group.sequences.iter().map(|(_, settings)| settings.len()).sum();
            group.variations.len() * self.methods.len() + stages * in_sequence
        });
        runs.sum::<usize>() + self.costs.iter().map(|group| group.corrections as usize * Edit::ALL.len()).sum::<usize>()
    }

    /// Whether the plan makes none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Does all runs that are not `done`, and adds each to the ledger as it finishes.
    ///
    /// The records do not depend on the number of threads; their order in the ledger does.
    ///
    /// # Errors
    /// [`BenchError::Interrupted`] where the flag was set; what a run or the ledger refuses.
    pub fn run(
        &self,
        ledger: &Mutex<Ledger>,
        done: &BTreeSet<Identity>,
        interrupted: &AtomicBool,
        archive: Option<&Archive>,
        progress: &dyn Progress,
    ) -> Result<(), BenchError> {
        let write = |record: Record| {
            let result = ledger.lock().expect("no holder of the ledger panics").append(&record);
            progress.finished();
            result
        };
        // Costs first, one after another and nothing beside them: they are timed.
        for group in &self.costs {
            let Parameters { nodes, originals, seed, .. } = group.parameters;
            let identity = |edit, correction| Identity::Cost {
                protocol: self.protocol.name.clone(),
                series: group.series.clone(),
                method: group.method.name().to_owned(),
                edit,
                nodes: count(nodes),
                originals: count(originals),
                seed,
                correction,
            };
            let (finished, left): (Vec<_>, Vec<_>) = Edit::ALL
                .into_iter()
                .flat_map(|edit| (0..group.corrections).map(move |correction| (edit, correction)))
                .partition(|(edit, correction)| done.contains(&identity(*edit, *correction)));
            finished.iter().for_each(|_| progress.finished());
            if left.is_empty() {
                continue;
            }
            progress.at(&format!("update cost, {}, {}, {nodes} nodes, seed {seed}", group.series, group.method.name()));
            let subject = Subject::teach(&*group.method, group.parameters)?;
            for (edit, correction) in left {
                if interrupted.load(Ordering::Relaxed) {
                    return Err(BenchError::Interrupted);
                }
                write(Record::Cost(subject.measure(&self.protocol.name, &group.series, edit, correction)?))?;
            }
        }
        self.groups.par_iter().try_for_each(|group| {
            let conditions = Conditions {
                protocol: &self.protocol,
                teacher: &group.teacher,
                seed: group.seed,
                schema: &group.schema,
                interrupted,
                archive,
            };
            let is_done = |key: Key| {
                let is_done = done.contains(&Identity::Run(key));
                is_done.then(|| progress.finished()).is_some()
            };
            let methods = || self.methods.iter().map(|method| &**method);
            let singles = group.variations.iter().map(|setting| {
                let left = methods().filter(|method| !is_done(conditions.key(setting, *method)));
                (setting, left.collect::<Vec<_>>())
            });
            let singles: Vec<_> = singles.filter(|(_, left)| !left.is_empty()).collect();
            // A stage needs the ones before it, so a sequence is run from its beginning where any stage is left.
            let stages_left = |name: &str, settings: &[Arc<Setting>], method: &dyn Method| {
                let stages = settings.iter().enumerate();
                let left =
                    stages.filter(|(index, setting)| !is_done(conditions.stage_key(name, *index, setting, method)));
                left.map(|(index, _)| index).collect::<BTreeSet<_>>()
            };
            let mut sequences = Vec::new();
            for (name, settings) in &group.sequences {
                for method in methods().filter(|method| method.role() != Role::FromScratch) {
                    let left = stages_left(name, settings, method);
                    if !left.is_empty() {
                        sequences.push((name, settings, method, left));
                    }
                }
            }
            let left: Vec<&dyn Method> = singles
                .iter()
                .flat_map(|(_, methods)| methods.iter().copied())
                .chain(sequences.iter().map(|(_, _, method, _)| *method))
                .collect();
            if left.is_empty() {
                return Ok(());
            }
            progress.at(&format!(
                "{}, {}, seed {}: teaching",
                group.original.task,
                group.teacher.profile().name,
                group.seed
            ));
            let standard = method::standard();
            let taught = conditions.teach(&group.original, &*standard)?;
            // Each model of the original task is evaluated once, whoever shares it.
            let mut originals: BTreeMap<&str, (&dyn Method, OriginalTask)> = BTreeMap::new();
            for method in left {
                if let Entry::Vacant(entry) = originals.entry(method.original()) {
                    let is_standard = method.original() == standard.original();
                    let taught = if is_standard { taught.clone() } else { conditions.taught_to(&taught, method)? };
                    entry.insert((method, taught));
                }
            }
            singles.par_iter().try_for_each(|(setting, methods)| {
                let mut befores = BTreeMap::new();
                for method in methods {
                    if let Entry::Vacant(entry) = befores.entry(method.original()) {
                        let (owner, taught) = &originals[method.original()];
                        entry.insert((taught, conditions.before(taught, setting, *owner)?));
                    }
                }
                methods.par_iter().try_for_each(|method| {
                    progress.at(&Identity::Run(conditions.key(setting, *method)).to_string());
                    let (taught, before) = &befores[method.original()];
                    write(Record::Run(conditions.run(setting, *method, taught, before)?))
                })
            })?;
            sequences.par_iter().try_for_each(|(name, settings, method, left)| {
                progress.at(&Identity::Run(conditions.stage_key(name, 0, &settings[0], *method)).to_string());
                let taught = &originals[method.original()].1;
                let runs = conditions.run_sequence(name, settings, *method, taught)?;
                let left = runs.into_iter().enumerate().filter(|(index, _)| left.contains(index));
                left.map(|(_, run)| run).try_for_each(|run| write(Record::Run(run)))
            })
        })
    }
}
