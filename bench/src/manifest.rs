//! The manifest of a folder with a ledger: what made the ledger, and of what. It is written before the first run, and
//! whoever mixes ledgers or wants one again can tell whether they are of one kind.
//!
//! A hash is a SHA-256 in hexadecimal digits, as `sha256sum` prints it. The *benchmark version* is the hash of this
//! text, of which every line ends with a line feed:
//!
//! ```text
//! schema 2
//! protocol HASH
//! task NAME HASH        for each task, in the order of the names
//! teacher NAME HASH     for each teacher, in the order of the names
//! ```
//!
//! The hashes are of the files that the protocol, the tasks and the teachers were read from. Tasks and teachers are
//! those that the protocol names, and those that were asked for beside them. So shards of one protocol have one
//! version, whichever of its cells they hold.

use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::digest::hash;
use crate::error::BenchError;
use crate::machine::Machine;
use crate::plan::Filter;
use crate::program::{self, UNKNOWN};
use crate::protocol::Protocol;
use crate::record::SCHEMA;
use crate::shard::Shard;
use crate::tally::is_default;

/// The manifest's name in its folder.
pub const FILE: &str = "manifest.toml";

/// How the file begins.
const HEAD: &str = "# What made this ledger, and of what. Written by situ-bench, never by hand. Hashes are as \
                    sha256sum prints them.\n\n";

/// What records must share before they stand in one table without a word.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// The benchmark version.
    pub benchmark: String,
    /// The program's revision ([`program::revision`]).
    pub revision: String,
    /// The hash of the program's sources ([`program::SOURCES`]).
    pub sources: String,
    /// The hash of `Cargo.lock`, which is one of the sources.
    pub lock: String,
    /// The compiler, in its own words.
    pub toolchain: String,
    /// A hash of each external method's command and of the files that it names, by the method's name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub methods: BTreeMap<String, String>,
}

impl Provenance {
    /// Of which nothing is known.
    pub fn unknown() -> Self {
        let [benchmark, revision, sources, lock, toolchain] = [UNKNOWN; 5].map(str::to_owned);
        Self { benchmark, revision, sources, lock, toolchain, methods: BTreeMap::new() }
    }

    /// Whether both are of one benchmark version, whatever the program.
    pub fn is_beside(&self, other: &Self) -> bool {
        self.benchmark != UNKNOWN && self.benchmark == other.benchmark
    }

    /// Whether both are of one benchmark version and one program, and an external method of both is the same. What is
    /// unknown agrees with nothing.
    pub fn agrees_with(&self, other: &Self) -> bool {
        let same = |one: &str, other: &str| one != UNKNOWN && one == other;
        let is_other = |(name, hash): (&String, &String)| other.methods.get(name).is_some_and(|other| other != hash);
        same(&self.benchmark, &other.benchmark)
            && same(&self.sources, &other.sources)
            && !self.methods.iter().any(is_other)
    }
}

/// The protocol of a ledger.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProtocolStamp {
    /// Its name.
    pub name: String,
    /// The hash of its file, `protocol.toml` in the folder.
    pub hash: String,
    /// The first seed of the run that began the folder; left out where it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first_seed: Option<u64>,
    /// Seeds of each cell; left out where it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seeds: Option<u64>,
}

/// A manifest.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Why the ledger has been overtaken, where it has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub superseded: Option<String>,
    /// The version of the ledger's lines.
    pub schema: u64,
    /// What carried the hand: `arm` or `hand`.
    pub plant: String,
    /// What must agree before ledgers mix.
    pub provenance: Provenance,
    /// The protocol.
    pub protocol: ProtocolStamp,
    /// The machine that the first run was begun on.
    pub machine: Machine,
    /// The hash of each task's file, by the task's name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub tasks: BTreeMap<String, String>,
    /// The hash of each teacher's file, by the teacher's name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub teachers: BTreeMap<String, String>,
    /// Which of the protocol's runs were asked for; all where it is left out.
    #[serde(default, skip_serializing_if = "is_default")]
    pub wanted: Filter,
    /// The part of these runs that the folder holds, where it is one of several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<Shard>,
    /// Other kinds of machines that made records.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub other_machines: Vec<Machine>,
    /// What else added records, where that was permitted.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mixed: Vec<Provenance>,
}

/// The path of the manifest beside a ledger.
pub fn beside(ledger: &Path) -> PathBuf {
    ledger.with_file_name(FILE)
}

impl Manifest {
    /// What this program, on this machine, makes of a protocol with these tasks and teachers, whose files have these
    /// hashes.
    pub fn new(
        protocol: &Protocol,
        plant: &str,
        tasks: BTreeMap<String, String>,
        teachers: BTreeMap<String, String>,
    ) -> Self {
        let stamp = ProtocolStamp {
            name: protocol.name.clone(),
            hash: hash(&protocol.source),
            first_seed: Some(protocol.first_seed),
            seeds: Some(protocol.seeds),
        };
        let mut version = format!("schema {SCHEMA}\nprotocol {}\n", stamp.hash);
        for (kind, hashes) in [("task", &tasks), ("teacher", &teachers)] {
            hashes.iter().for_each(|(name, hash)| version.push_str(&format!("{kind} {name} {hash}\n")));
        }
        let provenance = Provenance {
            benchmark: hash(version),
            revision: program::revision(),
            sources: program::SOURCES.to_owned(),
            lock: program::LOCK.to_owned(),
            toolchain: program::TOOLCHAIN.to_owned(),
            methods: BTreeMap::new(),
        };
        Self {
            superseded: None,
            schema: SCHEMA,
            plant: plant.to_owned(),
            provenance,
            protocol: stamp,
            machine: Machine::here(),
            tasks,
            teachers,
            wanted: Filter::default(),
            shard: None,
            other_machines: Vec::new(),
            mixed: Vec::new(),
        }
    }

