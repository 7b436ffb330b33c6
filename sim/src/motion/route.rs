//! Routes of the hand: straight to a pose, or along a way that its arm has found. Their course in time.

use std::sync::Arc;

use crate::arm::{ArmModel, Configuration};
use crate::frame::{Pose, angle_of, between};
use crate::step::DT;

/// The hand's largest speed in m/s.
pub const MAX_SPEED: f64 = 0.25;
/// The hand's largest rate of turning in rad/s.
pub const MAX_TURN: f64 = 1.5;
/// The time between two configurations is so many times what their poses ask for: the hand does not go straight in
/// between.
const SLACK: f64 = 1.2;

/// Where the hand and its arm are at a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    pub(crate) tcp: Pose,
    /// The joints' angles, if there is an arm.
    pub(crate) configuration: Option<Configuration>,
}

/// A way from one place to another.
pub(crate) enum Route {
    /// Straight in position, spherical in rotation.
    Straight {
        from: Pose,
        to: Pose,
        /// The arm's configurations at equal parts of the way, its two ends among them; empty without an arm.
        joints: Vec<Configuration>,
        /// Seconds at full speed.
        length: f64,
    },
    /// Straight in the joints' angles, piece by piece. The hand goes where the arm takes it.
    Joints {
        model: Arc<ArmModel>,
        /// Configurations with the seconds at full speed until each; the first has 0.
        marks: Vec<(f64, Configuration)>,
        /// The pose at which it ends, to the last bit.
        to: Pose,
    },
}

/// Seconds between two poses at the hand's full speed.
fn seconds_between(from: &Pose, to: &Pose) -> f64 {
    let distance = (to.translation.vector - from.translation.vector).norm();
    let angle = angle_of(&(from.rotation.inverse() * to.rotation));
    (distance / MAX_SPEED).max(angle / MAX_TURN)
}

impl Route {
    /// The straight way of a hand that nothing carries.
    pub(crate) fn free(from: Pose, to: Pose) -> Route {
        Route::Straight { from, to, joints: Vec::new(), length: seconds_between(&from, &to) }
    }

    /// The straight way, followed by an arm at these configurations. It is as fast as the hand may go where every joint
    /// keeps up, else slower.
    pub(crate) fn straight(from: Pose, to: Pose, joints: Vec<Configuration>, model: &ArmModel) -> Route {
        let pieces = joints.len().saturating_sub(1).max(1) as f64;
        let slowest = joints.windows(2).map(|pair| model.seconds_between(&pair[0], &pair[1])).fold(0.0, f64::max);
        Route::Straight { from, to, length: seconds_between(&from, &to).max(slowest * pieces), joints }
    }

    /// A way through configurations, which ends at the pose `to`.
    pub(crate) fn through(way: &[Configuration], to: Pose, model: &Arc<ArmModel>) -> Route {
        let mut marks = Vec::with_capacity(way.len());
        let mut at = 0.0;
        for (index, configuration) in way.iter().enumerate() {
            if let Some(before) = index.checked_sub(1).map(|before| &way[before]) {
                let hand = seconds_between(&model.tcp(before), &model.tcp(configuration));
                at += SLACK * hand.max(model.seconds_between(before, configuration));
            }
            marks.push((at, *configuration));
        }
        Route::Joints { model: Arc::clone(model), marks, to }
    }

    /// Seconds at full speed.
    pub(crate) fn length(&self) -> f64 {
        match self {
            Route::Straight { length, .. } => *length,
            Route::Joints { marks, .. } => marks.last().map_or(0.0, |mark| mark.0),
        }
    }

    /// The place when a part of the way is done, from 0 to 1.
    pub(crate) fn at(&self, part: f64) -> Place {
        match self {
            Route::Straight { from, to, joints, .. } => {
                let tcp = if part >= 1.0 { *to } else { between(from, to, part) };
                Place { tcp, configuration: on_the_way(joints, part) }
            }
            Route::Joints { model, marks, to } => {
                let time = part * self.length();
                let next = marks.partition_point(|mark| mark.0 < time).clamp(1, marks.len().max(2) - 1);
                let Some(&[(before, from), (after, until)]) = marks.get(next - 1..=next) else {
                    return Place { tcp: *to, configuration: marks.last().map(|mark| mark.1) };
                };
                let piece = if after > before { ((time - before) / (after - before)).clamp(0.0, 1.0) } else { 1.0 };
                let configuration = from + (until - from) * piece;
                let tcp = if part >= 1.0 { *to } else { model.tcp(&configuration) };
                Place { tcp, configuration: Some(configuration) }
            }
        }
    }
}

/// The configuration at a part of a way that is given at equal parts.
fn on_the_way(joints: &[Configuration], part: f64) -> Option<Configuration> {
    let last = joints.len().checked_sub(1)?;
    let at = part.clamp(0.0, 1.0) * last as f64;
    let index = (at as usize).min(last.saturating_sub(1));
    let (from, to) = (joints[index], joints[(index + 1).min(last)]);
    Some(from + (to - from) * (at - index as f64))
}

/// Time in which the hand reaches its largest speed, seconds.
const RAMP: f64 = 0.15;

/// A course in time from 0 to 1: speeding up evenly, going evenly, slowing down evenly.
pub(super) struct Course {
    /// Length of the way in seconds at full speed.
    length: f64,
    /// Seconds until full speed (or half of the time, if it is never reached).
    ramp: f64,
    /// Seconds in all.
    duration: f64,
    /// Steps in all.
    pub(super) steps: usize,
}

impl Course {
    /// The course of a way that takes so many seconds at full speed.
    pub(super) fn new(length: f64) -> Course {
        let (ramp, duration) = if length >= RAMP {
            (RAMP, length + RAMP)
        } else {
            let ramp = libm::sqrt(length * RAMP);
            (ramp, 2.0 * ramp)
        };
        Course { length, ramp, duration, steps: libm::ceil(duration / DT) as usize }
    }

    /// The part of the way that is done after so many steps.
    pub(super) fn way(&self, step: usize) -> f64 {
        let time = self.duration * step as f64 / self.steps as f64;
        let left = self.duration - time;
        let speeding = |t: f64| 0.5 * t * t / RAMP;
        let done = if time < self.ramp {
            speeding(time)
        } else if left < self.ramp {
            self.length - speeding(left)
        } else {
            speeding(self.ramp) + (time - self.ramp)
        };
        (done / self.length).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_is_smooth_and_keeps_its_limits() {
        for length in [1e-6, 0.02, 0.149, 0.15, 0.4, 3.0] {
            let course = Course::new(length);
            let ways: Vec<f64> = (0..=course.steps).map(|k| course.way(k)).collect();
            assert!(ways[0].abs() < 1e-12 && (ways[course.steps] - 1.0).abs() < 1e-12);
            let pace = course.duration / course.steps as f64;
            for pair in ways.windows(2) {
                let speed = (pair[1] - pair[0]) * length / pace;
                assert!((-1e-9..=1.0 + 1e-9).contains(&speed), "{length}: {speed}");
            }
            for three in ways.windows(3) {
                let change = (three[2] - 2.0 * three[1] + three[0]).abs() * length / (pace * pace);
                assert!(change <= 1.0 / RAMP + 1e-6, "{length}: {change}");
            }
        }
        assert_eq!(Course::new(0.0).steps, 0);
    }
}
