//! What must hold of any bytes that a stranger takes for a file of ours, or writes into one of our programs line by
//! line. The tests and the fuzzers (`bench/fuzz`) ask the same. A file is refused with its name, a line that it has,
//! and one line of plain text; or it is accepted, and then it can be used. Each check says whether it was accepted.

use std::path::Path;
use std::sync::OnceLock;

use serde_json::json;
use situ::demonstration::Kind;
use situ::method::{Method, named};
use situ_bench::asked::answer;
use situ_bench::cmd::learn::learn;
use situ_bench::demonstration_file::{DemonstrationFile, render};
use situ_bench::error::BenchError;
use situ_bench::external::{Methods, check_answer};
use situ_bench::import::{Imported, Mapping, import, import_bytes};
use situ_bench::kept_model::KeptModel;
use situ_bench::ledger::{self, Canonical};
use situ_bench::plan::{Filter, Plan};
use situ_bench::protocol::Protocol;
use situ_bench::record::Record;
use situ_bench::serve::Service;
use situ_bench::tables::{self, Heading};
use situ_tasks::{Plant, Predicate, Registry, Task, name};
use situ_teachers::{Profile, Roster, Way};

/// What the file is called. No text of a file holds this name by itself.
const FILE: &str = "a stranger's file";
/// The longest message that is still one to read.
const LONGEST_MESSAGE: usize = 3000;
/// A plan of so many records at most is made to name each of them.
const FEW_RECORDS: usize = 5000;
/// A demonstration of no more keyframes, features and choices is learned.
const FEW_KEYFRAMES: usize = 12;
const FEW_FEATURES: usize = 20;
const FEW_CHOICES: usize = 8;
/// So many primitives of a model are executed.
const FEW_NODES: usize = 4;
/// Tables are made of so many records at most.
const FEW_LINES: usize = 8;

/// A message is one line of plain text.
fn plain(message: &str) {
    assert!(!message.chars().any(char::is_control), "control characters: {message:?}");
    assert!(message.chars().count() <= LONGEST_MESSAGE, "{} letters: {message:.200}…", message.chars().count());
}

/// A refusal begins with the file and a line that it has.
fn refused(message: &str, bytes: &[u8]) -> bool {
    plain(message);
    let rest = message.strip_prefix(FILE).and_then(|rest| rest.strip_prefix(':'));
    let line = rest.and_then(|rest| rest.split_once(':')).and_then(|(line, _)| line.parse::<usize>().ok());
    let lines = 1 + bytes.iter().filter(|byte| **byte == b'\n').count();
    assert!(line.is_some_and(|line| (1..=lines).contains(&line)), "{lines} lines: {message}");
    false
}

/// A task file.
pub fn task(bytes: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(bytes) else { return false };
    let task = match Task::parse(text, Path::new(FILE)) {
        Ok(task) => task,
        Err(error) => return refused(&error.to_string(), bytes),
    };
    assert_eq!(name::mistake(task.name()), None);
    assert_eq!(task.settings().count(), 1 + task.variations().count());
    for setting in task.settings() {
        assert_eq!(&task.variation(setting.variation.as_deref()).expect("its own"), setting);
        for condition in [&setting.goal, &setting.premise] {
            assert_eq!(Predicate::parse(&condition.to_string()).as_ref(), Ok(condition));
        }
        assert!(setting.time_limit > 0.0 && !setting.skills.is_empty());
    }
    for sequence in task.sequences() {
        assert!(sequence.stages.iter().all(|name| task.stage(name).is_ok()), "{}", sequence.name);
    }
    true
}

fn registry() -> &'static Registry {
    static REGISTRY: OnceLock<Registry> = OnceLock::new();
    REGISTRY.get_or_init(|| Registry::builtin().expect("the library is sound"))
}

fn roster() -> &'static Roster {
    static ROSTER: OnceLock<Roster> = OnceLock::new();
    ROSTER.get_or_init(|| Roster::builtin().expect("the roster is sound"))
}