    /// Reads a manifest; `None` where there is none.
    ///
    /// # Errors
    /// [`BenchError::Read`]; [`BenchError::Malformed`] with the line and what was expected.
    pub fn read(path: &Path) -> Result<Option<Self>, BenchError> {
        let text = match fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(source) => return Err(BenchError::Read { path: path.to_owned(), source }),
        };
        toml::from_str(&text).map(Some).map_err(|error| {
            let start = error.span().map_or(0, |span| span.start);
            let line = text.as_bytes()[..start.min(text.len())].iter().filter(|byte| **byte == b'\n').count() + 1;
            BenchError::Malformed { path: path.to_owned(), line, problem: error.message().to_owned() }
        })
    }

    /// The file's text.
    pub fn text(&self) -> String {
        let fields = toml::to_string(self).expect("a manifest is of words, whole numbers and tables of words");
        format!("{HEAD}{fields}")
    }

    /// Notes that a machine makes records.
    pub fn meet(&mut self, machine: &Machine) {
        if self.machine != *machine && !self.other_machines.contains(machine) {
            self.other_machines.push(machine.clone());
        }
    }

    /// Notes what another part of the same runs says of itself: what made it, where, and why it has been overtaken.
    pub fn absorb(&mut self, part: &Self) {
        [&part.machine].into_iter().chain(&part.other_machines).for_each(|machine| self.meet(machine));
        for provenance in [&part.provenance].into_iter().chain(&part.mixed) {
            self.mix(provenance);
        }
        if self.superseded.is_none() {
            self.superseded.clone_from(&part.superseded);
        }
    }

    /// Notes that something else adds records. Whether there was anything to note.
    pub fn mix(&mut self, other: &Provenance) -> bool {
        let is_new = ![&self.provenance].into_iter().chain(&self.mixed).any(|known| known.agrees_with(other));
        if is_new {
            self.mixed.push(other.clone());
        }
        is_new
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manifest() -> Manifest {
        let hashes = |name: &str| BTreeMap::from([(name.to_owned(), hash(name))]);
        Manifest::new(&Protocol::find("quick").unwrap(), "arm", hashes("pour"), hashes("novice"))
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(FILE);
        assert_eq!(Manifest::read(&path).unwrap(), None);
        let mut manifest = manifest();
        manifest.mix(&Provenance::unknown());
        manifest.superseded = Some("\"Fresh\" starts.".to_owned());
        manifest.meet(&Machine::here());
        assert_eq!(manifest.other_machines, []);
        (0..2).for_each(|_| manifest.meet(&Machine::unknown()));
        assert_eq!(manifest.other_machines, [Machine::unknown()]);
        fs::write(&path, manifest.text()).unwrap();
        assert_eq!(Manifest::read(&path).unwrap(), Some(manifest.clone()));
        assert_eq!(manifest.text(), Manifest::read(&path).unwrap().unwrap().text(), "the same bytes");
        fs::write(&path, manifest.text().replace("plant = \"arm\"", "plant = 3")).unwrap();
        let error = Manifest::read(&path).unwrap_err();
        assert!(error.to_string().contains("manifest.toml:5: ") && error.exit_status() == 2, "{error}");
    }

    /// Each part of the version, changed, is another version. What does not belong to it, changed, is none.
    #[test]
    fn the_version_is_of_protocol_tasks_teachers_and_schema() {
        let version = |manifest: &Manifest| manifest.provenance.benchmark.clone();
        let (first, quick) = (manifest(), Protocol::find("quick").unwrap());
        let of = |protocol: &Protocol, task: &str, teacher: &str| {
            let hashes = |of: &str| BTreeMap::from([(of.to_owned(), hash(of))]);
            version(&Manifest::new(protocol, "arm", hashes(task), hashes(teacher)))
        };
        assert_eq!(of(&quick, "pour", "novice"), version(&first));
        assert_eq!(of(&Protocol { first_seed: 7, ..quick.clone() }, "pour", "novice"), version(&first), "a shard");
        let edited = Protocol { source: quick.source.clone() + "\n", ..quick.clone() };
        for other in [of(&edited, "pour", "novice"), of(&quick, "press", "novice"), of(&quick, "pour", "expert")] {
            assert_ne!(other, version(&first));
        }
    }

    #[test]
    fn what_is_unknown_agrees_with_nothing() {
        let mut manifest = manifest();
        let here = manifest.provenance.clone();
        assert!(here.agrees_with(&here) && !here.agrees_with(&Provenance::unknown()));
        assert!(!Provenance::unknown().agrees_with(&Provenance::unknown()));
        let elsewhere = Provenance { toolchain: "another".to_owned(), ..here.clone() };
        assert!(!manifest.mix(&elsewhere), "another compiler of the same sources");
        let edited = Provenance { sources: "another".to_owned(), ..here };
        assert!(manifest.mix(&edited) && !manifest.mix(&edited));
    }
}
