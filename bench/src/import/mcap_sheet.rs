//! An MCAP file as a sheet: what the topics last said whenever the gripper's pose is told.
//!
//! Messages are JSON, with the fields of Foxglove's schemas: a pose is a `PoseInFrame`, one of `PosesInFrame`, or a
//! `FrameTransform` alone or among `FrameTransforms`. Other encodings (protobuf, ROS, CDR, FlatBuffers) are refused.
//! The time is the log time. A topic that has not said anything yet is taken to say what it says first; marks and the
//! like are 0 until they are told.

use std::collections::BTreeSet;
use std::path::Path;

use mcap::io::MessageReader;
use mcap::sans_io::LinearReaderOptions;
use serde_json::Value;

use crate::error::BenchError;
use crate::import::mapping::Mapping;
use crate::import::mapping_keys::PoseKeys;
use crate::import::sheet::{Cells, MOST_ROWS, Sheet, Usual};

/// The column of the time, seconds since the first row.
const TIME: &str = "log_time";
const NANOSECONDS: f64 = 1e9;
/// The most bytes of a record. Without it the memory for a damaged length would be asked for.
const LONGEST_RECORD: usize = 256 << 20;
/// The one encoding of messages that is read.
const ENCODING: &str = "json";

/// What is taken of the messages of a topic.
enum Wanted<'a> {
    /// The pose of these keys, as seven columns.
    Pose(&'a PoseKeys, [String; 7]),
    /// A number or a word, with the path to it; whether it is 0 until it is told.
    Scalar { name: &'a str, path: &'a str, is_event: bool },
}

/// What a topic said, and when, in nanoseconds.
struct Said<'a> {
    topic: String,
    wanted: Wanted<'a>,
    poses: Vec<(u64, [f64; 7])>,
    scalars: Vec<(u64, Value)>,
}

fn refuse(path: &Path, problem: impl Into<String>) -> BenchError {
    let problem = situ_tasks::name::shown(&problem.into());
    BenchError::Recording { path: path.to_owned(), place: String::new(), problem }
}

/// The sheet of a file, with the topics that the mapping names.
///
/// # Errors
/// [`BenchError::Recording`] for damage, another encoding, or poses in different frames.
pub(super) fn read(bytes: &[u8], path: &Path, mapping: &Mapping) -> Result<Sheet, BenchError> {
    let topics = topics(bytes, path)?;
    let mut all = wanted(&topics, mapping);
    let mut worlds: BTreeSet<String> = BTreeSet::new();
    let mut messages = 0;
    for message in stream(bytes) {
        let message = message.map_err(|error| refuse(path, error.to_string()))?;
        let topic = &message.channel.topic;
        let mut of_topic = all.iter_mut().filter(|said| said.topic == *topic).peekable();
        if of_topic.peek().is_none() {
            continue;
        }
        messages += 1;
        if messages > MOST_ROWS {
            return Err(refuse(path, format!("more than {MOST_ROWS} messages of the topics that are read")));
        }
        let encoding = &message.channel.message_encoding;
        if encoding != ENCODING {
            let problem =
                format!("topic `{topic}`: messages in `{encoding}`: expected JSON, other encodings are not read");
            return Err(refuse(path, problem));
        }
        let value: Value = serde_json::from_slice(&message.data)
            .map_err(|error| refuse(path, format!("topic `{topic}` at {} ns: {error}", message.log_time)))?;
        for said in of_topic {
            said.hear(message.log_time, &value, &mut worlds);
        }
    }
    if worlds.len() > 1 {
        let names: Vec<String> = worlds.iter().map(|world| format!("`{world}`")).collect();
        let problem = format!("poses in the frames {}: expected all of them in one", names.join(" and "));
        return Err(refuse(path, problem));
    }
    all.iter_mut().for_each(Said::sort);
    sheet(&all, topics, path, mapping)
}

/// The messages of a file in order.
fn stream(bytes: &[u8]) -> MessageReader<&[u8]> {
    let options = LinearReaderOptions::default().with_record_length_limit(LONGEST_RECORD);
    MessageReader::new_with_options(bytes, options)
}

