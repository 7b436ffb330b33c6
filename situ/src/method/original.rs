//! The model of the original task: learned once, and taken over by every method that starts from it.

use std::sync::Arc;

use super::learned::Learned;
use super::rebuild::rebuild;
use crate::decisions::Decisions;
use crate::demonstration::Demonstration;
use crate::error::SituError;
use crate::keyframe::learner::KeyframeLearner;
use crate::keyframe::parameters::KeyframeParameters;
use crate::segmentation::by_reference_object;
use crate::state::Schema;
use crate::task_model::{History, TaskModel};

/// The name of the model that most methods start from: see [`super::Method::original`].
pub const KEYFRAME_AUTOMATON: &str = "keyframe automaton";

/// A model of the original task. Copies share it.
#[derive(Clone)]
pub enum Original {
    /// The automaton of keyframe policies, which many methods take over.
    Keyframe(KeyframeAutomaton),
    /// The model of a method with a representation of its own.
    Own(Arc<dyn Learned>),
}

impl Original {
    /// The model of a method with a representation of its own.
    pub fn of(learned: impl Learned + 'static) -> Self {
        Self::Own(Arc::new(learned))
    }

    /// The keyframe automaton, for a method that takes it over.
    ///
    /// # Errors
    /// [`SituError::OtherOriginal`].
    pub fn keyframe(&self, method: &str) -> Result<&KeyframeAutomaton, SituError> {
        match self {
            Self::Keyframe(automaton) => Ok(automaton),
            Self::Own(_) => Err(other(method, KEYFRAME_AUTOMATON)),
        }
    }

    /// A copy of a method's own model.
    ///
    /// # Errors
    /// [`SituError::OtherOriginal`].
    pub fn own(&self, method: &str) -> Result<Box<dyn Learned>, SituError> {
        match self {
            Self::Own(learned) => Ok(learned.boxed()),
            Self::Keyframe(_) => Err(other(method, "its own")),
        }
    }
}

fn other(method: &str, expected: &str) -> SituError {
    SituError::OtherOriginal { method: method.to_owned(), expected: expected.to_owned() }
}

/// The automaton that `rebuild` makes of the original demonstrations with the default kernels and the mended decisions,
/// whatever the method that takes it over at the first correction is set to.
#[derive(Clone, Debug)]
pub struct KeyframeAutomaton {
    /// The schema of all states.
    pub schema: Schema,
    /// The task model.
    pub model: Arc<TaskModel<KeyframeLearner>>,
    /// The root of whatever the methods draw that take the model over.
    pub seed: u64,
}

impl KeyframeAutomaton {
    /// Learns the automaton, with the default kernels.
    ///
    /// # Errors
    /// As [`super::Method::learn_original`].
    pub fn learn(schema: &Schema, demonstrations: &[Demonstration], seed: u64) -> Result<Self, SituError> {
        Self::learn_by(KeyframeParameters::default(), schema, demonstrations, seed)
    }

    /// The same with kernels of its own, for an ablation that changes what the originals are.
    ///
    /// # Errors
    /// As [`super::Method::learn_original`].
    pub fn learn_by(
        parameters: KeyframeParameters,
        schema: &Schema,
        demonstrations: &[Demonstration],
        seed: u64,
    ) -> Result<Self, SituError> {
        demonstrations.iter().try_for_each(|demonstration| demonstration.check_features(schema.len()))?;
        let learner = KeyframeLearner::new(schema, parameters);
        let segments = learner.one_representative(demonstrations.iter().map(by_reference_object).collect());
        let histories = demonstrations.iter().zip(segments);
        let histories = histories.map(|(shown, segments)| History::new(shown, segments, None)).collect();
        let (model, _) = rebuild(histories, None, &learner, &Decisions::mended())?;
        Ok(Self { schema: schema.clone(), model: Arc::new(model), seed })
    }

    /// A learner with the default kernels, for this automaton.
    pub fn learner(&self) -> KeyframeLearner {
        KeyframeLearner::new(&self.schema, KeyframeParameters::default())
    }
}
