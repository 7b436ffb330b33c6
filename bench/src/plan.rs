//! The runs of a protocol, every name looked up.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use situ::edit::Edit;
use situ::method::{KEYFRAME_AUTOMATON, Method, Role};
use situ::state::Schema;
use situ_tasks::{NeededEdit, Registry, Setting, Task};
use situ_teachers::{Roster, Teacher, convert};

use crate::content;
use crate::error::BenchError;
use crate::external::Methods;
use crate::grade;
use crate::protocol::{CostSeries, Protocol, Variations};
use crate::record::{Identity, Key};
use crate::shard::Shard;
use crate::synthetic::Parameters;
use crate::tally::count;

/// Which of a protocol's runs to do: of each list all that it names, everything where it is empty.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Filter {
    /// Task families.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tasks: Vec<String>,
    /// Variations. Where sequences are named, no other variations than these are run alone.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub variations: Vec<String>,
    /// Sequences of variations. Where variations are named, no other sequences than these are run.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sequences: Vec<String>,
    /// Methods; one that the protocol does not name is added.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub methods: Vec<String>,
    /// Teacher profiles; one that the protocol does not name is added.
    #[serde(skip_serializing_if = "Vec::is_empty")]
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

impl CostGroup {
    /// The name of a record.
    pub(crate) fn identity(&self, protocol: &str, edit: Edit, correction: u32) -> Identity {
        let Parameters { nodes, originals, seed, .. } = self.parameters;
        Identity::Cost {
            protocol: protocol.to_owned(),
            series: self.series.clone(),
            method: self.method.name().to_owned(),
            edit,
            nodes: count(nodes),
            originals: count(originals),
            seed,
            correction,
        }
    }
}

/// Runs that share an original task, its teacher and a seed.
pub(crate) struct Group {
    pub(crate) family: Arc<Family>,
    pub(crate) teacher: Teacher,
    pub(crate) seed: u64,
    /// What its runs are made of ([`content`]).
    pub(crate) content: Arc<str>,
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

/// Variations that a robot meets one after another, among them the original task, where what was changed is undone.
pub(crate) struct Sequence {
    pub(crate) name: String,
    pub(crate) settings: Vec<Arc<Setting>>,
}

/// The wanted names, each once, or the default ones where none is wanted.
///
/// # Errors
/// A name that nothing has, with the known ones.
fn chosen<'a>(
    what: &'static str,
    wanted: &'a [String],
    default: &'a [String],
    known: &[String],
) -> Result<Vec<&'a String>, BenchError> {
    let names = if wanted.is_empty() { default } else { wanted };
    match names.iter().find(|name| !known.contains(name)) {
        Some(name) => Err(BenchError::unknown(what, name, known.iter().map(String::as_str))),
        None => Ok(once(names)),
    }
}

/// The names in their order, each once.
fn once(names: &[String]) -> Vec<&String> {
    let mut met = BTreeSet::new();
    names.iter().filter(|name| met.insert(*name)).collect()
}

/// So many seeds from the first.
///
/// # Errors
/// [`BenchError::Argument`] where there are not so many.
fn seeds(first: u64, count: u64) -> Result<RangeInclusive<u64>, BenchError> {
    match first.checked_add(count.saturating_sub(1)) {
        Some(last) => Ok(first..=last),
        None => Err(BenchError::Argument(format!(
            "--seed {first}: expected at most {}, for the protocol has {count} seeds",
            u64::MAX - (count - 1)
        ))),
    }
}

