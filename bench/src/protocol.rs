//! A protocol: which runs, how many, and when a task counts as taught. It is a TOML file.

use std::path::Path;

use serde::Deserialize;
use situ::keyframe::policy::Execution;

use crate::error::BenchError;
use crate::executor::Executor;
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
    /// Whether the families' sequences of variations are run, too.
    #[serde(default)]
    pub sequences: bool,
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
const BUILTIN: [(&str, &str); 8] = [
    ("quick", include_str!("../protocols/quick.toml")),
    ("families", include_str!("../protocols/families.toml")),
    ("methods", include_str!("../protocols/methods.toml")),
    ("ablations", include_str!("../protocols/ablations.toml")),
    ("teachers", include_str!("../protocols/teachers.toml")),
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
        let mut protocol: Self = toml::from_str(text).map_err(|error| {
            let offset = error.span().map_or(0, |span| span.start);
            BenchError::Malformed {
                path: path.to_owned(),
                line: line_of(text, offset),
                problem: error.message().to_owned(),
            }
        })?;
        let refuse = |key: &str, expected: &str| {
            let last = key.rsplit('.').next().unwrap_or(key);
            let line = text.lines().position(|line| line.trim_start().starts_with(last)).map_or(1, |index| index + 1);
            Err(BenchError::Malformed { path: path.to_owned(), line, problem: format!("`{key}`: expected {expected}") })
        };
        if !(protocol.target > 0.0 && protocol.target <= 1.0) {
            return refuse("target", "a rate above 0 and at most 1");
        }
        if !(0.0..=1.0).contains(&protocol.confidence) {
            return refuse("confidence", "a probability from 0 to 1");
        }
        if protocol.rollouts == 0 {
            return refuse("rollouts", "1 or more");
        }
        if protocol.seeds == 0 {
            return refuse("seeds", "1 or more");
        }
        let budget = protocol.budget;
        if budget.least_originals == 0 || budget.least_originals > budget.originals {
            return refuse("budget.least_originals", "1 or more, and no more than `budget.originals`");
        }
        if budget.demonstrations == 0 {
            return refuse("budget.demonstrations", "1 or more");
        }
        for (key, list) in
            [("tasks", &protocol.tasks), ("teachers", &protocol.teachers), ("methods", &protocol.methods)]
        {
            // A protocol of update cost alone has no task.
            if list.is_empty() && (key != "tasks" || protocol.cost.is_empty()) {
                return refuse(key, "at least one name");
            }
        }
        let mut series: Vec<&str> = protocol.cost.iter().map(|cost| cost.series.as_str()).collect();
        series.sort_unstable();
        if series.windows(2).any(|pair| pair[0] == pair[1]) {
            return refuse("cost.series", "a name that no other series has");
        }
        if protocol.cost.iter().any(|cost| cost.nodes.iter().any(|nodes| *nodes < 10)) {
            return refuse("cost.nodes", "sizes of 10 or more");
        }
        if protocol.cost.iter().any(|cost| cost.originals.iter().any(|originals| *originals < 2)) {
            return refuse("cost.originals", "two or more: the second leaves the optional nodes out");
        }
        if protocol.cost.iter().any(|cost| cost.cells.is_some_and(|cells| cells < 5)) {
            return refuse("cost.cells", "5 or more: neighbours must look different");
        }
        protocol.source = text.to_owned();
        Ok(protocol)
    }
}

fn line_of(text: &str, offset: usize) -> usize {
    text[..offset.min(text.len())].matches('\n').count() + 1
}
