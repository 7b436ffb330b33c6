//! The kinds of TOML files that users write, so that one in the place of another is called what it is.

use toml::de::DeTable;

/// A kind of file, told by the keys that only it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A task family.
    Task,
    /// A protocol of runs.
    Protocol,
    /// Profiles of teachers.
    Teachers,
    /// Methods that are programs of their own.
    Methods,
}

impl FileKind {
    const ALL: [Self; 4] = [Self::Task, Self::Protocol, Self::Teachers, Self::Methods];

    /// What it is, and the option that takes it.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Task => ("a task", "--tasks, which takes its folder"),
            Self::Protocol => ("a protocol", "--protocol"),
            Self::Teachers => ("a file of teachers", "--teachers"),
            Self::Methods => ("a file of methods", "--methods"),
        }
    }

    /// The key at its root that no other kind has.
    fn mark(self) -> &'static str {
        match self {
            Self::Task => "goal",
            Self::Protocol => "methods",
            Self::Teachers => "profile",
            Self::Methods => "method",
        }
    }

    /// The key that shows that a file is of another kind, and what to do with it; `None` where it may be of this kind.
    pub(crate) fn mistaken(self, root: &DeTable<'_>) -> Option<(&'static str, String)> {
        let has = |kind: Self| root.contains_key(kind.mark());
        let other = Self::ALL.into_iter().filter(|_| !has(self)).find(|kind| has(*kind))?;
        let ((own, _), (what, option)) = (self.words(), other.words());
        Some((other.mark(), format!("this is {what}, expected {own}: give it to {option}")))
    }
}
