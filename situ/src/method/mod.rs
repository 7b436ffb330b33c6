//! What the harness compares: ways to keep a task model up to date, behind one trait.
//!
//! To add a method, write a type that implements [`Method`] in a file or folder of its own here and name it in
//! [`roster::all`]; the conformance test and the tables then know it.

pub mod bp_ar_hmm;
mod direct;
pub mod gaussian;
pub mod itmcd;
pub mod keyframe_method;
mod learned;
pub mod nearest;
mod original;
pub mod rebuild;
pub mod refinement;
pub mod replay;
pub mod roster;

pub use learned::{Calibrated, Learned};
pub use original::{KEYFRAME_AUTOMATON, KeyframeAutomaton, Original};
pub use roster::{all, named, pooled, standard};

use crate::demonstration::Demonstration;
use crate::edit::Edit;
use crate::error::SituError;
use crate::state::Schema;

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
    fn name(&self) -> &str;

    /// One sentence: what it does.
    fn summary(&self) -> &str;

    /// Where it comes from.
    fn source(&self) -> &str;

    /// What it does with a changed task.
    fn role(&self) -> Role;

    /// What the method's model of the original task is called. Methods with one word have one model of it, number for
    /// number; it is learned and evaluated once. A representation of its own has a word of its own.
    fn original(&self) -> &str {
        self.name()
    }

    /// The edits that the method can make, whatever it is shown. A task that needs another edit is out of its reach by
    /// construction, which is no failure of its learning: in the tables such a cell is *not applicable*.
    fn edits(&self) -> &[Edit] {
        &Edit::ALL
    }

    /// Learns the original task from these demonstrations. `seed` is the root of whatever the method draws (the Monte
    /// Carlo divergences of some); equal seeds give equal models.
    ///
    /// # Errors
    /// [`SituError::NoDemonstration`], or where a demonstration cannot be learned.
    fn learn_original(
        &self,
        schema: &Schema,
        demonstrations: &[Demonstration],
        seed: u64,
    ) -> Result<Original, SituError>;

    /// Takes over a model of the original task that this method, or another with the same [`Method::original`], has
    /// learned.
    ///
    /// # Errors
    /// [`SituError::OtherOriginal`] where the model is of another kind.
    fn take_over(&self, original: &Original) -> Result<Box<dyn Learned>, SituError> {
        original.own(self.name())
    }

    /// A model of this method, read again from what [`Learned::to_json`] gave: in all it does it is the model that was
    /// written. `seed` is that of the teaching.
    ///
    /// # Errors
    /// [`SituError::Unreadable`] where models of this method cannot be read, as by default; [`SituError::Model`].
    fn read(&self, _schema: &Schema, _model: serde_json::Value, _seed: u64) -> Result<Box<dyn Learned>, SituError> {
        Err(SituError::Unreadable { method: self.name().to_owned() })
    }

    /// Learns the original task and takes the model over.
    ///
    /// # Errors
    /// As [`Method::learn_original`].
    fn teach(
        &self,
        schema: &Schema,
        demonstrations: &[Demonstration],
        seed: u64,
    ) -> Result<Box<dyn Learned>, SituError> {
        self.take_over(&self.learn_original(schema, demonstrations, seed)?)
    }
}
