//! A protocol: which runs, how many, and when a task counts as taught. It is a TOML file.

use std::collections::BTreeSet;
use std::path::Path;

use serde::Deserialize;
use situ::keyframe::policy::Execution;
use situ_tasks::FileKind;
use situ_tasks::key::{Document, KeyPath};
use situ_tasks::name;

use crate::error::BenchError;
use crate::executor::Executor;
use crate::grade::{self, GradeSeries};
use crate::synthetic::{Applicable, Parameters};

/// How many demonstrations may be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    /// Original demonstrations before the first evaluation.
    pub least_originals: u32,
    /// Original demonstrations at the most. A seed that needs more is `untaught`.
    pub originals: u32,
    /// Demonstrations of the changed task at the most: corrections, or full ones where a method is taught from scratch.
    pub demonstrations: u32,
    /// Steps of the physics at the most. A run that needs more is `timed_out`, and the sweep goes on.
    #[serde(default = "Budget::usual_steps")]
    pub steps: u64,
}

impl Budget {
    /// So many that a run without an end meets them, and no other.
    fn usual_steps() -> u64 {
        100_000_000
    }
}

/// A series of measurements of update cost on synthetic automata, without physics. One thing varies and the rest is
/// held.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CostSeries {
    /// Its name: the quantity that it varies.
    pub series: String,
    /// Methods whose updates are measured.
    pub methods: Vec<String>,
    /// Sizes of the automata, in nodes.
    pub nodes: Vec<u32>,
    /// Numbers of original demonstrations.
    #[serde(default = "CostSeries::usual_originals")]
    pub originals: Vec<u32>,
    /// How many kinds of state there are; |Z| then grows with the automaton. Where this is not given, |Z| is held
    /// fixed.
    #[serde(default)]
    pub cells: Option<u32>,
    /// Draws of each.
    pub seeds: u64,
    /// Corrections of each edit on each automaton.
    #[serde(default = "CostSeries::usual_corrections")]
    pub corrections: u32,
}

impl CostSeries {
    fn usual_originals() -> Vec<u32> {
        vec![3]
    }

    fn usual_corrections() -> u32 {
        1
    }

    /// The automata of a size and a number of originals.
    pub fn parameters(&self, nodes: u32, originals: u32, seed: u64) -> Parameters {
        let usual = Parameters::of(nodes as usize, seed);
        let applicable = self.cells.map_or(usual.applicable, |cells| Applicable::Free(cells as usize));
        Parameters { originals: originals as usize, applicable, ..usual }
    }
}

/// Which variations of a family are run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Variations {
    /// All.
    #[default]
    All,
    /// The first that needs each edit, in the order of the family's file.
    FirstOfEachEdit,
    /// None: sequences alone.
    None,
}

/// Which sequences of variations are run: all or none, or those of these names.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged, expecting = "expected `true`, `false` or a list of names of sequences")]
pub enum Sequences {
    /// All, or none.
    All(bool),
    /// Those of one of these names, in every family that has such a sequence.
    Named(Vec<String>),
}

impl Default for Sequences {
    fn default() -> Self {
        Self::All(false)
    }
}

impl Sequences {
    /// Whether a sequence of this name is among them.
    pub(crate) fn holds(&self, name: &str) -> bool {
        match self {
            Self::All(all) => *all,
            Self::Named(names) => names.iter().any(|wanted| wanted == name),
        }
    }

    /// The names that are asked for.
    pub(crate) fn names(&self) -> &[String] {
        match self {
            Self::All(_) => &[],
            Self::Named(names) => names,
        }
    }
}

/// When a robot is corrected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Corrections {
    /// As long as it falls short of the target.
    #[default]
    UntilReached,
    /// Once, whether it fails or not: the teacher stops the first rollout that there is something to stop in.
    Once,
}

