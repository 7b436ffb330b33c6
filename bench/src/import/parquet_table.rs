//! The columns of a Parquet file: flat ones, and lists of one length.
//!
//! The file is read column by column, with the `parquet` crate and without Arrow. That crate checks much of what it
//! reads but not all: where damaged bytes make it panic, the panic is caught here and is an error like the others.

use std::fs::File;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use parquet::basic::Type;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArray, DataType};
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use crate::error::BenchError;
use crate::import::sheet::{Cells, MOST_ROWS};

/// Rows that are read at once.
const BATCH: usize = 1 << 16;
/// The most cells of one column.
const MOST_CELLS: usize = 100 * MOST_ROWS;
/// The most elements of a list that is a vector: more is an image.
pub(super) const LONGEST_VECTOR: usize = 4096;
/// The most bytes of a file.
const MOST_BYTES: u64 = 4 << 30;

/// A column as the file has it: the cells of all rows one after another.
pub(super) struct ParquetColumn {
    pub(super) name: String,
    /// Cells of a row: 1 but for lists; `None` where rows differ.
    pub(super) width: Option<usize>,
    pub(super) is_list: bool,
    pub(super) cells: Cells,
}

/// The columns of a file whose names are `wanted`, with the number of rows.
///
/// # Errors
/// [`BenchError::Read`]; [`BenchError::Recording`] for damage.
pub(super) fn read(path: &Path, wanted: impl Fn(&str) -> bool) -> Result<(usize, Vec<ParquetColumn>), BenchError> {
    let file = File::open(path).map_err(|source| BenchError::Read { path: path.to_owned(), source })?;
    let length = file.metadata().map_err(|source| BenchError::Read { path: path.to_owned(), source })?.len();
    if length > MOST_BYTES {
        return Err(damaged(path, &format!("{length} bytes: expected at most {MOST_BYTES}")));
    }
    let outcome = catch_unwind(AssertUnwindSafe(|| columns(file, &wanted)));
    match outcome {
        Ok(Ok(read)) => Ok(read),
        Ok(Err(error)) => Err(damaged(path, &error.to_string())),
        Err(_) => Err(damaged(path, "its bytes contradict each other")),
    }
}

fn damaged(path: &Path, problem: &str) -> BenchError {
    let problem = situ_tasks::name::shown(&format!("cannot be read as Parquet: {problem}"));
    BenchError::Recording { path: path.to_owned(), place: String::new(), problem }
}

fn columns(file: File, wanted: &impl Fn(&str) -> bool) -> Result<(usize, Vec<ParquetColumn>), ParquetError> {
    let reader = SerializedFileReader::new(file)?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let mut rows = 0;
    for group in 0..reader.num_row_groups() {
        let more = usize::try_from(reader.metadata().row_group(group).num_rows()).unwrap_or(usize::MAX);
        rows = more.saturating_add(rows);
    }
    if rows > MOST_ROWS {
        return Err(ParquetError::General(format!("{rows} rows, expected at most {MOST_ROWS}")));
    }
    let mut columns = Vec::new();
    for (index, column) in schema.columns().iter().enumerate() {
        let name = column.path().parts().first().cloned().unwrap_or_default();
        let is_list = column.max_rep_level() == 1;
        let is_plain = column.path().parts().len() == 1 || is_list;
        if !wanted(&name) || !is_plain || column.max_rep_level() > 1 {
            continue;
        }
        let mut all = Vectors::default();
        for group in 0..reader.num_row_groups() {
            let cells = reader.get_row_group(group)?.get_column_reader(index)?;
            if !all.extend(cells, column)? {
                break;
            }
        }
        if let Some(cells) = all.cells {
            let found = all.rows;
            if found != rows {
                return Err(ParquetError::General(format!("column `{name}` has {found} rows of {rows}")));
            }
            columns.push(ParquetColumn { name, width: all.width, is_list, cells });
        }
    }
    Ok((rows, columns))
}

