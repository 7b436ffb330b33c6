//! What of an import looks like a mistake: units, the order of quaternions, a gripper that never closes. Nothing of it
//! is refused, for a recording may be so.

use nalgebra::Vector3;
use situ::demonstration::Gripper;

use crate::import::drawn::Drawn;

/// No tool of an arm on a table is farther from what it is about, metres.
const FAR: f64 = 2.0;
/// No gripper of such an arm opens wider, metres.
const WIDE: f64 = 0.5;
/// Frames are not nearer in time, seconds.
const DENSE: f64 = 1e-4;

/// The lines about a demonstration: where the tool points, and each doubt.
pub(super) fn of(drawn: &Drawn<'_>) -> String {
    let frames = drawn.frames;
    let mut text = String::new();
    let mut say = |line: &str| text.push_str(&format!("  {line}\n"));
    if let Some(first) = drawn.keyframes.first() {
        let hand = &frames[first.picked.frame].hand;
        // Without the sign of a zero.
        let [x, y, z]: [f64; 3] =
            (hand.rotation * Vector3::z()).map(|part| (100.0 * part).round() / 100.0 + 0.0).into();
        say(&format!(
            "the gripper's z axis at keyframe 0 points along ({x:.2}, {y:.2}, {z:.2}); -1 at the end is down"
        ));
    }
    let far = drawn.keyframes.iter().map(|keyframe| {
        let frame = &frames[keyframe.picked.frame];
        (frame.objects[keyframe.about.object].translation.vector - frame.hand.translation.vector).norm()
    });
    let far = far.fold(0.0, f64::max);
    if far > FAR {
        say(&format!(
            "doubtful: {far:.1} m from the gripper to a reference object; see `units.length` and the columns"
        ));
    }
    let widths = drawn.keyframes.iter().filter_map(|keyframe| match keyframe.gripper {
        Gripper::Open(metres) => Some(metres),
        _ => None,
    });
    let widest = widths.fold(0.0, f64::max);
    if widest > WIDE {
        say(&format!("doubtful: the gripper opens by {widest:.1} m; see `opening.unit`"));
    }
    let is_closed = |gripper: Gripper| matches!(gripper, Gripper::Close(_)) || gripper == Gripper::Opening(0.0);
    let has_opening = frames.iter().any(|frame| frame.opening.is_some());
    if has_opening && !drawn.keyframes.iter().any(|keyframe| is_closed(keyframe.gripper)) {
        say("doubtful: the gripper never closes; see `opening.unit` and `opening.close_below`");
    }
    let seconds = frames.last().map_or(0.0, |last| last.seconds - frames[0].seconds);
    if frames.len() > 1 && seconds < DENSE * (frames.len() - 1) as f64 {
        say(&format!("doubtful: {} frames in {seconds:.4} s; see `units.time`", frames.len()));
    }
    text
}
