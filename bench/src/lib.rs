//! The harness.
pub mod archive;
pub mod error;
pub mod ledger;
pub mod record;
pub mod stats;
pub mod tables;
pub mod cost;
pub mod protocol;
pub mod rollout;
pub mod runner;
pub mod session;
pub mod cmd;
pub mod demonstration_file;
pub mod files;
mod json_lines;
pub mod synthetic;