/// The cells of a column, as far as they are read.
#[derive(Default)]
struct Vectors {
    cells: Option<Cells>,
    rows: usize,
    width: Option<usize>,
    differs: bool,
}

impl Vectors {
    /// Adds the cells of a row group; false where cells of this type are not read.
    fn extend(&mut self, reader: ColumnReader, column: &ColumnDescriptor) -> Result<bool, ParquetError> {
        match (reader, column.physical_type()) {
            (ColumnReader::BoolColumnReader(reader), _) => self.numbers(reader, column, |value| f64::from(*value))?,
            (ColumnReader::Int32ColumnReader(reader), _) => self.numbers(reader, column, |value| f64::from(*value))?,
            (ColumnReader::Int64ColumnReader(reader), _) => self.numbers(reader, column, |value| *value as f64)?,
            (ColumnReader::FloatColumnReader(reader), _) => self.numbers(reader, column, |value| f64::from(*value))?,
            (ColumnReader::DoubleColumnReader(reader), _) => self.numbers(reader, column, |value| *value)?,
            (ColumnReader::ByteArrayColumnReader(reader), Type::BYTE_ARRAY) => {
                let word = |value: &ByteArray| String::from_utf8_lossy(value.data()).into_owned();
                let words = self.values(reader, column, word, String::new())?;
                match &mut self.cells {
                    Some(Cells::Words(all)) => all.extend(words),
                    _ => self.cells = Some(Cells::Words(words)),
                }
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn numbers<T: DataType>(
        &mut self,
        reader: ColumnReaderImpl<T>,
        column: &ColumnDescriptor,
        number: impl Fn(&T::T) -> f64,
    ) -> Result<(), ParquetError> {
        let numbers = self.values(reader, column, number, f64::NAN)?;
        match &mut self.cells {
            Some(Cells::Numbers(all)) => all.extend(numbers),
            _ => self.cells = Some(Cells::Numbers(numbers)),
        }
        Ok(())
    }

    /// The values of a row group. What is null is `none`.
    fn values<T: DataType, V: Clone>(
        &mut self,
        mut reader: ColumnReaderImpl<T>,
        column: &ColumnDescriptor,
        value: impl Fn(&T::T) -> V,
        none: V,
    ) -> Result<Vec<V>, ParquetError> {
        let mut all = Vec::new();
        let is_list = column.max_rep_level() == 1;
        let mut width = 0;
        loop {
            let (mut values, mut depths, mut repeats) = (Vec::new(), Vec::new(), Vec::new());
            let (records, ..) = reader.read_records(BATCH, Some(&mut depths), Some(&mut repeats), &mut values)?;
            if records == 0 {
                break;
            }
            if column.max_def_level() == 0 {
                depths = vec![0; values.len()];
            }
            let mut values = values.iter();
            for (index, depth) in depths.iter().enumerate() {
                let begins = !is_list || repeats.get(index).copied().unwrap_or(0) == 0;
                if begins && self.rows > 0 && index + all.len() > 0 {
                    self.note(width);
                }
                if begins {
                    (self.rows, width) = (self.rows + 1, 0);
                }
                let is_there = *depth == column.max_def_level();
                // In a list, what is not as deep as an element is an empty list.
                if is_there || !is_list || *depth + 1 == column.max_def_level() && column.self_type().is_optional() {
                    all.push(if is_there { values.next().map_or(none.clone(), &value) } else { none.clone() });
                    width += 1;
                }
            }
            if all.len() > MOST_CELLS {
                return Err(ParquetError::General(format!("more than {MOST_CELLS} cells in a column")));
            }
        }
        if self.rows > 0 {
            self.note(width);
        }
        Ok(all)
    }

    /// Takes note of the width of a row.
    fn note(&mut self, width: usize) {
        match self.width {
            None if !self.differs => self.width = Some(width),
            Some(own) if own != width => (self.width, self.differs) = (None, true),
            _ => {}
        }
    }
}
