//! Of what provenance the ledgers of a table are: of one, or of several that somebody wanted mixed.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

use crate::error::BenchError;
use crate::ledger;
use crate::manifest::{self, Manifest, Provenance};
use crate::program::UNKNOWN;
use crate::record::Identity;
use crate::tables::Heading;

/// Which ledgers may stand in one table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Permitted {
    /// Those of one benchmark version and one program.
    One,
    /// Those of one benchmark version. Who asks for it sees to it that no method's records are of two programs.
    SideBySide,
    /// Any.
    Mixed,
}

/// The provenances of some ledgers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Provenances {
    /// Each that no other agrees with.
    each: Vec<Provenance>,
    /// The methods whose records are of each of them, where they stand side by side.
    methods: Vec<BTreeSet<String>>,
    /// Why some of the ledgers have been overtaken.
    superseded: Vec<String>,
}

impl Provenances {
    /// Of these ledgers, by the manifests beside them. A ledger without one is of unknown provenance.
    ///
    /// # Errors
    /// [`BenchError::Provenance`] where two ledgers do not agree and this is not permitted; [`BenchError::Read`]
    /// where a ledger is not there; as [`Manifest::read`].
    pub fn of(ledgers: &[PathBuf], permitted: Permitted) -> Result<Self, BenchError> {
        let mut all = Self::default();
        for (index, ledger) in ledgers.iter().enumerate() {
            if ledgers[..index].contains(ledger) {
                continue;
            }
            fs::metadata(ledger).map_err(|source| BenchError::Read { path: ledger.clone(), source })?;
            let manifest = Manifest::read(&manifest::beside(ledger))?;
            let provenance = manifest.as_ref().map_or_else(Provenance::unknown, |manifest| manifest.provenance.clone());
            let is_permitted = |first: &Provenance| match permitted {
                Permitted::One => first.agrees_with(&provenance),
                Permitted::SideBySide => first.agrees_with(&provenance) || first.is_beside(&provenance),
                Permitted::Mixed => true,
            };
            if let Some(first) = all.each.first()
                && !is_permitted(first)
            {
                let [one, other] = [&ledgers[0], ledger].map(|path| path.display().to_string());
                return Err(disagree(&one, first, &other, &provenance));
            }
            match manifest {
                Some(manifest) => all.add_all(manifest),
                None => all.add(provenance),
            }
        }
        Ok(all)
    }

    /// Of ledgers that stand side by side: of one benchmark version, and each method's records of one program. A record
    /// that two ledgers share is of the first.
    ///
    /// # Errors
    /// As [`Provenances::of`]; [`BenchError::Provenance`] where a method has records of two programs.
    pub fn side_by_side(ledgers: &[PathBuf]) -> Result<Self, BenchError> {
        let mut all = Self::of(ledgers, Permitted::SideBySide)?;
        if all.each.len() < 2 {
            return Ok(all);
        }
        let mut known: BTreeMap<Identity, usize> = BTreeMap::new();
        let mut of: BTreeMap<String, (usize, &PathBuf)> = BTreeMap::new();
        for ledger in ledgers {
            let provenance = Manifest::read(&manifest::beside(ledger))?.map(|manifest| manifest.provenance);
            let is_own = |own: &Provenance| provenance.as_ref().is_some_and(|other| own.agrees_with(other));
            let index = all.each.iter().position(is_own).unwrap_or_default();
            for record in ledger::read(ledger)?.records {
                let identity = record.identity();
                let method = identity.method().to_owned();
                let is_new = !known.contains_key(&identity);
                known.entry(identity).or_insert(index);
                let first = of.entry(method.clone()).or_insert((index, ledger));
                if is_new && first.0 != index {
                    let [one, other] = [first.1, ledger].map(|path| path.display().to_string());
                    let mut error = disagree(&one, &all.each[first.0], &other, &all.each[index]);
                    if let BenchError::Provenance { differing, .. } = &mut error {
                        differing.push_str(&format!(", and a row of `{method}` would be of both"));
                    }
                    return Err(error);
                }
            }
        }
        all.methods = vec![BTreeSet::new(); all.each.len()];
        for (method, (index, _)) in of {
            all.methods[index].insert(method);
        }
        Ok(all)
    }

