//! What a robot asks a task model while it executes it: one JSON object is a question, one is the answer, in the words
//! of an external method (`bench/docs/methods.md`).
//!
//! - `{"do": "next", "last": "z3", "state": […]}`: the places that may follow what ran last to its end, `null` before
//!   anything has run; the likeliest first. `end` is the end of the task.
//! - `{"do": "keyframes", "place": "z4", "state": […]}`: how to do it in this state: the reference object, and
//!   keyframes relative to it. `"execution": "sample"` draws them from the scatter of the data by `"seed"`; by default
//!   they are the means. `"attempt"` is the number of times that this place has failed here, 0 if it is left out: each
//!   asks for the next way.
//! - `{"do": "graph"}`: the places with the segments that they hold, and the edges.
//!
//! Where the model was learned from poses, `world` may stand in the place of `state`, as in a demonstration file of
//! version 2. The keyframes then come with poses in the world frame, too. `id` is given back.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;
use serde_json::{Map, Value, json};
use situ::demonstration::Pose;
use situ::keyframe::policy::Execution;
use situ::place::{NodeId, Place, SegmentId};
use situ::segment::RelativeKeyframe;
use situ::state::State;
use situ_tasks::name::shown;

use crate::demonstration_file::content::{FileGripper, FileWorld};
use crate::demonstration_file::perceived::poses_of;
use crate::kept_model::KeptModel;
use crate::strict_json::{StrictJson, keys};

/// The place that is the end of a task, as external methods call it.
const END: &str = "end";

#[derive(Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
enum Question {
    Next {
        #[serde(deserialize_with = "Option::deserialize")]
        last: Option<String>,
        state: Option<Vec<f64>>,
        world: Option<FileWorld>,
    },
    Keyframes {
        place: String,
        state: Option<Vec<f64>>,
        world: Option<FileWorld>,
        #[serde(default = "mean")]
        execution: Execution,
        #[serde(default)]
        attempt: usize,
        #[serde(default)]
        seed: u64,
    },
    Graph {},
}

fn mean() -> Execution {
    Execution::Mean
}

/// The answer to a question, as text on one line; where it cannot be answered, `error` says why.
pub fn answer(model: &KeptModel, text: &str) -> String {
    let (id, result) = match serde_json::from_str(text) {
        Ok(StrictJson(Value::Object(mut question))) => {
            let id = question.remove("id");
            (id, keys("ask", question).and_then(|question| answered(model, question)))
        }
        Ok(_) => (None, Err("expected an object such as {\"do\": \"graph\"}".to_owned())),
        Err(error) => (None, Err(format!("this is no JSON: {error}"))),
    };
    let mut answer = result.unwrap_or_else(|problem| Map::from_iter([("error".to_owned(), json!(shown(&problem)))]));
    if let Some(id) = id {
        answer.insert("id".to_owned(), id);
    }
    Value::Object(answer).to_string()
}

/// The answer where a line is none that can be read.
pub fn refused(problem: &str) -> String {
    json!({"error": shown(problem)}).to_string()
}

fn answered(model: &KeptModel, question: Question) -> Result<Map<String, Value>, String> {
    let value = match question {
        Question::Next { last, state, world } => {
            let last = last.map_or(Ok(Place::Start), |name| place(model, &name).map(Place::Node))?;
            let state = state_of(model, state, world.as_ref())?;
            let ranked = model.learned.ranked(last, &state).map_err(|error| error.to_string())?;
            let child =
                |(place, probability): &(Place, f64)| json!({"place": name(*place), "probability": probability});
            json!({"children": ranked.iter().map(child).collect::<Vec<_>>()})
        }
        Question::Keyframes { place: name, state, world, execution, attempt, seed } => {
            let (node, state) = (place(model, &name)?, state_of(model, state, world.as_ref())?);
            let ways = model.learned.ways(node, &state).map_err(|error| error.to_string())?;
            let way = ways[attempt.min(ways.len().saturating_sub(1))];
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let (reference, keyframes) =
                model.learned.keyframes(node, way, &state, execution, &mut rng).map_err(|error| error.to_string())?;
            let frame = match &world {
                None => None,
                Some(world) => match poses_of(world, "world").map_err(|(key, problem)| format!("{key}: {problem}"))? {
                    poses if poses.objects.contains_key(&*reference) => poses.objects.get(&*reference).copied(),
                    _ => return Err(format!("`{reference}`, which the place is about, is not in `world`")),
                },
            };
            let each = |keyframe: &RelativeKeyframe| written(keyframe, frame.as_ref());
            json!({"reference": reference, "keyframes": keyframes.iter().map(each).collect::<Vec<_>>()})
        }
        Question::Graph {} => graph(model),
    };
    match value {
        Value::Object(fields) => Ok(fields),
        _ => Err("expected an answer of fields".to_owned()),
    }
}

