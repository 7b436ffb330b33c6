//! Demonstrations as a LeRobot dataset, version 3, without images.
//!
//! The layout is that of the package `lerobot`: all frames in one file, a row an episode in another, statistics, tasks.
//! A correction is in one episode with its attempt, and `intervention` says of each frame who leads. Numbers are of
//! single precision, as policies want them. `action` is the pose of the next frame and the command to the gripper;
//! `observation.state` the pose and the command before. What a keyframe is and what it is about stand in columns of
//! their own.

use std::path::{Path, PathBuf};

use parquet::errors::ParquetError;
use serde_json::{Map, Value, json};

use crate::export::parquet_file::{Written, bytes};
use crate::export::statistics::Statistics;
use crate::export::timeline::{ExportedFrame, RATE, Timeline, kind_word, seven};
use crate::export::written_mapping::{Names, pose_keys};

const VERSION: &str = "v3.0";
/// The parts of the hand in `observation.state` and `action`.
const HAND: [&str; 8] = ["x", "y", "z", "qw", "qx", "qy", "qz", "gripper"];
/// Of a dataset's settings, those that the package writes by itself.
const CHUNK: u32 = 1000;
const DATA_MEGABYTES: u32 = 100;
const VIDEO_MEGABYTES: u32 = 200;

const DATA: &str = "data/chunk-000/file-000.parquet";
const EPISODES: &str = "meta/episodes/chunk-000/file-000.parquet";

/// A feature of the dataset: its column for some frames.
struct DatasetFeature {
    name: &'static str,
    kind: &'static str,
    elements: Option<Vec<String>>,
    column: Written,
}

/// The names by which the mapping finds the columns again.
pub(super) fn names() -> Names {
    let hand = pose_keys(|part| format!("observation.state.{part}"));
    let tables = format!(
        "[columns]\nmark = \"keyframe\"\nreference = \"reference\"\nnarration = \"narration\"\n\
         announced = \"announced\"\nhold = \"hold\"\n\n[gripper]\n{hand}\n\
         [opening]\ncommand = \"gripper_value\"\ncommand_kind = \"gripper_kind\"\n"
    );
    Names { tables, object: |object| pose_keys(|part| format!("observation.environment_state.{object}_{part}")) }
}

/// The files of a dataset in `folder`.
///
/// # Errors
/// Those of the Parquet writer.
pub(super) fn files(
    timeline: &Timeline<'_>,
    task: &str,
    folder: &Path,
) -> Result<Vec<(PathBuf, Vec<u8>)>, ParquetError> {
    let all: Vec<&[ExportedFrame<'_>]> = timeline.episodes.iter().map(|episode| &episode.frames[..]).collect();
    let features = features(timeline, &all, 0);
    let info = info(timeline, &features);
    let statistics: Map<String, Value> = numbers(&features).map(|(name, each)| (name, each.json())).collect();
    let episodes = episodes(timeline, task);
    let data: Vec<(String, Written)> =
        features.into_iter().map(|feature| (feature.name.to_owned(), feature.column)).collect();
    let tasks = [
        ("task_index".to_owned(), Written::Whole(vec![0])),
        ("__index_level_0__".to_owned(), Written::Words(vec![task.to_owned()])),
    ];
    let text = |value: &Value| format!("{value:#}\n").into_bytes();
    let at = |name: &str| folder.join(name);
    Ok(vec![
        (at("meta/info.json"), text(&info)),
        (at("meta/stats.json"), text(&Value::Object(statistics))),
        (at("meta/tasks.parquet"), bytes(&tasks, &[("pandas", pandas())])?),
        (at(EPISODES), bytes(&episodes, &[])?),
        (at(DATA), bytes(&data, &[])?),
    ])
}

/// What pandas is told of the table of tasks: the words are its index.
fn pandas() -> String {
    let column = |name: Option<&str>, field: &str, kind: &str, numpy: &str| json!({"name": name, "field_name": field, "pandas_type": kind, "numpy_type": numpy, "metadata": null});
    let columns = [
        column(Some("task_index"), "task_index", "int64", "int64"),
        column(None, "__index_level_0__", "unicode", "object"),
    ];
    let labels = json!([{"name": null, "field_name": null, "pandas_type": "unicode", "numpy_type": "object",
        "metadata": {"encoding": "UTF-8"}}]);
    json!({"index_columns": ["__index_level_0__"], "column_indexes": labels, "columns": columns}).to_string()
}

/// The features of episodes; the first of them has the index `from`.
fn features(timeline: &Timeline<'_>, episodes: &[&[ExportedFrame<'_>]], from: usize) -> Vec<DatasetFeature> {
    let numbers = episodes.iter().enumerate().flat_map(|(index, frames)| vec![(from + index) as i64; frames.len()]);
    let rows = DatasetRows {
        timeline,
        frames: episodes.iter().flat_map(|frames| frames.iter()).collect(),
        indices: episodes.iter().flat_map(|frames| 0..frames.len()).collect(),
        episodes: numbers.collect(),
        before: timeline.episodes[..from].iter().map(|episode| episode.frames.len()).sum(),
    };
    let mut features = rows.motion();
    features.extend(rows.keyframes());
    features.extend(rows.places());
    // As the keys of a JSON file stand, so that all files have one order.
    features.sort_by_key(|feature| feature.name);
    features
}

