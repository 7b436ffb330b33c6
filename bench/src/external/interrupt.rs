//! The user's interrupt, as whoever waits for another program hears it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

/// Whether the user wants to stop. The flag is made after the methods are: until then nobody can be heard.
#[derive(Clone, Debug, Default)]
pub(super) struct Interrupt {
    flag: Arc<OnceLock<Arc<AtomicBool>>>,
}

impl Interrupt {
    /// Heeds this flag from now on. The first one stays.
    pub(super) fn heed(&self, flag: &Arc<AtomicBool>) {
        let _ = self.flag.set(Arc::clone(flag));
    }

    /// Whether the flag is set.
    pub(super) fn is_set(&self) -> bool {
        self.flag.get().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }
}
