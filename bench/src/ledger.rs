//! The ledger: JSON Lines, one line for each finished run, written as the runs finish.
//!
//! A crash loses at most the line that was being written. Such a torn last line is dropped with a warning; any other
//! line that is not a record is an error with file and line. The lines stand in the order in which runs finished.
//! [`Canonical`] sorts them, and every table is made of the sorted records.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::ops::Deref;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use situ_tasks::name::shown;

use crate::error::BenchError;
use crate::files;
use crate::record::{CostRecord, Identity, Record, RunRecord, SCHEMA};
use crate::strict_json::StrictJson;

/// What some editors put before a text.
const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();

/// The content of a ledger.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contents {
    /// The records.
    pub records: Vec<Record>,
    /// Warnings for the user: torn lines that were dropped.
    pub warnings: Vec<String>,
}

impl Contents {
    /// The names of the runs that need not be done again.
    pub fn done(&self) -> BTreeSet<Identity> {
        self.records.iter().map(Record::identity).collect()
    }
}

#[derive(Serialize)]
struct Line<'a> {
    schema: u64,
    #[serde(flatten)]
    record: &'a Record,
}

/// The line of a record, its line feed included.
fn render(record: &Record) -> String {
    let line = serde_json::to_string(&Line { schema: SCHEMA, record });
    line.expect("a record's keys are strings") + "\n"
}

/// The record of a line, or the mistake in it.
fn parse(line: &str) -> Result<Record, String> {
    let StrictJson(value) = serde_json::from_str(line).map_err(|error| format!("not JSON of a record: {error}"))?;
    check(&value, "")?;
    let Value::Object(mut fields) = value else { return Err("expected an object".to_owned()) };
    match fields.remove("schema") {
        Some(Value::Number(schema)) if schema.as_u64() == Some(SCHEMA) => {}
        Some(other) => {
            return Err(format!("key `schema`: this program reads version {SCHEMA}, found {other}: make it anew"));
        }
        None => return Err(format!("key `schema` is missing, expected {SCHEMA}")),
    }
    let kind = fields.remove("kind");
    let fields = Value::Object(fields);
    match kind.as_ref().and_then(Value::as_str) {
        Some("run") => typed::<RunRecord>(fields).map(Record::Run),
        Some("cost") => typed::<CostRecord>(fields).map(Record::Cost),
        _ => Err("key `kind`: expected \"run\" or \"cost\"".to_owned()),
    }
}

/// Numbers of a record that are never negative, whatever holds them.
const NOT_NEGATIVE: [&str; 4] = ["seconds", "metres", "update_seconds", "squares"];
/// Counts of a record of which the first is a part of the second.
const PARTS: [(&str, &str); 5] = [
    ("successes", "rollouts"),
    ("once", "rollouts"),
    ("right", "choices"),
    ("explained", "segments"),
    ("both", "model"),
];

/// The greatest number of a record, either way, seeds apart. Sums and squares of such numbers are still finite.
const MOST: f64 = 1e12;

/// Refuses numbers that no run can have: more successes than rollouts, a time below 0. Refuses texts that a table could
/// not show on one line; the reasons of failures are shown by none.
fn check(value: &Value, path: &str) -> Result<(), String> {
    let is = |key: &str| path == key || path.ends_with(&format!(".{key}"));
    match value {
        Value::Number(number) if !is("seed") && number.as_f64().is_some_and(|number| number.abs() > MOST) => {
            Err(format!("key `{path}`: {number}, expected at most {MOST:e} either way"))
        }
        Value::String(text) if !is("why") && text.chars().any(char::is_control) => {
            Err(format!("key `{path}`: a control character, expected plain text"))
        }
        Value::Array(items) => {
            items.iter().enumerate().try_for_each(|(index, item)| check(item, &format!("{path}[{index}]")))
        }
        Value::Object(fields) => {
            let number = |key: &str| fields.get(key).and_then(Value::as_f64);
            let at = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
            if let Some(key) = NOT_NEGATIVE.iter().find(|key| number(key).is_some_and(|number| number < 0.0)) {
                return Err(format!("key `{}`: below 0, expected 0 or more", at(key)));
            }
            for (part, whole) in PARTS {
                if let Some((part_of, all)) = number(part).zip(number(whole))
                    && part_of > all
                {
                    return Err(format!("key `{}`: {part_of} of {all} {whole}, expected no more than all", at(part)));
                }
            }
            if let Some(key) = fields.keys().find(|key| key.chars().any(char::is_control)) {
                return Err(format!("key `{}`: a control character, expected plain text", at(key)));
            }
            fields.iter().try_for_each(|(key, value)| check(value, &at(key)))
        }
        _ => Ok(()),
    }
}

