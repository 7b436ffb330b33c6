//! `run`: the runs of a protocol, and their tables.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use clap::Args;
use situ_tasks::Registry;

use crate::archive::Archive;
use crate::cmd::library::{Carrier, Library, OwnMethods};
use crate::cmd::terminal::{self, Signs, say};
use crate::cmd::traces::{self, Traces};
use crate::digest;
use crate::error::BenchError;
use crate::external;
use crate::files;
use crate::ledger::{self, Canonical, Ledger};
use crate::lock::Lock;
use crate::manifest::{self, Manifest, Provenance};
use crate::plan::{Filter, Plan};
use crate::protocol::Protocol;
use crate::provenances::{self, Permitted, Provenances};
use crate::record::{Identity, Record};
use crate::runner::{Progress, Runner};
use crate::shard::Shard;
use crate::spending::Spending;
use crate::tables::{self, Publication};

/// Runs a protocol: teaches tasks, changes them, corrects the models, and compares the methods.
#[derive(Args, Clone, Debug, Default)]
#[command(
    after_long_help = "DIR/manifest.toml says what makes the runs, and of what; it is there before the first of them. \
        Every finished run is one line of DIR/ledger.jsonl, written as it finishes. Where the program was interrupted, \
        --resume goes on. At the end the ledger is put in order, and its tables are written beside it. Whatever the \
        number of threads, the same seed gives the same records, except for the times.

Examples:
  situ-bench run
  situ-bench run --task pour --variation lid --method situ --method rebuild
  situ-bench run --protocol paper --out paper --resume
  situ-bench run --tasks my_tasks --task tower --teachers my_teachers.toml --teacher grandfather
  situ-bench run --check results/quick"
)]
pub struct Run {
    /// The protocol: the name of a built-in one, or a file.
    #[arg(long, default_value = "quick", value_name = "NAME|FILE")]
    pub protocol: String,
    /// Only this task family; may be given several times.
    #[arg(long, value_name = "NAME")]
    pub task: Vec<String>,
    /// Only this variation; may be given several times.
    #[arg(long, value_name = "NAME")]
    pub variation: Vec<String>,
    /// Only this sequence of variations; may be given several times.
    #[arg(long, value_name = "NAME")]
    pub sequence: Vec<String>,
    /// These methods instead of the protocol's; may be given several times.
    #[arg(long, value_name = "NAME")]
    pub method: Vec<String>,
    /// These teacher profiles instead of the protocol's; may be given several times.
    #[arg(long, value_name = "NAME")]
    pub teacher: Vec<String>,
    /// The first seed instead of the protocol's. The protocol says how many seeds there are.
    #[arg(long)]
    pub seed: Option<u64>,
    /// Threads. One for each processor where it is not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// The folder for the ledger and the tables. Where it is not given, `runs/PROTOCOL`, which is begun anew each time.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Only this part of the runs, of so many: a machine each. It has a folder of its own, DIR/shard-I-of-N, and
    /// `merge` makes one of them. Where it is not given, a task of a Slurm array does its part of the array; 1/1 is all
    /// runs.
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Goes on with the ledger that is in the folder. It must be of this benchmark version and this program's revision.
    #[arg(long)]
    pub resume: bool,
    /// Goes on with a ledger of another provenance, too. Every table's heading names both.
    #[arg(long, requires = "resume")]
    pub mixed: bool,
    /// Also writes every demonstration, in the format of `learn`, below DIR/demonstrations.
    #[arg(long)]
    pub demonstrations: bool,
    /// Also prints where the processor time went, by task family and by phase.
    #[arg(long)]
    pub profile: bool,
    /// Compares the records and the tables with those in this folder, times left out. Exit status 1 where they differ.
    #[arg(long, value_name = "DIR")]
    pub check: Option<PathBuf>,
    /// Tasks and teachers of one's own. Without the arm the protocol is called `NAME-hand`.
    #[command(flatten)]
    pub library: Library,
    /// Methods of one's own: they are run where --method or the protocol names them.
    #[command(flatten)]
    pub own: OwnMethods,
}

/// The folder of what external methods say, in the folder of a run.
const LOGS: &str = "logs";
/// The ledger's name in its folder.
pub(super) const LEDGER: &str = "ledger.jsonl";
/// The protocol's name in the folder.
pub(super) const PROTOCOL: &str = "protocol.toml";

/// The records and tables of a protocol's runs.
pub(super) struct Published {
    pub(super) records: Canonical,
    /// The files of the tables, each with its name.
    tables: Vec<(String, String)>,
    /// The text that is to be printed: what the runs came to.
    pub(super) printed: String,
}

