//! What this process has simulated already: the last starts and snapshots, so that they are there at once when they are
//! asked for again.

use std::collections::VecDeque;
use std::sync::Arc;

use situ_tasks::{Episode, Setting, TaskError};

use super::served::Served;

/// The most snapshots that are kept.
const MOST: usize = 64;
/// The bytes that they may take.
const ROOM: usize = 256 << 20;
/// The most starts that are kept.
const MOST_STARTS: usize = 32;

/// Starts by setting and seed, and snapshots by their texts; the last one at the end.
#[derive(Default)]
pub(super) struct Shelf {
    starts: VecDeque<(u64, Arc<Episode>)>,
    kept: VecDeque<(String, Served)>,
}

impl Shelf {
    /// The episode of a setting at its start.
    ///
    /// # Errors
    /// Where the physics refuses it.
    pub(super) fn start(&mut self, setting: &Arc<Setting>, seed: u64) -> Result<Arc<Episode>, TaskError> {
        let is_it = |(own, start): &&(u64, Arc<Episode>)| *own == seed && Arc::ptr_eq(start.setting(), setting);
        if let Some((_, start)) = self.starts.iter().find(is_it) {
            return Ok(Arc::clone(start));
        }
        let start = Arc::new(Episode::start(setting, seed)?);
        self.starts.push_back((seed, Arc::clone(&start)));
        if self.starts.len() > MOST_STARTS {
            self.starts.pop_front();
        }
        Ok(start)
    }

    /// The episode of a text; `None` where it is not kept.
    pub(super) fn find(&self, text: &str) -> Option<&Served> {
        self.kept.iter().find(|(own, _)| own == text).map(|(_, served)| served)
    }

    /// Keeps an episode, and drops the oldest where there is no room for all.
    pub(super) fn keep(&mut self, text: &str, served: &Served) {
        if self.find(text).is_some() {
            return;
        }
        self.kept.push_back((text.to_owned(), served.clone()));
        while self.kept.len() > MOST || self.bytes() > ROOM {
            self.kept.pop_front();
        }
    }

    fn bytes(&self) -> usize {
        self.kept.iter().map(|(text, served)| text.len() + served.bytes()).sum()
    }
}