    fn add_all(&mut self, manifest: Manifest) {
        [manifest.provenance].into_iter().chain(manifest.mixed).for_each(|provenance| self.add(provenance));
        if let Some(why) = manifest.superseded
            && !self.superseded.contains(&why)
        {
            self.superseded.push(why);
        }
    }

    fn add(&mut self, provenance: Provenance) {
        let is_known = |known: &Provenance| *known == provenance || known.agrees_with(&provenance);
        if !self.each.iter().any(is_known) {
            self.each.push(provenance);
        }
    }

    /// What the headings of tables say of it. `ledgers` are the words that name the records on the command line.
    pub fn heading(&self, ledgers: &str) -> Heading {
        let of = |index: usize| match self.methods.get(index) {
            Some(methods) => {
                format!(" for {}", methods.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "))
            }
            None => String::new(),
        };
        let said = |(index, own): (usize, &Provenance)| said(own) + &of(index);
        let mut revisions: Vec<String> = self.each.iter().enumerate().map(said).collect();
        revisions.sort();
        revisions.dedup();
        let mut versions: Vec<String> = self.each.iter().map(|provenance| code(&provenance.benchmark)).collect();
        versions.sort();
        versions.dedup();
        let mut revision = match self.each.len() {
            0 | 1 => format!("Revision: {}", revisions.join("; ")),
            _ if self.methods.is_empty() => format!("Revisions, mixed: {}", revisions.join("; ")),
            _ => format!("Revisions, side by side: {}", revisions.join("; ")),
        };
        if versions.len() > 1 {
            revision.push_str(&format!("; of benchmark versions {}", versions.join(" and ")));
        }
        let superseded = (!self.superseded.is_empty()).then(|| self.superseded.join(" "));
        Heading { ledgers: ledgers.to_owned(), revision, superseded }
    }
}

impl From<Manifest> for Provenances {
    /// Of the ledger beside a manifest.
    fn from(manifest: Manifest) -> Self {
        let mut all = Self::default();
        all.add_all(manifest);
        all
    }
}

/// The error that two ledgers, or a ledger and this program, are not of one provenance.
pub fn disagree(first: &str, one: &Provenance, second: &str, other: &Provenance) -> BenchError {
    let mut differing = Vec::new();
    for (what, one, other) in [
        ("benchmark version", (&one.benchmark, code(&one.benchmark)), (&other.benchmark, code(&other.benchmark))),
        ("revision", (&one.sources, said(one)), (&other.sources, said(other))),
    ] {
        if one.0 != other.0 || one.0 == UNKNOWN {
            differing.push(format!("{what} {} and {}", one.1, other.1));
        }
    }
    let changed = one.methods.iter().filter(|(name, hash)| other.methods.get(*name).is_some_and(|own| own != *hash));
    differing.extend(changed.map(|(name, _)| format!("the program of `{name}`, which has changed")));
    BenchError::Provenance { first: first.to_owned(), second: second.to_owned(), differing: differing.join(", ") }
}

/// Digits of a hash that are enough to tell it from others.
const DIGITS: usize = 12;

/// The beginning of a hash, as code.
fn code(hash: &str) -> String {
    if hash == UNKNOWN { hash.to_owned() } else { format!("`{}`", hash.chars().take(DIGITS).collect::<String>()) }
}

/// A revision in words. One that is no commit is told by its sources.
fn said(provenance: &Provenance) -> String {
    let (commit, changes) = provenance.revision.split_once(", ").unwrap_or((&provenance.revision, ""));
    let changes = if changes.is_empty() { String::new() } else { format!(", {changes}") };
    let is_commit = commit != UNKNOWN && changes.is_empty();
    let sources = if is_commit || provenance.sources == UNKNOWN {
        String::new()
    } else {
        format!(" (sources {})", code(&provenance.sources))
    };
    format!("{}{changes}{sources}", code(commit))
}
