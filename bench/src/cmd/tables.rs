//! `tables`: Markdown and CSV from ledgers.

use std::fs;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::error::BenchError;
use crate::files;
use crate::ledger::{self, Contents};
use crate::tables::Kind;

/// Makes the tables of ledgers: to standard output, or into a folder.
#[derive(Args, Clone, Debug)]
#[command(
    after_long_help = "Several ledgers count as one: the shards of a protocol, say. The same records give the same bytes.

Examples:
  situ-bench tables quick.jsonl
  situ-bench tables quick.jsonl --table t1 --format csv
  situ-bench tables shard-1.jsonl shard-2.jsonl --out tables"
)]
pub struct Tables {
    /// Ledgers that `run` wrote.
    #[arg(required = true, value_name = "LEDGER")]
    pub ledgers: Vec<PathBuf>,
    /// Writes the tables into this folder; without it they are printed.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// The tables to make; all where none is named.
    #[arg(long, value_enum)]
    pub table: Vec<TableName>,
    /// The format; without it Markdown is printed, and a folder gets both.
    #[arg(long, value_enum)]
    pub format: Option<Format>,
}

/// A table's name on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TableName {
    /// What corrections take, against teaching from scratch.
    T1,
    /// Successive corrections, against all demonstrations at once.
    T2,
    /// Which edit was needed, and which was made; how far the structure is what the teacher meant.
    T3,
    /// What an update costs.
    T4,
    /// What a corrected model still does.
    T5,
    /// Every method beside every edit.
    Methods,
}

impl From<TableName> for Kind {
    fn from(name: TableName) -> Self {
        match name {
            TableName::T1 => Self::Effort,
            TableName::T2 => Self::Separate,
            TableName::T3 => Self::Edits,
            TableName::T4 => Self::Cost,
            TableName::T5 => Self::Retention,
            TableName::Methods => Self::Methods,
        }
    }
}

/// A way to write a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Markdown.
    Md,
    /// Comma-separated values.
    Csv,
}

/// What is to be printed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Printed {
    /// To standard output.
    pub text: String,
    /// To standard error.
    pub warnings: Vec<String>,
}

impl Tables {
    /// Makes the tables, writes them where a folder is named, and returns what is to be printed.
    ///
    /// # Errors
    /// As [`ledger::read_all`]; [`BenchError::Write`].
    pub fn run(&self) -> Result<Printed, BenchError> {
        let Contents { records, warnings } = ledger::read_all(&self.ledgers)?;
        let ledgers: Vec<String> = self.ledgers.iter().map(|path| path.display().to_string()).collect();
        let mut kinds: Vec<Kind> = self.table.iter().copied().map(Kind::from).collect();
        if kinds.is_empty() {
            kinds = Kind::ALL.to_vec();
        }
        kinds.sort_unstable();
        kinds.dedup();
        let mut written: Vec<(String, String)> = Vec::new();
        for kind in kinds {
            let tables = kind.tables(&records);
            let command = format!("situ-bench tables {} --table {}", ledgers.join(" "), kind.name());
            if self.format != Some(Format::Csv) {
                let sections: Vec<String> = tables.iter().map(|table| table.to_markdown(&command)).collect();
                written.push((format!("{}.md", kind.name()), sections.join("\n")));
            }
            let csv = self.format.map_or(self.out.is_some(), |format| format == Format::Csv);
            if csv {
                written.extend(tables.iter().map(|table| (format!("{}.csv", table.id()), table.to_csv())));
            }
        }
        let Some(folder) = &self.out else {
            let text = written.into_iter().map(|(_, text)| text).collect::<Vec<_>>().join("\n");
            return Ok(Printed { text, warnings });
        };
        fs::create_dir_all(folder).map_err(|source| BenchError::Write { path: folder.clone(), source })?;
        let outputs: Vec<(PathBuf, String)> =
            written.into_iter().map(|(name, text)| (folder.join(name), text)).collect();
        files::write_all(&outputs)?;
        let text = outputs.iter().map(|(path, _)| format!("{}\n", path.display())).collect();
        Ok(Printed { text, warnings })
    }
}
