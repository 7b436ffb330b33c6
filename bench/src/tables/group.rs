//! The groups of runs that a pooled row is over.

use situ::edit::Edit;

use crate::record::RunRecord;
use crate::shown::ShownList;

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
    /// Node modifications where what is observed shows the change, by the committed list.
    ModificationShown,
    /// Node modifications where it does not.
    ModificationNotShown,
    /// Every edit, where what is observed shows the change.
    Shown,
    /// Every edit, where it does not.
    NotShown,
}

impl Group {
    /// The groups that a run is in; none where no edit is needed. One of a task that is on no list of what is shown is
    /// in no group of those.
    pub(super) fn of(run: &RunRecord) -> impl Iterator<Item = Self> {
        let own = match run.key.edit {
            Edit::None => None,
            Edit::NodeAddition => Some(Self::NodeAddition),
            Edit::EdgeAddition if run.self_loop => Some(Self::SelfLoop),
            Edit::EdgeAddition => Some(Self::OtherEdge),
            Edit::NodeModification => Some(Self::NodeModification),
        };
        let shown = own.and_then(|_| ShownList::committed().is_shown(&run.key.task, &run.key.variation));
        let (modification, any) = match shown {
            Some(true) => (Self::ModificationShown, Self::Shown),
            _ => (Self::ModificationNotShown, Self::NotShown),
        };
        let groups = [
            own.map(|_| Self::All),
            own.filter(|own| *own != Self::SelfLoop).map(|_| Self::ButSelfLoops),
            own,
            shown.filter(|_| own == Some(Self::NodeModification)).map(|_| modification),
            shown.map(|_| any),
        ];
        groups.into_iter().flatten()
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
            Self::ModificationShown => "node-modification: shown",
            Self::ModificationNotShown => "node-modification: not shown",
            Self::Shown => "all: shown",
            Self::NotShown => "all: not shown",
        }
    }
}
