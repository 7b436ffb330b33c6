//! A LeRobot dataset, version 3, as a sheet.
//!
//! Its layout is that of the package `lerobot`: `meta/info.json`, and the frames of all episodes in
//! `data/chunk-…/file-….parquet`. A vector such as `observation.state` becomes a column for each of its elements,
//! called `observation.state[0]`, and by its name where the dataset names it: `observation.state.x`. `task` is what
//! the dataset says of a frame's task in words. Images and videos are not read.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::error::BenchError;
use crate::import::mapping::Mapping;
use crate::import::parquet_table::{LONGEST_VECTOR, ParquetColumn, read as read_parquet};
use crate::import::sheet::{Cells, Sheet, Usual};

/// The columns that a dataset has by itself.
const USUAL: Usual =
    Usual { time: Some("timestamp"), episode: Some("episode_index"), intervention: Some("intervention") };
/// Words about a frame that stand in a file of their own: the column of words, its index in the data, and the file.
const WORDS: [(&str, &str, &str); 2] =
    [("task", "task_index", "meta/tasks.parquet"), ("subtask", "subtask_index", "meta/subtasks.parquet")];

fn refuse(path: &Path, problem: impl Into<String>) -> BenchError {
    let problem = situ_tasks::name::shown(&problem.into());
    BenchError::Recording { path: path.to_owned(), place: String::new(), problem }
}

/// The sheet of a dataset, with the columns that the mapping names.
///
/// # Errors
/// [`BenchError::Read`]; [`BenchError::Recording`] with the file.
pub(super) fn read(folder: &Path, mapping: &Mapping) -> Result<Sheet, BenchError> {
    let features = features(&folder.join("meta/info.json"))?;
    let usual = [USUAL.time, USUAL.episode, USUAL.intervention].into_iter().flatten();
    let wanted: Vec<&str> = mapping.columns().into_iter().map(String::as_str).chain(usual).collect();
    let mut sheet = DatasetColumns { folder, wanted, columns: Vec::new(), others: Vec::new(), features };
    let files = data_files(folder)?;
    let mut rows = 0;
    for (number, path) in files.iter().enumerate() {
        let (more, columns) = read_parquet(path, |name| sheet.is_wanted(name))?;
        sheet.add(path, columns, number == 0)?;
        rows += more;
    }
    sheet.words()?;
    let DatasetColumns { mut columns, others, .. } = sheet;
    let mut met: Vec<String> = Vec::new();
    columns.retain(|(name, _)| {
        let is_new = !met.contains(name);
        met.push(name.clone());
        is_new
    });
    Ok(Sheet::new(folder, columns, "frame", (0..rows as u64).collect())?.with_usual(USUAL).with_others(others))
}

/// The features of a dataset, from the file that describes it.
fn features(path: &Path) -> Result<Vec<(String, Vec<String>)>, BenchError> {
    let text = fs::read_to_string(path).map_err(|source| BenchError::Read { path: path.to_owned(), source })?;
    let info: Value = serde_json::from_str(&text).map_err(|error| refuse(path, error.to_string()))?;
    let version = info.get("codebase_version").and_then(Value::as_str).unwrap_or_default();
    if version != "v3" && !version.starts_with("v3.") {
        let problem = format!(
            "codebase_version `{version}`: expected a dataset of version 3 (the package lerobot converts older ones)"
        );
        return Err(refuse(path, problem));
    }
    let Some(features) = info.get("features").and_then(Value::as_object) else {
        return Err(refuse(path, "expected `features`, the columns of the dataset"));
    };
    Ok(features.iter().map(|(name, feature)| (name.clone(), element_names(feature.get("names")))).collect())
}

/// The names of a vector's elements: a list of words, or lists by group.
fn element_names(names: Option<&Value>) -> Vec<String> {
    match names {
        Some(Value::Array(names)) => names.iter().filter_map(Value::as_str).map(str::to_owned).collect(),
        Some(Value::Object(groups)) => groups.values().flat_map(|group| element_names(Some(group))).collect(),
        _ => Vec::new(),
    }
}

/// The files of the frames in order.
fn data_files(folder: &Path) -> Result<Vec<PathBuf>, BenchError> {
    let data = folder.join("data");
    let list = |path: &Path| -> Result<Vec<PathBuf>, BenchError> {
        let wrong = |source| BenchError::Read { path: path.to_owned(), source };
        let mut entries = Vec::new();
        for entry in fs::read_dir(path).map_err(wrong)? {
            entries.push(entry.map_err(wrong)?.path());
        }
        entries.sort();
        Ok(entries)
    };
    let mut files = Vec::new();
    for chunk in list(&data)?.into_iter().filter(|path| path.is_dir()) {
        let parquet = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "parquet");
        files.extend(list(&chunk)?.into_iter().filter(parquet));
    }
    match files.is_empty() {
        true => Err(refuse(&data, "no frames: expected chunk-000/file-000.parquet")),
        false => Ok(files),
    }
}