fn typed<T: for<'a> Deserialize<'a>>(fields: Value) -> Result<T, String> {
    serde_path_to_error::deserialize(fields).map_err(|error| format!("key `{}`: {}", error.path(), error.inner()))
}

/// The records of a ledger's text, and how many bytes hold them: fewer than the text has where its end is torn.
fn records(path: &Path, text: &[u8]) -> Result<(Vec<Record>, usize), BenchError> {
    let mut records = Vec::new();
    // A byte-order mark is no part of the first line.
    let mut sound = if text.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 };
    let text = &text[sound..];
    for (index, bytes) in text.split_inclusive(|byte| *byte == b'\n').enumerate() {
        let refuse = |problem: String| BenchError::Malformed {
            path: path.to_owned(),
            line: index + 1,
            problem: shown(&problem),
        };
        // A text ends too early if and only if it is the beginning of a JSON object.
        let ends_early = || serde_json::from_slice::<Value>(bytes).is_err_and(|error| error.is_eof());
        if bytes.last() != Some(&b'\n') && ends_early() {
            break;
        }
        let line = std::str::from_utf8(bytes).map_err(|error| refuse(format!("not UTF-8: {error}")))?;
        records.push(parse(line.trim_end_matches(['\r', '\n'])).map_err(refuse)?);
        sound += bytes.len();
    }
    Ok((records, sound))
}

fn torn_warning(path: &Path, line: usize) -> String {
    format!("{}:{line}: an interrupted write: the line is dropped, its run will be done again", path.display())
}

/// Reads a ledger.
///
/// # Errors
/// [`BenchError::Read`]; [`BenchError::Malformed`] for a line that is not a record, except a torn last one.
pub fn read(path: &Path) -> Result<Contents, BenchError> {
    contents(path, &fs::read(path).map_err(|source| BenchError::Read { path: path.to_owned(), source })?)
}

/// The content of a ledger's text; `path` is for messages.
///
/// # Errors
/// [`BenchError::Malformed`], as [`read`].
pub fn contents(path: &Path, text: &[u8]) -> Result<Contents, BenchError> {
    let (records, sound) = records(path, text)?;
    let warnings = if sound < text.len() { vec![torn_warning(path, records.len() + 1)] } else { Vec::new() };
    Ok(Contents { records, warnings })
}

/// Reads several ledgers as one: the shards of a protocol, say. A run that is in two of them counts once. Also returns
/// the warnings.
///
/// # Errors
/// As [`read`]; [`BenchError::Conflict`] where two records of one run differ in more than their times.
pub fn read_all(paths: &[PathBuf]) -> Result<(Canonical, Vec<String>), BenchError> {
    let mut known: BTreeMap<Identity, (String, Record)> = BTreeMap::new();
    let mut warnings = Vec::new();
    for path in paths {
        let read = read(path)?;
        warnings.extend(read.warnings);
        for (index, record) in read.records.into_iter().enumerate() {
            let place = format!("{}:{}", path.display(), index + 1);
            let identity = record.identity();
            match known.get(&identity) {
                Some((first, other)) if other.without_times() != record.without_times() => {
                    let run = identity.to_string();
                    return Err(BenchError::Conflict { first: first.clone(), second: place, run });
                }
                Some(_) => {}
                None => drop(known.insert(identity, (place, record))),
            }
        }
    }
    Ok((Canonical(known.into_values().map(|(_, record)| record).collect()), warnings))
}

/// The records, each run's first, and a warning for each that is left out.
///
/// # Errors
/// [`BenchError::Conflict`] where two records of one run differ in more than their times.
fn once(path: &Path, records: Vec<Record>) -> Result<(Vec<Record>, Vec<String>), BenchError> {
    let mut first: BTreeMap<Identity, usize> = BTreeMap::new();
    let (mut kept, mut warnings) = (Vec::new(), Vec::new());
    let place = |index: usize| format!("{}:{}", path.display(), index + 1);
    for (index, record) in records.iter().enumerate() {
        let identity = record.identity();
        match first.get(&identity) {
            Some(other) if records[*other].without_times() != record.without_times() => {
                let run = identity.to_string();
                return Err(BenchError::Conflict { first: place(*other), second: place(index), run });
            }
            Some(other) => {
                warnings.push(format!(
                    "{}: {identity} stands in line {}, too: it is left out",
                    place(index),
                    other + 1
                ));
            }
            None => {
                first.insert(identity, index);
                kept.push(record.clone());
            }
        }
    }
    Ok((kept, warnings))
}

