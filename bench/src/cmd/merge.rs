//! `merge`: one folder of the shards of a protocol's runs.

use std::collections::BTreeSet;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::cmd::folder;
use crate::cmd::library::{Carrier, Library, OwnMethods};
use crate::cmd::run::{LEDGER, PROTOCOL};
use crate::cmd::terminal::say;
use crate::cmd::traces;
use crate::digest;
use crate::error::BenchError;
use crate::files;
use crate::ledger::{self, Canonical};
use crate::lock::Lock;
use crate::manifest::{self, Manifest};
use crate::plan::Plan;
use crate::protocol::Protocol;
use crate::provenances::{Permitted, Provenances};
use crate::record::{Identity, Record};
use crate::shard::Shard;
use crate::tables;

/// Makes one folder of the shards of a protocol's runs, as `run` without shards would have made it.
#[derive(Args, Clone, Debug)]
#[command(
    after_long_help = "A folder without a ledger stands for the folders in it that have one. All must be shards of the \
        same runs, by one protocol, one benchmark version and one revision of the program. A run that is in two shards \
        counts once where both say the same, all but the times; else it is refused. Where a run is missing, or one is \
        there that the protocol does not have, its name is said, and nothing is written. Demonstrations stay in the \
        folders of the shards.

Examples:
  situ-bench merge paper --out results/paper
  situ-bench merge paper/shard-1-of-2 paper/shard-2-of-2 --out results/paper"
)]
pub struct Merge {
    /// Folders that `run --shard` wrote, or one that holds them.
    #[arg(required = true, value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// The folder for the ledger and the tables. What is there already is not changed: it must be the same.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Permits shards of different provenance. Every table's heading names them.
    #[arg(long)]
    pub mixed: bool,
    /// A folder of task files that the runs were told of; may be given several times.
    #[arg(long, value_name = "DIR")]
    pub tasks: Vec<PathBuf>,
    /// A file of teacher profiles that the runs were told of; may be given several times.
    #[arg(long, value_name = "FILE")]
    pub teachers: Vec<PathBuf>,
    /// Methods of one's own that the shards ran.
    #[command(flatten)]
    pub own: OwnMethods,
}

/// The most names of runs that are said.
const NAMED: usize = 10;

impl Merge {
    /// Merges; returns the text that is to be printed.
    ///
    /// # Errors
    /// [`BenchError::Argument`] where the shards are not of one kind or not whole, or `out` holds something else;
    /// [`BenchError::Conflict`], [`BenchError::Provenance`]; files that cannot be read or written.
    pub fn run(&self) -> Result<String, BenchError> {
        let folders = self.shards()?;
        let ledgers: Vec<PathBuf> = folders.iter().map(|folder| folder.join(LEDGER)).collect();
        let manifests = folders.iter().map(|folder| folder::manifest(folder)).collect::<Result<Vec<_>, _>>()?;
        let first = one_kind(&folders, &manifests)?;
        let permitted = if self.mixed { Permitted::Mixed } else { Permitted::One };
        let heading = Provenances::of(&ledgers, permitted)?.heading(&format!("{}/{LEDGER}", first.protocol.name));
        let (records, warnings) = ledger::read_all(&ledgers)?;
        warnings.iter().for_each(|warning| say(&format!("warning: {warning}")));
        let source = folder::protocol(&folders[0], first)?;
        self.refuse_others(&Protocol::parse(&source, &folders[0].join(PROTOCOL))?, first, &records)?;
        let mut manifest = Manifest { shard: None, ..first.clone() };
        manifests.iter().for_each(|part| manifest.absorb(part));
        let mut outputs = vec![
            (manifest::FILE.to_owned(), manifest.text()),
            (PROTOCOL.to_owned(), source),
            (LEDGER.to_owned(), ledger::text(&records)),
        ];
        outputs.extend(tables::ALL.iter().flat_map(|table| table.files(&records, &heading)));
        let new = traces::make(&self.out)?;
        let written = self.write(&ledgers, outputs);
        if written.is_err() {
            traces::remove_empty(&new);
        }
        written?;
        let shards = if folders.len() == 1 { "1 shard" } else { &format!("{} shards", folders.len()) };
        Ok(format!("{} records of {shards} are in {}.\n", records.len(), self.out.display()))
    }

    /// Writes files into the folder, where each is new or as it was: who merges again what has not changed is told that
    /// it is there, and a former merge that was broken off is finished.
    fn write(&self, inputs: &[PathBuf], outputs: Vec<(String, String)>) -> Result<(), BenchError> {
        let _lock = Lock::take(&self.out)?;
        let outputs: Vec<(PathBuf, String)> =
            outputs.into_iter().map(|(name, text)| (self.out.join(name), text)).collect();
        for (path, text) in &outputs {
            match fs::read(path) {
                Ok(found) if found == text.as_bytes() => {}
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                Ok(_) => {
                    let path = path.display();
                    return Err(BenchError::Argument(format!(
                        "{path} is there already and says something else: give another --out"
                    )));
                }
                Err(source) => return Err(BenchError::Read { path: path.clone(), source }),
            }
        }
        let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
        files::write_beside(&inputs, &outputs)
    }

