//! Columns as the bytes of a Parquet file.

use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};

/// A column that is written. A list has so many cells a row.
pub(super) enum Written {
    Flags(Vec<bool>),
    Whole(Vec<i64>),
    Singles(Vec<f32>),
    Words(Vec<String>),
    SingleLists(usize, Vec<f32>),
    DoubleLists(usize, Vec<f64>),
    WholeLists(usize, Vec<i64>),
    WordLists(usize, Vec<String>),
}

impl Written {
    /// The type of a cell, and the cells of a row where it is a list.
    fn form(&self) -> (Physical, Option<usize>) {
        match self {
            Self::Flags(_) => (Physical::BOOLEAN, None),
            Self::Whole(_) => (Physical::INT64, None),
            Self::Singles(_) => (Physical::FLOAT, None),
            Self::Words(_) => (Physical::BYTE_ARRAY, None),
            Self::SingleLists(width, _) => (Physical::FLOAT, Some(*width)),
            Self::DoubleLists(width, _) => (Physical::DOUBLE, Some(*width)),
            Self::WholeLists(width, _) => (Physical::INT64, Some(*width)),
            Self::WordLists(width, _) => (Physical::BYTE_ARRAY, Some(*width)),
        }
    }

    fn field(&self, name: &str) -> Result<TypePtr, ParquetError> {
        let (physical, width) = self.form();
        let logical = (physical == Physical::BYTE_ARRAY).then_some(LogicalType::String);
        let leaf = |name: &str| {
            let leaf = Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL);
            leaf.with_logical_type(logical.clone()).build().map(Arc::new)
        };
        if width.is_none() {
            return leaf(name);
        }
        let list = Type::group_type_builder("list").with_repetition(Repetition::REPEATED);
        let list = list.with_fields(vec![leaf("element")?]).build()?;
        let outer = Type::group_type_builder(name).with_repetition(Repetition::OPTIONAL);
        outer.with_logical_type(Some(LogicalType::List)).with_fields(vec![Arc::new(list)]).build().map(Arc::new)
    }

    fn write(&self, writer: &mut SerializedColumnWriter<'_>) -> Result<(), ParquetError> {
        let bytes = |words: &[String]| words.iter().map(|word| ByteArray::from(word.as_str())).collect::<Vec<_>>();
        match self {
            Self::Flags(cells) => put::<BoolType>(writer, cells, None),
            Self::Whole(cells) => put::<Int64Type>(writer, cells, None),
            Self::Singles(cells) => put::<FloatType>(writer, cells, None),
            Self::Words(cells) => put::<ByteArrayType>(writer, &bytes(cells), None),
            Self::SingleLists(width, cells) => put::<FloatType>(writer, cells, Some(*width)),
            Self::DoubleLists(width, cells) => put::<DoubleType>(writer, cells, Some(*width)),
            Self::WholeLists(width, cells) => put::<Int64Type>(writer, cells, Some(*width)),
            Self::WordLists(width, cells) => put::<ByteArrayType>(writer, &bytes(cells), Some(*width)),
        }
    }
}

/// Writes cells of which none is null.
fn put<T: DataType>(
    writer: &mut SerializedColumnWriter<'_>,
    cells: &[T::T],
    width: Option<usize>,
) -> Result<(), ParquetError> {
    // An element of a list is three levels deep: the list is there, it has an element, and that is there.
    let depths = vec![if width.is_some() { 3 } else { 1 }; cells.len()];
    let repeats =
        width.map(|width| (0..cells.len()).map(|cell| i16::from(cell % width.max(1) != 0)).collect::<Vec<_>>());
    writer.typed::<T>().write_batch(cells, Some(&depths), repeats.as_deref())?;
    Ok(())
}

/// The bytes of a file of columns of one length, with the keys and values of its description.
pub(super) fn bytes(columns: &[(String, Written)], said: &[(&str, String)]) -> Result<Vec<u8>, ParquetError> {
    let fields = columns.iter().map(|(name, column)| column.field(name)).collect::<Result<Vec<_>, _>>()?;
    let schema = Arc::new(Type::group_type_builder("schema").with_fields(fields).build()?);
    let said = said.iter().map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone())).collect();
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY);
    let properties = Arc::new(properties.set_key_value_metadata(Some(said)).build());
    let mut file = SerializedFileWriter::new(Vec::new(), schema, properties)?;
    let mut group = file.next_row_group()?;
    for (_, column) in columns {
        if let Some(mut writer) = group.next_column()? {
            column.write(&mut writer)?;
            writer.close()?;
        }
    }
    group.close()?;
    file.into_inner()
}