/// Records in canonical order: runs by their keys, then costs. Every table is made of these.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Canonical(Vec<Record>);

impl From<Vec<Record>> for Canonical {
    fn from(mut records: Vec<Record>) -> Self {
        records.sort_by_cached_key(Record::identity);
        Self(records)
    }
}

impl Deref for Canonical {
    type Target = [Record];

    fn deref(&self) -> &[Record] {
        &self.0
    }
}

/// A ledger's text: one line for each record, in the order given.
pub fn text(records: &[Record]) -> String {
    records.iter().map(render).collect()
}

/// A ledger that runs are added to.
#[derive(Debug)]
pub struct Ledger {
    path: PathBuf,
    file: File,
}

impl Ledger {
    /// Opens a ledger to add to it, or begins one; its folder must be there. Also returns its content, so that
    /// finished runs need not be done again. A torn last line is cut off the file, and a run that stands there twice is
    /// left there once.
    ///
    /// # Errors
    /// As [`read`]; [`BenchError::Conflict`] where two records of one run differ in more than their times;
    /// [`BenchError::Write`].
    pub fn open(path: &Path) -> Result<(Self, Contents), BenchError> {
        let wrong = |source| BenchError::Write { path: path.to_owned(), source };
        let text = match fs::read(path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => Vec::new(),
            Err(source) => return Err(BenchError::Read { path: path.to_owned(), source }),
        };
        let (records, mut sound) = records(path, &text)?;
        let (records, doubled) = once(path, records)?;
        let mut contents = Contents { records, warnings: Vec::new() };
        if !doubled.is_empty() {
            files::write_all(&[(path.to_owned(), self::text(&contents.records))])?;
            contents.warnings = doubled;
            sound = text.len();
        }
        let file = OpenOptions::new().create(true).append(true).open(path).map_err(wrong)?;
        let mut ledger = Self { path: path.to_owned(), file };
        if sound < text.len() {
            contents.warnings.push(torn_warning(path, contents.records.len() + 1));
            ledger.file.set_len(sound as u64).map_err(wrong)?;
        } else if text.last().is_some_and(|byte| *byte != b'\n') {
            // A whole record without its line feed.
            ledger.file.write_all(b"\n").map_err(wrong)?;
        }
        Ok((ledger, contents))
    }

    /// Adds a record by one write of one whole line, which is handed to the disk before this returns.
    ///
    /// # Errors
    /// [`BenchError::Write`]; [`BenchError::Record`] where the line would not read back as the record (a number that is
    /// not finite): nothing is written then.
    pub fn append(&mut self, record: &Record) -> Result<(), BenchError> {
        let line = render(record);
        let refuse = |problem| BenchError::Record { path: self.path.clone(), problem };
        if parse(line.trim_end()).map_err(refuse)? != *record {
            return Err(refuse(format!("{} does not read back as it was", record.identity())));
        }
        let _writing = files::held();
        let written = self.file.write_all(line.as_bytes()).and_then(|()| self.file.sync_data());
        written.map_err(|source| BenchError::Write { path: self.path.clone(), source })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::sample;

    fn written(text: &[u8]) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("quick.jsonl");
        fs::write(&path, text).unwrap();
        (folder, path)
    }

