//! T4: what an update costs, in physics and on synthetic automata.

use super::publication::Publication;
use super::{growth, latency, physics};

/// The publication.
pub(super) const T4: Publication = Publication {
    name: "t4",
    question: "What does an update cost, and how does that grow with the task model?",
    tables: |records| {
        vec![
            physics::table(records),
            growth::scaling(records),
            growth::slopes(records),
            growth::crossover(records),
            latency::table(records),
        ]
    },
};
