//! Where a baseline was minted, and of what code.

use serde::{Deserialize, Serialize};

use crate::machine::Machine;
use crate::program;

/// Where and of what a baseline was minted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// The machine's processor, in its own words.
    pub machine: String,
    /// The revision of the code ([`program::revision`]).
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
        Self {
            machine: Machine::here().processor,
            revision: program::revision(),
            toolchain: program::TOOLCHAIN.to_owned(),
            target: program::TARGET.to_owned(),
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
