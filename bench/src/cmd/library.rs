//! Arguments that several verbs share: tasks, teachers and methods beside those that come with the program, and what
//! carries the hand.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use situ_tasks::{Plant, Registry};
use situ_teachers::Roster;

use crate::cmd::terminal;
use crate::digest;
use crate::error::BenchError;
use crate::external::{self, Methods};

/// What carries the hand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Carrier {
    /// An arm of seven joints, which has a limited reach and can run into things.
    #[default]
    Arm,
    /// Nothing: the hand goes wherever it is told.
    Hand,
}

impl Carrier {
    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Arm => "arm",
            Self::Hand => "hand",
        }
    }
}

impl From<Carrier> for Plant {
    fn from(carrier: Carrier) -> Self {
        match carrier {
            Carrier::Arm => Self::Arm,
            Carrier::Hand => Self::Hand,
        }
    }
}

/// Methods of one's own.
#[derive(Args, Clone, Debug, Default)]
pub struct OwnMethods {
    /// A file of methods that are programs of their own, to know beside the built-in ones; may be given several times.
    #[arg(long, value_name = "FILE")]
    pub methods: Vec<PathBuf>,
}

impl OwnMethods {
    /// All methods that are known. Those of one's own are started.
    ///
    /// # Errors
    /// A file that cannot be read, a mistake in one, or a program that does not say what it is.
    pub fn known(&self) -> Result<Methods, BenchError> {
        Methods::with_files(&self.methods)
    }

    /// The same for a verb that has no interrupt of its own: where the user stops it, no program is left running.
    ///
    /// # Errors
    /// As [`OwnMethods::known`].
    pub fn known_alone(&self) -> Result<Methods, BenchError> {
        if !self.methods.is_empty() {
            terminal::interrupt_flag(BenchError::Stopped, external::end_all);
        }
        self.known()
    }
}

/// Tasks and teachers of one's own, and what carries the hand.
#[derive(Args, Clone, Debug, Default)]
pub struct Library {
    /// A folder of task files (*.toml) to know beside the built-in tasks; may be given several times.
    #[arg(long, value_name = "DIR")]
    pub tasks: Vec<PathBuf>,
    /// A file of teacher profiles to know beside the built-in ones; may be given several times.
    #[arg(long, value_name = "FILE")]
    pub teachers: Vec<PathBuf>,
    /// What carries the hand.
    #[arg(long, value_enum, default_value_t)]
    pub plant: Carrier,
}

impl Library {
    /// All tasks that are known.
    ///
    /// # Errors
    /// A folder or file that cannot be read, a mistake in a file, or a name that is taken.
    pub fn registry(&self) -> Result<Registry, BenchError> {
        let builtin = Registry::builtin()?;
        let registry = self.tasks.iter().try_fold(builtin, |registry, folder| registry.with_dir(folder))?;
        Ok(registry.with_plant(self.plant.into()))
    }

    /// All teachers that are known.
    ///
    /// # Errors
    /// A file that cannot be read, a mistake in one, or a name that is taken.
    pub fn roster(&self) -> Result<Roster, BenchError> {
        let builtin = Roster::builtin()?;
        Ok(self.teachers.iter().try_fold(builtin, |roster, file| roster.with_file(file))?)
    }

    /// The hash of the file that each of these teachers was read from, by name. Names that no teacher has are left out.
    ///
    /// # Errors
    /// A file that cannot be read, or a mistake in one.
    pub fn teacher_hashes<'a>(
        &self,
        names: impl IntoIterator<Item = &'a String>,
    ) -> Result<BTreeMap<String, String>, BenchError> {
        let roster = self.roster()?;
        let hash = |name: &String| Some((name.clone(), digest::hash(roster.text(name)?)));
        Ok(names.into_iter().filter_map(hash).collect())
    }
}
