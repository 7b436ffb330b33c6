//! Whether somebody's results are what the benchmark gives: a sample of their runs, drawn and made anew.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::hash::{BuildHasher, RandomState};
use std::path::Path;
use std::sync::Mutex;

use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::cmd::folder;
use crate::cmd::library::{Carrier, Library};
use crate::cmd::run::{LEDGER, PROTOCOL};
use crate::cmd::terminal::{self, Signs};
use crate::error::BenchError;
use crate::external::Methods;
use crate::ledger::{self, Canonical, Ledger};
use crate::manifest::Manifest;
use crate::plan::{Filter, Plan};
use crate::protocol::Protocol;
use crate::record::{Identity, Record, RunRecord};
use crate::runner::Runner;
use crate::spending::Spending;

/// What is to be checked.
pub(super) struct Sample<'a> {
    /// Somebody's folder.
    pub(super) folder: &'a Path,
    /// How many runs are drawn.
    pub(super) runs: u32,
    /// The seed of what is drawn. Without it nobody can know it before.
    pub(super) seed: Option<u64>,
    pub(super) jobs: Option<u16>,
}

impl Sample<'_> {
    /// Makes the sample anew. Returns what is said, and what is wrong.
    ///
    /// # Errors
    /// [`BenchError::Argument`] where the folder is of another benchmark version, or holds no run; files that cannot be
    /// read; [`BenchError::Stopped`].
    pub(super) fn said(&self, library: &Library, methods: &Methods) -> Result<(String, Vec<String>), BenchError> {
        let manifest = folder::manifest(self.folder)?;
        let plant = if manifest.plant == Carrier::Hand.name() { Carrier::Hand } else { Carrier::Arm };
        let library = Library { plant, ..library.clone() };
        let text = folder::protocol(self.folder, &manifest)?;
        let protocol = Protocol::parse(&text, &self.folder.join(PROTOCOL))?;
        let protocol = Protocol { name: manifest.protocol.name.clone(), ..protocol };
        self.refuse_other_version(&protocol, &manifest, &library)?;
        let records = Canonical::from(ledger::read(&self.folder.join(LEDGER))?.records);
        let runs: Vec<&RunRecord> =
            records.iter().filter_map(|record| if let Record::Run(run) = record { Some(run) } else { None }).collect();
        if runs.is_empty() {
            return Err(BenchError::Argument(format!("{}: it holds no run in physics", self.folder.display())));
        }
        let seed = self.seed.unwrap_or_else(|| RandomState::new().hash_one("a sample"));
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut all = runs.clone();
        let (drawn, _) = all.partial_shuffle(&mut rng, self.runs as usize);
        drawn.sort_by_key(|run| run.key.clone());
        let mut said = format!("{} of {} runs, drawn by --seed {seed}\n\n", drawn.len(), runs.len());
        let interrupted = terminal::interrupt_flag(BenchError::Stopped, crate::external::end_all);
        methods.heed(&interrupted);
        let signs = Signs::of(drawn.len());
        let pool = terminal::threads(self.jobs)?;
        let mut findings = Vec::new();
        for run in drawn {
            let name = Identity::Run(run.key.clone());
            let again = pool.install(|| again(run, &protocol, &library, methods, (&signs, &interrupted)));
            let again = again.map_err(|error| match error {
                BenchError::Interrupted => BenchError::Stopped,
                error => error,
            })?;
            let verdict = compared(run, again.as_ref());
            let _ = writeln!(said, "{}  {name}", if verdict.is_none() { "same " } else { "other" });
            findings.extend(verdict.map(|problem| format!("{name}: {problem}")));
        }
        signs.end();
        Ok((said, findings))
    }

    /// Refuses a folder of another protocol, task, teacher or form of the ledger than are known here.
    fn refuse_other_version(
        &self,
        protocol: &Protocol,
        manifest: &Manifest,
        library: &Library,
    ) -> Result<(), BenchError> {
        let registry = library.registry()?;
        let text = |name: &String| Some((name.clone(), crate::digest::hash(registry.text(name)?)));
        let tasks = manifest.tasks.keys().filter_map(text).collect();
        let teachers = library.teacher_hashes(manifest.teachers.keys())?;
        let here = Manifest::new(protocol, &manifest.plant, tasks, teachers);
        if here.provenance.benchmark == manifest.provenance.benchmark {
            return Ok(());
        }
        let other = |(name, hash): (&String, &String), own: Option<&String>, what: &str| {
            (own != Some(hash)).then(|| format!("{what} `{name}`"))
        };
        let tasks = manifest.tasks.iter().filter_map(|task| other(task, here.tasks.get(task.0), "the task"));
        let teachers = manifest.teachers.iter();
        let teachers = teachers.filter_map(|teacher| other(teacher, here.teachers.get(teacher.0), "the teacher"));
        let mut differing: Vec<String> = tasks.chain(teachers).collect();
        if differing.is_empty() {
            differing.push("the form of the ledger".to_owned());
        }
        Err(BenchError::Argument(format!(
            "{}: it is of another benchmark version, which differs in {}: expected that of this program (or give --tasks \
             and --teachers)",
            self.folder.display(),
            differing.join(", ")
        )))
    }
}