impl Progress for Signs {
    fn at(&self, what: &str) {
        Signs::at(self, what);
    }

    fn finished(&self) {
        Signs::finished(self);
    }
}

impl Run {
    /// Does the runs; returns what they came to.
    ///
    /// # Errors
    /// Bad names and files; [`BenchError::Interrupted`]; [`BenchError::Differs`] from `--check`.
    pub fn run(&self) -> Result<String, BenchError> {
        let protocol = Protocol::find(&self.protocol)?;
        let protocol = if self.library.plant == Carrier::Hand { protocol.without_arm() } else { protocol };
        let shard = self.shard()?;
        if let Some((shard, folder)) = shard.zip(self.check.as_ref()) {
            let folder = folder.display();
            return Err(BenchError::Argument(format!("shard {shard} with --check {folder}: expected all runs there")));
        }
        let expected = self.check.as_ref().map(|folder| ledger::read(&folder.join(LEDGER))).transpose()?;
        let mut published = Self { shard, ..self.clone() }.publish(&protocol, &tables::ALL)?;
        if let (Some(folder), Some(expected)) = (&self.check, expected) {
            compare_records(&published.records, &Canonical::from(expected.records))?;
            compare_tables(&published.tables, folder)?;
            published
                .printed
                .push_str("The records and the tables are those of the checked folder, all but the times.\n");
        }
        Ok(published.printed)
    }

    /// Does the runs of a protocol; writes the ledger and these tables.
    ///
    /// # Errors
    /// Bad names and files; [`BenchError::Interrupted`].
    pub(super) fn publish(&self, protocol: &Protocol, publications: &[&Publication]) -> Result<Published, BenchError> {
        let folder = self.out.clone().unwrap_or_else(|| Path::new("runs").join(&protocol.name));
        let folder = self.shard.map_or(Ok(folder.clone()), |shard| shard.folder(&folder))?;
        let new = traces::make(&folder)?;
        let published = self.publish_into(&folder, protocol, publications, &new);
        if published.is_err() {
            traces::remove_empty(&new);
        }
        published
    }

    fn publish_into(
        &self,
        folder: &Path,
        protocol: &Protocol,
        publications: &[&Publication],
        new: &[PathBuf],
    ) -> Result<Published, BenchError> {
        let _lock = Lock::take(folder)?;
        let path = self.ledger(protocol, folder, new)?;
        let records = Canonical::from(ledger::read(&path)?.records);
        let command = Path::new(&protocol.name).join(LEDGER);
        let heading =
            Provenances::of(std::slice::from_ref(&path), Permitted::One)?.heading(&command.display().to_string());
        let tables: Vec<(String, String)> =
            publications.iter().flat_map(|table| table.files(&records, &heading)).collect();
        let is_made = |publication: &Publication| !publication.tables(&records).is_empty();
        let made: Vec<&Publication> = publications.iter().copied().filter(|one| is_made(one)).collect();
        let printed = tables::summary(&records, &folder.display().to_string(), &made) + &broken_off(&records);
        let mut outputs = vec![(path, ledger::text(&records))];
        outputs.extend(tables.iter().map(|(name, text)| (folder.join(name), text.clone())));
        files::write_all(&outputs)?;
        remove_former(folder, publications, &tables)?;
        Ok(Published { records, tables, printed })
    }

    /// Does the runs of a protocol; returns the path of their ledger. These folders are new.
    fn ledger(&self, protocol: &Protocol, folder: &Path, new: &[PathBuf]) -> Result<PathBuf, BenchError> {
        let filter = self.filter();
        let wanted = Protocol { first_seed: self.seed.unwrap_or(protocol.first_seed), ..protocol.clone() };
        let registry = self.library.registry()?;
        let methods = self.own.known()?;
        let plan = Plan::new(wanted, &filter, &registry, &self.library.roster()?, &methods)?;
        let plan = match self.shard {
            Some(shard) => plan.part(shard),
            None => plan,
        };
        let mut manifest = self.manifest(&plan, &registry)?;
        let external = methods.hashes().filter(|(name, _)| plan.has_method(name));
        manifest.provenance.methods = external.map(|(name, hash)| (name.to_owned(), hash)).collect();
        let begun = self.prepare(folder, protocol, manifest)?;
        let path = folder.join(LEDGER);
        let (ledger, contents) = Ledger::open(&path)?;
        contents.warnings.iter().for_each(|warning| say(&format!("warning: {warning}")));
        let done = self.done(&plan, &path, &contents.records)?;
        let traces = Traces { ledger: path.clone(), files: begun, lock: Lock::path(folder), folders: new.to_vec() };
        let last = traces.clone();
        let interrupted = terminal::interrupt_flag(BenchError::Interrupted, move || {
            external::end_all();
            last.remove_all();
        });
        methods.heed(&interrupted);
        methods.log_into(&folder.join(LOGS));
        let signs = Signs::of(plan.len());
        let part = self.shard.map_or(String::new(), |shard| format!("shard {shard}: "));
        say(&format!("{part}{} runs, in {}", plan.len(), folder.display()));
        let archive = self.demonstrations.then(|| Archive::new(folder.join("demonstrations")));
        let spending = Spending::default();
        let runner = Runner {
            plan: &plan,
            ledger: &Mutex::new(ledger),
            done: &done,
            interrupted: &interrupted,
            archive: archive.as_ref(),
            progress: &signs,
            spending: &spending,
        };
        let result = terminal::threads(self.jobs)?.install(|| runner.run());
        signs.end();
        if self.profile {
            say(&spending.table());
        }
        if result.is_err() {
            traces.remove_files();
        }
        result?;
        Ok(path)
    }

