//! Demonstrations as recordings: an MCAP file, or a LeRobot dataset.
//!
//! A demonstration file has no clock. It is made up: [`SPEED`], [`TURN`], [`RATE`]. Where the file has no poses of all
//! objects, one is where the last keyframe about it saw it.

#[cfg(feature = "lerobot")]
mod dataset;
#[cfg(feature = "mcap")]
mod mcap_file;
#[cfg(feature = "lerobot")]
mod parquet_file;
#[cfg(feature = "lerobot")]
mod statistics;
#[cfg_attr(not(all(feature = "lerobot", feature = "mcap")), allow(dead_code, reason = "each format uses some of it"))]
mod timeline;
#[cfg_attr(not(all(feature = "lerobot", feature = "mcap")), allow(dead_code, reason = "each format uses some of it"))]
mod written_mapping;

use std::path::{Path, PathBuf};

use crate::demonstration_file::DemonstrationFile;
use crate::error::BenchError;
use timeline::{ExportedEpisode, Timeline, timeline};
use written_mapping::Names;

pub use timeline::{RATE, SPEED, TURN};

/// What an export makes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exported {
    /// Each file and what is in it.
    pub files: Vec<(PathBuf, Vec<u8>)>,
    /// The text of the mapping by which `import` reads it again.
    pub mapping: String,
    /// What it is, and what was made up, line by line.
    pub report: String,
}

/// Demonstrations that go together, in the order in which they are learned, as an MCAP file.
///
/// # Errors
/// [`BenchError::Argument`] where this program was built without it, or there is no demonstration.
pub fn mcap(demonstrations: &[DemonstrationFile], path: &Path) -> Result<Exported, BenchError> {
    let timeline = some(demonstrations)?;
    let (bytes, names) = mcap_bytes(&timeline, path)?;
    Ok(exported(&timeline, vec![(path.to_owned(), bytes)], &names))
}

/// The same as a LeRobot dataset in `folder`; `task` is what its frames are said to be for.
///
/// # Errors
/// As [`mcap()`].
pub fn lerobot(demonstrations: &[DemonstrationFile], task: &str, folder: &Path) -> Result<Exported, BenchError> {
    let timeline = some(demonstrations)?;
    let (files, names) = dataset_files(&timeline, task, folder)?;
    Ok(exported(&timeline, files, &names))
}

fn some(demonstrations: &[DemonstrationFile]) -> Result<Timeline<'_>, BenchError> {
    match demonstrations {
        [] => Err(BenchError::Argument("no demonstration: expected at least one".to_owned())),
        some => Ok(timeline(some)),
    }
}

#[cfg(feature = "mcap")]
fn mcap_bytes(timeline: &Timeline<'_>, path: &Path) -> Result<(Vec<u8>, Names), BenchError> {
    let bytes = mcap_file::bytes(timeline)
        .map_err(|error| BenchError::Argument(format!("{}: no MCAP file: {error}", path.display())))?;
    Ok((bytes, mcap_file::names()))
}

#[cfg(not(feature = "mcap"))]
fn mcap_bytes(_: &Timeline<'_>, _: &Path) -> Result<(Vec<u8>, Names), BenchError> {
    Err(BenchError::Argument("MCAP: this program was built without the feature `mcap`".to_owned()))
}

/// Files with their contents, and the names of what is in them.
type Files = (Vec<(PathBuf, Vec<u8>)>, Names);

#[cfg(feature = "lerobot")]
fn dataset_files(timeline: &Timeline<'_>, task: &str, folder: &Path) -> Result<Files, BenchError> {
    let files = dataset::files(timeline, task, folder)
        .map_err(|error| BenchError::Argument(format!("{}: no dataset: {error}", folder.display())))?;
    Ok((files, dataset::names()))
}

#[cfg(not(feature = "lerobot"))]
fn dataset_files(_: &Timeline<'_>, _: &str, _: &Path) -> Result<Files, BenchError> {
    Err(BenchError::Argument("LeRobot: this program was built without the feature `lerobot`".to_owned()))
}

fn exported(timeline: &Timeline<'_>, files: Vec<(PathBuf, Vec<u8>)>, names: &Names) -> Exported {
    let frames: usize = timeline.episodes.iter().map(|episode| episode.frames.len()).sum();
    let mut report = format!(
        "{} episodes, {frames} frames at {RATE} a second; objects: {}\nThe clock is made up: {SPEED} m/s, {TURN} rad/s.\n",
        timeline.episodes.len(),
        timeline.objects.join(", "),
    );
    for (file, missing) in &timeline.unknown {
        report += &format!("{file} says nothing of {}: it stands where another file has it.\n", missing.join(", "));
    }
    for ExportedEpisode { file, .. } in &timeline.episodes {
        if let (Some(after), Some(interrupted)) = (&file.before.after, &file.before.interrupted)
            && after.demonstration != interrupted.demonstration
        {
            let (name, other) = (file.demonstration.name(), &interrupted.demonstration);
            report += &format!("{name}: the mapping does not say what was under way, since it is of {other}.\n");
        }
    }
    Exported { files, mapping: written_mapping::text(timeline, names), report }
}
