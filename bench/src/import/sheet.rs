//! A recording as a sheet: named columns of one length, whatever file it was.

use std::path::{Path, PathBuf};

use situ_tasks::name::shown;

use crate::error::BenchError;

/// The most rows of a recording: ten hours at 50 frames a second.
pub(super) const MOST_ROWS: usize = 1_800_000;

/// The cells of a column.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cells {
    Numbers(Vec<f64>),
    Words(Vec<String>),
}

impl Cells {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Numbers(numbers) => numbers.len(),
            Self::Words(words) => words.len(),
        }
    }
}

/// Columns that a kind of recording has by itself. Each counts where the mapping names no other and it is there.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Usual {
    /// Seconds.
    pub(super) time: Option<&'static str>,
    pub(super) episode: Option<&'static str>,
    pub(super) intervention: Option<&'static str>,
}

/// A recording as columns of one length.
#[derive(Debug)]
pub(super) struct Sheet {
    path: PathBuf,
    columns: Vec<(String, Cells)>,
    /// What the rows are called, and the number of each.
    row_word: &'static str,
    row_numbers: Vec<u64>,
    usual: Usual,
    /// What the recording has besides, for messages.
    others: Vec<String>,
}

impl Sheet {
    /// A sheet of columns that all have one cell for each of the rows.
    ///
    /// # Errors
    /// [`BenchError::Recording`] where it has too many rows, or none.
    pub(super) fn new(
        path: &Path,
        columns: Vec<(String, Cells)>,
        row_word: &'static str,
        row_numbers: Vec<u64>,
    ) -> Result<Self, BenchError> {
        let sheet =
            Self { path: path.to_owned(), columns, row_word, row_numbers, usual: Usual::default(), others: Vec::new() };
        let rows = sheet.rows();
        if rows == 0 {
            return Err(sheet.refuse("no row: expected at least one"));
        }
        if rows > MOST_ROWS {
            return Err(sheet.refuse(format!("{rows} rows: expected at most {MOST_ROWS}")));
        }
        match sheet.columns.iter().find(|(_, cells)| cells.len() != rows) {
            Some((name, cells)) => {
                Err(sheet.refuse(format!("column `{name}` has {} rows, others {rows}", cells.len())))
            }
            None => Ok(sheet),
        }
    }

    /// The same sheet with columns that count where the mapping says nothing.
    pub(super) fn with_usual(self, usual: Usual) -> Self {
        Self { usual, ..self }
    }

    /// The same sheet with the names of what the recording has besides and nobody asked for.
    pub(super) fn with_others(self, others: Vec<String>) -> Self {
        Self { others, ..self }
    }

    /// The columns that its kind has by itself, where they are there.
    pub(super) fn usual(&self) -> Usual {
        let there = |name: &&str| self.column(name).is_some();
        let Usual { time, episode, intervention } = self.usual;
        Usual { time: time.filter(there), episode: episode.filter(there), intervention: intervention.filter(there) }
    }

    /// The file or folder.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// How many rows there are.
    pub(super) fn rows(&self) -> usize {
        self.row_numbers.len()
    }

    /// The names of what the recording has.
    pub(super) fn names(&self) -> Vec<&str> {
        let names = self.columns.iter().map(|(name, _)| name.as_str());
        if self.others.is_empty() { names.collect() } else { self.others.iter().map(String::as_str).collect() }
    }

    /// The cells of a column.
    pub(super) fn column(&self, name: &str) -> Option<&Cells> {
        self.columns.iter().find(|(own, _)| own == name).map(|(_, cells)| cells)
    }

    /// The error of something in the recording as a whole.
    pub(super) fn refuse(&self, problem: impl Into<String>) -> BenchError {
        BenchError::Recording { path: self.path.clone(), place: String::new(), problem: shown(&problem.into()) }
    }

    /// The error of something in a row of a column.
    pub(super) fn refuse_at(&self, row: usize, column: &str, problem: impl Into<String>) -> BenchError {
        let number = self.row_numbers.get(row).copied().unwrap_or_default();
        let place = shown(&format!("{} {number}, column `{column}`: ", self.row_word));
        BenchError::Recording { path: self.path.clone(), place, problem: shown(&problem.into()) }
    }

    /// A column as finite numbers. `None` where there is no such column.
    ///
    /// # Errors
    /// [`BenchError::Recording`] at the first cell that is none.
    pub(super) fn numbers(&self, name: &str) -> Option<Result<Vec<f64>, BenchError>> {
        let finite = |row: usize, value: Option<f64>, word: &dyn Fn() -> String| match value {
            Some(value) if value.is_finite() => Ok(value),
            _ => Err(self.refuse_at(row, name, format!("`{}`: expected a finite number", word()))),
        };
        Some(match self.column(name)? {
            Cells::Numbers(numbers) => {
                let rows = numbers.iter().enumerate();
                rows.map(|(row, value)| finite(row, Some(*value), &|| value.to_string())).collect()
            }
            Cells::Words(words) => {
                let rows = words.iter().enumerate();
                rows.map(|(row, word)| finite(row, word.trim().parse().ok(), &|| word.clone())).collect()
            }
        })
    }

    /// A column as numbers in which `true` is 1, and `false` and nothing are 0.
    ///
    /// # Errors
    /// [`BenchError::Recording`] at the first cell that is neither.
    pub(super) fn flags(&self, name: &str) -> Option<Result<Vec<f64>, BenchError>> {
        let Cells::Words(words) = self.column(name)? else { return self.numbers(name) };
        let flag = |(row, word): (usize, &String)| match word.trim() {
            "" | "false" | "False" | "FALSE" => Ok(0.0),
            "true" | "True" | "TRUE" => Ok(1.0),
            word => match word.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(value),
                _ => Err(self.refuse_at(row, name, format!("`{word}`: expected a number, or true or false"))),
            },
        };
        Some(words.iter().enumerate().map(flag).collect())
    }

    /// A column as words.
    pub(super) fn words(&self, name: &str) -> Option<Vec<String>> {
        Some(match self.column(name)? {
            Cells::Words(words) => words.iter().map(|word| word.trim().to_owned()).collect(),
            Cells::Numbers(numbers) => numbers.iter().map(ToString::to_string).collect(),
        })
    }
}