    /// The runs of a plan that a ledger holds already.
    fn done(&self, plan: &Plan, ledger: &Path, records: &[Record]) -> Result<BTreeSet<Identity>, BenchError> {
        let planned = plan.places().into_keys().map(|run| (run.clone().names(), run));
        let planned: BTreeMap<Identity, Identity> = planned.collect();
        let mut done = BTreeSet::new();
        for (index, record) in records.iter().enumerate() {
            let run = record.identity();
            match planned.get(&run.clone().names()) {
                // Whoever mixes has been told.
                Some(planned) if *planned == run || self.mixed => drop(done.insert(planned.clone())),
                Some(_) => {
                    return Err(BenchError::Argument(format!(
                        "{}:{}: {run}: made of another task, teacher or protocol than this run's: give another --out",
                        ledger.display(),
                        index + 1
                    )));
                }
                None => {}
            }
        }
        Ok(done)
    }

    /// The manifest of this run. A protocol without tasks needs no teacher.
    fn manifest(&self, plan: &Plan, registry: &Registry) -> Result<Manifest, BenchError> {
        let protocol = &plan.protocol;
        let tasks = protocol.tasks.iter().chain(&self.task);
        let tasks = tasks.filter_map(|name| Some((name.clone(), digest::hash(registry.text(name)?))));
        let tasks: BTreeMap<_, _> = tasks.collect();
        let teachers = protocol.teachers.iter().chain(&self.teacher).filter(|_| !tasks.is_empty());
        let teachers = self.library.teacher_hashes(teachers)?;
        let manifest = Manifest::new(protocol, self.library.plant.name(), tasks, teachers);
        Ok(Manifest { wanted: self.filter(), shard: self.shard, ..manifest })
    }

    fn filter(&self) -> Filter {
        Filter {
            tasks: self.task.clone(),
            variations: self.variation.clone(),
            sequences: self.sequence.clone(),
            methods: self.method.clone(),
            teachers: self.teacher.clone(),
        }
    }

    /// The part of the runs that is asked for, here or by a Slurm array.
    fn shard(&self) -> Result<Option<Shard>, BenchError> {
        match self.shard {
            Some(shard) => Ok(Some(shard)),
            None => {
                let shard = Shard::of_slurm().map_err(BenchError::Argument)?;
                if let Some(shard) = shard {
                    say(&format!("a task of a Slurm array: shard {shard} (--shard 1/1 does all runs)"));
                }
                Ok(shard)
            }
        }
    }

    /// Makes the folder ready, its manifest first; returns the files that a run leaves behind of which nothing came:
    /// those that were not there before.
    fn prepare(&self, folder: &Path, protocol: &Protocol, manifest: Manifest) -> Result<Vec<PathBuf>, BenchError> {
        let write = |path: &Path, source| BenchError::Write { path: path.to_owned(), source };
        let (path, copy) = (folder.join(LEDGER), folder.join(PROTOCOL));
        if self.resume && path.exists() {
            let former = fs::read_to_string(&copy).map_err(|source| BenchError::Read { path: copy.clone(), source })?;
            if former != protocol.source {
                return Err(BenchError::Argument(format!(
                    "{} was made by another protocol than {}: give another --out, or that protocol's file",
                    path.display(),
                    self.protocol
                )));
            }
            self.go_on(&path, manifest)?;
            return Ok(Vec::new());
        }
        if path.exists() {
            if self.out.is_some() {
                let path = path.display();
                return Err(BenchError::Argument(format!(
                    "{path} is there already: go on with --resume, or give another --out"
                )));
            }
            fs::remove_file(&path).map_err(|source| write(&path, source))?;
        }
        let new = [manifest::beside(&path), copy.clone(), path.clone()].into_iter().filter(|path| !path.exists());
        let new = new.collect();
        files::write_all(&[(manifest::beside(&path), manifest.text()), (copy, protocol.source.clone())])?;
        Ok(new)
    }

