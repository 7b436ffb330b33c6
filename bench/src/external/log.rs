//! What an external method says on its standard error.

use std::collections::VecDeque;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use situ_tasks::name::one_line;

use crate::cmd::say;

/// Lines that stand in an error's message.
const LAST: usize = 5;
/// Letters of each of them.
const LONGEST: usize = 300;
/// Bytes of a log. A sweep of days is not to fill the disk with them.
const MOST_BYTES: usize = 16 << 20;

/// Where the standard error of a method's processes goes: to the user, until there is a file for it.
#[derive(Debug)]
pub(super) struct Log {
    method: String,
    path: OnceLock<PathBuf>,
    file: Mutex<Option<(File, usize)>>,
}

impl Log {
    pub(super) fn new(method: &str) -> Self {
        Self { method: method.to_owned(), path: OnceLock::new(), file: Mutex::new(None) }
    }

    /// From now on lines go to a file of the method's name in this folder, which is made with the first of them.
    pub(super) fn write_into(&self, folder: &Path) {
        let _ = self.path.set(folder.join(format!("{}.log", self.method)));
    }

    /// Writes a line. A log that cannot be written is no failure of the method.
    pub(super) fn line(&self, text: &str) {
        let Some(path) = self.path.get() else { return say(&format!("{}: {text}", self.method)) };
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        if file.is_none() {
            let _ = path.parent().map(std::fs::create_dir_all);
            *file = OpenOptions::new().create(true).append(true).open(path).ok().map(|file| (file, 0));
        }
        let Some((file, written)) = file.as_mut() else { return };
        if *written < MOST_BYTES {
            *written += text.len() + 1;
            let end = if *written < MOST_BYTES { "" } else { "The log is full.\n" };
            let _ = file.write_all(format!("{text}\n{end}").as_bytes());
        }
    }
}

/// The last lines that one process said, and whether it says no more.
#[derive(Debug, Default)]
pub(super) struct Tail {
    lines: Mutex<VecDeque<String>>,
    has_ended: AtomicBool,
}

impl Tail {
    pub(super) fn push(&self, line: &str) {
        let mut lines = self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        // Underlined places, as in the traces of Python, say nothing on one line.
        let says_something = line.chars().any(|letter| !matches!(letter, '^' | '~') && !letter.is_whitespace());
        lines.extend(says_something.then(|| one_line(line.trim()).chars().take(LONGEST).collect()));
        while lines.len() > LAST {
            lines.pop_front();
        }
    }

    /// Nothing more is said.
    pub(super) fn end(&self) {
        self.has_ended.store(true, Ordering::Relaxed);
    }

    pub(super) fn has_ended(&self) -> bool {
        self.has_ended.load(Ordering::Relaxed)
    }

    /// For the end of a message; empty where nothing was said.
    pub(super) fn words(&self) -> String {
        let lines = self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
        if lines.is_empty() { String::new() } else { format!("; its last words: {}", lines.join(" | ")) }
    }
}
