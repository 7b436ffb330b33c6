//! Files of external methods: what each is called, how it is started, and how long it may take.
//!
//! ```toml
//! [[method]]
//! name = "mine"                       # small letters, digits, `_` and `:`; no method of the program's
//! command = ["python3", "mine.py"]    # started in the folder of this file
//! processes = 2                       # at the most; one for each thread where it is left out
//! files = ["helper.py"]               # of the program, beside those that the command names
//! env = { PYTHONPATH = "lib" }         # of its environment, beside what this program's has
//! start = 60.0                        # seconds until it answers `hello`
//! teach = 600.0                       # seconds for `teach`
//! correct = 600.0                     # seconds for `correct`
//! ask = 60.0                          # seconds for any other question
//! ```

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Deserialize;
use situ::method;
use situ_tasks::key::{Document, KeyPath};
use situ_tasks::{FileKind, name};

use crate::digest::hash;
use crate::error::BenchError;

/// The file, key for key.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MethodsFile {
    method: Vec<Entry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    command: Vec<String>,
    processes: Option<u16>,
    #[serde(default)]
    env: BTreeMap<String, String>,
    #[serde(default)]
    files: Vec<String>,
    #[serde(default = "a_minute")]
    start: f64,
    #[serde(default = "ten_minutes")]
    teach: f64,
    #[serde(default = "ten_minutes")]
    correct: f64,
    #[serde(default = "a_minute")]
    ask: f64,
}

impl Entry {
    /// What is wrong with its words, and their key.
    fn mistake(&self, folder: &Path) -> Option<(&'static str, String)> {
        let is_name = |name: &String| !name.is_empty() && !name.contains(['=', '\0']);
        if let Some((name, _)) = self.env.iter().find(|(name, value)| !is_name(name) || value.contains('\0')) {
            return Some(("env", format!("`{}`: expected names and values of variables", name::shown(name))));
        }
        if self.command.is_empty() {
            return Some(("command", "expected a program and its arguments".to_owned()));
        }
        if self.command.iter().any(|word| word.contains('\0')) {
            return Some(("command", "expected words without a zero character".to_owned()));
        }
        let missing = self.files.iter().find(|name| !folder.join(name).is_file())?;
        Some(("files", format!("`{}`: expected a file, beside this one", name::shown(missing))))
    }
}

const fn a_minute() -> f64 {
    60.0
}

const fn ten_minutes() -> f64 {
    600.0
}

/// The least and the greatest limit of time, seconds.
const LIMITS: std::ops::RangeInclusive<f64> = 0.01..=1e6;
/// The most processes of one method.
const MOST_PROCESSES: u16 = 256;

/// How long the answers to its questions may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limits {
    pub(super) start: Duration,
    pub(super) teach: Duration,
    pub(super) correct: Duration,
    pub(super) ask: Duration,
}

/// An external method, as its file describes it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Described {
    pub(super) name: String,
    /// The program and its arguments.
    pub(super) command: Vec<String>,
    /// Files that the program is made of, beside those that the command names.
    pub(super) files: Vec<String>,
    /// What its environment has beside that of this program.
    pub(super) env: BTreeMap<String, String>,
    /// The folder in which it is started.
    pub(super) folder: PathBuf,
    /// The most processes; `None` for one a thread.
    pub(super) processes: Option<usize>,
    pub(super) limits: Limits,
    /// The file and line at which it stands.
    pub(super) place: String,
}

impl Described {
    /// A hash of what can be known of the program: its command, and the files that the command names.
    pub(super) fn hash(&self) -> String {
        let mut text = String::new();
        for word in self.command.iter().chain(&self.files) {
            let content = fs::read(self.folder.join(word)).map_or_else(|_| String::new(), hash);
            text.push_str(&format!("{word:?} {content}\n"));
        }
        self.env.iter().for_each(|(name, value)| text.push_str(&format!("{name:?} {value:?}\n")));
        hash(text)
    }
}

/// Reads a file of external methods.
///
/// # Errors
/// With file, line, key and what was expected.
pub(super) fn read(path: &Path) -> Result<Vec<Described>, BenchError> {
    let text = fs::read_to_string(path).map_err(|source| BenchError::Read { path: path.to_owned(), source })?;
    parse(&text, path)
}

