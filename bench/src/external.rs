//! Methods that are programs of their own, in any language: one JSON object a line on their standard input is a
//! question, one a line on their standard output is the answer. `bench/docs/methods.md` is the page about it.
//!
//! A program is started as often as there is need, and each process holds one model at a time. What a model was told is
//! kept here, so that another process can be given the same model. What a method answers is checked; whatever it does,
//! its run is recorded, and nothing of it is left running.

mod answers;
mod file;
mod interrupt;
mod known;
mod log;
mod method;
mod model;
mod pool;
mod process;
mod program;
mod told;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use situ::method::{Method, all};

use crate::error::BenchError;
use interrupt::Interrupt;

pub use answers::check_answer;
pub use method::External;
pub use process::end_all;

/// The methods that are known: those of the program, and external ones.
#[derive(Default)]
pub struct Methods {
    external: Vec<External>,
    interrupt: Interrupt,
}

impl Methods {
    /// The methods of the program alone.
    pub fn builtin() -> Self {
        Self::default()
    }

    /// Starts the methods of these files, too.
    ///
    /// # Errors
    /// A file that cannot be read or a mistake in it; a program that does not start, or does not say what it is.
    pub fn with_files(paths: &[PathBuf]) -> Result<Self, BenchError> {
        let mut methods = Self::default();
        for path in paths {
            for described in file::read(path)? {
                if methods.external.iter().any(|other| other.name() == described.name) {
                    let problem = format!("{}`{}` is a method of two files", described.place, described.name);
                    return Err(BenchError::Argument(problem));
                }
                methods.external.push(External::start(described, &methods.interrupt)?);
            }
        }
        let known: Vec<&str> = methods.external.iter().map(External::name).collect();
        for method in &methods.external {
            if !known.contains(&method.original()) {
                return Err(BenchError::Argument(format!(
                    "`{}`: it says that its original model is that of `{}`: expected its own or that of one of {}",
                    method.name(),
                    situ_tasks::name::shown(method.original()),
                    known.join(", ")
                )));
            }
        }
        Ok(methods)
    }

    /// All of them, in the order of the tables.
    pub fn all(&self) -> Vec<Box<dyn Method>> {
        let external = self.external.iter().map(|method| Box::new(method.clone()) as Box<dyn Method>);
        all().into_iter().chain(external).collect()
    }

    /// The method of this name.
    ///
    /// # Errors
    /// [`BenchError::Unknown`], with the names there are.
    pub fn named(&self, name: &str) -> Result<Box<dyn Method>, BenchError> {
        let (mut all, index) = (self.all(), |all: &[Box<dyn Method>]| all.iter().position(|own| own.name() == name));
        match index(&all) {
            Some(index) => Ok(all.swap_remove(index)),
            None if self.external.is_empty() => {
                let known = all.iter().map(|method| method.name());
                let known = known.chain(["or a program of your own, with --methods FILE"]);
                Err(BenchError::unknown("method", name, known))
            }
            // One's own first: they are what was meant most probably.
            None => {
                let builtin = all.iter().map(|method| method.name()).take(all.len() - self.external.len());
                Err(BenchError::unknown("method", name, self.external().chain(builtin)))
            }
        }
    }

    /// The names of the external methods.
    pub fn external(&self) -> impl Iterator<Item = &str> {
        self.external.iter().map(External::name)
    }

    /// The external methods, each with a hash of what is known of its program.
    pub fn hashes(&self) -> impl Iterator<Item = (&str, String)> {
        self.external.iter().map(|method| (method.name(), method.hash()))
    }

    /// From now on what they say on their standard error goes to files in this folder, a file for each.
    pub fn log_into(&self, folder: &Path) {
        self.external.iter().for_each(|method| method.log_into(folder));
    }

    /// Whoever waits for one of them gives up where this flag is set.
    pub fn heed(&self, interrupted: &Arc<AtomicBool>) {
        self.interrupt.heed(interrupted);
    }
}
