//! Hidden Markov models that end: the policies and the signatures of SITU (decisions D5, D12 to D14).
//!
//! A model of K states starts by `initial` (K), continues by `transition` (K × K, row-major), and ends after state i
//! with probability `end[i]`. Every row of `transition` and its `end` sum to 1. So a whole *sequence* has a
//! probability, not only a frame. The models that [`Hmm::fit`] makes are left-to-right; the inference here holds for
//! any model.
//!
//! The emission is generic ([`EmissionDensity`]). That of a policy is [`Emission`]: a Gaussian over poses, and a
//! gripper command.

mod density;
mod emission;
mod fit;
mod frames;
mod gripper;
mod inference;
mod model;
mod parameters;
mod residuals;
mod scoring;
mod transition;

pub use density::EmissionDensity;
pub use emission::{Emission, Observation};
pub use fit::HmmFit;
pub use gripper::GripperEmission;
pub use inference::Expectations;
pub use model::Hmm;
pub use parameters::{HmmError, HmmParameters};
pub(super) use scoring::Scoring;