/// The same from the text of a file.
pub(super) fn parse(text: &str, path: &Path) -> Result<Vec<Described>, BenchError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let document = Document::parse(text, path)?;
    document.check_kind(FileKind::Methods)?;
    document.check_finite()?;
    let file: MethodsFile = toml::from_str(text).map_err(|error| document.serde_error(&error))?;
    let folder = path.parent().unwrap_or_else(|| Path::new(""));
    let taken: BTreeMap<_, _> = method::all().iter().map(|method| (method.name().to_owned(), ())).collect();
    let mut met = BTreeSet::new();
    let mut all = Vec::new();
    for (index, entry) in file.method.into_iter().enumerate() {
        let at = |key: &str| KeyPath::default().field("method").index(index).field(key);
        let refuse = |key: &str, expected: String| Err(BenchError::from(document.error(&at(key), expected)));
        if let Some(problem) = mistake_in_name(&entry.name) {
            return refuse("name", problem);
        }
        if taken.contains_key(&entry.name) {
            return refuse("name", format!("`{}` is a method of the program: expected another name", entry.name));
        }
        let family = entry.name.split(':').next().unwrap_or_default();
        if family != entry.name && taken.contains_key(family) {
            return refuse("name", format!("`{family}` is a method of the program: expected variants of your own"));
        }
        if !met.insert(entry.name.clone()) {
            return refuse("name", format!("`{}` stands there twice: expected once", entry.name));
        }
        if let Some((key, problem)) = entry.mistake(folder) {
            return refuse(key, problem);
        }
        if entry.processes.is_some_and(|count| !(1..=MOST_PROCESSES).contains(&count)) {
            return refuse("processes", format!("expected 1 to {MOST_PROCESSES}"));
        }
        let limits = [("start", entry.start), ("teach", entry.teach), ("correct", entry.correct), ("ask", entry.ask)];
        if let Some((key, seconds)) = limits.into_iter().find(|(_, seconds)| !LIMITS.contains(seconds)) {
            return refuse(key, format!("{seconds}: expected {} to {} seconds", LIMITS.start(), LIMITS.end()));
        }
        let [start, teach, correct, ask] = limits.map(|(_, seconds)| Duration::from_secs_f64(seconds));
        all.push(Described {
            command: entry.command,
            env: entry.env,
            files: entry.files,
            folder: folder.to_owned(),
            processes: entry.processes.map(usize::from),
            limits: Limits { start, teach, correct, ask },
            place: document.error(&at("command"), "").to_string(),
            name: entry.name,
        });
    }
    Ok(all)
}

/// What is wrong with a method's name: as those of tasks, and a colon before the name of a variant.
fn mistake_in_name(whole: &str) -> Option<String> {
    let mut parts = whole.splitn(2, ':');
    parts.find_map(name::mistake)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        parse(text, Path::new("mine.toml")).unwrap_err().to_string()
    }

    #[test]
    fn what_is_left_out_has_its_usual_value() {
        let text = "[[method]]\nname = \"mine:fast\"\ncommand = [\"python3\", \"mine.py\"]\n";
        let [mine] = &parse(text, Path::new("a/mine.toml")).unwrap()[..] else { panic!("one method") };
        assert_eq!((mine.name.as_str(), &*mine.folder, mine.processes), ("mine:fast", Path::new("a"), None));
        assert_eq!(mine.limits.teach, Duration::from_secs(600));
        let other = parse(&text.replace("mine.py", "yours.py"), Path::new("a/mine.toml")).unwrap();
        assert_ne!(other[0].hash(), mine.hash());
    }

    #[test]
    fn a_mistake_is_told_with_its_line_and_key() {
        let good = "[[method]]\nname = \"mine\"\ncommand = [\"true\"]\n";
        let cases = [
            (good.replace("mine", "situ"), "mine.toml:2: `method[0].name`: `situ` is a method of the program"),
            (good.replace("mine", "situ:mine"), "mine.toml:2: `method[0].name`: `situ` is a method of the program"),
            (good.replace("mine", "../x"), "mine.toml:2: `method[0].name`"),
            (good.to_owned() + good, "mine.toml:5: `method[1].name`: `mine` stands there twice"),
            (good.replace("[\"true\"]", "[]"), "mine.toml:3: `method[0].command`: expected a program"),
            (good.to_owned() + "ask = 0\n", "mine.toml:4: `method[0].ask`: 0: expected 0.01 to 1000000 seconds"),
            (good.to_owned() + "ask = nan\n", "mine.toml:4: `method[0].ask`"),
            (good.to_owned() + "processes = 0\n", "mine.toml:4: `method[0].processes`: expected 1 to 256"),
            (good.to_owned() + "processes = 70000\n", "mine.toml:4: "),
            (
                good.to_owned() + "files = [\"nowhere.py\"]\n",
                "mine.toml:4: `method[0].files`: `nowhere.py`: expected a file",
            ),
            (good.to_owned() + "colour = 3\n", "mine.toml:4: "),
            ("goal = 3\n".to_owned(), "this is a task"),
        ];
        for (text, expected) in cases {
            let message = refused(&text);
            assert!(message.contains(expected), "{message}\nexpected {expected}");
        }
    }
}
