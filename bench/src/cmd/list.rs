//! `list`: what there is to choose from.

use std::fmt::Write;

use clap::{Args, ValueEnum};
use situ::method::{Method, Role};
use situ_tasks::{Registry, Task};
use situ_teachers::Profile;

use crate::cmd::library::{Library, OwnMethods};
use crate::error::BenchError;
use crate::external::Methods;
use crate::protocol::Protocol;
use crate::tables;

/// Lists what there is to choose from.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = "Examples:
  situ-bench list
  situ-bench list methods
  situ-bench list tasks --tasks my_tasks")]
pub struct List {
    /// What to list. Everything where nothing is named.
    #[arg(value_enum)]
    pub what: Option<What>,
    /// Tasks and teachers of one's own.
    #[command(flatten)]
    pub library: Library,
    /// Methods of one's own.
    #[command(flatten)]
    pub own: OwnMethods,
}

/// Something to choose from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum What {
    /// Ways to keep a task model up to date.
    Methods,
    /// Task families, their variations, and the edits these need.
    Tasks,
    /// Sequences of variations that a robot meets one after another.
    Sequences,
    /// Teacher profiles.
    Teachers,
    /// Protocols that come with the program.
    Protocols,
    /// Tables that can be made from a ledger.
    Tables,
}

impl What {
    fn section(self, library: &Library, own: &OwnMethods) -> Result<String, BenchError> {
        Ok(match self {
            Self::Methods => methods(&own.known_alone()?),
            Self::Tasks => tasks(&library.registry()?),
            Self::Sequences => sequences(&library.registry()?),
            Self::Teachers => teachers(library.roster()?.profiles()),
            Self::Protocols => protocols()?,
            Self::Tables => tables(),
        })
    }
}

impl List {
    /// The text that is to be printed.
    ///
    /// # Errors
    /// A folder or file that cannot be read, or a mistake in one. The tests read all files that come with the program.
    pub fn run(&self) -> Result<String, BenchError> {
        let sections = match self.what {
            Some(what) => vec![what],
            None => What::value_variants().to_vec(),
        };
        Ok(sections
            .into_iter()
            .map(|what| what.section(&self.library, &self.own))
            .collect::<Result<Vec<_>, _>>()?
            .join("\n"))
    }
}

const fn role(role: Role) -> &'static str {
    match role {
        Role::Correct => "takes corrections",
        Role::FromScratch => "taught anew",
        Role::Control => "control",
    }
}

/// Rows in columns. The last column is not padded.
fn aligned(title: &str, rows: &[Vec<String>]) -> String {
    let mut widths = Vec::new();
    for row in rows {
        widths.resize(row.len().max(widths.len()), 0);
        for (width, word) in widths.iter_mut().zip(row) {
            *width = word.chars().count().max(*width);
        }
    }
    let mut text = format!("{title}\n");
    for row in rows {
        let line: String = row.iter().zip(&widths).fold(String::new(), |mut line, (word, width)| {
            let _ = write!(line, "  {word:<width$}");
            line
        });
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

fn methods(known: &Methods) -> String {
    let words = |method: Box<dyn Method>| {
        [method.name(), role(method.role()), method.summary(), method.source()].map(str::to_owned).to_vec()
    };
    aligned("methods", &known.all().into_iter().map(words).collect::<Vec<_>>())
}

/// The first sentence of a text, on one line.
fn sentence(text: &str) -> String {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    line.split_inclusive(". ").next().unwrap_or_default().trim_end().to_owned()
}

fn tasks(registry: &Registry) -> String {
    let rows = registry.tasks().flat_map(Task::settings).map(|setting| {
        let edit = if setting.variation.is_some() { setting.edit.word() } else { "original" };
        [setting.label(), edit.to_owned(), sentence(&setting.analysis)].to_vec()
    });
    aligned("tasks", &rows.collect::<Vec<_>>())
}

fn sequences(registry: &Registry) -> String {
    let rows = registry.tasks().flat_map(|task| task.sequences().iter().map(|sequence| (task.name(), sequence)));
    let rows = rows.map(|(task, sequence)| {
        let name = format!("{task}: {}", sequence.name);
        [name, sequence.stages.join(", "), sentence(&sequence.analysis)].to_vec()
    });
    aligned("sequences", &rows.collect::<Vec<_>>())
}

fn teachers(profiles: &[Profile]) -> String {
    let row = |profile: &Profile| [profile.name.clone(), sentence(&profile.analysis)].to_vec();
    aligned("teachers", &profiles.iter().map(row).collect::<Vec<_>>())
}

fn protocols() -> Result<String, BenchError> {
    let row = |name| Protocol::find(name).map(|protocol| [name.to_owned(), sentence(&protocol.analysis)].to_vec());
    Ok(aligned("protocols", &Protocol::names().map(row).collect::<Result<Vec<_>, _>>()?))
}

fn tables() -> String {
    let rows = tables::ALL.iter().map(|table| [table.name, table.question].map(str::to_owned).to_vec());
    aligned("tables", &rows.collect::<Vec<_>>())
}
