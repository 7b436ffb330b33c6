//! One of several parts of a protocol's runs, each for a machine of its own.

use std::env;
use std::fmt;
use std::fs;
use std::io::ErrorKind;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::error::BenchError;

/// The `number`-th of `of` parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shard {
    /// Its number, from 1.
    pub number: NonZeroU32,
    /// How many there are.
    pub of: NonZeroU32,
}

/// The most shards.
const MOST: u32 = 10_000;

impl Shard {
    /// A shard of so many.
    ///
    /// # Errors
    /// What was expected.
    pub fn new(number: u32, of: u32) -> Result<Self, String> {
        let expected = || format!("{number}/{of}: expected I/N with I from 1 to N, and N at most {MOST}");
        let (Some(number), Some(of)) = (NonZeroU32::new(number), NonZeroU32::new(of)) else { return Err(expected()) };
        if number > of || of.get() > MOST { Err(expected()) } else { Ok(Self { number, of }) }
    }

    /// Whether the thing of this index, from 0, belongs to it.
    pub fn holds(self, index: usize) -> bool {
        index % self.of.get() as usize == self.number.get() as usize - 1
    }

    /// That one of as many shards which holds the thing of this index, from 0.
    pub fn holder(self, index: usize) -> Option<Self> {
        let number = u32::try_from(index % self.of.get() as usize).ok()?.checked_add(1)?;
        Self::new(number, self.of.get()).ok()
    }

    /// Its folder, among those of the other shards in `out`.
    ///
    /// # Errors
    /// [`BenchError::Argument`] where `out` has a folder of a shard of another number of shards: the two do not go
    /// together. [`BenchError::Read`].
    pub fn folder(self, out: &Path) -> Result<PathBuf, BenchError> {
        let wrong = |source| BenchError::Read { path: out.to_owned(), source };
        let entries = match fs::read_dir(out) {
            Ok(entries) => entries,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(out.join(self.name())),
            Err(source) => return Err(wrong(source)),
        };
        for entry in entries {
            let found = entry.map_err(wrong)?.file_name().to_str().and_then(Self::named);
            if let Some(found) = found.filter(|found| found.of != self.of) {
                return Err(BenchError::Argument(format!(
                    "{} holds shard {found}, and this is {self}: give another --out, or the same number of shards",
                    out.display()
                )));
            }
        }
        Ok(out.join(self.name()))
    }

    /// The name of its folder.
    fn name(self) -> String {
        format!("shard-{}-of-{}", self.number, self.of)
    }

    /// The shard whose folder has this name.
    fn named(name: &str) -> Option<Self> {
        name.strip_prefix("shard-")?.replacen("-of-", "/", 1).parse().ok()
    }

    /// The shard that a task of a Slurm array is: its place in the array, whatever numbers the array has. `None`
    /// outside of an array.
    ///
    /// # Errors
    /// Where the array has no such places: its numbers are not in steps, or it does not say how many there are.
    pub fn of_slurm() -> Result<Option<Self>, String> {
        Self::of_array(|name| Some(env::var_os(name)?.to_string_lossy().into_owned()))
    }

    fn of_array(variable: impl Fn(&str) -> Option<String>) -> Result<Option<Self>, String> {
        let number = |name: &str| -> Result<Option<u32>, String> {
            let parse = |text: String| {
                text.trim().parse().map_err(|_| format!("{name} is `{}`: expected a number", text.escape_debug()))
            };
            variable(name).map(parse).transpose()
        };
        let Some(own) = number("SLURM_ARRAY_TASK_ID")? else { return Ok(None) };
        let Some(count) = number("SLURM_ARRAY_TASK_COUNT")? else {
            return Err(format!("task {own} of a Slurm array without SLURM_ARRAY_TASK_COUNT: expected it, or --shard"));
        };
        let least = number("SLURM_ARRAY_TASK_MIN")?.unwrap_or(0);
        let step = number("SLURM_ARRAY_TASK_STEP")?.unwrap_or(1).max(1);
        let place = own.checked_sub(least).filter(|apart| apart % step == 0).map(|apart| apart / step);
        match place.filter(|place| *place < count) {
            Some(place) => Self::new(place + 1, count).map(Some),
            None => Err(format!(
                "task {own} of a Slurm array of {count} from {least} on: expected an array in steps, such as 0-6, or \
                 --shard"
            )),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        let (number, of) = numbers.ok_or_else(|| "expected I/N, such as 3/7".to_owned())?;
        Self::new(number, of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_thing_belongs_to_one() {
        for of in 1..9 {
            let shards: Vec<Shard> = (1..=of).map(|number| Shard::new(number, of).unwrap()).collect();
            for index in 0..40 {
                let holders: Vec<Shard> = shards.iter().copied().filter(|shard| shard.holds(index)).collect();
                assert_eq!(holders, Vec::from_iter(shards[0].holder(index)), "{index} of {of}");
            }
        }
    }

    #[test]
    fn what_is_written_is_read() {
        assert_eq!("3/7".parse::<Shard>().unwrap().to_string(), "3/7");
        for bad in ["", "3", "0/7", "8/7", "3/0", "-1/7", "1/10001", "a/b", "3/7/9"] {
            assert!(bad.parse::<Shard>().unwrap_err().contains("expected"), "{bad}");
        }
    }

    #[test]
    fn shards_of_one_number_share_a_folder() {
        let out = tempfile::tempdir().unwrap();
        let shard = |text: &str| text.parse::<Shard>().unwrap();
        let own = shard("3/7").folder(out.path()).unwrap();
        assert_eq!(own, out.path().join("shard-3-of-7"));
        for name in ["shard-3-of-7", "shard-7-of-7", "shard-of-9", "shards-1-of-9", "merged"] {
            fs::create_dir(out.path().join(name)).unwrap();
        }
        assert_eq!(shard("3/7").folder(out.path()).unwrap(), own);
        let error = shard("1/1").folder(out.path()).unwrap_err().to_string();
        assert!(error.contains("/7, and this is 1/1"), "{error}");
    }

    #[test]
    fn a_task_of_an_array_is_a_shard() {
        let of = |variables: &[(&str, &str)]| {
            Shard::of_array(|name| {
                variables.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_owned())
            })
        };
        let array = |own: &'static str, count: &'static str, least: &'static str, step: &'static str| {
            of(&[
                ("SLURM_ARRAY_TASK_ID", own),
                ("SLURM_ARRAY_TASK_COUNT", count),
                ("SLURM_ARRAY_TASK_MIN", least),
                ("SLURM_ARRAY_TASK_STEP", step),
            ])
        };
        assert_eq!(of(&[]), Ok(None));
        assert_eq!(array("0", "7", "0", "1"), Ok(Some(Shard::new(1, 7).unwrap())));
        assert_eq!(array("6", "7", "0", "1"), Ok(Some(Shard::new(7, 7).unwrap())));
        assert_eq!(array("5", "3", "1", "2"), Ok(Some(Shard::new(3, 3).unwrap())));
        // A task that is submitted alone is an array of one.
        assert_eq!(array("3", "1", "3", "1"), Ok(Some(Shard::new(1, 1).unwrap())));
        assert!(of(&[("SLURM_ARRAY_TASK_ID", "3")]).unwrap_err().contains("--shard"), "all tasks used to do all runs");
        assert!(array("9", "3", "1", "1").unwrap_err().contains("--shard"), "an array of 1,5,9");
        assert!(array("4", "3", "1", "2").is_err() && array("x", "3", "1", "2").is_err());
    }
}
