//! `supersede`: says of a folder of results that it has been overtaken.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Deserialize;
use serde_json::Value;

use crate::cmd::run;
use crate::digest;
use crate::error::BenchError;
use crate::files;
use crate::machine::Machine;
use crate::manifest::{self, Manifest, ProtocolStamp, Provenance};
use crate::plan::Filter;
use crate::program::UNKNOWN;
use crate::provenances::Provenances;

/// Says of a folder of results that it has been overtaken, and why: in its manifest and in the heading of each table.
#[derive(Args, Clone, Debug)]
#[command(
    after_long_help = "A folder without a manifest gets one, in which what cannot be known any more is `unknown`. The \
        ledger and the rows of the tables stay as they are, so a folder that an older program made can be marked, too. \
        Said again, the new reason takes the place of the former.

Examples:
  situ-bench supersede results/families --because \"It was made by the protocol before fresh starts.\""
)]
pub struct Supersede {
    /// The folder of a run.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// The reason, in a line.
    #[arg(long, value_name = "REASON")]
    pub because: String,
}

/// What can be known of a protocol of any time.
#[derive(Deserialize)]
struct AnyProtocol {
    name: String,
    first_seed: Option<u64>,
    seeds: Option<u64>,
}

impl Supersede {
    /// Writes the manifest and marks the tables; returns the text that is to be printed.
    ///
    /// # Errors
    /// A reason that is no line, a folder without ledger and protocol, and files that cannot be read or written.
    pub fn run(&self) -> Result<String, BenchError> {
        let why = self.because.trim();
        if why.is_empty() || why.chars().any(char::is_control) {
            return Err(BenchError::Argument("--because: expected a reason in one line".to_owned()));
        }
        let ledger = self.folder.join(run::LEDGER);
        let former = Manifest::read(&manifest::beside(&ledger))?;
        let manifest = former.map_or_else(|| unknown(&self.folder), Ok)?;
        let manifest = Manifest { superseded: Some(why.to_owned()), ..manifest };
        let heading = Provenances::from(manifest.clone()).heading("");
        let mut outputs = vec![(manifest::beside(&ledger), manifest.text())];
        for path in markdown(&self.folder)? {
            let text = read(&path)?;
            let marked = heading.mark(&text);
            if marked != text {
                outputs.push((path, marked));
            }
        }
        files::write_all(&outputs)?;
        Ok(outputs.iter().map(|(path, _)| format!("{}\n", path.display())).collect())
    }
}

fn read(path: &Path) -> Result<String, BenchError> {
    fs::read_to_string(path).map_err(|source| BenchError::Read { path: path.to_owned(), source })
}

/// The Markdown files of a folder, in the order of their names.
fn markdown(folder: &Path) -> Result<Vec<PathBuf>, BenchError> {
    let fail = |source| BenchError::Read { path: folder.to_owned(), source };
    let entries = fs::read_dir(folder).map_err(fail)?.map(|entry| entry.map(|entry| entry.path()));
    let mut paths = entries.collect::<Result<Vec<_>, _>>().map_err(fail)?;
    paths.retain(|path| path.is_file() && path.extension().is_some_and(|ending| ending == "md"));
    paths.sort();
    Ok(paths)
}

/// The manifest of a folder that was made when there were none: what its protocol and its ledger's first line say.
fn unknown(folder: &Path) -> Result<Manifest, BenchError> {
    let (protocol, ledger) = (folder.join(run::PROTOCOL), folder.join(run::LEDGER));
    let malformed = |path: PathBuf, problem| BenchError::Malformed { path, line: 1, problem };
    let source = read(&protocol)?;
    let AnyProtocol { name, first_seed, seeds } =
        toml::from_str(&source).map_err(|error| malformed(protocol, error.message().to_owned()))?;
    let text = read(&ledger)?;
    let line: Option<Value> = text.lines().next().and_then(|line| serde_json::from_str(line).ok());
    let schema = line.and_then(|line| line.get("schema")?.as_u64());
    Ok(Manifest {
        superseded: None,
        schema: schema.ok_or_else(|| malformed(ledger, "expected a line of a ledger, with its `schema`".to_owned()))?,
        plant: UNKNOWN.to_owned(),
        provenance: Provenance::unknown(),
        protocol: ProtocolStamp { name, hash: digest::hash(&source), first_seed, seeds },
        machine: Machine::unknown(),
        tasks: [].into(),
        teachers: [].into(),
        wanted: Filter::default(),
        shard: None,
        other_machines: Vec::new(),
        mixed: Vec::new(),
    })
}