/// A protocol. One that is accepted can be planned, or names what nothing has.
pub fn protocol(bytes: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(bytes) else { return false };
    let protocol = match Protocol::parse(text, Path::new(FILE)) {
        Ok(protocol) => protocol,
        Err(error) => return refused(&error.to_string(), bytes),
    };
    assert_eq!(name::mistake(&protocol.name), None);
    assert!(protocol.target > 0.0 && protocol.target <= 1.0 && (0.0..=1.0).contains(&protocol.confidence));
    match Plan::new(protocol, &Filter::default(), registry(), roster(), &Methods::builtin()) {
        Ok(plan) if plan.len() <= FEW_RECORDS => assert_eq!(plan.places().len(), plan.len(), "a name each"),
        Ok(_) => {}
        Err(error) => plain(&error.to_string()),
    }
    true
}

fn situ() -> Box<dyn Method> {
    named("situ").expect("the method of the paper")
}

/// The original demonstrations of the repository's example.
fn originals() -> &'static [DemonstrationFile; 2] {
    static ORIGINALS: OnceLock<[DemonstrationFile; 2]> = OnceLock::new();
    const TEXTS: [&str; 2] = [
        include_str!("../../../examples/demonstrations/serve-1.json"),
        include_str!("../../../examples/demonstrations/serve-2.json"),
    ];
    ORIGINALS.get_or_init(|| {
        TEXTS.map(|text| DemonstrationFile::parse(text.to_owned(), Path::new("serve.json")).expect("the example"))
    })
}

/// A demonstration file. One that is accepted is written and read back as it was. A small one is learned, or refused
/// by name.
pub fn demonstration(bytes: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(bytes) else { return false };
    let file = match DemonstrationFile::parse(text.to_owned(), Path::new(FILE)) {
        Ok(file) => file,
        Err(error) => return refused(&error.to_string(), bytes),
    };
    let written = render(&file.demonstration, &file.schema, &file.before);
    let again = DemonstrationFile::parse(written.clone(), file.path()).expect("what is written is read");
    assert_eq!(render(&again.demonstration, &again.schema, &again.before), written);
    let is_small = file.demonstration.keyframes().len() <= FEW_KEYFRAMES
        && file.schema.len() <= FEW_FEATURES
        && file.before.trail.len() <= FEW_CHOICES;
    if !is_small {
        return true;
    }
    let learning = match file.demonstration.kind() {
        Kind::Original => learn(situ(), &[file], &[], 0),
        Kind::Corrective => learn(situ(), originals(), &[file], 0),
    };
    match learning {
        Ok(learning) => {
            let dot = learning.kept.learned.graph().unwrap().to_dot("a model");
            assert!(!dot.chars().any(|letter| letter.is_control() && letter != '\n'), "{dot:?}");
            learning.kept.learned.to_json();
        }
        Err(error) => {
            let message = error.to_string();
            plain(&message);
            assert!(message.contains(FILE), "{message}");
        }
    }
    true
}

/// The file of a model. One that is accepted is written and read back as it was, and answers what it is asked.
pub fn model(bytes: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(bytes) else { return false };
    let read = |text: &str| KeptModel::parse(text, Path::new(FILE), &Methods::builtin());
    let kept = match read(text) {
        Ok(kept) => kept,
        Err(error) => return refused(&error.to_string(), bytes),
    };
    let written = kept.render();
    assert_eq!(read(&written).expect("what is written is read").render(), written);
    let state = vec![0.5; kept.schema.len()];
    let mut questions = vec![json!({"do": "graph"}), json!({"do": "next", "last": null, "state": state})];
    for node in kept.graph.nodes.iter().take(FEW_NODES) {
        let place = node.id.to_string();
        questions.push(json!({"do": "next", "last": place, "state": state}));
        questions.push(json!({"do": "keyframes", "place": place, "state": state, "execution": "sample"}));
    }
    for question in questions {
        let answer = answer(&kept, &question.to_string());
        let told: serde_json::Value = serde_json::from_str(&answer).expect("an answer is JSON");
        assert_eq!(told.get("error"), None, "{question}");
    }
    true
}

