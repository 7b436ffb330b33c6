//! `list`: what there is to choose from.

use std::fmt::Write;

use clap::{Args, ValueEnum};
use situ::method::{self, Role};

use crate::tables::Kind;

/// Lists what there is to choose from.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = "Examples:\n  situ-bench list\n  situ-bench list methods")]
pub struct List {
    /// What to list; all of it where nothing is named.
    #[arg(value_enum)]
    pub what: Option<What>,
}

/// Something to choose from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum What {
    /// Ways to keep a task model up to date.
    Methods,
    /// Tables that can be made from a ledger.
    Tables,
}

impl What {
    fn section(self) -> String {
        match self {
            Self::Methods => methods(),
            Self::Tables => tables(),
        }
    }
}

impl List {
    /// What is to be printed.
    pub fn run(&self) -> String {
        let sections = match self.what {
            Some(what) => vec![what],
            None => What::value_variants().to_vec(),
        };
        sections.into_iter().map(What::section).collect::<Vec<_>>().join("\n")
    }
}

const fn role(role: Role) -> &'static str {
    match role {
        Role::Correct => "takes corrections",
        Role::FromScratch => "taught anew",
        Role::Control => "control",
    }
}

/// Rows in columns, the last of which is not padded.
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

fn methods() -> String {
    let words = |method: Box<dyn method::Method>| {
        [method.name(), role(method.role()), method.summary(), method.source()].map(str::to_owned).to_vec()
    };
    aligned("methods", &method::all().into_iter().map(words).collect::<Vec<_>>())
}

fn tables() -> String {
    let row = |kind: &Kind| [kind.name(), kind.question()].map(str::to_owned).to_vec();
    aligned("tables", &Kind::ALL.iter().map(row).collect::<Vec<_>>())
}