    #[test]
    fn what_is_appended_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("quick.jsonl");
        for part in sample::records().chunks(5) {
            let (mut ledger, _) = Ledger::open(&path).unwrap();
            part.iter().for_each(|record| ledger.append(record).unwrap());
        }
        let contents = read(&path).unwrap();
        assert_eq!(contents, Contents { records: sample::records(), warnings: Vec::new() });
        assert_eq!(contents.done().len(), sample::records().len());
        assert_eq!(fs::read_to_string(&path).unwrap(), text(&sample::records()));
        assert!(text(&sample::records()).starts_with(r#"{"schema":2,"kind":"run","key":{"protocol":"quick","#));
    }

    #[test]
    fn a_number_that_is_not_finite_is_not_written() {
        let (_folder, path) = written(b"");
        let (mut ledger, _) = Ledger::open(&path).unwrap();
        let Record::Cost(mut cost) = sample::records().pop().unwrap() else { panic!("the last record is a cost") };
        cost.update_seconds = f64::NAN;
        let error = ledger.append(&Record::Cost(cost)).unwrap_err();
        assert!(error.to_string().contains("update_seconds"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"");
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

        /// A write that stops anywhere loses its own line and no other. The ledger goes on from there.
        #[test]
        fn a_torn_last_line_is_dropped_with_a_warning(records in 1_usize..5, share in 0.0..1.0_f64) {
            let whole = text(&sample::records()[..records]);
            let last = whole[..whole.len() - 1].rfind('\n').map_or(0, |at| at + 1);
            let cut = last + 1 + (share * (whole.len() - last - 2) as f64) as usize;
            let (_folder, path) = written(&whole.as_bytes()[..cut]);
            let complete = cut == whole.len() - 1;
            let kept = if complete { records } else { records - 1 };
            let contents = read(&path).unwrap();
            prop_assert_eq!(&contents.records[..], &sample::records()[..kept]);
            prop_assert_eq!(contents.warnings.len(), usize::from(!complete));
            if let Some(warning) = contents.warnings.first() {
                prop_assert!(warning.starts_with(&format!("{}:{records}: ", path.display())), "{}", warning);
            }
            let (mut ledger, _) = Ledger::open(&path).unwrap();
            ledger.append(&sample::records()[9]).unwrap();
            let again = read(&path).unwrap();
            prop_assert!(again.warnings.is_empty());
            prop_assert_eq!(&again.records[..kept], &sample::records()[..kept]);
            prop_assert_eq!(&again.records[kept..], &sample::records()[9..10]);
        }
    }

    #[test]
    fn any_other_bad_line_is_an_error_with_file_and_line() {
        let good = text(&sample::records()[..1]);
        let cases = [
            (good.replace("\"schema\":2", "\"schema\":1"), "version 2, found 1"),
            (good.replace("\"schema\":2,", ""), "`schema` is missing"),
            (good.replace("\"run\"", "\"rum\""), "expected \"run\" or \"cost\""),
            (good.replace("\"seed\":0", "\"seed\":-1"), "key `key.seed`"),
            (good.replace("\"seed\":0", "\"seed\":0,\"seed\":0"), "`seed` stands there twice"),
            (good.replace("\"seconds\":", "\"seconds\":-"), "seconds`: below 0"),
            (good.replace("\"rollouts\":", "\"rollouts\":0,\"x\":"), "expected no more than all"),
            (good.replace("\"keyframes\":12", "\"keyframe\":12"), "key `original"),
            (good.replace("node-addition", "node-removal"), "node-removal"),
            ("{\"schema\":2,\n".to_owned(), "not JSON"),
            ("\n".to_owned(), "not JSON"),
            ("[1]\n".to_owned(), "expected an object"),
            // These are not torn: a whole object that is no record, and a text that is no beginning of a record.
            ("{\"schema\":2}".to_owned(), "key `kind`"),
            ("{\"schema\":2]".to_owned(), "not JSON"),
        ];
        for (bad, problem) in cases {
            let (_folder, path) = written((good.clone() + &bad).as_bytes());
            for error in [read(&path).unwrap_err(), Ledger::open(&path).unwrap_err()] {
                let message = error.to_string();
                assert!(message.starts_with(&format!("{}:2: ", path.display())), "{message}");
                assert!(message.contains(problem) && error.exit_status() == 2, "{problem} in {message}");
            }
        }
    }

    #[test]
    fn ledgers_of_one_run_agree_but_for_their_times() {
        let mut other = sample::records();
        for record in &mut other {
            if let Record::Cost(cost) = record {
                cost.update_seconds *= 3.0;
            }
        }
        let (_a, first) = written(text(&sample::records()).as_bytes());
        let (_b, second) = written(text(&other).as_bytes());
        let (records, warnings) = read_all(&[first.clone(), second]).unwrap();
        assert_eq!((records, warnings), (Canonical::from(sample::records()), Vec::new()));
        if let Record::Cost(cost) = &mut other[14] {
            cost.counters.hmm_fits += 1;
        }
        let (_c, third) = written(text(&other).as_bytes());
        let error = read_all(&[first, third.clone()]).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{}:15 and ", third.display())), "{error}");
    }
}