/// The frames of some episodes, one after another.
struct DatasetRows<'a> {
    timeline: &'a Timeline<'a>,
    frames: Vec<&'a ExportedFrame<'a>>,
    /// The index of each frame in its episode.
    indices: Vec<usize>,
    /// The index of each frame's episode.
    episodes: Vec<i64>,
    /// Frames of episodes before these.
    before: usize,
}

impl DatasetRows<'_> {
    /// What is observed, and what is done.
    fn motion(&self) -> Vec<DatasetFeature> {
        let hand = |frame: &ExportedFrame<'_>, share: f64| {
            seven(&frame.hand).into_iter().chain([share]).map(|value| value as f32).collect::<Vec<f32>>()
        };
        let state = self.frames.iter().enumerate().flat_map(|(row, frame)| {
            // The command that was in force when the frame began.
            let last = if self.indices[row] == 0 { frame } else { self.frames[row - 1] };
            hand(frame, self.timeline.share(last.gripper))
        });
        let action = self.frames.iter().enumerate().flat_map(|(row, frame)| {
            let is_last = self.indices.get(row + 1).is_none_or(|next| *next == 0);
            hand(if is_last { frame } else { self.frames[row + 1] }, self.timeline.share(frame.gripper))
        });
        let things = self.frames.iter().flat_map(|frame| frame.objects.iter().flat_map(seven));
        let things: Vec<f32> = things.map(|value| value as f32).collect();
        let part = |object: &&str| HAND[..7].iter().map(|part| format!("{object}_{part}")).collect::<Vec<_>>();
        let parts: Vec<String> = self.timeline.objects.iter().flat_map(part).collect();
        let names = || HAND.map(str::to_owned).to_vec();
        let vectors = |name, elements: Vec<String>, numbers| DatasetFeature {
            name,
            kind: "float32",
            column: Written::SingleLists(elements.len(), numbers),
            elements: Some(elements),
        };
        vec![
            vectors("observation.state", names(), state.collect()),
            vectors("observation.environment_state", parts, things),
            vectors("action", names(), action.collect()),
        ]
    }

    /// What is shown, and who leads.
    fn keyframes(&self) -> Vec<DatasetFeature> {
        let single = |of: fn(&ExportedFrame<'_>) -> f64| {
            Written::Singles(self.frames.iter().map(|frame| of(frame) as f32).collect())
        };
        let flag =
            |of: fn(&ExportedFrame<'_>) -> bool| Written::Flags(self.frames.iter().map(|frame| of(frame)).collect());
        let words = |of: for<'b> fn(&'b ExportedFrame<'b>) -> &'b str| {
            Written::Words(self.frames.iter().map(|frame| of(frame).to_owned()).collect())
        };
        let marks = self.frames.iter().map(|frame| frame.mark.into()).collect();
        vec![
            scalar("intervention", "bool", flag(|frame| frame.intervention)),
            scalar("keyframe", "int64", Written::Whole(marks)),
            scalar("hold", "float32", single(|frame| if frame.mark > 0 { frame.keyframe.hold } else { 0.0 })),
            scalar("announced", "bool", flag(|frame| frame.mark > 0 && frame.keyframe.announced)),
            scalar("reference", "string", words(|frame| &frame.keyframe.reference)),
            scalar("narration", "string", words(|frame| frame.keyframe.narration.as_deref().unwrap_or_default())),
            scalar("gripper_value", "float32", single(|frame| frame.gripper.value())),
            scalar("gripper_kind", "string", words(|frame| kind_word(frame.gripper))),
        ]
    }

    /// Where each frame is in the dataset.
    fn places(&self) -> Vec<DatasetFeature> {
        let time = |index: &usize| (*index as f64 / f64::from(RATE)) as f32;
        let all = self.before..self.before + self.frames.len();
        vec![
            scalar("timestamp", "float32", Written::Singles(self.indices.iter().map(time).collect())),
            scalar("frame_index", "int64", Written::Whole(self.indices.iter().map(|index| *index as i64).collect())),
            scalar("episode_index", "int64", Written::Whole(self.episodes.clone())),
            scalar("index", "int64", Written::Whole(all.map(|index| index as i64).collect())),
            scalar("task_index", "int64", Written::Whole(vec![0; self.frames.len()])),
        ]
    }
}

