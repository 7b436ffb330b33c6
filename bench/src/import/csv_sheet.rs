//! A CSV file as a sheet.

use std::path::Path;

use crate::error::BenchError;
use crate::import::sheet::{Cells, MOST_ROWS, Sheet};

/// The most columns of a file.
const MOST_COLUMNS: usize = 10_000;

/// Counts the lines of a file. The reader's own count is one short after lines that end as on Windows: it stops between
/// the two letters of such an end.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
}

impl Lines<'_> {
    /// The line, from 1, of the record that is read from a byte on; the bytes are asked in their order.
    fn at(&mut self, byte: u64) -> u64 {
        let mut byte = usize::try_from(byte).unwrap_or(usize::MAX).min(self.bytes.len());
        while matches!(self.bytes.get(byte), Some(b'\r' | b'\n')) {
            byte += 1;
        }
        let ends = self.bytes[self.at.min(byte)..byte].iter().filter(|letter| **letter == b'\n').count();
        (self.at, self.line) = (byte, self.line + ends as u64);
        self.line
    }
}

/// The sheet of a CSV file: a row of names, then a row for each frame, all of one length. A byte-order mark is left
/// out.
///
/// # Errors
/// [`BenchError::Recording`] with the line.
pub(super) fn read(bytes: &[u8], path: &Path) -> Result<Sheet, BenchError> {
    let refuse = |line: u64, problem: String| {
        let place = format!("line {line}: ");
        Err(BenchError::Recording { path: path.to_owned(), place, problem: situ_tasks::name::shown(&problem) })
    };
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(bytes);
    let mut columns: Vec<(String, Vec<String>)> = Vec::new();
    let (mut lines, mut counter) = (Vec::new(), Lines { bytes, at: 0, line: 1 });
    for record in reader.records() {
        let record = match record {
            Ok(record) => record,
            Err(error) => {
                let line = error.position().map_or(1, |position| counter.at(position.byte()));
                return refuse(line, "expected text in UTF-8".to_owned());
            }
        };
        let line = record.position().map_or(1, |position| counter.at(position.byte()));
        if columns.is_empty() {
            if record.len() > MOST_COLUMNS {
                return refuse(line, format!("{} columns: expected at most {MOST_COLUMNS}", record.len()));
            }
            for name in &record {
                let name = name.trim();
                if columns.iter().any(|(other, _)| other == name) {
                    return refuse(line, format!("two columns are called `{name}`: expected a name of its own each"));
                }
                columns.push((name.to_owned(), Vec::new()));
            }
            continue;
        }
        if record.len() != columns.len() {
            return refuse(line, format!("{} cells: expected {}, one a column", record.len(), columns.len()));
        }
        if lines.len() >= MOST_ROWS {
            return refuse(line, format!("expected at most {MOST_ROWS} rows"));
        }
        for ((_, cells), cell) in columns.iter_mut().zip(&record) {
            cells.push(cell.to_owned());
        }
        lines.push(line);
    }
    let columns = columns.into_iter().map(|(name, words)| (name, Cells::Words(words))).collect();
    Sheet::new(path, columns, "line", lines)
}
