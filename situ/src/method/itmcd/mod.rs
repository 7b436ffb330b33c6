//! Incremental task modification via corrective demonstrations (Gutierrez, Chu, Thomaz and Niekum, ICRA 2018): a
//! *reconstruction*, for the modification of the criterion and the numbers of the paper are not known to us.
//!
//! At a correction the automaton is made a STARHMM ([`starhmm`]); every edit that it could need ([`candidate`]) is
//! fitted to all data, original and corrective, by EM; AICc ([`criterion`]) chooses ([`selection`]); and the correction
//! is folded into the keyframe task model by exactly that edit, by the lines of Algorithm 2 that SITU does it by. So
//! what it starts from and what it executes is that of every keyframe method, and what differs is the choice.
//!
//! What had to be decided, beside what a step is ([`frames`]):
//! - *Modification.* A refit of a phase to old and new data alike loses to a new node wherever the two differ, for a
//!   Gaussian over both is wide. What a modification says is that the old way is over: so the old version of the phase
//!   keeps explaining what was shown before, the new one explains the correction, and both end and are entered by one w
//!   and one v. A modification costs an emission; a new node a w and a v besides.
//! - *k and n.* All parameters of the model against all scalar observations. With a single original n is so small that
//!   AICc misses most modifications: the correction is then averaged in.
//! - *The search.* An edge for every absent pair, so O(|T|²) EM runs over all data; but where the correction is
//!   impossible under a candidate, log L is −∞ by structure alone, and no EM is run. That is exact. Each run starts
//!   from the fit before the edit, once, and is stopped after [`parameters`]' `max_iterations` or where an iteration
//!   gains next to nothing: that is a bound of ours.
//! - *The place of a new node.* After what ran last: the correction begins there, whatever was interrupted.
//! - *More than one edit.* By rounds ([`selection`]). The first goes as far as any single edit can, however badly it
//!   fits on the way.
//! - *Termination.* Where a primitive ends is seen, as for every method here: by the change of the reference object. So
//!   τ has a constant only.
//! - *Autoregression.* Off: see [`parameters::Lag`].
//! - *Refusal.* Where every candidate is too large for the data, the model stays as it is. The candidates of the last
//!   correction, the refused ones among them, are in the model's JSON under `rounds`.

mod automaton;
pub mod candidate;
pub mod criterion;
pub mod frames;
pub mod parameters;
pub mod selection;
pub mod starhmm;
mod task;

use crate::demonstration::{Demonstration, Schema};
use crate::edit::Edit;
use crate::error::SituError;
use crate::method::{KEYFRAME_AUTOMATON, Learned, Method, Role};

use parameters::ItmcdParameters;
pub use task::ItmcdTask;

/// The method.
#[derive(Clone, Copy, Debug, Default)]
pub struct Itmcd {
    /// Its parameters.
    pub parameters: ItmcdParameters,
}

impl Method for Itmcd {
    fn name(&self) -> &'static str {
        "itmcd"
    }

    fn summary(&self) -> &'static str {
        "every edit fitted to all data by EM, the best by AICc folded in"
    }

    fn source(&self) -> &'static str {
        "Gutierrez, Chu, Thomaz and Niekum 2018 (reconstruction)"
    }

    fn role(&self) -> Role {
        Role::Correct
    }

    fn original(&self) -> &'static str {
        KEYFRAME_AUTOMATON
    }

    fn edits(&self) -> &'static [Edit] {
        &Edit::ALL
    }

    fn teach(&self, schema: &Schema, demonstrations: &[Demonstration], _: u64) -> Result<Box<dyn Learned>, SituError> {
        Ok(Box::new(ItmcdTask::teach(schema, demonstrations, self.parameters)?))
    }
}