fn scalar(name: &'static str, kind: &'static str, column: Written) -> DatasetFeature {
    DatasetFeature { name, kind, elements: None, column }
}

/// The statistics of each feature that is of numbers.
fn numbers(features: &[DatasetFeature]) -> impl Iterator<Item = (String, Statistics)> {
    features.iter().filter_map(|feature| {
        let (width, numbers): (usize, Vec<f64>) = match &feature.column {
            Written::Flags(cells) => (1, cells.iter().map(|cell| f64::from(*cell)).collect()),
            Written::Whole(cells) => (1, cells.iter().map(|cell| *cell as f64).collect()),
            Written::Singles(cells) => (1, cells.iter().map(|cell| f64::from(*cell)).collect()),
            Written::SingleLists(width, cells) => (*width, cells.iter().map(|cell| f64::from(*cell)).collect()),
            _ => return None,
        };
        Some((feature.name.to_owned(), Statistics::of(&numbers, width)))
    })
}

fn info(timeline: &Timeline<'_>, features: &[DatasetFeature]) -> Value {
    let feature = |feature: &DatasetFeature| {
        let DatasetFeature { name, kind, elements, .. } = feature;
        let shape = elements.as_ref().map_or(1, Vec::len);
        ((*name).to_owned(), json!({"dtype": kind, "shape": [shape], "names": elements}))
    };
    let episodes = timeline.episodes.len();
    json!({
        "codebase_version": VERSION,
        "robot_type": null,
        "total_episodes": episodes,
        "total_frames": timeline.episodes.iter().map(|episode| episode.frames.len()).sum::<usize>(),
        "total_tasks": 1,
        "chunks_size": CHUNK,
        "data_files_size_in_mb": DATA_MEGABYTES,
        "video_files_size_in_mb": VIDEO_MEGABYTES,
        "fps": RATE,
        "splits": {"train": format!("0:{episodes}")},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": null,
        "features": features.iter().map(feature).collect::<Map<String, Value>>(),
    })
}

/// A row an episode: where its frames are, and their statistics.
fn episodes(timeline: &Timeline<'_>, task: &str) -> Vec<(String, Written)> {
    let count = timeline.episodes.len();
    let lengths: Vec<i64> = timeline.episodes.iter().map(|episode| episode.frames.len() as i64).collect();
    let ends: Vec<i64> = lengths
        .iter()
        .scan(0, |sum, length| {
            *sum += length;
            Some(*sum)
        })
        .collect();
    let begins = ends.iter().zip(&lengths).map(|(end, length)| end - length).collect();
    let zero = || Written::Whole(vec![0; count]);
    let mut columns: Vec<(String, Written)> = [
        ("episode_index", Written::Whole((0..count as i64).collect())),
        ("tasks", Written::WordLists(1, vec![task.to_owned(); count])),
        ("length", Written::Whole(lengths)),
        ("data/chunk_index", zero()),
        ("data/file_index", zero()),
        ("dataset_from_index", Written::Whole(begins)),
        ("dataset_to_index", Written::Whole(ends)),
        ("meta/episodes/chunk_index", zero()),
        ("meta/episodes/file_index", zero()),
    ]
    .map(|(name, column)| (name.to_owned(), column))
    .into();
    let of = |index: usize| {
        let frames = &timeline.episodes[index].frames[..];
        numbers(&features(timeline, &[frames], index)).collect::<Vec<_>>()
    };
    let all: Vec<Vec<(String, Statistics)>> = (0..count).map(of).collect();
    let names = all.first().into_iter().flatten().map(|(name, _)| name);
    for (feature, name) in names.enumerate() {
        let each = || all.iter().map(|statistics| &statistics[feature].1);
        let Some(first) = each().next() else { continue };
        for (part, (word, values)) in first.named().into_iter().enumerate() {
            let cells = each().flat_map(|statistics| statistics.named()[part].1.clone()).collect();
            columns.push((format!("stats/{name}/{word}"), Written::DoubleLists(values.len(), cells)));
        }
        let counts = each().map(|statistics| statistics.count as i64).collect();
        columns.push((format!("stats/{name}/count"), Written::WholeLists(1, counts)));
    }
    columns
}
