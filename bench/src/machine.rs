//! The kind of a machine. Its name, which says nothing about it, is not asked for.

use std::env::consts;
use std::fs;

use serde::{Deserialize, Serialize};

use crate::program::UNKNOWN;

/// The kind of a machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Machine {
    /// The processor's architecture, such as `x86_64`.
    pub architecture: String,
    /// The operating system, such as `linux`.
    pub system: String,
    /// The processor, in its own words; `unknown` where the system does not say.
    pub processor: String,
}

impl Machine {
    /// This one.
    pub fn here() -> Self {
        let cpu = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = cpu.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
        Self {
            architecture: consts::ARCH.to_owned(),
            system: consts::OS.to_owned(),
            processor: model.map_or(UNKNOWN, |(_, model)| model.trim()).to_owned(),
        }
    }

    /// One of which nothing is known.
    pub fn unknown() -> Self {
        let [architecture, system, processor] = [UNKNOWN; 3].map(str::to_owned);
        Self { architecture, system, processor }
    }
}
