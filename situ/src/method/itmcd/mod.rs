//! `itmcd`: incremental task modification via corrective demonstrations (Gutierrez, Chu, Thomaz and Niekum, ICRA 2018).
//! This is a *reconstruction*: we do not know the paper's modification of the criterion, nor its numbers.
//!
//! At a correction the automaton becomes a STARHMM ([`starhmm`]). Every edit that it could need ([`candidate`]) is
//! fitted by EM to all data, original and corrective, and AICc chooses ([`selection`]). Then exactly
//! that edit is made to the keyframe task model, by the lines of Algorithm 2 that SITU uses too. So only the choice
//! differs: it starts from the same task model as every keyframe method, and executes it in the same way.
//!
//! These things had to be decided, besides what a step is ([`frames`]):
//! - *Modification.* A phase that is fitted again to old and new data alike loses against a new node if the two differ,
//!   because a Gaussian over both is wide. A modification means that the old way is over. So the old version of the
//!   phase still explains what was shown before, and the new version explains the correction. Both versions share one w
//!   and one v. A modification costs an emission; a new node also costs a w and a v.
//! - *k and n.* All parameters of the model against all scalar observations. With a single original, n is so small that
//!   AICc misses most modifications; then the correction is averaged in.
//! - *The search.* There is one candidate edge per absent pair, so O(|T|²) runs of EM over all data. If the correction
//!   is impossible under a candidate, log L is −∞ by structure alone, and no EM runs; that is exact. Each run starts
//!   once, from the fit before the edit. It stops after `max_iterations` of [`parameters`], or when an iteration gains
//!   next to nothing; that bound is ours.
//! - *The place of a new node.* It is after what ran last, because the correction begins there, even if another node
//!   was interrupted.
//! - *More than one edit.* The search goes by rounds ([`selection`]). The first round goes as far as any single edit
//!   can, even if it fits badly on the way.
//! - *Termination.* The end of a primitive is observed, as for every method here: the reference object changes. So τ
//!   only has a constant.
//! - *Autoregression.* There is none: an emission does not see the step before.
//! - *Refusal.* If every candidate is too large for the data, the model stays as it is. The candidates of the last
//!   correction, with those that were refused, are in the model's JSON under `rounds`.

mod automaton;
pub mod candidate;
pub mod frames;
pub mod parameters;
mod planned;
pub mod selection;
pub mod starhmm;
mod task;

use crate::demonstration::Demonstration;
use crate::edit::Edit;
use crate::error::SituError;
use crate::method::{KEYFRAME_AUTOMATON, KeyframeAutomaton, Learned, Method, Original, Role};
use crate::state::Schema;

use parameters::ItmcdParameters;
pub use task::ItmcdTask;

/// The method.
#[derive(Clone, Copy, Debug, Default)]
pub struct Itmcd {
    /// Its parameters.
    pub parameters: ItmcdParameters,
}

impl Method for Itmcd {
    fn name(&self) -> &str {
        "itmcd"
    }

    fn summary(&self) -> &str {
        "every edit fitted to all data by EM, the best by AICc folded in"
    }

    fn source(&self) -> &str {
        "Gutierrez, Chu, Thomaz and Niekum 2018 (reconstruction)"
    }

    fn role(&self) -> Role {
        Role::Correct
    }

    fn original(&self) -> &str {
        KEYFRAME_AUTOMATON
    }

    fn edits(&self) -> &[Edit] {
        &Edit::ALL
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
        Ok(Box::new(ItmcdTask::new(original.keyframe(self.name())?, self.parameters)?))
    }
}
