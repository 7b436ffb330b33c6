//! An external method: known by its answer to `hello`, and asked through its pool of processes.

use std::path::Path;
use std::sync::Arc;

use serde_json::{Value, json};
use situ::demonstration::Demonstration;
use situ::edit::Edit;
use situ::error::SituError;
use situ::method::{Learned, Method, Original, Role};
use situ::segmentation::lengths;
use situ::state::{Feature, Schema};

use super::answers::{Taught, read};
use super::file::Described;
use super::interrupt::Interrupt;
use super::model::ExternalModel;
use super::pool::question;
use super::process::Fault;
use super::program::Program;
use super::told::{Shown, Told};
use crate::demonstration_file::shown_keys;
use crate::error::BenchError;

/// Bits of a seed that a program is given. Every language can hold such a number.
const SEED_BITS: u32 = 53;

/// The method. Copies share their processes.
#[derive(Clone)]
pub struct External(Arc<Program>);

impl External {
    /// Starts a process of a method, and asks what it is.
    ///
    /// # Errors
    /// [`BenchError::Argument`] where it does not say so: with its file and line.
    pub(super) fn start(described: Described, interrupt: &Interrupt) -> Result<Self, BenchError> {
        Program::start(described, interrupt).map(|program| Self(Arc::new(program)))
    }

    /// From now on the standard error of its processes goes to a file of its name in this folder.
    pub(super) fn log_into(&self, folder: &Path) {
        self.0.pool.log.write_into(folder);
    }

    /// A hash of what is known of the program.
    pub(super) fn hash(&self) -> String {
        self.0.pool.described.hash()
    }
}

impl Method for External {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn summary(&self) -> &str {
        &self.0.hello.summary
    }

    fn source(&self) -> &str {
        &self.0.hello.source
    }

    fn role(&self) -> Role {
        self.0.hello.role
    }

    fn original(&self) -> &str {
        &self.0.original
    }

    fn edits(&self) -> &[Edit] {
        &self.0.hello.edits
    }

    fn learn_original(
        &self,
        schema: &Schema,
        demonstrations: &[Demonstration],
        seed: u64,
    ) -> Result<Original, SituError> {
        if demonstrations.is_empty() {
            return Err(SituError::NoDemonstration);
        }
        demonstrations.iter().try_for_each(|demonstration| demonstration.check_features(schema.len()))?;
        let question = question(json!({
            "do": "teach",
            "schema": schema,
            "half_turn": schema.half_turn(),
            "demonstrations": demonstrations.iter().map(|shown| shown_keys(shown, schema)).collect::<Vec<_>>(),
            "seed": seed >> (u64::BITS - SEED_BITS),
        }));
        let told = self.0.pool.made(&question).and_then(|(answer, mark)| {
            let Taught { segments } = read("teach", answer).map_err(Fault::Broken)?;
            let own = segments.unwrap_or_else(|| demonstrations.iter().map(lengths).collect());
            if own.len() != demonstrations.len() {
                let problem = format!("segments of {} demonstrations: expected {}", own.len(), demonstrations.len());
                return Err(Fault::Broken(format!("the answer to `teach`: {problem}")));
            }
            let shown = demonstrations.iter().zip(own).map(|(shown, lengths)| Shown::cut(shown, lengths));
            let told = Told::new(None, question, shown.collect::<Result<_, _>>().map_err(Fault::Broken)?);
            mark.holds(&told);
            Ok(told)
        });
        let told = told.map_err(|fault| self.0.failed(fault))?;
        Ok(Original::of(ExternalModel::new(Arc::clone(&self.0), schema, told, Vec::new())))
    }

    /// A model of its own is shared; one of another program that has the same original is told again.
    fn take_over(&self, original: &Original) -> Result<Box<dyn Learned>, SituError> {
        let learned = original.own(self.name())?;
        if self.original() == self.name() {
            return Ok(learned);
        }
        let told = self.told_again(&learned.to_json()).ok_or_else(|| SituError::OtherOriginal {
            method: self.name().to_owned(),
            expected: format!("`{}`, as an external method has it", self.original()),
        })?;
        Ok(Box::new(told))
    }

    /// A model that was written is told again, question for question.
    fn read(&self, schema: &Schema, model: Value, _: u64) -> Result<Box<dyn Learned>, SituError> {
        let told = self.told_again(&model).filter(|told| told.is_of(schema)).ok_or_else(|| SituError::Model {
            place: "model".to_owned(),
            problem: format!("expected what `{}` was told, over the schema of the file", self.name()),
        })?;
        told.graph()?;
        Ok(Box::new(told))
    }
}

impl External {
    /// A model of what an external method was told; `None` where it is something else.
    fn told_again(&self, json: &Value) -> Option<ExternalModel> {
        let told = Told::from_json(json)?;
        let features: Vec<Feature> = serde_json::from_value(json.get("schema")?.clone()).ok()?;
        let half_turn = serde_json::from_value(json.get("half_turn")?.clone()).ok()?;
        let names = serde_json::from_value(json.get("names")?.clone()).ok()?;
        let schema = Schema::new(features).ok()?.with_half_turn(half_turn);
        Some(ExternalModel::new(Arc::clone(&self.0), &schema, told, names))
    }
}
