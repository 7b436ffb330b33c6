//! Where tasks and teachers come from, beside those that come with the program: arguments that several verbs share.

use std::path::PathBuf;

use clap::Args;
use situ_tasks::Registry;
use situ_teachers::Roster;

use crate::error::BenchError;

/// Tasks and teachers of one's own.
#[derive(Args, Clone, Debug, Default)]
pub struct Library {
    /// A folder of task files (*.toml) to know beside the built-in tasks; may be given several times.
    #[arg(long, value_name = "DIR")]
    pub tasks: Vec<PathBuf>,
    /// A file of teacher profiles to know beside the built-in ones; may be given several times.
    #[arg(long, value_name = "FILE")]
    pub teachers: Vec<PathBuf>,
}

impl Library {
    /// All tasks that are known.
    ///
    /// # Errors
    /// A folder or file that cannot be read, a mistake in a file, or a name that is taken.
    pub fn registry(&self) -> Result<Registry, BenchError> {
        let builtin = Registry::builtin()?;
        Ok(self.tasks.iter().try_fold(builtin, |registry, folder| registry.with_dir(folder))?)
    }

    /// All teachers that are known.
    ///
    /// # Errors
    /// A file that cannot be read, a mistake in one, or a name that is taken.
    pub fn roster(&self) -> Result<Roster, BenchError> {
        let builtin = Roster::builtin()?;
        Ok(self.teachers.iter().try_fold(builtin, |roster, file| roster.with_file(file))?)
    }
}