/// The columns of a dataset as far as they are read.
struct DatasetColumns<'a> {
    folder: &'a Path,
    wanted: Vec<&'a str>,
    columns: Vec<(String, Cells)>,
    /// Everything that could be asked for.
    others: Vec<String>,
    features: Vec<(String, Vec<String>)>,
}

impl DatasetColumns<'_> {
    fn is_wanted(&self, name: &str) -> bool {
        let element = |wanted: &&str| wanted.strip_prefix(name).is_some_and(|rest| rest.starts_with(['.', '[']));
        self.wanted.iter().any(|wanted| *wanted == name || element(wanted))
            || WORDS.iter().any(|(word, index, _)| *index == name && self.wanted.contains(word))
    }

    /// Adds the columns of a file; `is_first` where they are the first.
    fn add(&mut self, path: &Path, columns: Vec<ParquetColumn>, is_first: bool) -> Result<(), BenchError> {
        if is_first {
            self.others = self.features.iter().flat_map(|(name, elements)| named(name, elements)).collect();
        }
        for column in columns {
            let ParquetColumn { name, width, is_list, cells } = column;
            let Some(width) = width.filter(|width| (1..=LONGEST_VECTOR).contains(width)) else {
                let problem = format!("column `{name}`: expected lists of one length, 1 to {LONGEST_VECTOR}");
                return Err(refuse(path, problem));
            };
            if !is_list || width == 1 {
                self.append(&name, &cells, 0, 1);
            }
            let elements = self.features.iter().find(|(feature, _)| *feature == name);
            let elements = elements.map(|(_, elements)| elements.clone()).unwrap_or_default();
            for element in (0..width).filter(|_| is_list) {
                self.append(&format!("{name}[{element}]"), &cells, element, width);
                if let Some(own) = elements.get(element) {
                    self.append(&format!("{name}.{own}"), &cells, element, width);
                }
            }
        }
        Ok(())
    }

    /// Adds each `width`th cell to a column, if anybody wants it.
    fn append(&mut self, name: &str, cells: &Cells, from: usize, width: usize) {
        let is_index = WORDS.iter().any(|(word, index, _)| *index == name && self.wanted.contains(word));
        if !self.wanted.contains(&name) && !is_index {
            return;
        }
        let more = match cells {
            Cells::Numbers(numbers) => Cells::Numbers(numbers.iter().skip(from).step_by(width).copied().collect()),
            Cells::Words(words) => Cells::Words(words.iter().skip(from).step_by(width).cloned().collect()),
        };
        match (self.columns.iter_mut().find(|(own, _)| own == name), more) {
            (Some((_, Cells::Numbers(all))), Cells::Numbers(more)) => all.extend(more),
            (Some((_, Cells::Words(all))), Cells::Words(more)) => all.extend(more),
            // Another type in a later file: the column is too short then, and that is refused.
            (Some(_), _) => {}
            (None, more) => self.columns.push((name.to_owned(), more)),
        }
    }

    /// Adds the words that stand in files of their own.
    fn words(&mut self) -> Result<(), BenchError> {
        for (word, index, file) in WORDS {
            let is_there = self.columns.iter().any(|(name, _)| name == word);
            let indices = self.columns.iter().find(|(name, _)| name == index);
            let (Some((_, Cells::Numbers(indices))), true, false) = (indices, self.wanted.contains(&word), is_there)
            else {
                continue;
            };
            let path = self.folder.join(file);
            let (_, table) = read_parquet(&path, |_| true)?;
            let column = |is_word: bool| table.iter().find(|column| matches!(column.cells, Cells::Words(_)) == is_word);
            let (Some(ParquetColumn { cells: Cells::Words(words), .. }), Some(ParquetColumn { cells, .. })) =
                (column(true), column(false))
            else {
                return Err(refuse(&path, format!("expected a column of words and `{index}`")));
            };
            let Cells::Numbers(keys) = cells else { continue };
            let of = |number: &f64| {
                let found = keys.iter().position(|key| key == number).and_then(|row| words.get(row));
                found.cloned().ok_or_else(|| refuse(&path, format!("no {word} with `{index}` {number}")))
            };
            let words = indices.iter().map(of).collect::<Result<Vec<_>, _>>()?;
            self.columns.push((word.to_owned(), Cells::Words(words)));
        }
        Ok(())
    }
}

/// The names by which a feature can be asked for.
fn named(feature: &str, elements: &[String]) -> Vec<String> {
    match elements {
        [] | [_] => vec![feature.to_owned()],
        elements => elements.iter().map(|element| format!("{feature}.{element}")).collect(),
    }
}