/// The name of a place that may follow.
fn name(place: Place) -> String {
    if place == Place::End { END.to_owned() } else { place.to_string() }
}

/// The node of a name such as `z3`.
fn place(model: &KeptModel, name: &str) -> Result<NodeId, String> {
    let nodes = &model.graph.nodes;
    nodes.iter().find(|node| node.id.to_string() == name).map(|node| node.id).ok_or_else(|| {
        let known: Vec<String> = nodes.iter().map(|node| node.id.to_string()).collect();
        format!("no place is called `{name}`, expected one of {}", known.join(", "))
    })
}

fn state_of(model: &KeptModel, state: Option<Vec<f64>>, world: Option<&FileWorld>) -> Result<State, String> {
    let values = match (state, world, &model.features) {
        (Some(values), None, _) => values,
        (None, Some(world), Some(features)) => {
            let poses = poses_of(world, "world").map_err(|(key, problem)| format!("{key}: {problem}"))?;
            if features.has_opening() && poses.opening.is_none() {
                return Err("world.opening: missing, expected metres between the fingers".to_owned());
            }
            let is_there = |name: &&str| poses.objects.contains_key(*name) || features.asks_whether_seen(name);
            if let Some(absent) = features.objects().into_iter().find(|name| !is_there(name)) {
                return Err(format!("world.objects: `{absent}` is not there, expected its pose"));
            }
            features.state(&poses)
        }
        (None, Some(_), None) => {
            return Err("world: this model was learned from states, expected `state`".to_owned());
        }
        _ => return Err("expected either `state` or `world`".to_owned()),
    };
    if values.len() != model.schema.len() {
        return Err(format!("state: {} numbers, expected {}", values.len(), model.schema.len()));
    }
    Ok(State::new(values))
}

/// A keyframe relative to its reference object, and in the world where that object's pose is known.
fn written(keyframe: &RelativeKeyframe, frame: Option<&Pose>) -> Value {
    let pose = |pose: &Pose| {
        let rotation = pose.rotation.quaternion();
        (json!(pose.translation.vector.as_slice()), json!([rotation.w, rotation.i, rotation.j, rotation.k]))
    };
    let (position, quaternion) = pose(&keyframe.pose);
    let mut value = json!({
        "position": position,
        "quaternion_wxyz": quaternion,
        "gripper": FileGripper(keyframe.gripper),
        "hold": keyframe.hold,
    });
    if let Some(frame) = frame {
        let (position, quaternion) = pose(&(frame * keyframe.pose));
        value["in_world"] = json!({"position": position, "quaternion_wxyz": quaternion});
    }
    value
}

fn graph(model: &KeptModel) -> Value {
    let segment = |id: &SegmentId| {
        let seen = model.seen.get(id.demonstration as usize);
        json!([seen.map(|seen| seen.name.as_str()), id.index])
    };
    let nodes = model.graph.nodes.iter().map(|node| {
        let segments: Vec<Value> = node.segments.iter().map(segment).collect();
        json!({"place": node.id.to_string(), "reference": node.reference, "ways": node.paths.len(), "segments": segments})
    });
    let from = |place: &Place| if *place == Place::Start { Value::Null } else { json!(name(*place)) };
    let edges = model.graph.edges.iter().map(|(before, after)| json!([from(before), name(*after)]));
    json!({"nodes": nodes.collect::<Vec<_>>(), "edges": edges.collect::<Vec<_>>()})
}
