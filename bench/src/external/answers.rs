//! The answers of an external method, key for key, and what must hold of them.

use std::sync::Arc;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use situ::demonstration::{Gripper, Pose};
use situ::edit::Edit;
use situ::method::Role;
use situ::segment::RelativeKeyframe;
use situ::trace::Counters;
use situ_tasks::name::shown;

use crate::demonstration_file::content::{FileGripper, FilePose};
use crate::demonstration_file::rules;
use crate::strict_json::keys;

/// What a method says that it is.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Hello {
    pub(super) name: Option<String>,
    pub(super) summary: String,
    pub(super) source: String,
    #[serde(deserialize_with = "role")]
    pub(super) role: Role,
    #[serde(default = "every_edit", deserialize_with = "edits")]
    pub(super) edits: Vec<Edit>,
    pub(super) original: Option<String>,
}

fn every_edit() -> Vec<Edit> {
    Edit::ALL.to_vec()
}

fn role<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Role, D::Error> {
    let word = String::deserialize(deserializer)?;
    match word.as_str() {
        "correct" => Ok(Role::Correct),
        "from_scratch" => Ok(Role::FromScratch),
        "control" => Ok(Role::Control),
        other => Err(serde::de::Error::unknown_variant(other, &["correct", "from_scratch", "control"])),
    }
}

/// Edits by their words, with `_` or `-`. A change that needs none is within the reach of every method.
fn edits<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Vec<Edit>, D::Error> {
    let words = Vec::<String>::deserialize(deserializer)?;
    let known = |word: &String| Edit::ALL.into_iter().find(|edit| edit.name() == word.replace('_', "-"));
    let mut edits = Vec::new();
    for word in &words {
        let names = &["node_addition", "edge_addition", "node_modification", "none"];
        edits.push(known(word).ok_or_else(|| serde::de::Error::unknown_variant(word, names))?);
    }
    edits.extend((!edits.contains(&Edit::None)).then_some(Edit::None));
    Ok(edits)
}

/// The answer to `teach`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Taught {
    /// The number of keyframes of each segment of each demonstration, where the method cuts them in its own way.
    pub(super) segments: Option<Vec<Vec<usize>>>,
}

/// The answer to `correct`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Corrected {
    /// The edits that it says it made; none where it does not say.
    #[serde(default, deserialize_with = "edits")]
    pub(super) edits: Vec<Edit>,
    #[serde(default)]
    counters: Map<String, Value>,
    /// The number of keyframes of each segment, where the method cuts the demonstration in its own way.
    pub(super) segments: Option<Vec<usize>>,
}

impl Corrected {
    /// The counters that it gives; those that it does not give are 0.
    pub(super) fn counters(&self) -> Result<Counters, String> {
        let none = Counters { logistic_steps: 1, ..Counters::default() };
        let mut all = serde_json::to_value(none).expect("whole numbers");
        all["logistic_steps"] = 0.into();
        let known = all.as_object_mut().expect("counters have names");
        for (name, count) in &self.counters {
            match known.get_mut(name) {
                Some(own) => own.clone_from(count),
                None => {
                    let known: Vec<&str> = known.keys().map(String::as_str).collect();
                    return Err(format!("no counter is called `{}`: expected {}", shown(name), known.join(", ")));
                }
            }
        }
        serde_json::from_value(all).map_err(|error| format!("counters: {error}"))
    }
}

/// The answer to `next`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Next {
    pub(super) children: Vec<Child>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Child {
    pub(super) place: String,
    pub(super) probability: f64,
}

/// The answer to `keyframes`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Executed {
    reference: String,
    keyframes: Vec<ExecutedKeyframe>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ExecutedKeyframe {
    position: [f64; 3],
    quaternion_wxyz: [f64; 4],
    gripper: FileGripper,
    #[serde(default)]
    hold: f64,
}

impl Executed {
    /// The reference object, and the keyframes relative to it.
    pub(super) fn relative(self) -> Result<(Arc<str>, Vec<RelativeKeyframe>), String> {
        let mut keyframes = Vec::with_capacity(self.keyframes.len());
        for (index, keyframe) in self.keyframes.into_iter().enumerate() {
            keyframes.push(keyframe.relative().map_err(|problem| format!("keyframes[{index}].{problem}"))?);
        }
        Ok((self.reference.into(), keyframes))
    }
}

impl ExecutedKeyframe {
    fn relative(self) -> Result<RelativeKeyframe, String> {
        let pose = FilePose { position: self.position, quaternion: self.quaternion_wxyz };
        let pose: Pose = rules::pose(&pose, "pose").map_err(|(key, problem)| format!("{key}: {problem}"))?;
        let gripper: Gripper = self.gripper.0;
        rules::check_gripper(gripper, self.hold).map_err(|(key, problem)| format!("{key}: {problem}"))?;
        Ok(RelativeKeyframe { pose, gripper, hold: self.hold })
    }
}

/// The answer to `graph`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Structure {
    pub(super) nodes: Vec<StructureNode>,
    /// Places from which and to which an edge leads; `None` is START.
    pub(super) edges: Vec<(Option<String>, String)>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StructureNode {
    pub(super) place: String,
    /// The segments that the primitive was learned from: the demonstration's name, and the index of the segment.
    pub(super) segments: Vec<(String, u32)>,
    /// The ways of doing it.
    #[serde(default = "one")]
    pub(super) ways: usize,
}

