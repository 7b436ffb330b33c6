//! What a node does: a movement primitive in the frame of its reference object, with the gripper commands on the way.

use std::sync::Arc;

use nalgebra::Translation3;
use rand::Rng;
use serde::Serialize;

use super::dmp::{Dmp, STEPS, at_even_times};
use super::recording::{Frame, RATE};
use super::run::Run;
use crate::demonstration::{Gripper, Pose};
use crate::keyframe::policy::Execution;
use crate::keyframe::pose::{Tangent, exp, karcher_mean, log};
use crate::random::standard_normal;
use crate::segment::RelativeKeyframe;

/// Seconds from waypoint to waypoint.
const WAYPOINT_SECONDS: f64 = 0.5;
/// The greatest deviation of a sampled start or goal, as in decision D15: 5 mm (3), and 2° in radians (3).
const GREATEST_DEVIATION: [f64; 6] = [0.005, 0.005, 0.005, 0.034_9, 0.034_9, 0.034_9];
/// A draw beyond so many deviations is drawn again: one in twenty.
const GREATEST_DRAW: f64 = 2.0;
/// Two commands of one kind are different if their values differ by more than this share.
const SAME_COMMAND: f64 = 0.1;

/// A keyframe of the execution: its place on the movement, and what happens there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Waypoint {
    /// The step of the movement, 1 to [`STEPS`].
    step: usize,
    /// The command in force from here on.
    gripper: Gripper,
    /// Seconds of rest: the mean over the runs.
    hold: f64,
}

/// The mean and the deviation of starts or goals.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct End {
    mean: Tangent,
    deviation: Tangent,
}

/// A skill.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Skill {
    /// The reference object. Everything here is in its frame, as it is when the skill begins.
    pub(super) reference: Arc<str>,
    /// The mean rotation of the goals, at which rotation vectors are taken.
    base: Pose,
    dmp: Dmp<6>,
    start: End,
    goal: End,
    waypoints: Vec<Waypoint>,
}

impl Skill {
    /// Fits the skill to these runs on one object, at least one run, each with its recording.
    pub(super) fn fit(reference: Arc<str>, runs: &[(&Run, &[Frame])]) -> Self {
        // A run begins where the run before it ended.
        let frames: Vec<&[Frame]> =
            runs.iter().map(|(run, frames)| &frames[run.stretch.start.saturating_sub(1)..run.stretch.end]).collect();
        let relative: Vec<Vec<Pose>> = runs
            .iter()
            .zip(&frames)
            .map(|((run, all), frames)| frames.iter().map(|frame| all[run.first].object.inv_mul(&frame.pose)).collect())
            .collect();
        let goals: Vec<Pose> = relative.iter().filter_map(|poses| poses.last().copied()).collect();
        let mean = karcher_mean(&goals, &vec![1.0; goals.len()]);
        let base = Pose::from_parts(Translation3::identity(), mean.rotation);
        let trajectories: Vec<Vec<Tangent>> =
            relative.iter().map(|poses| poses.iter().map(|pose| log(&base, pose)).collect()).collect();
        let ends = |at: fn(&[Tangent]) -> Tangent| End::of(&trajectories.iter().map(|one| at(one)).collect::<Vec<_>>());
        Self {
            reference,
            base,
            start: ends(|points| at_even_times(points, 1)[0]),
            goal: ends(|points| at_even_times(points, 1)[1]),
            dmp: Dmp::fit(&trajectories),
            waypoints: waypoints(&frames),
        }
    }

    /// The keyframes of one execution, relative to the reference object: waypoints of the movement's rollout. A sample
    /// draws its start and its goal from the scatter of those of the runs.
    pub(super) fn keyframes(&self, execution: Execution, rng: &mut impl Rng) -> Vec<RelativeKeyframe> {
        let mut end = |end: &End| match execution {
            Execution::Mean => end.mean,
            Execution::Sample => end.draw(rng),
        };
        let (start, goal) = (end(&self.start), end(&self.goal));
        self.between(&start, &goal)
    }

    /// The poses of the mean execution.
    pub(super) fn mean_path(&self) -> Vec<Pose> {
        self.between(&self.start.mean, &self.goal.mean).into_iter().map(|keyframe| keyframe.pose).collect()
    }

    fn between(&self, start: &Tangent, goal: &Tangent) -> Vec<RelativeKeyframe> {
        let points = self.dmp.rollout(start, goal);
        let keyframe = |waypoint: &Waypoint| {
            // The last waypoint is where the movement has settled.
            let point = if waypoint.step == STEPS { STEPS + 1 } else { waypoint.step };
            RelativeKeyframe { pose: exp(&self.base, &points[point]), gripper: waypoint.gripper, hold: waypoint.hold }
        };
        self.waypoints.iter().map(keyframe).collect()
    }
}

impl End {
    fn of(points: &[Tangent]) -> Self {
        let count = points.len() as f64;
        let mean = points.iter().sum::<Tangent>() / count;
        let squares: Tangent = points.iter().map(|point| (point - mean).component_mul(&(point - mean))).sum();
        Self { mean, deviation: Tangent::from_fn(|axis, _| libm::sqrt(squares[axis] / count)) }
    }

