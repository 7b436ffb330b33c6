//! What the harness compares: ways to keep a task model up to date, behind one trait.
//!
//! To add a method, write a type that implements [`Method`] in a file or folder of its own here and name it in [`all`];
//! the conformance test and the tables then know it.

pub mod bp_ar_hmm;
mod direct;
pub mod gaussian;
pub mod itmcd;
pub mod keyframe_method;
mod original;
pub mod rebuild;
pub mod refinement;

pub use original::KEYFRAME_AUTOMATON;

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;

use crate::correction::Correction;
use crate::demonstration::{Demonstration, RelativeKeyframe, Schema, Segment, State};
use crate::edit::Edit;
use crate::error::SituError;
use crate::graph::Graph;
use crate::keyframe::policy::Execution;
use crate::place::{NodeId, Place};
use crate::segmentation::by_reference_object;
use crate::trace::Trace;

/// What a method does with a task that has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Takes over the original model and folds corrections in.
    Correct,
    /// Knows no earlier model; is taught the changed task by full demonstrations.
    FromScratch,
    /// Keeps the original model as it is.
    Control,
}

/// A way to keep a task model up to date.
pub trait Method: Send + Sync {
    /// The name in files, tables and on the command line.
    fn name(&self) -> &'static str;

    /// One sentence: what it does.
    fn summary(&self) -> &'static str;

    /// Where it comes from.
    fn source(&self) -> &'static str;

    /// What it does with a changed task.
    fn role(&self) -> Role;

    /// What the method's model of the original task is called: methods with one word have one model of it, number for number, which is
    /// evaluated once. A representation of its own has a word of its own.
    fn original(&self) -> &'static str {
        self.name()
    }

    /// The edits that the method can make, whatever it is shown. What needs another is out of its reach by construction and no failure of its
    /// learning: in the tables such a cell is *not applicable*.
    fn edits(&self) -> &'static [Edit] {
        &Edit::ALL
    }

    /// A demonstration cut into the segments that the method's [`Graph`] names; all of its keyframes are in one of them.
    fn segments(&self, demonstration: &Demonstration) -> Vec<Segment> {
        by_reference_object(demonstration)
    }

    /// The model of the original task, taught by these demonstrations. `seed` is the root of whatever the method draws
    /// (the Monte Carlo divergences of some); equal seeds give equal models.
    ///
    /// # Errors
    /// [`SituError::NoDemonstration`], or where a demonstration cannot be learned.
    fn teach(
        &self,
        schema: &Schema,
        demonstrations: &[Demonstration],
        seed: u64,
    ) -> Result<Box<dyn Learned>, SituError>;
}

/// A task model that a method keeps up to date, and that can be executed.
pub trait Learned: Send + Sync {
    /// Folds a correction in.
    ///
    /// # Errors
    /// Where what it says to have run cannot have run, or the states are of another schema: the model is then as before. Where the learner refuses a segment: the model is lost then,
    /// so keep [`Learned::boxed`] of it where that matters.
    fn correct(&mut self, correction: Correction<'_>) -> Result<Trace, SituError>;

    /// The place that most probably follows `last` in `state`, and its probability; `None` where nothing follows.
    fn next(&self, last: Place, state: &State) -> Option<(Place, f64)>;

    /// The reference object of a primitive, and the keyframes of one execution relative to it.
    ///
    /// # Errors
    /// [`SituError::UnknownNode`].
    fn keyframes(
        &self,
        node: NodeId,
        execution: Execution,
        rng: &mut ChaCha8Rng,
    ) -> Result<(Arc<str>, Vec<RelativeKeyframe>), SituError>;

    /// The structure.
    fn graph(&self) -> Graph;

    /// Another one like it.
    fn boxed(&self) -> Box<dyn Learned>;

    /// The whole model, every number of it: equal models give equal text.
    fn to_json(&self) -> serde_json::Value;
}

/// Every method, in the order of the tables.
pub fn all() -> Vec<Box<dyn Method>> {
    let keyframe = keyframe_method::all().into_iter().map(|method| Box::new(method) as Box<dyn Method>);
    let retraining: [Box<dyn Method>; 2] = [Box::new(bp_ar_hmm::BpArHmm::default()), Box::new(itmcd::Itmcd::default())];
    keyframe.chain(retraining).chain(refinement::all()).collect()
}

/// The method by whose model of the original task it is decided that the task is taught: one for all, or what a method is given would
/// depend on those that happen to run beside it.
pub fn standard() -> Box<dyn Method> {
    named("no_update").expect("it is listed")
}

/// The method that makes, of all that a keyframe automaton was ever taught, one model at once.
pub fn joint() -> Box<dyn Method> {
    named("rebuild").expect("it is listed")
}

/// The method of this name.
pub fn named(name: &str) -> Option<Box<dyn Method>> {
    all().into_iter().find(|method| method.name() == name)
}