/// A protocol.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Protocol {
    /// Its name, in every table.
    pub name: String,
    /// Why it is as it is, in prose.
    pub analysis: String,
    /// Task families; none where update cost alone is measured.
    pub tasks: Vec<String>,
    /// Which of their variations.
    #[serde(default)]
    pub variations: Variations,
    /// Teacher profiles.
    pub teachers: Vec<String>,
    /// Methods.
    pub methods: Vec<String>,
    /// Those of them whose model is compared with the pooled one: what `rebuild` makes of the same demonstrations at
    /// once.
    #[serde(default, rename = "joint")]
    pub pooled: Vec<String>,
    /// Which of the families' sequences of variations are run, too.
    #[serde(default)]
    pub sequences: Sequences,
    /// The first seed. Seeds come in blocks: 1 to 100 to look at, 101 to 199 to accept a change, 201 on to publish.
    #[serde(default = "Protocol::usual_first_seed")]
    pub first_seed: u64,
    /// Seeds of each cell.
    pub seeds: u64,
    /// Success rate at which a task counts as taught, above 0 and at most 1.
    pub target: f64,
    /// Rollouts of an evaluation.
    pub rollouts: u32,
    /// A child that is less probable than this is not executed; the rollout ends with `NoConfidentChild` (decision
    /// D11).
    pub confidence: f64,
    /// How policies are executed (decision D15).
    pub execution: Execution,
    /// What an executor does where a primitive fails; the paper's where it is left out.
    #[serde(default)]
    pub executor: Executor,
    /// When a robot is corrected.
    #[serde(default)]
    pub corrections: Corrections,
    /// Series of graded changes. Where there are any, they name the variations that each teacher shows.
    #[serde(default)]
    pub grade: Vec<GradeSeries>,
    /// Budgets of demonstrations.
    pub budget: Budget,
    /// The update-cost part, where there is one.
    #[serde(default)]
    pub cost: Vec<CostSeries>,
    /// The text it was read from.
    #[serde(skip)]
    pub source: String,
}

/// The protocols that come with the program.
const BUILTIN: [(&str, &str); 10] = [
    ("quick", include_str!("../protocols/quick.toml")),
    ("families", include_str!("../protocols/families.toml")),
    ("methods", include_str!("../protocols/methods.toml")),
    ("ablations", include_str!("../protocols/ablations.toml")),
    ("teachers", include_str!("../protocols/teachers.toml")),
    ("sequences", include_str!("../protocols/sequences.toml")),
    ("grades", include_str!("../protocols/grades.toml")),
    ("cost", include_str!("../protocols/cost.toml")),
    ("latency", include_str!("../protocols/latency.toml")),
    ("paper", include_str!("../protocols/paper.toml")),
];

impl Protocol {
    fn usual_first_seed() -> u64 {
        1
    }

