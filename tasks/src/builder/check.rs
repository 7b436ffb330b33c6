//! The file that settings are built from, and the checks of its values. Each mistake is reported at its key.

use situ_sim::MAX_OPENING;

use super::names::Names;
use crate::error::TaskError;
use crate::expression::Call;
use crate::file::TaskFile;
use crate::key::{Document, KeyPath};
use crate::name;
use crate::predicate::Predicate;
use crate::vocabulary::Role;

/// Builds the settings of one file.
pub(crate) struct Builder<'a> {
    pub(crate) document: &'a Document<'a>,
    pub(crate) file: &'a TaskFile,
}

impl Builder<'_> {
    pub(super) fn wrong<T>(&self, key: &KeyPath, expected: impl Into<String>) -> Result<T, TaskError> {
        Err(self.document.error(key, expected))
    }

    pub(super) fn predicate(&self, key: &KeyPath, text: &str, names: &Names) -> Result<Predicate, TaskError> {
        let call = Call::parse(text).map_err(|expected| self.document.error(key, expected))?;
        self.condition(key, &call, names)
    }

    pub(super) fn check_name(&self, key: &KeyPath, name: &str, role: Role, names: &Names) -> Result<(), TaskError> {
        names.mistake(name, role).map_or(Ok(()), |expected| self.wrong(key, expected))
    }

    pub(super) fn check_word(&self, key: &KeyPath, word: &str) -> Result<(), TaskError> {
        name::mistake(word).map_or(Ok(()), |expected| self.wrong(key, expected))
    }

    pub(super) fn check_positive(&self, key: &KeyPath, value: f64) -> Result<(), TaskError> {
        if value > 0.0 { Ok(()) } else { self.wrong(key, format!("{value}: expected more than 0")) }
    }

    pub(super) fn check_not_negative(&self, key: &KeyPath, value: f64) -> Result<(), TaskError> {
        if value >= 0.0 { Ok(()) } else { self.wrong(key, format!("{value}: expected 0 or more")) }
    }

    pub(super) fn check_opening(&self, key: &KeyPath, width: f64) -> Result<(), TaskError> {
        if (0.0..=MAX_OPENING).contains(&width) {
            return Ok(());
        }
        self.wrong(key, format!("{width}: expected an opening of 0 to {MAX_OPENING} metres"))
    }
}
