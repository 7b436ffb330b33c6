//! The runs of a protocol, every name looked up.

use std::collections::BTreeSet;
use std::sync::Arc;

use situ::edit::Edit;
use situ::method::{self, KEYFRAME_AUTOMATON, Method, Role};
use situ::state::Schema;
use situ_tasks::{NeededEdit, Registry, Setting, Task};
use situ_teachers::{Roster, Teacher, convert};

use crate::error::BenchError;
use crate::protocol::{CostSeries, Protocol, Variations};
use crate::synthetic::Parameters;

/// Which of a protocol's runs to do: of each list all that it names, everything where it is empty.
#[derive(Clone, Debug, Default)]
pub struct Filter {
    /// Task families.
    pub tasks: Vec<String>,
    /// Variations. Where sequences are named, no other variations than these are run alone.
    pub variations: Vec<String>,
    /// Sequences of variations. Where variations are named, no other sequences than these are run.
    pub sequences: Vec<String>,
    /// Methods; one that the protocol does not name is added.
    pub methods: Vec<String>,
    /// Teacher profiles; one that the protocol does not name is added.
    pub teachers: Vec<String>,
}

/// The runs of a protocol, every name looked up.
pub struct Plan {
    pub(crate) protocol: Protocol,
    pub(crate) groups: Vec<Group>,
    pub(crate) methods: Vec<Box<dyn Method>>,
    pub(crate) costs: Vec<CostGroup>,
}

/// Measurements of update cost that share an automaton.
pub(crate) struct CostGroup {
    pub(crate) series: String,
    pub(crate) method: Box<dyn Method>,
    pub(crate) parameters: Parameters,
    pub(crate) corrections: u32,
}

/// Runs that share an original task, its teacher and a seed.
pub(crate) struct Group {
    pub(crate) family: Arc<Family>,
    pub(crate) teacher: Teacher,
    pub(crate) seed: u64,
}

/// An original task, and the variations that are to be run.
pub(crate) struct Family {
    pub(crate) original: Arc<Setting>,
    /// The features of the observed states of all its settings.
    pub(crate) schema: Schema,
    pub(crate) variations: Vec<Arc<Setting>>,
    pub(crate) sequences: Vec<Sequence>,
}

impl Family {
    /// The most beads that one of its settings has. They decide how long its runs take.
    pub(crate) fn beads(&self) -> usize {
        let settings = self.variations.iter().chain(self.sequences.iter().flat_map(|sequence| &sequence.settings));
        let beads = settings.chain([&self.original]).filter_map(|setting| setting.beads.as_ref());
        beads.map(|(_, beads)| beads.count).max().unwrap_or(0)
    }
}

/// Variations that a robot meets one after another.
pub(crate) struct Sequence {
    pub(crate) name: String,
    pub(crate) settings: Vec<Arc<Setting>>,
}

/// The wanted names, or the default ones where none is wanted.
///
/// # Errors
/// A name that nothing has, with the known ones.
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

/// The names of the methods that are so.
fn methods_that(is_so: impl Fn(&dyn Method) -> bool) -> Vec<String> {
    method::all().iter().filter(|method| is_so(&***method)).map(|method| method.name().to_owned()).collect()
}

impl Plan {
    /// Looks every name up.
    ///
    /// # Errors
    /// A name that nothing has, with the known ones.
    pub fn new(protocol: Protocol, filter: &Filter, registry: &Registry, roster: &Roster) -> Result<Self, BenchError> {
        let first_seed = protocol.first_seed;
        let known: Vec<String> = registry.names().map(str::to_owned).collect();
        let tasks = chosen("task", &filter.tasks, &protocol.tasks, &known)?;
        let methods = chosen("method", &filter.methods, &protocol.methods, &methods_that(|_| true))?;
        let methods: Vec<Box<dyn Method>> = methods.iter().filter_map(|name| method::named(name)).collect();
        let comparable =
            methods_that(|method| method.role() == Role::Correct && method.original() == KEYFRAME_AUTOMATON);
        chosen("method of keyframe automata", &protocol.pooled, &[], &comparable)?;
        let tasks = tasks.iter().map(|task| registry.get(task)).collect::<Result<Vec<_>, _>>()?;
        let teachers = if filter.teachers.is_empty() { &protocol.teachers } else { &filter.teachers };
        let mut groups = Vec::new();
        for task in &tasks {
            let Some(family) = filter.family(task, &protocol)?.map(Arc::new) else { continue };
            for teacher in teachers {
                let teacher = Teacher::new(roster.get(teacher)?.clone());
                for seed in first_seed..first_seed.saturating_add(protocol.seeds) {
                    groups.push(Group { family: Arc::clone(&family), teacher: teacher.clone(), seed });
                }
            }
        }
        let known: Vec<String> = tasks.iter().flat_map(|task| task.variations()).map(str::to_owned).collect();
        chosen("variation", &filter.variations, &[], &known)?;
        let sequences = tasks.iter().flat_map(|task| task.sequences());
        let known: Vec<String> = sequences.map(|sequence| sequence.name.clone()).collect();
        chosen("sequence", &filter.sequences, &[], &known)?;
        let mut costs = Vec::new();
        for series in protocol.cost.iter().filter(|_| filter.names_no_run()) {
            costs.extend(cost_groups(series, filter, first_seed)?);
        }
        Ok(Self { protocol, groups, methods, costs })
    }

