//! The program of an external method: what it says that it is, and its processes.

use situ::edit::Edit;
use situ::error::SituError;
use situ_tasks::name::shown;

use super::answers::{Hello, read};
use super::file::Described;
use super::interrupt::Interrupt;
use super::pool::Pool;
use super::process::Fault;
use crate::error::BenchError;

/// A program that has said what it is.
pub(super) struct Program {
    pub(super) hello: Hello,
    /// The method whose original model it takes over.
    pub(super) original: String,
    pub(super) pool: Pool,
}

impl Program {
    /// Starts a process of a method, and asks what it is.
    ///
    /// # Errors
    /// [`BenchError::Argument`] where it does not say so: with its file and line.
    pub(super) fn start(described: Described, interrupt: &Interrupt) -> Result<Self, BenchError> {
        let (place, name) = (described.place.clone(), described.name.clone());
        let refuse = |problem: &str| BenchError::Argument(format!("{place}`{name}`: {problem}"));
        let pool = Pool::new(described, interrupt.clone());
        let answer = pool.hello().map_err(|fault| match fault {
            Fault::Refused(why) => refuse(&format!("it refuses `hello`: {why}")),
            Fault::Broken(problem) => refuse(&problem),
        })?;
        let hello: Hello = read("hello", answer).map_err(|problem| refuse(&problem))?;
        if hello.name.as_ref().is_some_and(|own| *own != name) {
            let own = shown(hello.name.as_deref().unwrap_or_default());
            return Err(refuse(&format!("it says that it is `{own}`: expected the name in the file")));
        }
        if [&hello.summary, &hello.source].iter().any(|text| text.trim().is_empty()) {
            return Err(refuse("the answer to `hello`: expected a summary and a source, a sentence each"));
        }
        let original = hello.original.clone().unwrap_or_else(|| name.clone());
        Ok(Self { hello, original, pool })
    }

    pub(super) fn name(&self) -> &str {
        &self.pool.described.name
    }

    /// Whether it says that it can make an edit.
    pub(super) fn can(&self, edit: Edit) -> bool {
        self.hello.edits.contains(&edit)
    }

    /// The error of a question that has no answer.
    pub(super) fn failed(&self, fault: Fault) -> SituError {
        let (Fault::Refused(problem) | Fault::Broken(problem)) = fault;
        SituError::Outside { method: self.name().to_owned(), problem }
    }
}