/// A run, made anew; `None` where the program has no such run.
fn again(
    run: &RunRecord,
    protocol: &Protocol,
    library: &Library,
    methods: &Methods,
    (signs, interrupted): (&Signs, &std::sync::atomic::AtomicBool),
) -> Result<Option<RunRecord>, BenchError> {
    let key = &run.key;
    let sequence = key.stage.as_ref().map(|stage| stage.sequence.clone());
    let filter = Filter {
        tasks: vec![key.task.clone()],
        variations: if sequence.is_none() { vec![key.variation.clone()] } else { Vec::new() },
        sequences: sequence.into_iter().collect(),
        methods: vec![key.method.clone()],
        teachers: vec![key.teacher.clone()],
    };
    let protocol = Protocol { first_seed: key.seed, seeds: 1, ..protocol.clone() };
    let plan = Plan::new(protocol, &filter, &library.registry()?, &library.roster()?, methods)?;
    let folder =
        tempfile::tempdir().map_err(|source| BenchError::Write { path: "a temporary folder".into(), source })?;
    let path = folder.path().join(LEDGER);
    let (ledger, _) = Ledger::open(&path)?;
    let (ledger, spending) = (Mutex::new(ledger), Spending::new());
    let runner = Runner {
        plan: &plan,
        ledger: &ledger,
        done: &BTreeSet::new(),
        interrupted,
        archive: None,
        progress: signs,
        spending: &spending,
    };
    runner.run()?;
    let names = Identity::Run(key.clone()).names();
    let found = ledger::read(&path)?.records.into_iter().find(|record| record.identity().names() == names);
    Ok(found.and_then(|record| if let Record::Run(run) = record { Some(run) } else { None }))
}

/// What is wrong with a run beside the one that was made anew, times left out; `None` where they are the same.
fn compared(run: &RunRecord, again: Option<&RunRecord>) -> Option<String> {
    let Some(again) = again else { return Some("the program has no such run".to_owned()) };
    // A ledger of before there were contents is compared without them.
    let has_content = !run.key.content.is_empty();
    let timeless = |run: &RunRecord| {
        let record = Record::Run(run.clone()).without_times();
        let record = if has_content { record } else { record.without_content() };
        serde_json::to_value(record).expect("a record is JSON")
    };
    let (said, made) = (timeless(run), timeless(again));
    let (said, made) = (said.as_object()?, made.as_object()?);
    let key = said.keys().chain(made.keys()).find(|key| said.get(*key) != made.get(*key))?;
    let word = |of: Option<&serde_json::Value>| {
        let text = of.map_or_else(|| "nothing".to_owned(), ToString::to_string);
        text.chars().take(QUOTED).collect::<String>()
    };
    Some(format!("`{key}` is {}, and made anew it is {}", word(said.get(key)), word(made.get(key))))
}

/// Letters of a value that stand in a finding.
const QUOTED: usize = 120;