    /// Whether this program may add to a ledger. Where the ledger is of another provenance, its manifest notes both.
    fn go_on(&self, ledger: &Path, here: Manifest) -> Result<(), BenchError> {
        let path = manifest::beside(ledger);
        let former = Manifest::read(&path)?;
        let provenance = former.as_ref().map_or_else(Provenance::unknown, |former| former.provenance.clone());
        if let Some(former) = &former
            && former.shard != here.shard
        {
            let part = |shard: Option<Shard>| shard.map_or("all runs".to_owned(), |shard| format!("shard {shard}"));
            return Err(BenchError::Argument(format!(
                "{} holds {}, and this is {}: give another --out",
                ledger.display(),
                part(former.shard),
                part(here.shard)
            )));
        }
        if provenance.agrees_with(&here.provenance) {
            let Some(former) = former else { return Ok(()) };
            let mut noted = Manifest { wanted: former.wanted.or(&here.wanted), ..former.clone() };
            noted.meet(&here.machine);
            noted.provenance.methods.extend(here.provenance.methods);
            return if noted == former { Ok(()) } else { files::write_all(&[(path, noted.text())]) };
        }
        if !self.mixed {
            let ledger = ledger.display().to_string();
            return Err(provenances::disagree(&ledger, &provenance, "this run", &here.provenance));
        }
        let (mut manifest, other) = match former {
            Some(former) => (former, here.provenance),
            None => (here, provenance),
        };
        if manifest.mix(&other) { files::write_all(&[(path, manifest.text())]) } else { Ok(()) }
    }
}

/// A line about the runs that were not done to their end, where there are any.
fn broken_off(records: &Canonical) -> String {
    let is_failure = |record: &&Record| matches!(record, Record::Run(run) if run.outcome.is_failure());
    match records.iter().filter(is_failure).count() {
        0 => String::new(),
        count => format!("{count} runs broke off; they count as failures of their methods: see the table `endings`.\n"),
    }
}

/// Removes tables of a former run that have no row any more.
fn remove_former(folder: &Path, publications: &[&Publication], tables: &[(String, String)]) -> Result<(), BenchError> {
    for path in unmade(publications, tables).map(|name| folder.join(name)).filter(|path| path.is_file()) {
        fs::remove_file(&path).map_err(|source| BenchError::Write { path, source })?;
    }
    Ok(())
}

/// The names of tables that have no row.
fn unmade(publications: &[&Publication], tables: &[(String, String)]) -> impl Iterator<Item = String> {
    let names = publications.iter().flat_map(|table| table.names());
    names.filter(|name| tables.iter().all(|(made, _)| made != name))
}

/// Compares records, all but their times.
fn compare_records(records: &Canonical, expected: &Canonical) -> Result<(), BenchError> {
    // A ledger of before there were contents is compared without them.
    let has_contents = expected.iter().all(Record::has_content);
    let by_name = |records: &Canonical| -> BTreeMap<_, _> {
        let comparable = |record: &Record| {
            let record = record.without_times();
            if has_contents { record } else { record.without_content() }
        };
        let comparable = records.iter().map(comparable);
        comparable.map(|record| (record.identity(), ledger::text(&[record]))).collect()
    };
    let (records, expected) = (by_name(records), by_name(expected));
    let names: BTreeSet<_> = records.keys().chain(expected.keys()).collect();
    let differing = names.into_iter().filter(|name| records.get(name) != expected.get(name));
    refuse("records", differing.map(ToString::to_string).collect())
}

/// Compares tables with those of a folder, all but their times.
fn compare_tables(tables: &[(String, String)], folder: &Path) -> Result<(), BenchError> {
    let mut differing = Vec::new();
    for (name, text) in tables {
        let path = folder.join(name);
        let expected = fs::read_to_string(&path).map_err(|source| BenchError::Read { path, source })?;
        if tables::differs(name, text, &expected) {
            differing.push(name.clone());
        }
    }
    differing.extend(unmade(&tables::ALL, tables).filter(|name| folder.join(name).exists()));
    refuse("tables", differing)
}

fn refuse(what: &'static str, differing: Vec<String>) -> Result<(), BenchError> {
    if differing.is_empty() { Ok(()) } else { Err(BenchError::Differs { what, names: differing }) }
}
