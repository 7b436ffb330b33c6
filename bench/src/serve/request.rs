//! The requests, key for key. `bench/docs/serve.md` is the page about them.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use situ_tasks::Moment;
use situ_tasks::name::shown;

use crate::demonstration_file::content::FileGripper;
use crate::strict_json::{StrictJson, keys};

/// The words of `do`.
const WORDS: &str = "hello, tasks, reset, observe, move, gripper, snapshot, restore, is_solved, demonstrate, correct, \
                     watch, picture, bye";

/// What is asked for.
pub(super) enum Request {
    Hello(Greeting),
    Tasks,
    Reset(Beginning),
    Observe,
    Move(Target),
    Gripper(Command),
    Snapshot,
    Restore(Kept),
    IsSolved,
    Demonstrate(Try),
    Correct(Try),
    Watch(Look),
    Picture(Picture),
    Bye,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Greeting {
    pub(super) protocol: Option<u64>,
}

/// Where an episode begins.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Beginning {
    pub(super) task: String,
    pub(super) variation: Option<String>,
    pub(super) seed: u64,
    pub(super) teacher: Option<String>,
}

/// A keyframe, world frame.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Target {
    pub(super) position: [f64; 3],
    pub(super) quaternion_wxyz: [f64; 4],
    pub(super) gripper: Option<FileGripper>,
    #[serde(default)]
    pub(super) hold: f64,
    pub(super) about: Option<About>,
}

/// The primitive that a keyframe is of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct About {
    /// The reference object of the primitive.
    pub(super) reference: String,
    /// The index of the keyframe in it, from 0.
    pub(super) keyframe: usize,
}

/// A command to the gripper where the hand is.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Command {
    pub(super) gripper: FileGripper,
    #[serde(default)]
    pub(super) hold: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Kept {
    pub(super) snapshot: String,
}

/// A try of the teacher.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Try {
    #[serde(default)]
    pub(super) attempt: u32,
}

/// What a watching teacher looks at.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Look {
    pub(super) reference: String,
    moment: MomentWord,
}

impl Look {
    pub(super) fn moment(&self) -> Moment {
        match self.moment {
            MomentWord::Before => Moment::Before,
            MomentWord::Guard => Moment::Guard,
            MomentWord::After => Moment::After,
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum MomentWord {
    Before,
    Guard,
    After,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Picture {
    #[serde(default = "width")]
    pub(super) width: u32,
    #[serde(default = "height")]
    pub(super) height: u32,
    #[serde(default)]
    pub(super) format: PictureFormat,
    pub(super) path: Option<String>,
}

const fn width() -> u32 {
    480
}

const fn height() -> u32 {
    300
}

#[derive(Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum PictureFormat {
    #[default]
    Png,
    Rgb,
}

/// Reads a line: its `id`, `null` where none can be read, and what is asked for or why it cannot be done.
pub(super) fn read(line: &str) -> (Value, Result<Request, String>) {
    // Some shells begin what they write with a byte-order mark.
    let line = line.strip_prefix('\u{feff}').unwrap_or(line);
    let mut fields = match serde_json::from_str(line) {
        Ok(StrictJson(Value::Object(fields))) => fields,
        Ok(_) => {
            return (Value::Null, Err("expected a JSON object on the line, such as {\"do\": \"hello\"}".to_owned()));
        }
        Err(error) => {
            let problem = format!("expected one JSON object on the line, which has no NaN ({error})");
            return (Value::Null, Err(shown(&problem)));
        }
    };
    match fields.remove("id").unwrap_or_default() {
        Value::Array(_) | Value::Object(_) | Value::Bool(_) => {
            (Value::Null, Err("key `id`: expected a number, a text or no such key".to_owned()))
        }
        id => (id, request(fields).map_err(|problem| shown(&problem))),
    }
}

fn request(mut fields: Map<String, Value>) -> Result<Request, String> {
    let word = match fields.remove("do") {
        Some(Value::String(word)) => word,
        Some(_) => return Err(format!("key `do`: expected a text, one of {WORDS}")),
        None => return Err(format!("no key `do`: expected one of {WORDS}")),
    };
    Ok(match word.as_str() {
        "hello" => Request::Hello(keys(&word, fields)?),
        "tasks" => none(&word, &fields, Request::Tasks)?,
        "reset" => Request::Reset(keys(&word, fields)?),
        "observe" => none(&word, &fields, Request::Observe)?,
        "move" => Request::Move(keys(&word, fields)?),
        "gripper" => Request::Gripper(keys(&word, fields)?),
        "snapshot" => none(&word, &fields, Request::Snapshot)?,
        "restore" => Request::Restore(keys(&word, fields)?),
        "is_solved" => none(&word, &fields, Request::IsSolved)?,
        "demonstrate" => Request::Demonstrate(keys(&word, fields)?),
        "correct" => Request::Correct(keys(&word, fields)?),
        "watch" => Request::Watch(keys(&word, fields)?),
        "picture" => Request::Picture(keys(&word, fields)?),
        "bye" => none(&word, &fields, Request::Bye)?,
        other => return Err(format!("nothing is called `{}` here: `do` is one of {WORDS}", shown(other))),
    })
}

/// A request that has no keys of its own.
fn none(what: &str, fields: &Map<String, Value>, request: Request) -> Result<Request, String> {
    match fields.keys().next() {
        Some(key) => Err(format!("`{what}`: unknown key `{}`, expected none but `do` and `id`", shown(key))),
        None => Ok(request),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(line: &str) -> (Value, String) {
        let (id, request) = read(line);
        (id, request.err().unwrap_or_else(|| panic!("accepted: {line}")))
    }

    #[test]
    fn what_is_no_request_is_told_with_what_would_be() {
        let cases = [
            ("", "expected one JSON object"),
            ("[]", "expected a JSON object"),
            ("nan", "which has no NaN"),
            (r#"{"do": "dance"}"#, "nothing is called `dance`"),
            (r#"{"id": 1}"#, "no key `do`"),
            (r#"{"do": 1}"#, "expected a text"),
            (r#"{"id": [1], "do": "bye"}"#, "expected a number, a text"),
            (r#"{"do": "bye", "do": "bye"}"#, "`do` stands there twice"),
            (r#"{"do": "observe", "how": 1}"#, "unknown key `how`"),
            (r#"{"do": "reset", "task": "pour", "seed": -1}"#, "`reset`, key `seed`"),
            (r#"{"do": "reset", "task": "pour", "seed": 0, "sead": 1}"#, "unknown field `sead`"),
            (r#"{"do": "move", "position": [0, 0, NaN]}"#, "no NaN"),
            (r#"{"do": "move", "position": [0, 0, 1e400], "quaternion_wxyz": [1, 0, 0, 0]}"#, "number out of range"),
            (r#"{"do": "move", "position": [0, 0], "quaternion_wxyz": [1, 0, 0, 0]}"#, "key `position"),
            (r#"{"do": "gripper", "gripper": {"shut": 1}}"#, "unknown field `shut`"),
        ];
        for (line, expected) in cases {
            let (_, said) = problem(line);
            assert!(said.contains(expected), "{line}: {said}");
        }
        assert_eq!(problem(r#"{"id": "a", "do": "dance"}"#).0, "a");
        assert_eq!(problem(r#"{"id": 7, "do": 3}"#).0, 7);
        let (id, request) = read(r#"{"id": 2, "do": "gripper", "gripper": 0.5}"#);
        assert!(id == 2 && matches!(request, Ok(Request::Gripper(Command { hold: 0.0, .. }))));
    }
}
