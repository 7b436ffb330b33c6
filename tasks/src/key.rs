//! Where in a file a value stands: paths of keys, and the lines they are on.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::TaskError;
use crate::file_kind::FileKind;
use crate::name::shown;

/// One step of a path of keys.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Step {
    Field(String),
    Index(usize),
}

/// A path of keys from the root of a file to a value: `skill[2].keyframes[0].close`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct KeyPath(Vec<Step>);

impl KeyPath {
    /// The key `name` below this one.
    pub fn field(&self, name: &str) -> KeyPath {
        self.with(Step::Field(name.to_owned()))
    }

    /// The element `index` of this one.
    pub fn index(&self, index: usize) -> KeyPath {
        self.with(Step::Index(index))
    }

    /// The names on the path, without the indices: `skill.keyframes.close`.
    pub fn names(&self) -> String {
        let names = self.0.iter().filter_map(|step| match step {
            Step::Field(name) => Some(name.as_str()),
            Step::Index(_) => None,
        });
        names.collect::<Vec<_>>().join(".")
    }

    fn with(&self, step: Step) -> KeyPath {
        let mut steps = self.0.clone();
        steps.push(step);
        KeyPath(steps)
    }
}

impl fmt::Display for KeyPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return f.write_str("(the file)");
        }
        for (i, step) in self.0.iter().enumerate() {
            match step {
                Step::Field(name) if i == 0 => f.write_str(name)?,
                Step::Field(name) => write!(f, ".{name}")?,
                Step::Index(index) => write!(f, "[{index}]")?,
            }
        }
        Ok(())
    }
}

/// A parsed file that knows the line of each of its keys.
pub struct Document<'a> {
    file: PathBuf,
    text: &'a str,
    tree: DeTable<'a>,
}

