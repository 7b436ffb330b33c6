//! The program's verbs. Each has a file: its arguments, and what they do. Each returns the text that is to be printed.

pub mod ask;
pub mod check;
pub mod cost;
pub mod export;
mod folder;
pub mod import;
pub mod learn;
pub mod library;
mod lines;
pub mod list;
pub mod merge;
pub mod run;
pub mod serve;
pub mod show;
pub mod supersede;
pub mod tables;
mod terminal;
mod traces;

pub use terminal::say;
