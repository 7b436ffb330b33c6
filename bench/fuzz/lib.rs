//! Fuzzers ask of every input what the bounded tests ask of theirs.

#[path = "../tests/all/strangers/checks.rs"]
pub mod checks;
