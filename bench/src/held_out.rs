//! How well a model explains a demonstration that it was not given.

use serde::{Deserialize, Serialize};
use situ::demonstration::Demonstration;
use situ::method::Learned;

/// A model's likelihood of a demonstration that was held out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeldOut {
    /// Segments, as the method cuts the demonstration.
    pub segments: u32,
    /// Those that some primitive about their reference object can explain.
    pub explained: u32,
    /// Keyframes of these.
    pub keyframes: u32,
    /// The sum of their log-likelihoods, each under the policy that explains it best, nats.
    pub log_likelihood: f64,
}

impl HeldOut {
    /// The likelihood of a demonstration under a model; `None` where the method's policies are no densities.
    pub fn of(model: &dyn Learned, demonstration: &Demonstration) -> Option<Self> {
        let segments = model.held_out(demonstration);
        let mut held_out = Self { segments: segments.len() as u32, ..Self::default() };
        for (keyframes, log_likelihood) in &segments {
            let Some(log_likelihood) = log_likelihood else { continue };
            held_out.explained += 1;
            held_out.keyframes += *keyframes as u32;
            held_out.log_likelihood += log_likelihood;
        }
        (!segments.is_empty()).then_some(held_out)
    }

    /// Nats per keyframe that was explained; `None` where none was.
    pub fn per_keyframe(&self) -> Option<f64> {
        (self.keyframes > 0).then(|| self.log_likelihood / f64::from(self.keyframes))
    }
}
