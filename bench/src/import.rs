//! Recordings of one's own robot as demonstrations: CSV files, LeRobot datasets and MCAP files.
//!
//! A [`Mapping`] says where in a recording the gripper and the objects are. A recording becomes a sheet of named
//! columns, the sheet becomes frames in our units, and from the frames of each episode the keyframes are picked and
//! what they are about is decided. `bench/docs/import.md` is the page about it.

mod attempt;
mod csv_sheet;
mod doubts;
mod drawn;
mod frames;
mod keyframes;
#[cfg(feature = "lerobot")]
mod lerobot_sheet;
#[cfg_attr(not(all(feature = "lerobot", feature = "mcap")), allow(dead_code, reason = "each format uses some of it"))]
mod mapping;
mod mapping_keys;
#[cfg(feature = "mcap")]
mod mcap_sheet;
#[cfg(feature = "lerobot")]
mod parquet_table;
mod polyline;
mod recording;
mod references;
mod report;
#[cfg_attr(not(all(feature = "lerobot", feature = "mcap")), allow(dead_code, reason = "each format uses some of it"))]
mod sheet;
mod written;

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

use situ::demonstration::Kind;
use situ_tasks::name::shown;

use crate::demonstration_file::Instance;
use crate::error::BenchError;
use attempt::{Reached, reached};
use drawn::Drawn;
use frames::{Take, takes};
use keyframes::closed;
use mapping::key;
use mapping_keys::{EpisodeKeys, Stopped};
use report::counted;
use sheet::Sheet;

pub use mapping::Mapping;
pub use mapping_keys::QuaternionOrder;
pub use polyline::{Tolerance, polyline};

/// What an import makes.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// The demonstrations in order, each its name and the text of its file.
    pub demonstrations: Vec<(String, String)>,
    /// What was decided, one line a keyframe.
    pub report: String,
}

/// Demonstrations of recordings.
///
/// # Errors
/// [`BenchError::Read`]; [`BenchError::Task`] for a mistake in the mapping: with file, line and key;
/// [`BenchError::Recording`] for one in a recording: with file, row and column.
pub fn import(paths: &[PathBuf], mapping: &Mapping) -> Result<Imported, BenchError> {
    let sheets = paths.iter().map(|path| recording::sheet(path, mapping)).collect::<Result<Vec<_>, _>>()?;
    demonstrations(&sheets, mapping)
}

/// Demonstrations of a CSV or an MCAP file with these bytes; `path` is for messages and names.
///
/// # Errors
/// As [`import`].
pub fn import_bytes(bytes: &[u8], path: &Path, mapping: &Mapping) -> Result<Imported, BenchError> {
    demonstrations(&[recording::file(bytes, path, mapping)?], mapping)
}

/// How the stop before a correction was found.
const FOUND: &str = "as far as the attempt came";
const SAID: &str = "the mapping says so";

/// An episode, its name, and whether the gripper is closed at each of its frames.
struct Episode {
    take: Take,
    name: String,
    closed: Vec<bool>,
}

impl Episode {
    /// Whether a person intervened.
    fn is_led(&self) -> bool {
        self.take.frames.iter().any(|frame| frame.intervention)
    }
}

/// A demonstration and where the robot had stopped before it.
struct Finished<'a> {
    drawn: Drawn<'a>,
    after: Option<Instance>,
    interrupted: Option<Instance>,
    /// How that was found.
    because: &'static str,
}

fn demonstrations(sheets: &[Sheet], mapping: &Mapping) -> Result<Imported, BenchError> {
    let mut report = String::new();
    let mut episodes: Vec<Episode> = Vec::new();
    for sheet in sheets {
        let more = episodes_of(sheet, mapping, sheets.len() == 1)?;
        if let Some(twin) = more.iter().find(|one| episodes.iter().any(|other| other.take.label == one.take.label)) {
            return Err(sheet.refuse(format!("episode `{}` is in an earlier recording, too", twin.take.label)));
        }
        let (number, rows) = (counted(more.len(), "episode"), counted(sheet.rows(), "frame"));
        let path = shown(&sheet.path().display().to_string());
        report += &format!("{path}: {number}, {rows}\n");
        episodes.extend(more);
    }
    check_episodes(&episodes, mapping)?;
    let mut originals = Vec::new();
    for episode in episodes.iter().filter(|episode| is_original(episode, mapping)) {
        let drawn = draw(episode, &episode.name, Kind::Original, 0..episode.closed.len(), mapping)?;
        originals.push(Finished { drawn, after: None, interrupted: None, because: "" });
    }
    let mut corrections = Vec::new();
    for episode in episodes.iter().filter(|episode| !is_original(episode, mapping)) {
        for (number, range) in correction_ranges(episode).into_iter().enumerate() {
            corrections.push(correction(episode, number, range, &originals, mapping)?);
        }
    }
    let all: Vec<Finished<'_>> = originals.into_iter().chain(corrections).collect();
    check_names(&all, mapping)?;
    let demonstrations = all.iter().map(|finished| {
        let Finished { drawn, after, interrupted, because } = finished;
        report += &format!("\n{}", report::demonstration(drawn, (after.as_ref(), interrupted.as_ref()), because));
        report += &doubts::of(drawn);
        (drawn.name.clone(), drawn.text(after.clone(), interrupted.clone()))
    });
    Ok(Imported { demonstrations: demonstrations.collect(), report })
}