impl<'a> Document<'a> {
    /// Reads the text as TOML.
    ///
    /// # Errors
    /// [`TaskError::File`], with file and line.
    pub fn parse(text: &'a str, file: &Path) -> Result<Document<'a>, TaskError> {
        match DeTable::parse(text) {
            Ok(tree) => Ok(Document { file: file.to_owned(), text, tree: tree.into_inner() }),
            Err(error) => Err(syntax_error(text, file, &error)),
        }
    }

    /// Refuses a file that is of another kind.
    ///
    /// # Errors
    /// [`TaskError::File`] at the key that shows it.
    pub fn check_kind(&self, kind: FileKind) -> Result<(), TaskError> {
        match kind.mistaken(&self.tree) {
            Some((key, problem)) => Err(self.error(&KeyPath::default().field(key), problem)),
            None => Ok(()),
        }
    }

    /// Refuses a number that is infinite or not a number.
    ///
    /// # Errors
    /// [`TaskError::File`] at the first.
    pub fn check_finite(&self) -> Result<(), TaskError> {
        match odd_number_in_table(&self.tree, &KeyPath::default()) {
            Some((key, start, text)) => {
                Err(self.error_at(start, key.to_string(), format!("`{text}`: expected a finite number")))
            }
            None => Ok(()),
        }
    }

    /// The integers of the file, each with its key; one that is beyond 64 bits is `None`.
    pub fn integers(&self) -> Vec<(KeyPath, Option<i64>)> {
        let mut found = Vec::new();
        integers_of_table(&self.tree, &KeyPath::default(), &mut found);
        found
    }

    /// An error at `key`, saying what was expected.
    pub fn error(&self, key: &KeyPath, expected: impl Into<String>) -> TaskError {
        let span = self.span(key);
        self.error_at(span.start, key.to_string(), expected.into())
    }

    /// The error of the deserializer, with the key that holds the place it points at.
    pub fn serde_error(&self, error: &toml::de::Error) -> TaskError {
        let start = error.span().map_or(0, |span| span.start);
        let mut best = KeyPath::default();
        // What the file as a whole lacks is at no key.
        if error.span().is_some_and(|span| !span.is_empty()) {
            deepest_in_table(&self.tree, start, &KeyPath::default(), &mut best);
        }
        self.error_at(start, best.to_string(), error.message().to_owned())
    }

    fn error_at(&self, start: usize, key: String, expected: String) -> TaskError {
        let line = line_of(self.text, start);
        mistake(&self.file, line, &key, &expected)
    }

    /// The span of the value at `key`, or of its nearest ancestor that is in the file.
    fn span(&self, key: &KeyPath) -> Range<usize> {
        let mut span = 0..0;
        let mut table = Some(&self.tree);
        let mut value: Option<&Spanned<DeValue<'_>>> = None;
        for step in &key.0 {
            let next = match step {
                Step::Field(name) => {
                    let table = table.or_else(|| value.and_then(|v| v.get_ref().as_table()));
                    table.and_then(|t| t.iter().find(|(k, _)| k.get_ref() == name.as_str())).map(|(k, v)| (k.span(), v))
                }
                Step::Index(i) => {
                    value.and_then(|v| v.get_ref().as_array()).and_then(|array| array.get(*i)).map(|v| (v.span(), v))
                }
            };
            let Some((found, child)) = next else { break };
            span = found;
            value = Some(child);
            table = None;
        }
        span
    }
}

/// The error of the parser. There is no tree to look the key up in, so it is what stands before the `=` of the line.
fn syntax_error(text: &str, file: &Path, error: &toml::de::Error) -> TaskError {
    let start = error.span().map_or(0, |span| span.start);
    let line = line_of(text, start);
    let words = text.lines().nth(line - 1).unwrap_or_default();
    let key = words.split('=').next().unwrap_or_default().trim().to_owned();
    mistake(file, line, &key, error.message())
}

/// The error of a mistake. Both texts may repeat what the file says.
fn mistake(file: &Path, line: usize, key: &str, expected: &str) -> TaskError {
    TaskError::File { file: file.to_owned(), line, key: shown(key), expected: shown(expected) }
}

/// The number of the line, from 1, that holds the byte `start`.
fn line_of(text: &str, start: usize) -> usize {
    let before = text.as_bytes().get(..start).unwrap_or_default();
    1 + before.iter().filter(|&&byte| byte == b'\n').count()
}

/// The key of the smallest entry around `place`.
fn deepest_in_table(table: &DeTable<'_>, place: usize, path: &KeyPath, best: &mut KeyPath) {
    for (key, value) in table {
        let path = path.field(key.get_ref());
        if key.span().contains(&place) {
            best.clone_from(&path);
        }
        deepest_in_value(value, place, &path, best);
    }
}

fn deepest_in_value(value: &Spanned<DeValue<'_>>, place: usize, path: &KeyPath, best: &mut KeyPath) {
    if value.span().contains(&place) && path.0.len() > best.0.len() {
        best.clone_from(path);
    }
    match value.get_ref() {
        DeValue::Table(table) => deepest_in_table(table, place, path, best),
        DeValue::Array(array) => {
            for (i, element) in array.iter().enumerate() {
                deepest_in_value(element, place, &path.index(i), best);
            }
        }
        _ => {}
    }
}

fn integers_of_table(table: &DeTable<'_>, path: &KeyPath, found: &mut Vec<(KeyPath, Option<i64>)>) {
    table.iter().for_each(|(key, value)| integers_of(value, path.field(key.get_ref()), found));
}

fn integers_of(value: &Spanned<DeValue<'_>>, path: KeyPath, found: &mut Vec<(KeyPath, Option<i64>)>) {
    match value.get_ref() {
        DeValue::Integer(integer) => found.push((path, i64::from_str_radix(integer.as_str(), integer.radix()).ok())),
        DeValue::Table(table) => integers_of_table(table, &path, found),
        DeValue::Array(array) => {
            array.iter().enumerate().for_each(|(i, element)| integers_of(element, path.index(i), found));
        }
        _ => {}
    }
}

/// The first number that is not finite: its key, where it is, how it is written.
fn odd_number_in_table(table: &DeTable<'_>, path: &KeyPath) -> Option<(KeyPath, usize, String)> {
    table.iter().find_map(|(key, value)| odd_number(value, &path.field(key.get_ref())))
}

fn odd_number(value: &Spanned<DeValue<'_>>, path: &KeyPath) -> Option<(KeyPath, usize, String)> {
    match value.get_ref() {
        DeValue::Float(float) => {
            let finite = float.as_str().parse().is_ok_and(f64::is_finite);
            (!finite).then(|| (path.clone(), value.span().start, float.as_str().to_owned()))
        }
        DeValue::Table(table) => odd_number_in_table(table, path),
        DeValue::Array(array) => array.iter().enumerate().find_map(|(i, element)| odd_number(element, &path.index(i))),
        _ => None,
    }
}