    fn draw(&self, rng: &mut impl Rng) -> Tangent {
        let mut normal = || loop {
            let normal = standard_normal(rng);
            if normal.abs() <= GREATEST_DRAW {
                return normal;
            }
        };
        Tangent::from_fn(|axis, _| self.mean[axis] + normal() * self.deviation[axis].min(GREATEST_DEVIATION[axis]))
    }
}

/// The waypoints: even in time, with the end, and wherever the command changes. The command at a step is that of most
/// runs.
fn waypoints(runs: &[&[Frame]]) -> Vec<Waypoint> {
    let at = |frames: &[Frame], step: usize| (step * (frames.len() - 1) + STEPS / 2) / STEPS;
    let command = |step: usize| majority(runs.iter().map(|frames| frames[at(frames, step)].command));
    let commands: Vec<Gripper> = (0..=STEPS).filter_map(command).collect();
    let seconds = runs.iter().map(|frames| (frames.len() - 1) as f64 / RATE).sum::<f64>() / runs.len() as f64;
    let count = (libm::ceil(seconds / WAYPOINT_SECONDS) as usize).clamp(1, STEPS);
    let mut steps: Vec<usize> = (1..=count).map(|number| number * STEPS / count).collect();
    steps.extend((1..commands.len()).filter(|step| !is_same(commands[step - 1], commands[*step])));
    steps.sort_unstable();
    steps.dedup();
    let mut waypoints: Vec<Waypoint> =
        steps.into_iter().map(|step| Waypoint { step, gripper: commands[step], hold: 0.0 }).collect();
    for frames in runs {
        for (index, frame) in frames.iter().enumerate().filter(|(_, frame)| frame.rest > 0.0) {
            let step = index * STEPS / (frames.len() - 1).max(1);
            if let Some(nearest) = waypoints.iter_mut().min_by_key(|waypoint| waypoint.step.abs_diff(step)) {
                nearest.hold += frame.rest / runs.len() as f64;
            }
        }
    }
    waypoints
}

/// The most frequent kind of command, the first of equals, with the mean value of that kind.
fn majority(commands: impl Iterator<Item = Gripper> + Clone) -> Option<Gripper> {
    let alike = |command: Gripper| {
        commands.clone().filter(move |other| core::mem::discriminant(other) == core::mem::discriminant(&command))
    };
    let most =
        commands.clone().reduce(|best, other| if alike(other).count() > alike(best).count() { other } else { best })?;
    let mean = alike(most).map(Gripper::value).sum::<f64>() / alike(most).count() as f64;
    Some(match most {
        Gripper::Opening(_) => Gripper::Opening(mean),
        Gripper::Open(_) => Gripper::Open(mean),
        Gripper::Close(_) => Gripper::Close(mean),
    })
}

fn is_same(left: Gripper, right: Gripper) -> bool {
    let greatest = left.value().abs().max(right.value().abs());
    core::mem::discriminant(&left) == core::mem::discriminant(&right)
        && (left.value() - right.value()).abs() <= SAME_COMMAND * greatest
}

#[cfg(test)]
mod tests {
    use super::super::recording::tests::shown;
    use super::*;

    /// A movement of 1 m with a grip in its middle: waypoints every half second and at the grip, which holds from there
    /// on; and a rest is the mean over the runs.
    #[test]
    fn waypoints_are_even_and_where_the_command_changes() {
        let (open, shut) = (Gripper::Open(0.08), Gripper::Close(20.0));
        let run = |hold: f64| shown(&[(0.0, open, 0.0), (0.5, shut, hold), (1.0, shut, 0.0)]);
        let (short, long) = (run(1.0), run(3.0));
        let alone = waypoints(&[&short]);
        let change = alone.iter().position(|waypoint| waypoint.gripper == shut).expect("it closes");
        // 2 s of way, 1 s of rest, 2 s of way: it closes when two fifths of the time are over.
        assert!(alone[change].step.abs_diff(2 * STEPS / 5) <= 2, "{alone:?}");
        assert!(alone[..change].iter().all(|waypoint| waypoint.gripper == open), "{alone:?}");
        assert!(alone[change..].iter().all(|waypoint| waypoint.gripper == shut), "{alone:?}");
        assert_eq!(alone.last().map(|waypoint| waypoint.step), Some(STEPS));
        let apart = alone.windows(2).map(|pair| pair[1].step - pair[0].step);
        assert!(apart.into_iter().all(|steps| (1..=STEPS / 10).contains(&steps)), "{alone:?}");
        for (runs, mean) in [(vec![&short], 1.0), (vec![&short, &long], 2.0), (vec![&long, &long, &short], 7.0 / 3.0)] {
            let runs: Vec<&[Frame]> = runs.into_iter().map(Vec::as_slice).collect();
            let holds: f64 = waypoints(&runs).iter().map(|waypoint| waypoint.hold).sum();
            assert!((holds - mean).abs() < 1e-12, "{holds} is not {mean}");
        }
    }
}
