//! Where a baseline was minted, and of what code.

use std::fs;
use std::process::Command;

use serde::{Deserialize, Serialize};

/// Where and of what a baseline was minted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// The machine's processor, in its own words.
    pub machine: String,
    /// The revision of the code; `unknown` outside a repository.
    pub revision: String,
    /// The compiler, in its own words.
    pub toolchain: String,
    /// The target triple.
    pub target: String,
    /// The processor's vectors that the kernels ran on ([`situ::vector::kind`]).
    #[serde(default)]
    pub vectors: String,
}

impl Origin {
    /// Of this code, on this machine.
    pub fn here() -> Self {
        let cpu = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = cpu.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
        let git = |words: &[&str]| {
            let output = Command::new("git").args(words).output().ok().filter(|output| output.status.success())?;
            Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
        };
        let changes = git(&["status", "--porcelain", "--untracked-files=no"]);
        let changed = changes.is_some_and(|changes| !changes.is_empty());
        let revision = git(&["rev-parse", "HEAD"]).unwrap_or_else(|| "unknown".to_owned());
        Self {
            machine: model.map_or("unknown", |(_, model)| model.trim()).to_owned(),
            revision: if changed { format!("{revision}, changed") } else { revision },
            toolchain: env!("SITU_TOOLCHAIN").to_owned(),
            target: env!("SITU_TARGET").to_owned(),
            vectors: situ::vector::kind().to_owned(),
        }
    }

    /// Whether instructions that were counted here and there can be compared.
    pub fn counts_as(&self, other: &Self) -> bool {
        (&self.toolchain, &self.target, &self.vectors) == (&other.toolchain, &other.target, &other.vectors)
    }

    /// One of a test, with this compiler.
    #[cfg(test)]
    pub(super) fn sample(toolchain: &str) -> Self {
        let word = |text: &str| text.to_owned();
        let [machine, revision, target, vectors] = ["a", "b", "c", "d"].map(word);
        Self { machine, revision, toolchain: word(toolchain), target, vectors }
    }
}
