//! An episode put aside as a text: how it began, and all that was done in it.
//!
//! The same start and the same keyframes give the same bits on every machine. So a text that holds them is the state of
//! the world, whoever restores it, and a stranger's text can do no more than any other request. A hash of the state
//! tells whether the program that restores it, its files and its plant are those that put it aside.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::deed::{Deed, DeedKeys};
use super::seen::observation;
use super::served::{MOST_KEYFRAMES, Served};
use crate::digest::hash;
use crate::strict_json::{StrictJson, keys};

/// The version of the text.
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TokenKeys {
    snapshot: u32,
    task: String,
    variation: Option<String>,
    teacher: String,
    seed: u64,
    keyframes: Vec<DeedKeys>,
    state: String,
}

/// An episode put aside, read and checked by itself.
pub(super) struct Token {
    pub(super) task: String,
    pub(super) variation: Option<String>,
    pub(super) teacher: String,
    pub(super) seed: u64,
    pub(super) deeds: Vec<Deed>,
    state: String,
}

/// The hash of all that is observed, of the beads, and of the arm's angles: where a hand without an arm went the same
/// way, the arm would go on another.
fn state(served: &Served) -> String {
    let world = served.episode.world();
    hash(format!("{}\n{:?}\n{:?}", observation(served), world.beads(), world.configuration()))
}

/// The text of an episode put aside.
pub(super) fn write(served: &Served) -> String {
    let setting = served.setting();
    let content = TokenKeys {
        snapshot: VERSION,
        task: setting.task.clone(),
        variation: setting.variation.clone(),
        teacher: served.teacher.profile().name.clone(),
        seed: served.seed,
        keyframes: served.deeds.iter().map(Deed::keys).collect(),
        state: state(served),
    };
    serde_json::to_string(&content).expect("finite numbers and string keys")
}

impl Token {
    /// # Errors
    /// What is wrong with the text, and what was expected.
    pub(super) fn read(text: &str) -> Result<Self, String> {
        let whole = "expected the text that `snapshot` gave";
        let StrictJson(value) = serde_json::from_str(text).map_err(|error| format!("{whole} ({error})"))?;
        let Value::Object(fields) = value else { return Err(whole.to_owned()) };
        let TokenKeys { snapshot, task, variation, teacher, seed, keyframes, state } = keys("snapshot", fields)?;
        if snapshot != VERSION {
            return Err(format!("a snapshot of version {snapshot}, expected {VERSION}"));
        }
        if keyframes.len() > MOST_KEYFRAMES {
            return Err(format!("{} keyframes, expected at most {MOST_KEYFRAMES}", keyframes.len()));
        }
        let deed = |(index, keys)| Deed::from_keys(keys).map_err(|problem| format!("keyframes[{index}], {problem}"));
        let deeds = keyframes.into_iter().enumerate().map(deed).collect::<Result<_, String>>()?;
        Ok(Self { task, variation, teacher, seed, deeds, state })
    }

    /// # Errors
    /// Where the episode that came of it is another than the one that was put aside.
    pub(super) fn check(&self, served: &Served) -> Result<(), String> {
        if state(served) == self.state {
            return Ok(());
        }
        Err("another state comes of this snapshot here: expected one of the same program, task files and --plant"
            .to_owned())
    }
}
