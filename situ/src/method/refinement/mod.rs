//! Refinement of single primitives: these methods learn from a correction, but cannot change the structure of a task.
//!
//! | method | a primitive is | a correction | source |
//! |---|---|---|---|
//! | `keyframe_model` | keyframe clusters in order | moves, adds, deletes clusters | Akgun et al. 2012, 2016 |
//! | `cost_weights:all`, `:one_at_a_time` | the minimiser of a weighted cost | moves weights | Bajcsy et al. 2018 |
//! | `cost_weights:coactive` | the same | moves weights | Jain et al. 2013 |
//! | `tactile_gmr` | a Gaussian mixture, regressed | is more data for it | Sauser et al. 2012 |
//!
//! All are *reconstructions*: they apply to one primitive of our scenes what the originals do to one skill. They share
//! one frame. The automaton with its classifiers is the one that every keyframe method starts from, and it never
//! changes. A node gets a refined primitive ([`Refine`]) from the first correction about it; until then it does exactly
//! what the original policy does. A correction is cut into segments. Each segment goes to the node that it may show
//! another way of doing ([`attribution`]), and is ignored if there is none. The tables show what these methods lack,
//! and [`Method::edits`] declares it.

pub mod alignment;
pub mod attribution;
pub mod cost_weights;
pub mod keyframe_model;
pub mod refine;
pub mod tactile_gmr;
mod task;

pub use refine::{Refine, RefinedKeyframe};

use super::{KEYFRAME_AUTOMATON, KeyframeAutomaton, Learned, Method, Original, Role};
use crate::demonstration::Demonstration;
use crate::edit::Edit;
use crate::error::SituError;
use crate::state::Schema;

/// A method that refines primitives by `R`.
#[derive(Clone, Copy, Debug)]
pub struct RefinementMethod<R> {
    name: &'static str,
    summary: &'static str,
    source: &'static str,
    refine: R,
}

/// The methods, in the order of the tables.
pub fn all() -> Vec<Box<dyn Method>> {
    use cost_weights::{CostWeights, Rule};
    const BAJCSY: &str = "Bajcsy, Losey, O'Malley and Dragan 2018 (reconstruction)";
    let weights =
        |name, summary, source, rule| RefinementMethod { name, summary, source, refine: CostWeights { rule } };
    vec![
        Box::new(RefinementMethod {
            name: "keyframe_model",
            summary: "keyframe clusters of single primitives moved, added and deleted; no structure",
            source: "Akgun et al. 2012; Akgun and Thomaz 2016 (reconstruction)",
            refine: keyframe_model::KeyframeModel,
        }),
        Box::new(weights(
            "cost_weights:all",
            "weights of a primitive's cost, a correction moves them all; no structure",
            BAJCSY,
            Rule::All,
        )),
        Box::new(weights(
            "cost_weights:one_at_a_time",
            "weights of a primitive's cost, a correction moves one; no structure",
            BAJCSY,
            Rule::OneAtATime,
        )),
        Box::new(weights(
            "cost_weights:coactive",
            "weights of a primitive's cost by coactive learning; no structure",
            "Jain, Wojcik, Joachims and Saxena 2013 (reconstruction)",
            Rule::Coactive,
        )),
        Box::new(RefinementMethod {
            name: "tactile_gmr",
            summary: "Gaussian mixture regression of pose from phase and contact, refitted with corrections; no structure",
            source: "Sauser, Argall, Metta and Billard 2012 (reconstruction: a gripper command stands for taxels)",
            refine: tactile_gmr::TactileGmr,
        }),
    ]
}

impl<R: Refine> Method for RefinementMethod<R> {
    fn name(&self) -> &str {
        self.name
    }

    fn summary(&self) -> &str {
        self.summary
    }

    fn source(&self) -> &str {
        self.source
    }

    fn role(&self) -> Role {
        Role::Correct
    }

    fn original(&self) -> &str {
        KEYFRAME_AUTOMATON
    }

    fn edits(&self) -> &[Edit] {
        &[Edit::NodeModification, Edit::None]
    }

    fn learn_original(
        &self,
        schema: &Schema,
        demonstrations: &[Demonstration],
        seed: u64,
    ) -> Result<Original, SituError> {
        KeyframeAutomaton::learn(schema, demonstrations, seed).map(Original::Keyframe)
    }

    fn take_over(&self, original: &Original) -> Result<Box<dyn Learned>, SituError> {
        Ok(Box::new(task::RefinedTask::new(self.refine, original.keyframe(self.name)?)))
    }
}