    /// The folders that have a ledger, each once, but for the merge that is written.
    fn shards(&self) -> Result<Vec<PathBuf>, BenchError> {
        let out = self.out.canonicalize().ok();
        let mut met = BTreeSet::new();
        let mut found = Vec::new();
        for folder in &self.folders {
            let wrong = |source| BenchError::Read { path: folder.clone(), source };
            let entries = fs::read_dir(folder).map_err(wrong)?;
            let mut shards = Vec::new();
            for entry in entries {
                let path = entry.map_err(wrong)?.path();
                // What a former merge wrote there is no shard.
                let is_out = || out.is_some() && path.canonicalize().ok() == out;
                if path.is_dir() && has_ledger(&path)? && !(is_out() && folder::manifest(&path)?.shard.is_none()) {
                    shards.push(path);
                }
            }
            shards.sort();
            let is_one = has_ledger(folder)?;
            if is_one != shards.is_empty() {
                let (folder, shard) = (folder.display(), shards.first().map(|shard| shard.display()));
                return Err(BenchError::Argument(match shard {
                    Some(shard) => format!("{folder} has a {LEDGER}, and so has {shard}: give those that are shards"),
                    None => format!("{folder}: no {LEDGER}, expected a shard or a folder of shards"),
                }));
            }
            let all = if is_one { vec![folder.clone()] } else { shards };
            found.extend(
                all.into_iter().filter(|path| met.insert(path.canonicalize().unwrap_or_else(|_| path.clone()))),
            );
        }
        Ok(found)
    }

    /// Refuses shards that do not hold all runs, or others beside them.
    fn refuse_others(&self, protocol: &Protocol, first: &Manifest, records: &Canonical) -> Result<(), BenchError> {
        let plant = if first.plant == Carrier::Hand.name() { Carrier::Hand } else { Carrier::Arm };
        let library = Library { tasks: self.tasks.clone(), teachers: self.teachers.clone(), plant };
        let registry = library.registry()?;
        for (name, hash) in &first.tasks {
            if let Some(text) = registry.text(name)
                && digest::hash(text) != *hash
            {
                return Err(BenchError::Argument(format!(
                    "the task `{name}` is not the one of the shards: expected the file with the SHA-256 {hash}"
                )));
            }
        }
        let seed = first.protocol.first_seed.unwrap_or(protocol.first_seed);
        let protocol = Protocol { name: first.protocol.name.clone(), first_seed: seed, ..protocol.clone() };
        let wanted =
            Plan::new(protocol, &first.wanted, &registry, &library.roster()?, &self.own.known_alone()?)?.places();
        let found: BTreeSet<Identity> = records.iter().map(Record::identity).collect();
        let missing = wanted.iter().filter(|(run, _)| !found.contains(run)).map(|(run, place)| {
            let holder = first.shard.and_then(|shard| shard.holder(*place));
            format!("{run}{}", holder.map_or(String::new(), |shard| format!(" (shard {shard})")))
        });
        refuse(missing, wanted.len(), "missing, expected all (go on with `run --resume`):")?;
        let others = found.iter().filter(|run| !wanted.contains_key(run)).map(Identity::to_string);
        refuse(others, found.len(), "none of those that the manifest asks for, expected no other:")
    }
}

/// Refuses runs, of so many, that are so, where there are any.
fn refuse(runs: impl Iterator<Item = String>, of: usize, are_so: &str) -> Result<(), BenchError> {
    let runs: Vec<String> = runs.collect();
    if runs.is_empty() {
        return Ok(());
    }
    let more = runs.len().saturating_sub(NAMED);
    let more = if more > 0 { format!("\n  and {more} more") } else { String::new() };
    let named = runs[..runs.len().min(NAMED)].join("\n  ");
    Err(BenchError::Argument(format!("{} of {of} runs are {are_so}\n  {named}{more}", runs.len())))
}

/// Whether a folder has a ledger. One that cannot be looked into is an error: it is not left out unsaid.
fn has_ledger(folder: &Path) -> Result<bool, BenchError> {
    let path = folder.join(LEDGER);
    path.try_exists().map_err(|source| BenchError::Read { path, source })
}

/// The manifest of the first, where all are shards of the same runs.
fn one_kind<'a>(folders: &[PathBuf], manifests: &'a [Manifest]) -> Result<&'a Manifest, BenchError> {
    let first = &manifests[0];
    let of = |manifest: &Manifest| manifest.shard.map(|shard| shard.of);
    for (folder, other) in folders.iter().zip(manifests) {
        let differs = [
            ("protocol or its first seed", other.protocol != first.protocol),
            ("plant", other.plant != first.plant),
            ("runs that were asked for", other.wanted != first.wanted),
            ("number of shards", of(other) != of(first)),
        ];
        if let Some((what, _)) = differs.into_iter().find(|(_, differs)| *differs) {
            let (folder, first) = (folder.display(), folders[0].display());
            return Err(BenchError::Argument(format!(
                "{folder} and {first} differ in their {what}: expected shards of the same runs"
            )));
        }
    }
    if let Some(Shard { of, .. }) = first.shard {
        let found: BTreeSet<u32> = manifests.iter().filter_map(|one| Some(one.shard?.number.get())).collect();
        let missing: Vec<String> =
            (1..=of.get()).filter(|number| !found.contains(number)).map(|n| n.to_string()).collect();
        if !missing.is_empty() {
            return Err(BenchError::Argument(format!("of {of} shards these are missing: {}", missing.join(", "))));
        }
    }
    Ok(first)
}
