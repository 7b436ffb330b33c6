//! When a watching teacher stops the robot.

use crate::moment::Moment;
use crate::predicate::Predicate;

/// A moment at which a watching teacher stops the robot. It is for teaching alone: an evaluation is never interrupted,
/// and no feature shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Intervention {
    /// What the teacher would say.
    pub name: String,
    /// When the teacher looks.
    pub moment: Moment,
    /// The reference object of the primitive that is about to run, runs, or has just run. None: any object.
    pub reference: Option<String>,
    /// What the teacher sees then.
    pub when: Predicate,
}
