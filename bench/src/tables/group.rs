//! The groups of runs that a pooled row is over.

use situ::edit::Edit;

use crate::record::RunRecord;

/// Runs that are pooled: all that need an edit, and those that need one of a kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Group {
    /// Every edit.
    All,
    /// Every edit but an edge from a skill to itself: a retry, which is nothing new to show.
    ButSelfLoops,
    /// Node additions.
    NodeAddition,
    /// Edges from a skill to itself.
    SelfLoop,
    /// Edges between two skills.
    OtherEdge,
    /// Node modifications.
    NodeModification,
}

impl Group {
    /// The groups that a run is in; none where no edit is needed.
    pub(super) fn of(run: &RunRecord) -> impl Iterator<Item = Self> {
        let own = match run.key.edit {
            Edit::None => None,
            Edit::NodeAddition => Some(Self::NodeAddition),
            Edit::EdgeAddition if run.self_loop => Some(Self::SelfLoop),
            Edit::EdgeAddition => Some(Self::OtherEdge),
            Edit::NodeModification => Some(Self::NodeModification),
        };
        let pooled = own.map(|_| Self::All).into_iter();
        pooled.chain(own.filter(|own| *own != Self::SelfLoop).map(|_| Self::ButSelfLoops)).chain(own)
    }

    /// Its name in tables.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::ButSelfLoops => "all but self-loops",
            Self::NodeAddition => "node-addition",
            Self::SelfLoop => "edge-addition: self-loop",
            Self::OtherEdge => "edge-addition: other",
            Self::NodeModification => "node-modification",
        }
    }
}