    /// The names of the protocols that come with the program.
    pub fn names() -> impl Iterator<Item = &'static str> {
        BUILTIN.into_iter().map(|(name, _)| name)
    }

    /// A protocol by the name of one that comes with the program, or by the path of a file.
    ///
    /// # Errors
    /// Where it is neither, or the file is wrong: with file, line and what was expected.
    pub fn find(name_or_path: &str) -> Result<Self, BenchError> {
        if let Some((name, text)) = BUILTIN.into_iter().find(|(name, _)| *name == name_or_path) {
            return Self::parse(text, Path::new(&format!("protocols/{name}.toml")));
        }
        let path = Path::new(name_or_path);
        if !path.exists() {
            return Err(BenchError::unknown("protocol", name_or_path, Self::names()));
        }
        let text =
            std::fs::read_to_string(path).map_err(|source| BenchError::Read { path: path.to_owned(), source })?;
        Self::parse(&text, path)
    }

    /// The same protocol with nothing to carry the hand. It has a name of its own, because its runs are other runs.
    #[must_use]
    pub fn without_arm(self) -> Self {
        let source = format!("# Run with --plant hand, as `{}-hand`.\n{}", self.name, self.source);
        Self { name: format!("{}-hand", self.name), source, ..self }
    }

    /// Reads a protocol from the text of a file; `path` is for messages.
    ///
    /// # Errors
    /// With file, line, key and what was expected.
    pub fn parse(text: &str, path: &Path) -> Result<Self, BenchError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let document = Document::parse(text, path)?;
        document.check_kind(FileKind::Protocol)?;
        document.check_finite()?;
        check_integers(&document)?;
        let mut protocol: Self = toml::from_str(text).map_err(|error| document.serde_error(&error))?;
        protocol.check(&document)?;
        protocol.source = text.to_owned();
        Ok(protocol)
    }

    /// Checks what no key can say for itself.
    fn check(&self, document: &Document<'_>) -> Result<(), BenchError> {
        let at = |key: &str| key.split('.').fold(KeyPath::default(), |key, name| key.field(name));
        let refuse = |key: KeyPath, expected: String| Err(BenchError::from(document.error(&key, expected)));
        if let Some(problem) = name::mistake(&self.name) {
            return refuse(at("name"), problem);
        }
        if !(self.target > 0.0 && self.target <= 1.0) {
            return refuse(at("target"), format!("{}: expected a rate above 0 and at most 1", self.target));
        }
        if !(0.0..=1.0).contains(&self.confidence) {
            return refuse(at("confidence"), format!("{}: expected a probability from 0 to 1", self.confidence));
        }
        if self.budget.least_originals > self.budget.originals {
            return refuse(at("budget.least_originals"), "expected no more than `budget.originals`".to_owned());
        }
        let lists = [("tasks", &self.tasks), ("teachers", &self.teachers), ("methods", &self.methods)];
        for (key, list) in lists {
            // A protocol of update cost alone has no task.
            if list.is_empty() && (key != "tasks" || self.cost.is_empty()) {
                return refuse(at(key), "expected at least one name".to_owned());
            }
        }
        let more = [("joint", &*self.pooled), ("sequences", self.sequences.names())];
        for (key, list) in lists.map(|(key, list)| (key, &**list)).into_iter().chain(more) {
            if let Some(index) = second(list) {
                return refuse(at(key).index(index), format!("`{}` stands there twice: expected once", list[index]));
            }
        }
        grade::check(&self.grade, &self.teachers, document)?;
        self.check_costs(document)?;
        self.check_size(document)
    }

    /// Checks the series of update costs.
    fn check_costs(&self, document: &Document<'_>) -> Result<(), BenchError> {
        let refuse = |key: KeyPath, expected: String| Err(BenchError::from(document.error(&key, expected)));
        let mut met = BTreeSet::new();
        for (index, cost) in self.cost.iter().enumerate() {
            let at = |key: &str| KeyPath::default().field("cost").index(index).field(key);
            if let Some(problem) = mistake_in_series(&cost.series) {
                return refuse(at("series"), problem);
            }
            if !met.insert(&cost.series) {
                return refuse(at("series"), "expected a name that no other series has".to_owned());
            }
            if let Some(second) = second(&cost.methods) {
                return refuse(at("methods").index(second), "it stands there twice: expected once".to_owned());
            }
            for (key, list) in [("nodes", &cost.nodes), ("originals", &cost.originals)] {
                if list.is_empty() {
                    return refuse(at(key), "expected at least one number".to_owned());
                }
                if let Some(second) = second(list) {
                    return refuse(at(key).index(second), "it stands there twice: expected once".to_owned());
                }
            }
            let most = cost.originals.iter().copied().max().unwrap_or(0);
            if let Some(nodes) = cost.nodes.iter().position(|nodes| nodes.saturating_mul(most) > MOST_SEGMENTS) {
                let expected = format!("expected nodes × originals of at most {MOST_SEGMENTS}");
                return refuse(at("nodes").index(nodes), expected);
            }
        }
        Ok(())
    }

    /// Checks that there are not more records than a ledger can hold: each bound by itself leaves room for that.
    fn check_size(&self, document: &Document<'_>) -> Result<(), BenchError> {
        let refuse = |key: KeyPath, what: &str| {
            Err(BenchError::from(document.error(&key, format!("expected {what} of at most {MOST_RUNS}"))))
        };
        let product = |factors: &[u64]| factors.iter().fold(1_u64, |product, factor| product.saturating_mul(*factor));
        let lengths = [&self.tasks, &self.teachers, &self.methods].map(|list| list.len() as u64);
        if product(&lengths).saturating_mul(self.seeds) > MOST_RUNS {
            return refuse(KeyPath::default().field("seeds"), "tasks × teachers × methods × seeds");
        }
        let mut measured = 0_u64;
        for (index, cost) in self.cost.iter().enumerate() {
            let lengths = [cost.methods.len(), cost.nodes.len(), cost.originals.len()].map(|length| length as u64);
            let updates = product(&[product(&lengths), cost.seeds, u64::from(cost.corrections)]);
            measured = measured.saturating_add(updates);
            if measured > MOST_RUNS {
                let key = KeyPath::default().field("cost").index(index).field("seeds");
                return refuse(key, "methods × nodes × originals × seeds × corrections over all series");
            }
        }
        Ok(())
    }
}