/// A question to a model: any line gets one line of an answer.
pub fn question(bytes: &[u8]) -> bool {
    static KEPT: OnceLock<KeptModel> = OnceLock::new();
    let Ok(text) = str::from_utf8(bytes) else { return false };
    let kept = KEPT.get_or_init(|| KeptModel::teach(situ(), originals(), 0).expect("the example can be learned"));
    let answer = answer(kept, text);
    assert!(!answer.contains('\n'), "{answer:?}");
    let told: serde_json::Value = serde_json::from_str(&answer).expect("an answer is JSON");
    told.get("error").is_none()
}

/// A ledger. One that is accepted is written and read back as it was, and tables can be made of it.
pub fn ledger(bytes: &[u8]) -> bool {
    let contents = match ledger::contents(Path::new(FILE), bytes) {
        Ok(contents) => contents,
        Err(error) => return refused(&error.to_string(), bytes),
    };
    for warning in &contents.warnings {
        refused(warning, bytes);
    }
    let written = ledger::text(&contents.records);
    let again = ledger::contents(Path::new(FILE), written.as_bytes()).expect("what is written is read");
    assert_eq!((&again.records, again.warnings.len()), (&contents.records, 0));
    if contents.records.len() > FEW_LINES {
        return true;
    }
    let canonical = Canonical::from(contents.records);
    assert_eq!(Canonical::from(canonical.to_vec()), canonical);
    assert!(canonical.is_sorted_by_key(Record::identity));
    let heading =
        Heading { ledgers: "a ledger".to_owned(), revision: "Revision: unknown".to_owned(), superseded: None };
    for table in tables::ALL.iter().flat_map(|publication| publication.tables(&canonical)) {
        for text in [table.to_csv(), table.to_markdown(&heading, "a command")] {
            assert!(!text.chars().any(|letter| letter.is_control() && letter != '\n'), "{text:?}");
        }
    }
    true
}

/// A file of teachers.
pub fn teachers(bytes: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(bytes) else { return false };
    let profiles = match Profile::parse(text, Path::new(FILE)) {
        Ok(profiles) => profiles,
        Err(error) => return refused(&error.to_string(), bytes),
    };
    for (index, profile) in profiles.iter().enumerate() {
        assert_eq!(name::mistake(&profile.name), None);
        assert!(profiles[..index].iter().all(|other| other.name != profile.name), "{}", profile.name);
        assert!(Way::ALL.iter().all(|way| (0.0..=1.0).contains(&profile.rate(*way))), "{profile:?}");
    }
    true
}

/// A mapping of the example of a recording.
const MAPPING: &str = include_str!("../../../examples/recording/saucer.toml");
/// A recording for a mapping of any kind.
const RECORDING: &str = include_str!("../../../examples/recording/saucer.csv");
/// A mapping for the topics that `export` writes.
const TOPICS: &str = "[columns]\nepisode = \"/demonstration.episode\"\nmark = \"/demonstration.keyframe\"\n\
    [gripper]\ntopic = \"/gripper\"\n[objects.cup]\ntopic = \"/objects\"\nframe = \"cup\"\n";

/// A recording as CSV or MCAP, the Parquet file of a dataset, or a mapping of a recording.
pub fn recording(bytes: &[u8]) -> bool {
    let path = Path::new(FILE);
    let mut accepted = false;
    if let Ok(text) = str::from_utf8(bytes) {
        accepted |= match Mapping::parse(text, path) {
            Ok(mapping) => imports(import_bytes(RECORDING.as_bytes(), Path::new("saucer.csv"), &mapping)),
            Err(error) => refused(&error.to_string(), bytes),
        };
    }
    for mapping in [MAPPING, TOPICS] {
        let mapping = Mapping::parse(mapping, Path::new("map.toml")).expect("a sound mapping");
        accepted |= imports(import_bytes(bytes, path, &mapping));
    }
    if bytes.starts_with(b"PAR1") {
        accepted |= dataset(bytes);
    }
    accepted
}

