//! Trials of a setting: whether what its file claims is true from the start that one seed decides.

use std::sync::Arc;

use situ_sim::World;

use crate::edit::NeededEdit;
use crate::episode::Episode;
use crate::error::TaskError;
use crate::script::{self, Ending, ScriptRecord};
use crate::setting::Setting;

/// What was tried from one start.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Whether the goal held before anything was done.
    pub solved_at_start: bool,
    /// The first feature of the observed state that was not a finite number, at the start or after a script.
    pub odd_feature: Option<String>,
    /// The competent script.
    pub competent: Attempt,
    /// The original script, which knows nothing of the variation.
    pub original: Attempt,
    /// The original script until a watching teacher or the arm's planner stops it, and then the competent one. None
    /// where no edit is needed.
    pub corrected: Option<Attempt>,
}

/// What a script did, and what it took.
#[derive(Debug, Clone, PartialEq)]
pub struct Attempt {
    /// What it did.
    pub record: ScriptRecord,
    /// Simulated seconds.
    pub seconds: f64,
    /// Path of the hand, metres.
    pub metres: f64,
}

impl Attempt {
    /// Whether the goal was achieved.
    pub fn succeeded(&self) -> bool {
        self.record.ending == Ending::Succeeded
    }
}

/// A program of skills, run to its end.
type Script = fn(&mut Episode, &mut dyn FnMut(&World)) -> ScriptRecord;

/// Tries the scripts from the start that the seed decides.
///
/// # Errors
/// As [`Episode::start`]: the objects find no place, the premise does not hold after settling, or the physics refuses
/// the scene.
pub fn trial(setting: &Arc<Setting>, seed: u64) -> Result<Trial, TaskError> {
    let start = Episode::start(setting, seed)?;
    let mut odd_feature = odd(&start);
    let mut attempt = |script: Script| {
        let mut episode = start.clone();
        let record = script(&mut episode, &mut |_| {});
        odd_feature = odd_feature.take().or_else(|| odd(&episode));
        Attempt { record, seconds: episode.seconds(), metres: episode.path() }
    };
    let competent = attempt(script::competent);
    let original = attempt(script::original);
    let corrected = (setting.edit != NeededEdit::None).then(|| attempt(corrected));
    Ok(Trial { solved_at_start: start.succeeded(), odd_feature, competent, original, corrected })
}

/// The original script until a watching teacher or the arm's planner stops it, then the competent one from there. If
/// nothing stops the original, nothing is corrected.
fn corrected(episode: &mut Episode, observer: &mut dyn FnMut(&World)) -> ScriptRecord {
    let first = script::watched(episode, observer);
    if !matches!(first.ending, Ending::Stopped | Ending::OutOfReach | Ending::NoPlan) {
        return first;
    }
    let mut second = script::competent(episode, observer);
    second.keyframes += first.keyframes;
    second.guarded += first.guarded;
    second.aborted += first.aborted;
    second
}

/// The first feature whose value is not a finite number.
fn odd(episode: &Episode) -> Option<String> {
    let features = episode.setting().schema.features.iter();
    features.zip(episode.observe()).find(|(_, value)| !value.is_finite()).map(|(feature, _)| feature.name.clone())
}