/// The topics of a file in order of their names.
fn topics(bytes: &[u8], path: &Path) -> Result<Vec<String>, BenchError> {
    let mut topics = BTreeSet::new();
    for message in stream(bytes) {
        let message = message.map_err(|error| refuse(path, error.to_string()))?;
        if !topics.contains(&message.channel.topic) {
            topics.insert(message.channel.topic.clone());
        }
    }
    Ok(topics.into_iter().collect())
}

/// What the mapping asks of the topics. A column is a topic with a path behind it; of two topics it is the longer one.
fn wanted<'a>(topics: &[String], mapping: &'a Mapping) -> Vec<Said<'a>> {
    let said = |topic: &str, wanted| Said { topic: topic.to_owned(), wanted, poses: Vec::new(), scalars: Vec::new() };
    let mut all = Vec::new();
    for pose in mapping.poses() {
        if let (Some(topic), Some(columns)) = (&pose.topic, pose.topic_columns()) {
            all.push(said(topic, Wanted::Pose(pose, columns)));
        }
    }
    let events: Vec<&String> = mapping.events().collect();
    for name in mapping.columns() {
        let of = |topic: &&String| name.strip_prefix(topic.as_str()).is_some_and(|rest| rest.starts_with('.'));
        let Some(topic) = topics.iter().filter(of).max_by_key(|topic| topic.len()) else { continue };
        let path = &name[topic.len() + 1..];
        all.push(said(topic, Wanted::Scalar { name, path, is_event: events.contains(&name) }));
    }
    all
}

impl Said<'_> {
    /// Takes what it wants of a message; the frame in which a pose stands joins the `worlds`.
    fn hear(&mut self, time: u64, message: &Value, worlds: &mut BTreeSet<String>) {
        match &self.wanted {
            Wanted::Pose(keys, _) => {
                if let Some((world, pose)) = pose(message, keys) {
                    worlds.extend(world.map(str::to_owned));
                    self.poses.push((time, pose));
                }
            }
            Wanted::Scalar { path, .. } => {
                if let Some(value) = at(message, path) {
                    self.scalars.push((time, value.clone()));
                }
            }
        }
    }

    /// Messages may be written in another order than that of their times.
    fn sort(&mut self) {
        self.poses.sort_by_key(|(time, _)| *time);
        self.scalars.sort_by_key(|(time, _)| *time);
    }

    /// The times of what was said.
    fn times(&self) -> Vec<u64> {
        let scalars = self.scalars.iter().map(|(time, _)| *time);
        self.poses.iter().map(|(time, _)| *time).chain(scalars).collect()
    }

    /// Its columns, one cell for each time.
    fn columns(&self, times: &[u64]) -> Vec<(String, Cells)> {
        match &self.wanted {
            Wanted::Pose(_, names) => {
                let last = latest(&self.poses, times);
                let Some(rows) = last.into_iter().map(|pose| pose.or(self.poses.first())).collect::<Option<Vec<_>>>()
                else {
                    return Vec::new();
                };
                let column = |part: usize| Cells::Numbers(rows.iter().map(|(_, pose)| pose[part]).collect());
                names.iter().enumerate().map(|(part, name)| (name.clone(), column(part))).collect()
            }
            Wanted::Scalar { name, is_event, .. } => {
                let first = if *is_event { None } else { self.scalars.first() };
                let rows = latest(&self.scalars, times).into_iter().map(|said| said.or(first).map(|(_, value)| value));
                let cells = if self.scalars.iter().any(|(_, value)| value.is_string()) {
                    Cells::Words(rows.map(|value| word(value.unwrap_or(&Value::Null))).collect())
                } else {
                    Cells::Numbers(rows.map(|value| value.map_or(0.0, number)).collect())
                };
                vec![((*name).to_owned(), cells)]
            }
        }
    }
}

/// At each time the last of what was said until then, both in order.
fn latest<'a, T>(said: &'a [(u64, T)], times: &[u64]) -> Vec<Option<&'a (u64, T)>> {
    let mut next = 0;
    let mut at = |time: &u64| {
        while said.get(next).is_some_and(|(said, _)| said <= time) {
            next += 1;
        }
        next.checked_sub(1).and_then(|last| said.get(last))
    };
    times.iter().map(&mut at).collect()
}

