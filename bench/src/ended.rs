//! How rollouts end.

use std::fmt;

/// How a rollout ended.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Ended {
    /// The model chose END.
    End,
    /// No child was probable enough.
    NoConfidentChild,
    /// The reference object of the chosen primitive was not there.
    ReferenceAbsent,
    /// A motion was aborted: the force on the hand was too great.
    Aborted,
    /// The arm could not hold the hand at a keyframe.
    OutOfReach,
    /// The arm found no free way to a keyframe.
    NoPlan,
    /// Time was up, or too many primitives ran.
    TimeOut,
    /// The watching teacher stopped the robot, for this reason.
    Stopped(String),
    /// The numbers of the physics were no longer sound. That is nobody's failure.
    Spoilt,
}

impl fmt::Display for Ended {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::End => "end",
            Self::NoConfidentChild => "no confident child",
            Self::ReferenceAbsent => "reference absent",
            Self::Aborted => "aborted",
            Self::OutOfReach => "out of reach",
            Self::NoPlan => "no plan",
            Self::TimeOut => "time-out",
            Self::Stopped(reason) => reason,
            Self::Spoilt => "spoilt",
        })
    }
}
