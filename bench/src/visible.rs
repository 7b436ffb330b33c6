//! Which variations show their change: whether what is observed tells a changed task from the original one where
//! another decision has to be made.
//!
//! A task model decides each time a primitive has ended. The competent script of the original task and that of the
//! variation are held side by side, from the same seed: as long as both do the same skills, each skill that is done in
//! another way is a decision that differs; the first skill that is another one is the last such decision, because after
//! it the scripts are not at the same place. So a retry is decided after the try that failed, and is held against the
//! original after its success. No model can make such a decision better than the best of what it observes lets it.

use std::collections::BTreeMap;
use std::sync::Arc;

use situ::demonstration::Kind;
use situ::random::stream;
use situ_tasks::{Episode, Setting, Skill};
use situ_teachers::{Roster, Teacher, convert};

use crate::error::BenchError;
use crate::stats::roc::best_feature;

/// Times that the starts are relabelled.
pub const RELABELLINGS: usize = 1000;

/// The least area under the curve at which one feature shows a change.
pub const LEAST_AREA: f64 = 0.95;

/// Values that differ by this share of their feature's scale or less are the same to an observer: 2 mm of a length.
/// What is not fixed settles by some micrometres; no camera sees that, and nobody should learn from it.
pub const RESOLUTION: f64 = 0.01;

/// A decision that the variation's script makes in another way than the original task's.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Differing {
    /// Its place in the scripts, from 0.
    pub index: usize,
    /// The skill that has ended; `start` where none has.
    pub after: String,
    /// What the original script does next; `end` where it is done.
    pub original: String,
    /// What the variation's script does next. The same name is another way to do it.
    pub changed: String,
}

/// The two groups of observed states at a decision: in the original task, and in the variation.
pub type Groups = [Vec<Vec<f64>>; 2];

/// How well one observed feature tells the variation from the original task at a decision.
#[derive(Clone, Debug, PartialEq)]
pub struct Visibility {
    /// The decision.
    pub decision: Differing,
    /// From how many starts both scripts came to it.
    pub starts: usize,
    /// The feature that tells them apart best.
    pub feature: String,
    /// Its area under the curve, 0.5 to 1.
    pub area: f64,
    /// The greatest area of all relabellings.
    pub relabelled: f64,
}

impl Visibility {
    /// Whether the change is shown.
    pub fn is_shown(&self) -> bool {
        self.area >= LEAST_AREA && self.area > self.relabelled
    }
}

/// A competent script as it went: its skills, and what was observed before each of them and at the end.
pub struct Walk {
    skills: Vec<Skill>,
    states: Vec<Vec<f64>>,
}

impl Walk {
    /// The script from the start that the seed decides. `None` where it does not get to the goal.
    ///
    /// # Errors
    /// As [`Episode::start`], and where an observation is not finite.
    pub fn of(setting: &Arc<Setting>, seed: u64) -> Result<Option<Self>, BenchError> {
        // The expert is the script, bit for bit, and writes down what is observed.
        let expert = Teacher::new(Roster::builtin()?.get("expert")?.clone());
        let schema = convert::schema(setting)?;
        let mut episode = Episode::start(setting, seed)?;
        let shown = expert.demonstrate(&setting.label(), Kind::Original, &schema, &mut episode, seed, &mut |_| {})?;
        let Some(demonstration) = shown.demonstration.filter(|_| shown.clean) else { return Ok(None) };
        let skill = |name: &String| setting.skills.iter().find(|skill| skill.name == *name).cloned();
        let begun = demonstration.keyframes().iter().filter(|keyframe| keyframe.announced);
        let states = begun.map(|keyframe| &keyframe.state).chain([demonstration.final_state()]);
        let states = states.map(|state| state.values().to_vec()).collect();
        Ok(Some(Self { skills: shown.skills.iter().filter_map(skill).collect(), states }))
    }

    /// The decisions that `changed` makes in another way than this script, with what was observed at each: here, and
    /// there.
    fn differing<'a>(&'a self, changed: &'a Self) -> Vec<(Differing, [&'a Vec<f64>; 2])> {
        let name = |skill: Option<&Skill>| skill.map_or("end", |skill| &skill.name).to_owned();
        let mut found = Vec::new();
        for index in 0..self.states.len().min(changed.states.len()) {
            let (one, other) = (self.skills.get(index), changed.skills.get(index));
            let is_same =
                |one: &Skill, other: &Skill| one.reference == other.reference && one.keyframes == other.keyframes;
            let names = (name(one), name(other));
            let goes_on = names.0 == names.1;
            if !goes_on || one.zip(other).is_some_and(|(one, other)| !is_same(one, other)) {
                let after = index.checked_sub(1).map_or("start", |before| &self.skills[before].name).to_owned();
                let decision = Differing { index, after, original: names.0, changed: names.1 };
                found.push((decision, [&self.states[index], &changed.states[index]]));
            }
            if !goes_on {
                break;
            }
        }
        found
    }
}

/// The decisions that differ, over pairs of scripts of the original task and of the variation, each from one seed.
pub fn groups(pairs: &[(&Walk, &Walk)]) -> BTreeMap<Differing, Groups> {
    let mut groups: BTreeMap<Differing, Groups> = BTreeMap::new();
    for (decision, states) in pairs.iter().flat_map(|(original, changed)| original.differing(changed)) {
        let group = groups.entry(decision).or_default();
        group.iter_mut().zip(states).for_each(|(group, state)| group.push(state.clone()));
    }
    groups
}

/// How visible a variation's change is, at each decision that at least half of the pairs of scripts come to.
pub fn visibilities(setting: &Setting, pairs: &[(&Walk, &Walk)]) -> Vec<Visibility> {
    let resolutions: Vec<f64> = setting.schema.features.iter().map(|feature| RESOLUTION * feature.scale).collect();
    let usual = groups(pairs).into_iter().filter(|(_, [original, _])| 2 * original.len() >= pairs.len());
    let seen = usual.filter_map(|(decision, [original, changed])| {
        let seed = stream(0, &format!("visible/{}/{}", setting.label(), decision.index));
        let best = best_feature([&original, &changed], &resolutions, RELABELLINGS, seed)?;
        let feature = setting.schema.features[best.feature].name.clone();
        let (area, relabelled) = (best.area, best.relabelled);
        Some(Visibility { decision, starts: original.len(), feature, area, relabelled })
    });
    seen.collect()
}
