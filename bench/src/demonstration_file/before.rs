//! Where the robot had stopped before a demonstration, in the words of a file.

use situ::place::SegmentId;
use situ::state::State;
use situ::trail::{PastStep, StepEnd};

use super::content::Instance;
use crate::stop::StopPoint;

/// Where the robot had stopped before a demonstration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Before {
    /// The primitive that ran last to its end; `None` for START.
    pub after: Option<Instance>,
    /// The primitive that was under way when it failed or was stopped, if one was.
    pub interrupted: Option<Instance>,
    /// What it had chosen, in order; empty where nobody wrote it down.
    pub trail: Vec<BeforeStep>,
}

/// A choice on the trail that led to a demonstration.
#[derive(Clone, Debug, PartialEq)]
pub struct BeforeStep {
    /// The world in which it was made.
    pub state: State,
    /// The primitive.
    pub primitive: Instance,
    /// How it ended.
    pub end: StepEnd,
}

impl Before {
    /// A stop in the words of a file; `shown` are the names of the earlier demonstrations in order.
    pub fn of(stop: &StopPoint, shown: &[&str]) -> Self {
        let instance = |SegmentId { demonstration, index }| Instance {
            demonstration: shown[demonstration as usize].to_owned(),
            segment: index,
        };
        let step =
            |step: &PastStep| BeforeStep { state: step.state.clone(), primitive: instance(step.of), end: step.end };
        Self {
            after: stop.last.map(instance),
            interrupted: stop.interrupted.map(instance),
            trail: stop.trail.iter().map(step).collect(),
        }
    }

    /// The primitives that it names, each with its key.
    pub(crate) fn named(&self) -> Vec<(String, &Instance)> {
        let after = self.after.iter().map(|instance| ("after".to_owned(), instance));
        let interrupted = self.interrupted.iter().map(|instance| ("interrupted".to_owned(), instance));
        let trail = self.trail.iter().enumerate();
        let trail = trail.map(|(index, step)| (format!("trail[{index}].primitive"), &step.primitive));
        after.chain(interrupted).chain(trail).collect()
    }
}
