//! `tables`: Markdown, CSV, LaTeX and figures from ledgers.

use std::fs;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};

use crate::cmd::run::LEDGER;
use crate::error::BenchError;
use crate::files;
use crate::ledger;
use crate::provenances::{Permitted, Provenances};
use crate::tables::{ALL, Publication};

/// Makes the tables and figures of ledgers: to standard output, or into a folder.
#[derive(Args, Clone, Debug)]
#[command(
    after_long_help = "Several ledgers count as one: the shards of a protocol, say, or one's own beside ours. They must \
        be of one benchmark version, by the manifest.toml beside each of them, and the records of a method of one \
        revision of the program; the headings say which. The same records give the same bytes.

Examples:
  situ-bench tables quick.jsonl
  situ-bench tables quick.jsonl --table t1 --format csv
  situ-bench tables results/families --table questions --format tex
  situ-bench tables results/quick mine --table methods
  situ-bench tables shard-1.jsonl shard-2.jsonl --out tables"
)]
pub struct Tables {
    /// Ledgers that `run` wrote, or their folders.
    #[arg(required = true, value_name = "LEDGER")]
    pub ledgers: Vec<PathBuf>,
    /// Permits ledgers of different provenance. Every table's heading names them.
    #[arg(long)]
    pub mixed: bool,
    /// Writes the tables into this folder; without it they are printed.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// The tables to make; all where none is named.
    #[arg(long, value_parser = published())]
    pub table: Vec<&'static Publication>,
    /// The format; without it a folder gets all files, the figures with them, and what is printed is text where a
    /// terminal shows it, else Markdown.
    #[arg(long, value_enum)]
    pub format: Option<Format>,
}

/// A table by its name on the command line.
fn published() -> impl TypedValueParser<Value = &'static Publication> {
    let value = |table: &&'static Publication| PossibleValue::new(table.name).help(table.question);
    PossibleValuesParser::new(ALL.iter().map(value))
        .try_map(|name| ALL.into_iter().find(|table| table.name == name).ok_or("no such table"))
}

/// A way to write a table, or the figures beside them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Lines that fit the terminal, or 100 columns where there is none.
    Text,
    /// Markdown.
    Md,
    /// Comma-separated values.
    Csv,
    /// LaTeX, for the package booktabs.
    Tex,
    /// The figures.
    Svg,
}

impl Format {
    /// How the names of its files end.
    const fn ending(self) -> &'static str {
        match self {
            Self::Text => ".txt",
            Self::Md => ".md",
            Self::Csv => ".csv",
            Self::Tex => ".tex",
            Self::Svg => ".svg",
        }
    }
}

/// The text that is to be printed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PrintedTables {
    /// To standard output.
    pub text: String,
    /// To standard error.
    pub warnings: Vec<String>,
}

/// The least width that tables are fitted to.
const LEAST: usize = 60;
/// The width where no terminal says one.
const USUAL: usize = 100;

/// The width of the terminal.
fn width() -> usize {
    terminal_size::terminal_size().map_or(USUAL, |(width, _)| usize::from(width.0).max(LEAST))
}

impl Tables {
    /// Makes the tables, writes them where a folder is named, and returns the text that is to be printed.
    ///
    /// # Errors
    /// As [`Provenances::of`] and [`ledger::read_all`]; [`BenchError::Write`].
    pub fn run(&self) -> Result<PrintedTables, BenchError> {
        let in_folder = |path: &PathBuf| if path.is_dir() { path.join(LEDGER) } else { path.clone() };
        Self { ledgers: self.ledgers.iter().map(in_folder).collect(), ..self.clone() }.of_ledgers()
    }

    fn of_ledgers(&self) -> Result<PrintedTables, BenchError> {
        let provenances = match self.mixed {
            true => Provenances::of(&self.ledgers, Permitted::Mixed)?,
            false => Provenances::side_by_side(&self.ledgers)?,
        };
        let (records, warnings) = ledger::read_all(&self.ledgers)?;
        let ledgers: Vec<String> = self.ledgers.iter().map(|path| path.display().to_string()).collect();
        let heading = provenances.heading(&ledgers.join(" "));
        let printed = if io::stdout().is_terminal() { Format::Text } else { Format::Md };
        let format = self.format.or(self.out.is_none().then_some(printed));
        let is_wanted =
            |table: &Publication| self.table.is_empty() || self.table.iter().any(|wanted| wanted.name == table.name);
        if format == Some(Format::Text) {
            if let Some(folder) = &self.out {
                let problem = "--format text is for a terminal: expected md, csv, tex or svg with --out".to_owned();
                return Err(BenchError::Argument(format!("{}: {problem}", folder.display())));
            }
            let wanted = ALL.iter().filter(|table| is_wanted(table));
            let texts = wanted.map(|table| table.aligned(&records, &heading, width())).filter(|text| !text.is_empty());
            return Ok(PrintedTables { text: texts.collect::<Vec<_>>().join("\n"), warnings });
        }
        let files = ALL.iter().filter(|table| is_wanted(table)).flat_map(|table| table.files(&records, &heading));
        let files: Vec<(String, String)> =
            files.filter(|(name, _)| format.is_none_or(|format| name.ends_with(format.ending()))).collect();
        let Some(folder) = &self.out else {
            let text = files.into_iter().map(|(_, text)| text).collect::<Vec<_>>().join("\n");
            return Ok(PrintedTables { text, warnings });
        };
        fs::create_dir_all(folder).map_err(|source| BenchError::Write { path: folder.clone(), source })?;
        let outputs: Vec<(PathBuf, String)> = files.into_iter().map(|(name, text)| (folder.join(name), text)).collect();
        let ledgers: Vec<&Path> = self.ledgers.iter().map(PathBuf::as_path).collect();
        files::write_beside(&ledgers, &outputs)?;
        let text = outputs.iter().map(|(path, _)| format!("{}\n", path.display())).collect();
        Ok(PrintedTables { text, warnings })
    }
}
