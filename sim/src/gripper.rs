//! Commands to the gripper, and what it can do.

use serde::{Deserialize, Serialize};

/// The largest distance of a finger's pad from the middle in metres.
pub(crate) const STROKE: f64 = 0.040;
/// The largest distance between the pads in metres.
pub const MAX_OPENING: f64 = 2.0 * STROKE;
/// The largest squeeze in newtons.
pub const MAX_SQUEEZE: f64 = 60.0;

/// A command to the gripper.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum GripperCommand {
    /// Open to this distance between the pads, metres (clamped to what the gripper can do).
    Open(f64),
    /// Close and press with this force, newtons on either side (clamped likewise).
    Close(f64),
}

impl GripperCommand {
    /// The command within what the gripper can do; none where it is not a number.
    pub(crate) fn clamped(self) -> Option<GripperCommand> {
        match self {
            GripperCommand::Open(width) if width.is_finite() => {
                Some(GripperCommand::Open(width.clamp(0.0, MAX_OPENING)))
            }
            GripperCommand::Close(force) if force.is_finite() => {
                Some(GripperCommand::Close(force.clamp(0.0, MAX_SQUEEZE)))
            }
            _ => None,
        }
    }
}
