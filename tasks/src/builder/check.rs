//! The file that settings are built from, and the checks of its values. Each mistake is reported at its key.

use situ_sim::MAX_OPENING;

use super::names::Names;
use crate::error::TaskError;
use crate::file::TaskFile;
use crate::key::{Document, Key};
use crate::predicate::Predicate;
use crate::vocabulary::Role;

/// Builds the settings of one file.
pub(crate) struct Builder<'a> {
    pub(crate) document: &'a Document<'a>,
    pub(crate) file: &'a TaskFile,
}

impl Builder<'_> {
    pub(super) fn wrong<T>(&self, key: &Key, expected: impl Into<String>) -> Result<T, TaskError> {
        Err(self.document.error(key, expected))
    }

    pub(super) fn predicate(&self, key: &Key, text: &str, names: &Names) -> Result<Predicate, TaskError> {
        let predicate = Predicate::parse(text).map_err(|expected| self.document.error(key, expected))?;
        let mut mistake = None;
        predicate.visit_names(&mut |name, role| mistake = mistake.take().or_else(|| names.mistake(name, role)));
        mistake.map_or(Ok(predicate), |expected| self.wrong(key, expected))
    }

    pub(super) fn check_name(&self, key: &Key, name: &str, role: Role, names: &Names) -> Result<(), TaskError> {
        names.mistake(name, role).map_or(Ok(()), |expected| self.wrong(key, expected))
    }

    pub(super) fn check_word(&self, key: &Key, word: &str) -> Result<(), TaskError> {
        let fine = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        if word.starts_with(|c: char| c.is_ascii_lowercase()) && word.chars().all(fine) {
            return Ok(());
        }
        self.wrong(key, format!("`{word}`: expected a name of small letters, digits and `_` that begins with a letter"))
    }

    pub(super) fn check_positive(&self, key: &Key, value: f64) -> Result<(), TaskError> {
        if value > 0.0 { Ok(()) } else { self.wrong(key, format!("{value}: expected more than 0")) }
    }

    pub(super) fn check_not_negative(&self, key: &Key, value: f64) -> Result<(), TaskError> {
        if value >= 0.0 { Ok(()) } else { self.wrong(key, format!("{value}: expected 0 or more")) }
    }

    pub(super) fn check_opening(&self, key: &Key, width: f64) -> Result<(), TaskError> {
        if (0.0..=MAX_OPENING).contains(&width) {
            return Ok(());
        }
        self.wrong(key, format!("{width}: expected an opening of 0 to {MAX_OPENING} metres"))
    }
}
