//! The harness.
pub mod archive;
pub mod cmd;
pub mod cost;
pub mod demonstration_file;
pub mod error;
pub mod files;
mod json_lines;
pub mod ledger;
pub mod pictures;
pub mod protocol;
pub mod record;
pub mod rollout;
pub mod runner;
pub mod session;
pub mod stats;
pub mod synthetic;
pub mod tables;