/// What comes out of an import is JSON with at least a keyframe, and a name of its own each.
fn imports(imported: Result<Imported, BenchError>) -> bool {
    let imported = match imported {
        Ok(imported) => imported,
        Err(error) => {
            plain(&error.to_string());
            return false;
        }
    };
    assert!(!imported.report.chars().any(|letter| letter.is_control() && letter != '\n'), "{:?}", imported.report);
    for (name, text) in &imported.demonstrations {
        let value: serde_json::Value = serde_json::from_str(text).expect("a demonstration is JSON");
        assert_eq!(value["name"].as_str(), Some(name.as_str()));
        assert!(value["keyframes"].as_array().is_some_and(|keyframes| !keyframes.is_empty()), "{name}");
    }
    true
}

/// A dataset whose frames are these bytes.
fn dataset(bytes: &[u8]) -> bool {
    const INFO: &str = r#"{"codebase_version": "v3.0", "features": {"observation.state": {"names": null}}}"#;
    const COLUMNS: &str = "[gripper]\nposition = [\"observation.state[0]\", \"observation.state[1]\", \
        \"observation.state[2]\"]\norientation = \"none\"\n[objects.table]\nfixed = {position = [0, 0, 0]}\n";
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data/chunk-000");
    std::fs::create_dir_all(&data).expect("a folder");
    std::fs::create_dir_all(folder.path().join("meta")).expect("a folder");
    std::fs::write(folder.path().join("meta/info.json"), INFO).expect("a file");
    std::fs::write(data.join("file-000.parquet"), bytes).expect("a file");
    let mapping = Mapping::parse(COLUMNS, Path::new("map.toml")).expect("a sound mapping");
    imports(import(&[folder.path().to_owned()], &mapping))
}

/// The lines of one session that are answered at most, and the letters of one that is.
const FEW_REQUESTS: usize = 16;
const SHORT: usize = 4000;
/// The questions to a method.
const QUESTIONS: [&str; 8] = ["hello", "teach", "load", "correct", "next", "keyframes", "graph", "save"];

/// One answer to a line: an object on one line. Says whether the request was done.
fn answered(service: &mut Service, line: &str) -> (serde_json::Value, bool) {
    let reply = service.answer(line);
    assert!(!reply.line.chars().any(char::is_control), "{:?}", reply.line);
    let answer: serde_json::Value = serde_json::from_str(&reply.line).expect("an answer is JSON");
    assert!(answer.is_object() && answer.get("id").is_some(), "{answer}");
    let problem = answer.get("error").map(|problem| problem.as_str().expect("a text").to_owned());
    if let Some(problem) = &problem {
        plain(problem);
        assert!(!problem.contains("a fault of the program"), "{line}: {problem}");
    }
    (answer, problem.is_none())
}

/// Requests to `serve`, one a line. Each is answered, and where it is refused, the episode is as it was.
pub fn requests(bytes: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(bytes) else { return false };
    let hand = registry().clone().with_plant(Plant::Hand);
    let mut service = Service::new(hand, roster().clone(), "hand").without_files();
    let (mut all_done, observe) = (true, r#"{"do": "observe"}"#);
    for line in text.lines().filter(|line| line.len() < SHORT).take(FEW_REQUESTS) {
        let (before, _) = answered(&mut service, observe);
        let (_, is_done) = answered(&mut service, line);
        all_done &= is_done;
        if !is_done {
            assert_eq!(answered(&mut service, observe).0, before, "{line}");
        }
    }
    all_done
}

/// Answers of an external method, one a line. Each is an answer to some question, or refused in one line of text.
pub fn answers(bytes: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(bytes) else { return false };
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut all_are = true;
    for line in text.lines() {
        let problems = QUESTIONS.map(|question| check_answer(question, line).err());
        problems.iter().flatten().for_each(|problem| plain(&name::shown(problem)));
        all_are &= problems.iter().any(Option::is_none);
    }
    all_are
}
