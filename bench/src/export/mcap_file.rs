//! Demonstrations as an MCAP file of JSON messages with Foxglove's schemas, one after another.
//!
//! `/gripper` is a `foxglove.PoseInFrame`, `/objects` are `foxglove.FrameTransforms`, and `/demonstration` says in our
//! own words what is being done: the demonstration, the keyframe, the reference object, the command to the gripper.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::MessageHeader;
use mcap::{McapResult, WriteOptions, Writer};
use serde_json::{Value, json};
use situ::demonstration::Pose;

use crate::export::timeline::{ExportedFrame, RATE, Timeline, kind_word, seven};
use crate::export::written_mapping::{Names, quoted};

/// The frame in which all poses stand.
const WORLD: &str = "world";
const GRIPPER: &str = "/gripper";
const OBJECTS: &str = "/objects";
const DEMONSTRATION: &str = "/demonstration";
const SECOND: u64 = 1_000_000_000;
/// Nanoseconds between two demonstrations.
const PAUSE: u64 = SECOND;

/// The names by which the mapping finds the topics again.
pub(super) fn names() -> Names {
    let columns = ["episode", "reference", "narration", "announced", "intervention", "hold"];
    let columns: String = columns.map(|name| format!("{name} = \"{DEMONSTRATION}.{name}\"\n")).concat();
    let tables = format!(
        "[columns]\nmark = \"{DEMONSTRATION}.keyframe\"\n{columns}\n[gripper]\ntopic = \"{GRIPPER}\"\n\n\
         [opening]\ncommand = \"{DEMONSTRATION}.gripper.value\"\ncommand_kind = \"{DEMONSTRATION}.gripper.kind\"\n"
    );
    Names { tables, object: |object| format!("topic = \"{OBJECTS}\"\nframe = {}\n", quoted(object)) }
}

/// The bytes of the file.
///
/// # Errors
/// Those of the writer.
pub(super) fn bytes(timeline: &Timeline<'_>) -> McapResult<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    let options = WriteOptions::new().library("situ-bench");
    let mut writer = Writer::with_options(&mut bytes, options)?;
    let mut channel = |topic: &str, name: &str, schema: Value| -> McapResult<u16> {
        let schema = writer.add_schema(name, "jsonschema", schema.to_string().as_bytes())?;
        writer.add_channel(schema, topic, "json", &BTreeMap::new())
    };
    let channels = [
        channel(OBJECTS, "foxglove.FrameTransforms", transforms_schema())?,
        channel(DEMONSTRATION, "situ_bench.Demonstration", demonstration_schema())?,
        channel(GRIPPER, "foxglove.PoseInFrame", pose_schema())?,
    ];
    let (mut begin, mut sequence) = (0, 0);
    for (episode, exported) in timeline.episodes.iter().enumerate() {
        for (index, frame) in exported.frames.iter().enumerate() {
            let log_time = begin + index as u64 * SECOND / u64::from(RATE);
            let name = exported.file.demonstration.name();
            let messages = [
                transforms(timeline, frame, log_time),
                demonstration(episode, name, frame),
                json!({"timestamp": stamp(log_time), "frame_id": WORLD, "pose": pose(&frame.hand)}),
            ];
            for (channel_id, message) in channels.into_iter().zip(messages) {
                let header = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
                writer.write_to_known_channel(&header, message.to_string().as_bytes())?;
            }
            sequence += 1;
        }
        begin += exported.frames.len() as u64 * SECOND / u64::from(RATE) + PAUSE;
    }
    writer.finish()?;
    drop(writer);
    Ok(bytes.into_inner())
}

fn stamp(time: u64) -> Value {
    json!({"sec": time / SECOND, "nsec": time % SECOND})
}

fn pose(of: &Pose) -> Value {
    let [x, y, z, qw, qx, qy, qz] = seven(of);
    json!({"position": {"x": x, "y": y, "z": z}, "orientation": {"x": qx, "y": qy, "z": qz, "w": qw}})
}

fn transforms(timeline: &Timeline<'_>, frame: &ExportedFrame<'_>, time: u64) -> Value {
    let transform = |(name, of): (&&str, &Pose)| {
        let [x, y, z, qw, qx, qy, qz] = seven(of);
        json!({
            "timestamp": stamp(time),
            "parent_frame_id": WORLD,
            "child_frame_id": name,
            "translation": {"x": x, "y": y, "z": z},
            "rotation": {"x": qx, "y": qy, "z": qz, "w": qw},
        })
    };
    json!({"transforms": timeline.objects.iter().zip(&frame.objects).map(transform).collect::<Vec<_>>()})
}

fn demonstration(episode: usize, name: &str, frame: &ExportedFrame<'_>) -> Value {
    let keyframe = frame.keyframe;
    let is_mark = frame.mark > 0;
    json!({
        "episode": episode,
        "name": name,
        "keyframe": frame.mark,
        "reference": &*keyframe.reference,
        "narration": keyframe.narration.as_deref().unwrap_or_default(),
        "announced": is_mark && keyframe.announced,
        "hold": if is_mark { keyframe.hold } else { 0.0 },
        "intervention": frame.intervention,
        "gripper": {"value": frame.gripper.value(), "kind": kind_word(frame.gripper)},
    })
}

/// The schema of an object with these members.
fn object(members: Value) -> Value {
    json!({"type": "object", "properties": members})
}

fn numbers(names: &[&str]) -> Value {
    object(names.iter().map(|name| ((*name).to_owned(), json!({"type": "number"}))).collect())
}

fn time_schema() -> Value {
    object(json!({"sec": {"type": "integer", "minimum": 0}, "nsec": {"type": "integer", "minimum": 0}}))
}

fn pose_schema() -> Value {
    let pose = object(json!({"position": numbers(&["x", "y", "z"]), "orientation": numbers(&["x", "y", "z", "w"])}));
    let mut schema = object(json!({"timestamp": time_schema(), "frame_id": {"type": "string"}, "pose": pose}));
    schema["title"] = json!("foxglove.PoseInFrame");
    schema
}

fn transforms_schema() -> Value {
    let transform = object(json!({
        "timestamp": time_schema(),
        "parent_frame_id": {"type": "string"},
        "child_frame_id": {"type": "string"},
        "translation": numbers(&["x", "y", "z"]),
        "rotation": numbers(&["x", "y", "z", "w"]),
    }));
    let mut schema = object(json!({"transforms": {"type": "array", "items": transform}}));
    schema["title"] = json!("foxglove.FrameTransforms");
    schema
}

fn demonstration_schema() -> Value {
    let gripper = object(json!({"value": {"type": "number"}, "kind": {"type": "string"}}));
    object(json!({
        "episode": {"type": "integer"},
        "name": {"type": "string"},
        "keyframe": {"type": "integer", "description": "the keyframe that is reached here, from 1; 0 on the way"},
        "reference": {"type": "string"},
        "narration": {"type": "string"},
        "announced": {"type": "boolean"},
        "hold": {"type": "number"},
        "intervention": {"type": "boolean"},
        "gripper": gripper,
    }))
}