const fn one() -> usize {
    1
}

/// The answer to `save`.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Saved {
    pub(super) model: Value,
}

/// The fields of a line that answers the question of this number.
///
/// # Errors
/// What was expected.
pub(super) fn fields(line: &str, asked: u64) -> Result<Map<String, Value>, String> {
    let fields = match serde_json::from_str(line) {
        Ok(Value::Object(fields)) => fields,
        Ok(_) => return Err("expected a JSON object".to_owned()),
        Err(error) => return Err(format!("expected a line of JSON, which has no NaN ({error})")),
    };
    if fields.get("id").and_then(Value::as_u64) != Some(asked) {
        return Err(format!("expected an answer with \"id\": {asked}"));
    }
    match fields.get("error") {
        None | Some(Value::String(_)) => Ok(fields),
        Some(_) => Err("expected \"error\" to be a text".to_owned()),
    }
}

/// Whether a line is an answer to a question, for whoever writes a method: `question` is its `do`, and its `id` is 1.
/// What the benchmark holds against the model besides, such as the names of places, is not looked at.
///
/// # Errors
/// What was expected.
pub fn check_answer(question: &str, line: &str) -> Result<(), String> {
    let fields = fields(line, 1)?;
    if fields.contains_key("error") {
        return Ok(());
    }
    match question {
        "hello" => read::<Hello>(question, fields).map(drop),
        "teach" | "load" => read::<Taught>(question, fields).map(drop),
        "correct" => read::<Corrected>(question, fields).and_then(|answer| answer.counters()).map(drop),
        "next" => read::<Next>(question, fields).map(drop),
        "keyframes" => read::<Executed>(question, fields).and_then(Executed::relative).map(drop),
        "graph" => read::<Structure>(question, fields).map(drop),
        "save" => read::<Saved>(question, fields).map(drop),
        other => Err(format!("no question is called `{}`", shown(other))),
    }
}

/// Reads an answer.
///
/// # Errors
/// What was expected.
pub(super) fn read<T: DeserializeOwned>(what: &str, mut answer: Map<String, Value>) -> Result<T, String> {
    answer.remove("id");
    keys(what, answer).map_err(|problem| format!("the answer to {problem}"))
}

#[cfg(test)]
mod tests {
    use nalgebra::Quaternion;
    use serde_json::json;

    use super::*;

    fn keys(value: Value) -> Map<String, Value> {
        value.as_object().unwrap().clone()
    }

    #[test]
    fn a_mistake_is_told_with_its_key() {
        let next = |value| read::<Next>("next", keys(value)).err();
        assert_eq!(next(json!({"id": 3, "children": [{"place": "p", "probability": 0.5}]})), None);
        let problem = next(json!({"children": [{"place": "p", "probability": "likely"}]})).unwrap();
        assert!(problem.starts_with("the answer to `next`, key `children[0].probability`: invalid type"), "{problem}");
        assert!(next(json!({"childern": []})).unwrap().contains("unknown field `childern`"));
        let hello = |value| read::<Hello>("hello", keys(value));
        let good = json!({"summary": "s", "source": "t", "role": "correct", "edits": ["node_addition"]});
        assert_eq!(hello(good.clone()).unwrap().edits, [Edit::NodeAddition, Edit::None]);
        for (key, value) in [("role", json!("teach")), ("edits", json!(["node"]))] {
            let mut other = good.clone();
            other[key] = value;
            assert!(hello(other).err().unwrap().contains(&format!("key `{key}")), "{key}");
        }
    }

    #[test]
    fn counters_that_are_given_count_and_the_others_are_none() {
        let read = |value| read::<Corrected>("correct", keys(value)).and_then(|answer| answer.counters());
        assert_eq!(read(json!({})), Ok(Counters::default()));
        let given = json!({"counters": {"hmm_fits": 3, "logistic_steps": 2}});
        assert_eq!(read(given), Ok(Counters { hmm_fits: 3, logistic_steps: 2, ..Counters::default() }));
        assert!(read(json!({"counters": {"fits": 3}})).unwrap_err().contains("expected"));
        assert!(read(json!({"counters": {"hmm_fits": -3}})).is_err());
    }

    #[test]
    fn a_quaternion_of_nearly_length_one_keeps_its_bits() {
        let turned: Quaternion<f64> = Quaternion::new(0.5, 0.5, -0.5, 0.5);
        let keyframe = |quaternion: [f64; 4]| {
            let keyframe = json!({"position": [0.1, 0, 1], "quaternion_wxyz": quaternion, "gripper": {"open": 0.05}});
            let answer = json!({"reference": "bowl", "keyframes": [keyframe]});
            read::<Executed>("keyframes", keys(answer)).and_then(Executed::relative)
        };
        let (_, keyframes) = keyframe([turned.w, turned.i, turned.j, turned.k]).unwrap();
        assert_eq!((*keyframes[0].pose.rotation, keyframes[0].hold), (turned, 0.0));
        let problem = keyframe([0.0, 0.0, 0.0, 0.0]).unwrap_err();
        assert!(problem.contains("keyframes[0]") && problem.contains("length 0"), "{problem}");
    }
}