    /// The number of records that the plan makes.
    pub fn len(&self) -> usize {
        let in_sequence = self.methods.iter().filter(|method| method.role() != Role::FromScratch).count();
        let runs = self.groups.iter().map(|group| {
            let stages: usize = group.family.sequences.iter().map(|sequence| sequence.settings.len()).sum();
            let single = group.family.variations.iter().map(|setting| self.methods_for(setting).count());
            single.sum::<usize>() + stages * in_sequence
        });
        runs.sum::<usize>() + self.costs.iter().map(|group| group.corrections as usize * Edit::ALL.len()).sum::<usize>()
    }

    /// The methods that are run on a variation. A change that needs no edit needs no teaching from scratch either.
    pub(crate) fn methods_for(&self, setting: &Setting) -> impl Iterator<Item = &dyn Method> {
        let is_idle = setting.edit == NeededEdit::None;
        let methods = self.methods.iter().map(|method| &**method);
        methods.filter(move |method| !(is_idle && method.role() == Role::FromScratch))
    }

    /// Whether the plan makes none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Filter {
    /// Whether all runs in physics are wanted; only then are costs measured.
    fn names_no_run(&self) -> bool {
        [&self.tasks, &self.variations, &self.sequences, &self.teachers].iter().all(|names| names.is_empty())
    }

    /// The part of a task that is to be run; `None` where there is none.
    fn family(&self, task: &Task, protocol: &Protocol) -> Result<Option<Family>, BenchError> {
        let is_wanted = |name: &str| match self.variations.as_slice() {
            [] => self.sequences.is_empty(),
            names => names.iter().any(|wanted| wanted == name),
        };
        let variations = task.variations().filter(|name| is_wanted(name)).map(|name| task.variation(Some(name)));
        let mut variations = variations.collect::<Result<Vec<_>, _>>()?;
        if self.variations.is_empty() && protocol.variations == Variations::FirstOfEachEdit {
            let mut met = BTreeSet::new();
            variations.retain(|setting| met.insert(setting.edit));
        }
        let is_wanted = |name: &String| match self.sequences.as_slice() {
            [] => protocol.sequences && self.variations.is_empty(),
            names => names.contains(name),
        };
        let sequences = task.sequences().iter().filter(|sequence| is_wanted(&sequence.name)).map(|sequence| {
            let settings = sequence.variations.iter().map(|name| task.variation(Some(name)));
            Ok(Sequence { name: sequence.name.clone(), settings: settings.collect::<Result<_, _>>()? })
        });
        let sequences = sequences.collect::<Result<Vec<_>, BenchError>>()?;
        if variations.is_empty() && sequences.is_empty() {
            return Ok(None);
        }
        let original = task.variation(None)?;
        Ok(Some(Family { schema: convert::schema(&original)?, original, variations, sequences }))
    }
}

/// The automata of a series, and the methods that are measured on them.
fn cost_groups(series: &CostSeries, filter: &Filter, first_seed: u64) -> Result<Vec<CostGroup>, BenchError> {
    let mut groups = Vec::new();
    for name in chosen("method", &[], &series.methods, &methods_that(|_| true))? {
        if !filter.methods.is_empty() && !filter.methods.contains(name) {
            continue;
        }
        for &nodes in &series.nodes {
            for &originals in &series.originals {
                for seed in first_seed..first_seed.saturating_add(series.seeds) {
                    let Some(method) = method::named(name) else { continue };
                    let parameters = series.parameters(nodes, originals, seed);
                    let (series, corrections) = (series.series.clone(), series.corrections);
                    groups.push(CostGroup { series, method, parameters, corrections });
                }
            }
        }
    }
    Ok(groups)
}