/// The episodes of a sheet, but for those that the mapping leaves out.
fn episodes_of(sheet: &Sheet, mapping: &Mapping, is_alone: bool) -> Result<Vec<Episode>, BenchError> {
    let stem = sheet.path().file_stem().map_or("recording".into(), |stem| stem.to_string_lossy().into_owned());
    let has_labels = mapping.keys.columns.episode.is_some() || sheet.usual().episode.is_some();
    let prefix = mapping.keys.name.as_ref();
    let named = |label: &str| match (has_labels, prefix) {
        (true, prefix) => format!("{}-{label}", prefix.unwrap_or(&stem)),
        (false, Some(prefix)) if is_alone => prefix.clone(),
        (false, Some(prefix)) => format!("{prefix}-{label}"),
        (false, None) => label.to_owned(),
    };
    let mut episodes = Vec::new();
    for take in takes(sheet, mapping, &stem)? {
        let keys = mapping.episode(&take.label, None).map(|(_, keys)| keys);
        if keys.is_some_and(|keys| keys.skip) {
            continue;
        }
        let name = keys.and_then(|keys| keys.name.clone()).unwrap_or_else(|| named(&take.label));
        let closed = closed(&take.frames, mapping);
        episodes.push(Episode { take, name, closed });
    }
    Ok(episodes)
}

/// Every episode that the mapping speaks of is there, or left out.
fn check_episodes(episodes: &[Episode], mapping: &Mapping) -> Result<(), BenchError> {
    for (index, keys) in mapping.keys.episodes.iter().enumerate() {
        let label = keys.episode.text();
        if !keys.skip && episodes.iter().all(|episode| episode.take.label != label) {
            let known: Vec<&str> = episodes.iter().map(|episode| episode.take.label.as_str()).collect();
            let at = key(&["episodes"]).index(index).field("episode");
            let problem = format!("no episode `{label}`: expected one of {}", known.join(", "));
            return Err(mapping.refuse(&at, problem));
        }
    }
    if episodes.is_empty() {
        return Err(mapping.refuse(&key(&["episodes"]), "leaves no episode: expected at least one"));
    }
    Ok(())
}

/// Every demonstration has a name of its own, and what the mapping says of demonstrations is said of one of them.
fn check_names(all: &[Finished<'_>], mapping: &Mapping) -> Result<(), BenchError> {
    let mut met = BTreeSet::new();
    for Finished { drawn, .. } in all {
        if !met.insert(drawn.name.as_str()) {
            let problem = format!("two demonstrations are called `{}`: expected a name of its own each", drawn.name);
            return Err(mapping.refuse(&key(&["name"]), problem));
        }
    }
    for (index, keys) in mapping.keys.overrides.iter().enumerate() {
        let Some(named) = keys.demonstration.as_deref() else { continue };
        if !met.contains(named) {
            let known: Vec<&str> = met.iter().copied().collect();
            let at = key(&["override"]).index(index).field("demonstration");
            let problem = format!("no demonstration `{named}`: expected one of {}", known.join(", "));
            return Err(mapping.refuse(&at, problem));
        }
    }
    Ok(())
}

/// Whether an episode is a demonstration of the whole task: nobody intervened, and nothing else is said.
fn is_original(episode: &Episode, mapping: &Mapping) -> bool {
    let own = mapping.episode(&episode.take.label, None).and_then(|(_, keys)| keys.kind);
    let kind = own.or(mapping.keys.kind).unwrap_or(Kind::Original);
    kind == Kind::Original && !episode.is_led()
}

/// The frames of each correction in an episode: each run of frames in which a person intervened; all of an episode in
/// which nobody did.
fn correction_ranges(episode: &Episode) -> Vec<Range<usize>> {
    let frames = &episode.take.frames;
    let mut ranges: Vec<Range<usize>> = Vec::new();
    for (index, _) in frames.iter().enumerate().filter(|(_, frame)| frame.intervention) {
        match ranges.last_mut().filter(|range| range.end == index) {
            Some(range) => range.end = index + 1,
            None => ranges.push(index..index + 1),
        }
    }
    if ranges.is_empty() {
        ranges.push(0..frames.len());
    }
    ranges
}

fn draw<'a>(
    episode: &'a Episode,
    name: &str,
    kind: Kind,
    range: Range<usize>,
    mapping: &'a Mapping,
) -> Result<Drawn<'a>, BenchError> {
    let is_end = range.end == episode.take.frames.len();
    let mut drawn = Drawn::new(name.to_owned(), kind, (&episode.take, range), &episode.closed, mapping)?;
    let said = mapping.episode(&episode.take.label, None).and_then(|(_, keys)| keys.carried_to_end);
    drawn.carried_to_end = said.unwrap_or(is_end);
    Ok(drawn)
}