/// The names of the methods that are so.
fn methods_that(known: &Methods, is_so: impl Fn(&dyn Method) -> bool) -> Vec<String> {
    known.all().iter().filter(|method| is_so(&***method)).map(|method| method.name().to_owned()).collect()
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
        known: &Methods,
    ) -> Result<Self, BenchError> {
        let all_seeds = seeds(protocol.first_seed, protocol.seeds)?;
        let names: Vec<String> = registry.names().map(str::to_owned).collect();
        let tasks = chosen("task", &filter.tasks, &protocol.tasks, &names)?;
        let methods = chosen("method", &filter.methods, &protocol.methods, &methods_that(known, |_| true))?;
        let methods = methods.iter().map(|name| known.named(name)).collect::<Result<Vec<_>, _>>()?;
        let is_comparable =
            |method: &dyn Method| method.role() == Role::Correct && method.original() == KEYFRAME_AUTOMATON;
        let comparable = methods_that(known, is_comparable);
        chosen("method of keyframe automata", &protocol.pooled, &[], &comparable)?;
        let tasks = tasks.iter().map(|task| registry.get(task)).collect::<Result<Vec<_>, _>>()?;
        let teachers = if filter.teachers.is_empty() { &protocol.teachers } else { &filter.teachers };
        let mut groups = Vec::new();
        for task in &tasks {
            for name in once(teachers) {
                let Some(family) = filter.family(task, &protocol, name)?.map(Arc::new) else { continue };
                let teacher = Teacher::new(roster.get(name)?.clone());
                let texts = [registry.text(&family.original.task), roster.text(name)].map(Option::unwrap_or_default);
                let content: Arc<str> = content::of(&protocol, family.original.plant, texts[0], texts[1]).into();
                for seed in all_seeds.clone() {
                    let (family, teacher, content) = (Arc::clone(&family), teacher.clone(), Arc::clone(&content));
                    groups.push(Group { family, teacher, seed, content });
                }
            }
        }
        let names: Vec<String> = tasks.iter().flat_map(|task| task.variations()).map(str::to_owned).collect();
        chosen("variation", &filter.variations, &[], &names)?;
        let sequences = tasks.iter().flat_map(|task| task.sequences());
        let names: Vec<String> = sequences.map(|sequence| sequence.name.clone()).collect();
        chosen("sequence", &filter.sequences, protocol.sequences.names(), &names)?;
        let mut costs = Vec::new();
        for series in protocol.cost.iter().filter(|_| filter.names_no_run()) {
            costs.extend(cost_groups(series, filter, protocol.first_seed, known)?);
        }
        Ok(Self { protocol, groups, methods, costs })
    }

    /// The same with a method of one's own beside the others.
    #[must_use]
    pub fn with_method(mut self, method: Box<dyn Method>) -> Self {
        self.methods.push(method);
        self
    }

    /// Whether this method is one of the plan's.
    pub fn has_method(&self, name: &str) -> bool {
        self.methods.iter().chain(self.costs.iter().map(|group| &group.method)).any(|method| method.name() == name)
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

    /// The part of it that is a shard: every so many groups of runs, which share what they were taught, one.
    #[must_use]
    pub fn part(mut self, shard: Shard) -> Self {
        let mut index = 0..;
        self.groups.retain(|_| index.next().is_some_and(|index| shard.holds(index)));
        let mut index = 0..;
        self.costs.retain(|_| index.next().is_some_and(|index| shard.holds(index)));
        self
    }

    /// The names of the records that the plan makes, each with its place, by which a shard [holds](Shard::holds) it.
    pub fn places(&self) -> BTreeMap<Identity, usize> {
        let mut all = BTreeMap::new();
        for (place, Group { family, teacher, seed, content }) in self.groups.iter().enumerate() {
            let teacher = &teacher.profile().name;
            let key = |setting: &Setting, method: &dyn Method| {
                Key::of(&self.protocol.name, setting, teacher, method, *seed).made_of(content)
            };
            for setting in &family.variations {
                all.extend(self.methods_for(setting).map(|method| (Identity::Run(key(setting, method)), place)));
            }
            let in_sequence = || self.methods.iter().filter(|method| method.role() != Role::FromScratch);
            for sequence in &family.sequences {
                for (index, setting) in sequence.settings.iter().enumerate() {
                    for method in in_sequence() {
                        all.insert(Identity::Run(key(setting, &**method).at(&sequence.name, index)), place);
                    }
                }
            }
        }
        for (place, group) in self.costs.iter().enumerate() {
            let numbers = |edit| (0..group.corrections).map(move |number| (edit, number));
            let all_of_it = Edit::ALL.into_iter().flat_map(numbers);
            let name = |(edit, number)| group.identity(&self.protocol.name, edit, number);
            all.extend(all_of_it.map(|one| (name(one), place)));
        }
        all
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
    /// What one of the two asks for.
    #[must_use]
    pub fn or(&self, other: &Self) -> Self {
        // An empty list asks for everything.
        let either = |one: &[String], other: &[String]| -> Vec<String> {
            if one.is_empty() || other.is_empty() {
                return Vec::new();
            }
            once(&[one, other].concat()).into_iter().cloned().collect()
        };
        Self {
            tasks: either(&self.tasks, &other.tasks),
            variations: either(&self.variations, &other.variations),
            sequences: either(&self.sequences, &other.sequences),
            methods: either(&self.methods, &other.methods),
            teachers: either(&self.teachers, &other.teachers),
        }
    }

    /// Whether all runs in physics are wanted; only then are costs measured.
    fn names_no_run(&self) -> bool {
        [&self.tasks, &self.variations, &self.sequences, &self.teachers].iter().all(|names| names.is_empty())
    }

    /// The part of a task that is to be run with a teacher; `None` where there is none.
    fn family(&self, task: &Task, protocol: &Protocol, teacher: &str) -> Result<Option<Family>, BenchError> {
        let is_wanted = |name: &str| match self.variations.as_slice() {
            [] => self.sequences.is_empty(),
            names => names.iter().any(|wanted| wanted == name),
        };
        let variations = task.variations().filter(|name| is_wanted(name)).map(|name| task.variation(Some(name)));
        let mut variations = variations.collect::<Result<Vec<_>, _>>()?;
        let mut met = BTreeSet::new();
        variations.retain(|setting| match protocol.variations {
            _ if !self.variations.is_empty() => true,
            Variations::All => true,
            Variations::FirstOfEachEdit => met.insert(setting.edit),
            Variations::None => false,
        });
        let has_grade = |setting: &Setting| grade::grade(&protocol.grade, setting, teacher).is_some();
        variations.retain(|setting| protocol.grade.is_empty() || has_grade(setting));
        let is_wanted = |name: &String| match self.sequences.as_slice() {
            [] => protocol.sequences.holds(name) && self.variations.is_empty(),
            names => names.contains(name),
        };
        let sequences = task.sequences().iter().filter(|sequence| is_wanted(&sequence.name)).map(|sequence| {
            let settings = sequence.stages.iter().map(|name| task.stage(name));
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
fn cost_groups(
    series: &CostSeries,
    filter: &Filter,
    first_seed: u64,
    known: &Methods,
) -> Result<Vec<CostGroup>, BenchError> {
    let mut groups = Vec::new();
    for name in chosen("method", &[], &series.methods, &methods_that(known, |_| true))? {
        if !filter.methods.is_empty() && !filter.methods.contains(name) {
            continue;
        }
        for &nodes in &series.nodes {
            for &originals in &series.originals {
                for seed in seeds(first_seed, series.seeds)? {
                    let method = known.named(name)?;
                    let parameters = series.parameters(nodes, originals, seed);
                    let (series, corrections) = (series.series.clone(), series.corrections);
                    groups.push(CostGroup { series, method, parameters, corrections });
                }
            }
        }
    }
    Ok(groups)
}
