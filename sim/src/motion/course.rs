//! The course of a motion in time: how much of its way is done after so many steps.

use crate::step::DT;

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