/// A correction of an episode, `number` from 0, with where the attempt had stopped.
fn correction<'a>(
    episode: &'a Episode,
    number: usize,
    range: Range<usize>,
    originals: &[Finished<'_>],
    mapping: &'a Mapping,
) -> Result<Finished<'a>, BenchError> {
    let label = &episode.take.label;
    let of_all = mapping.episode(label, None);
    let own = mapping.episode(label, Some(number + 1)).or(of_all);
    let given = of_all.and_then(|(_, keys)| keys.corrections.get(number).cloned());
    let given = given.or_else(|| own.and_then(|(_, keys)| keys.correction.and(keys.name.clone())));
    let name = match given {
        Some(name) => name,
        None if episode.is_led() => format!("{}-correction-{}", episode.name, number + 1),
        None => episode.name.clone(),
    };
    let mut drawn = draw(episode, &name, Kind::Corrective, range.clone(), mapping)?;
    if let Some(said) = own.and_then(|(_, keys)| keys.carried_to_end) {
        drawn.carried_to_end = said;
    }
    let follows = own.and_then(|(_, keys)| keys.follows.as_ref()).or(mapping.keys.follows.as_ref());
    let followed = match follows {
        Some(name) => originals.iter().find(|original| original.drawn.name == *name),
        None => originals.first(),
    };
    let at = own.map_or(key(&["follows"]), |(index, _)| key(&["episodes"]).index(index));
    let Some(follows) = follows.cloned().or(followed.map(|original| original.drawn.name.clone())) else {
        let problem = format!("`{name}` corrects an attempt: expected `follows`, the name of the original it followed");
        return Err(mapping.refuse(&at, problem));
    };
    let (Reached { after, interrupted }, because) = match (said(own.map(|(_, keys)| keys)), followed) {
        ((Some(after), Some(interrupted)), _) => (Reached { after, interrupted }, SAID),
        ((Some(after), None), _) if !episode.is_led() => (Reached { after, interrupted: None }, SAID),
        (_, _) if !episode.is_led() => {
            let problem = format!("all of episode `{label}` is a correction: expected `after` in its `[[episodes]]`");
            return Err(mapping.refuse(&at, problem));
        }
        (_, None) => {
            let problem = format!("no original `{follows}` is in this import: expected `after` and `interrupted`");
            return Err(mapping.refuse(&at, problem));
        }
        ((after, interrupted), Some(original)) => {
            let found = along(episode, range.start, original, mapping);
            let (after, interrupted) = (after.unwrap_or(found.after), interrupted.unwrap_or(found.interrupted));
            (Reached { after, interrupted }, if found == (Reached { after, interrupted }) { FOUND } else { SAID })
        }
    };
    let segments = followed.map_or(usize::MAX, |original| original.drawn.segments().len());
    if after.max(interrupted).is_some_and(|index| index as usize >= segments) {
        let problem = format!("`{follows}` has {segments} segments: expected 0 to {}", segments - 1);
        return Err(mapping.refuse(&at, problem));
    }
    let instance = |segment| Instance { demonstration: follows.clone(), segment };
    Ok(Finished { drawn, after: after.map(instance), interrupted: interrupted.map(instance), because })
}

/// What the mapping says of the stop: of each part nothing, or a segment, or none.
fn said(keys: Option<&EpisodeKeys>) -> (Option<Option<u32>>, Option<Option<u32>>) {
    let of = |part: Option<Stopped>| part.map(Stopped::segment);
    keys.map_or((None, None), |keys| (of(keys.after), of(keys.interrupted)))
}

/// How far the frames of an episode before `end` come along an original.
fn along(episode: &Episode, end: usize, original: &Finished<'_>, mapping: &Mapping) -> Reached {
    let keys = &mapping.keys.keyframes;
    let tolerance = Tolerance { metres: keys.metres, radians: keys.radians };
    let closed = closed(original.drawn.frames, mapping);
    let ends = original.drawn.segment_ends(|frame| closed[frame]);
    reached(&episode.take.frames[..end], &episode.closed[..end], &ends, tolerance)
}