/// The most runs in physics, and the most updates of each edit that are measured.
const MOST_RUNS: u64 = 1_000_000;
/// The most nodes times originals of an automaton whose updates are measured.
const MOST_SEGMENTS: u32 = 1_000_000;

/// The least and the greatest value of each integer of a protocol.
const BOUNDS: [(&str, i64, i64); 12] = [
    ("first_seed", 0, i64::MAX),
    ("seeds", 1, 100_000),
    ("rollouts", 1, 10_000),
    ("budget.least_originals", 1, 1000),
    ("budget.originals", 1, 1000),
    ("budget.demonstrations", 1, 1000),
    ("budget.steps", 1, 1_000_000_000_000),
    // Ten nodes are needed for every edit to have its place.
    ("cost.nodes", 10, 100_000),
    // The second original leaves the optional nodes out.
    ("cost.originals", 2, 1000),
    // Neighbours must look different.
    ("cost.cells", 5, 100_000),
    ("cost.seeds", 1, 100_000),
    ("cost.corrections", 1, 100_000),
];

/// Refuses an integer that is out of its bounds. That comes before all other checks: the number of another key that is
/// wrong, too, may be one that no program should try.
fn check_integers(document: &Document<'_>) -> Result<(), BenchError> {
    for (key, value) in document.integers() {
        let Some((_, least, most)) = BOUNDS.iter().find(|(name, ..)| *name == key.names()) else { continue };
        if !value.is_some_and(|value| (*least..=*most).contains(&value)) {
            let value = value.map_or_else(|| "a number beyond 64 bits".to_owned(), |value| value.to_string());
            return Err(document.error(&key, format!("{value}: expected {least} to {most}")).into());
        }
    }
    Ok(())
}

/// What is wrong with the name of a series, which stands in tables, but in no path: so it may be a phrase.
fn mistake_in_series(series: &str) -> Option<String> {
    let is_fine = |letter: char| letter.is_ascii_alphanumeric() || "_|, ".contains(letter);
    let is_phrase = series.starts_with(|first: char| first.is_ascii_alphabetic()) && series.chars().all(is_fine);
    (!is_phrase || series.len() > LONGEST_SERIES).then(|| {
        format!(
            "`{series}`: expected a name of at most {LONGEST_SERIES} letters, digits, `_`, `|`, commas and spaces that \
             begins with a letter"
        )
    })
}

/// The most letters of the name of a series.
const LONGEST_SERIES: usize = 60;

/// The index of the first element that stands in the list before.
fn second<T: Ord>(list: &[T]) -> Option<usize> {
    let mut met = BTreeSet::new();
    list.iter().position(|element| !met.insert(element))
}