fn word(value: &Value) -> String {
    match value {
        Value::String(word) => word.clone(),
        Value::Null => String::new(),
        other => other.to_string(),
    }
}

/// A number; what is none is refused where it is used.
fn number(value: &Value) -> f64 {
    match value {
        Value::Bool(flag) => f64::from(*flag),
        other => other.as_f64().unwrap_or(f64::NAN),
    }
}

/// The value at a path such as `joints.3`.
fn at<'a>(message: &'a Value, path: &str) -> Option<&'a Value> {
    path.split('.').try_fold(message, |value, step| match value {
        Value::Array(values) => values.get(step.parse::<usize>().ok()?),
        other => other.get(step),
    })
}

/// The frame and the pose in a message: position, and a quaternion with its real part first.
fn pose<'a>(message: &'a Value, keys: &PoseKeys) -> Option<(Option<&'a str>, [f64; 7])> {
    let framed = |key: &str| message.get(key).and_then(Value::as_str);
    if let Some(transforms) = message.get("transforms").and_then(Value::as_array) {
        let child = |transform: &&Value| {
            let name = transform.get("child_frame_id").and_then(Value::as_str);
            keys.frame.as_deref().is_none_or(|frame| name == Some(frame))
        };
        return transform(transforms.iter().find(child)?);
    }
    if message.get("child_frame_id").is_some() {
        let is_ours = keys.frame.as_deref().is_none_or(|frame| framed("child_frame_id") == Some(frame));
        return if is_ours { transform(message) } else { None };
    }
    let header = message.get("header").and_then(|header| header.get("frame_id")).and_then(Value::as_str);
    let world = framed("frame_id").or(header);
    let pose = match message.get("poses").and_then(Value::as_array) {
        Some(poses) => poses.get(keys.index.unwrap_or(0))?,
        None => message.get("pose").unwrap_or(message),
    };
    Some((world, parts(pose.get("position")?, pose.get("orientation")?)?))
}

fn transform(transform: &Value) -> Option<(Option<&str>, [f64; 7])> {
    let parent = transform.get("parent_frame_id").and_then(Value::as_str);
    Some((parent, parts(transform.get("translation")?, transform.get("rotation")?)?))
}

/// Foxglove names the parts of a quaternion, so that no order is to be said.
fn parts(position: &Value, rotation: &Value) -> Option<[f64; 7]> {
    let of = |value: &Value, part: &str| value.get(part).and_then(Value::as_f64);
    let [x, y, z] = ["x", "y", "z"].map(|part| of(position, part));
    let [qw, qx, qy, qz] = ["w", "x", "y", "z"].map(|part| of(rotation, part));
    Some([x?, y?, z?, qw?, qx?, qy?, qz?])
}

fn sheet(all: &[Said<'_>], topics: Vec<String>, path: &Path, mapping: &Mapping) -> Result<Sheet, BenchError> {
    let hand = &mapping.keys.gripper;
    let is_hand = |said: &&Said<'_>| match &said.wanted {
        Wanted::Pose(_, columns) => hand.topic_columns().is_some_and(|own| own == *columns),
        Wanted::Scalar { name, .. } => hand.position.as_ref().is_some_and(|names| names[0] == *name),
    };
    let times = all.iter().find(is_hand).map(Said::times).unwrap_or_default();
    if times.is_empty() {
        let topics = topics.join(", ");
        let problem =
            format!("no pose of the gripper (key `gripper` of the mapping): the file has the topics {topics}");
        return Err(refuse(path, problem));
    }
    let seconds = times.iter().map(|time| (time - times[0]) as f64 / NANOSECONDS).collect();
    let mut columns = vec![(TIME.to_owned(), Cells::Numbers(seconds))];
    for said in all {
        let more = said.columns(&times).into_iter();
        let new: Vec<_> = more.filter(|(name, _)| columns.iter().all(|(own, _)| own != name)).collect();
        columns.extend(new);
    }
    let rows = (0..times.len() as u64).collect();
    let usual = Usual { time: Some(TIME), ..Usual::default() };
    Ok(Sheet::new(path, columns, "message", rows)?.with_usual(usual).with_others(topics))
}
