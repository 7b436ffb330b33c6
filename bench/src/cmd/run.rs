//! `run`: the runs of a protocol, and their tables.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use clap::Args;
use indicatif::ProgressBar;

use crate::archive::Archive;
use crate::cmd::library::{Carrier, Library};
use crate::cmd::terminal;
use crate::error::BenchError;
use crate::files;
use crate::ledger::{self, Ledger};
use crate::protocol::Protocol;
use crate::record::Record;
use crate::runner::{Filter, Plan, Progress};
use crate::tables::Kind;

/// Runs a protocol: teaches tasks, changes them, corrects the models, and compares the methods.
#[derive(Args, Clone, Debug, Default)]
#[command(
    after_long_help = "Every finished run is one line of DIR/ledger.jsonl, written as it finishes; an interrupted run goes on with --resume. At the end
the ledger is put in order and its tables are written beside it. The same seed gives the same records, but for the times,
whatever the number of threads.

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
    /// The first seed; the protocol says how many follow.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Threads; all processors where it is not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// The folder for the ledger and the tables; `runs/PROTOCOL` where it is not given, begun anew each time.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Goes on with the ledger that is in the folder.
    #[arg(long)]
    pub resume: bool,
    /// Also writes every demonstration, in the format of `learn`, below DIR/demonstrations.
    #[arg(long)]
    pub demonstrations: bool,
    /// Compares the records with the ledger in this folder, all but the times; exit status 1 where they differ.
    #[arg(long, value_name = "DIR")]
    pub check: Option<PathBuf>,
    /// Tasks and teachers of one's own; without the arm the protocol is called `NAME-hand`.
    #[command(flatten)]
    pub library: Library,
}

/// The ledger's name in its folder.
const LEDGER: &str = "ledger.jsonl";
/// The protocol's name in the folder.
const PROTOCOL: &str = "protocol.toml";

struct Bar(ProgressBar);

impl Progress for Bar {
    fn at(&self, what: &str) {
        self.0.set_message(what.to_owned());
    }

    fn finished(&self) {
        self.0.inc(1);
    }
}

impl Run {
    /// Does the runs; returns the tables to be printed.
    ///
    /// # Errors
    /// Bad names and files; [`BenchError::Interrupted`]; [`BenchError::Differs`] from `--check`.
    pub fn run(&self) -> Result<String, BenchError> {
        let protocol = Protocol::find(&self.protocol)?;
        let protocol = if self.library.plant == Carrier::Hand { protocol.without_arm() } else { protocol };
        let expected = self.check.as_ref().map(|folder| ledger::read(&folder.join(LEDGER))).transpose()?;
        let (records, mut printed) = self.records(&protocol, &Kind::ALL)?;
        if let Some(expected) = expected {
            compare(&records, &ledger::canonical(expected.records))?;
            printed.push_str("The records are those of the checked ledger, all but the times.\n");
        }
        Ok(printed)
    }

    /// The records of the runs of a protocol, in canonical order, and the tables of these kinds to be printed; everything is written.
    ///
    /// # Errors
    /// Bad names and files; [`BenchError::Interrupted`].
    pub(super) fn records(&self, protocol: &Protocol, kinds: &[Kind]) -> Result<(Vec<Record>, String), BenchError> {
        let filter = Filter {
            tasks: self.task.clone(),
            variations: self.variation.clone(),
            sequences: self.sequence.clone(),
            methods: self.method.clone(),
            teachers: self.teacher.clone(),
        };
        let plan = Plan::new(protocol.clone(), &filter, &self.library.registry()?, &self.library.roster()?, self.seed)?;
        let folder = self.out.clone().unwrap_or_else(|| Path::new("runs").join(&protocol.name));
        let path = self.prepare(&folder, protocol)?;
        let (ledger, contents) = Ledger::open(&path)?;
        contents.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
        let done: BTreeSet<_> = contents.done();

        let interrupted = terminal::interrupt_flag();
        let bar = Bar(ProgressBar::new(plan.len() as u64).with_style(terminal::progress_style()));
        let archive = self.demonstrations.then(|| Archive::new(folder.join("demonstrations")));
        let result = terminal::threads(self.jobs)?
            .install(|| plan.run(&Mutex::new(ledger), &done, &interrupted, archive.as_ref(), &bar));
        bar.0.finish_and_clear();
        result?;

        let records = ledger::canonical(ledger::read(&path)?.records);
        let mut outputs = vec![(path.clone(), ledger::text(&records))];
        let command = format!("situ-bench tables {} --table", Path::new(&protocol.name).join(LEDGER).display());
        let mut printed = String::new();
        for kind in kinds {
            let tables = kind.tables(&records);
            let markdown: Vec<String> =
                tables.iter().map(|table| table.to_markdown(&format!("{command} {}", kind.name()))).collect();
            printed.push_str(&markdown.join("\n"));
            printed.push('\n');
            outputs.push((folder.join(format!("{}.md", kind.name())), markdown.join("\n")));
            outputs.extend(tables.iter().map(|table| (folder.join(format!("{}.csv", table.id())), table.to_csv())));
        }
        files::write_all(&outputs)?;
        Ok((records, printed))
    }

    /// Makes the folder ready; returns the ledger's path.
    fn prepare(&self, folder: &Path, protocol: &Protocol) -> Result<PathBuf, BenchError> {
        let write = |path: &Path, source| BenchError::Write { path: path.to_owned(), source };
        fs::create_dir_all(folder).map_err(|source| write(folder, source))?;
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
            return Ok(path);
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
        files::write_all(&[(copy, protocol.source.clone())])?;
        Ok(path)
    }
}

/// Compares records, all but their times.
fn compare(records: &[Record], expected: &[Record]) -> Result<(), BenchError> {
    let index = |records: &[Record]| {
        let render = |record: &Record| (record.identity(), ledger::text(&[record.without_times()]));
        records.iter().map(render).collect::<std::collections::BTreeMap<_, _>>()
    };
    let (records, expected) = (index(records), index(expected));
    let names: BTreeSet<_> = records.keys().chain(expected.keys()).collect();
    let differing: Vec<String> =
        names.into_iter().filter(|name| records.get(name) != expected.get(name)).map(ToString::to_string).collect();
    if differing.is_empty() { Ok(()) } else { Err(BenchError::Differs { runs: differing }) }
}
