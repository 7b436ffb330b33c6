//! Where the arm's links are at given angles, and at which angles the hand is at a given pose.

use nalgebra::{Matrix6, SMatrix, Vector3, Vector6};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::arm::model::{ArmModel, Configuration, JOINTS};
use crate::frame::{Pose, pose_at, rotation_about};

/// The hand's velocity (m/s, then rad/s, world frame) for the velocity of each joint (rad/s), shape (6, JOINTS).
type Jacobian = SMatrix<f64, 6, JOINTS>;

/// Iterations of a solution that starts anywhere.
const ITERATIONS: usize = 120;
/// A solution is so near to its target: metres, and the same number of radians.
const TOLERANCE: f64 = 1e-7;
/// What is left of the damping at the target itself, squared.
const LEAST_DAMPING: f64 = 1e-10;
/// The damping, squared, as a part of the squared error (Sugihara, "Solvability-unconcerned inverse kinematics", 2011).
const DAMPING: f64 = 0.05;
/// No joint turns by more than this in an iteration, radians: beyond it the linear step means nothing.
const LONGEST_STEP: f64 = 0.4;
/// How readily each joint moves. The third, a roll of the upper arm, swings the elbow out. It is the one to spare, and
/// moves last.
const READINESS: [f64; JOINTS] = [1.0, 1.0, 0.1, 1.0, 1.0, 1.0, 1.0];
/// In so many first iterations the spare joint is drawn to the rest position. Else it wanders off to a limit on a long
/// way.
const DRAWN: usize = 3;
/// It is drawn by this part of what is missing.
const REST_GAIN: f64 = 0.1;
/// It is drawn by no more than this in an iteration, radians. A way is followed in steps of a centimetre, and there the
/// draws make 0.9 rad/s at most.
const LONGEST_DRAW: f64 = 0.012;
/// Starts drawn at random, after the given one and the rest position.
const RESTARTS: usize = 24;

/// Where everything is at a configuration, in the world.
pub(crate) struct Posture {
    /// The frame of the link after each joint.
    pub(crate) links: [Pose; JOINTS],
    /// The tool centre point.
    pub(crate) tcp: Pose,
}

impl ArmModel {
    /// Where everything is at these angles.
    pub(crate) fn posture(&self, configuration: &Configuration) -> Posture {
        let mut frame = self.mount;
        let links = std::array::from_fn(|index| {
            let joint = &self.joints[index];
            frame *=
                joint.origin * pose_at([0.0; 3], rotation_about(joint.axis.into_inner().into(), configuration[index]));
            frame
        });
        Posture { links, tcp: frame * self.tool }
    }

    /// The pose of the tool centre point at these angles: metres, world frame.
    pub fn tcp(&self, configuration: &Configuration) -> Pose {
        self.posture(configuration).tcp
    }

    fn jacobian(&self, posture: &Posture) -> Jacobian {
        let at = posture.tcp.translation.vector;
        let mut jacobian = Jacobian::zeros();
        for (index, (joint, link)) in self.joints.iter().zip(&posture.links).enumerate() {
            let axis = link.rotation * joint.axis.into_inner();
            let velocity = axis.cross(&(at - link.translation.vector));
            jacobian.fixed_view_mut::<3, 1>(0, index).copy_from(&velocity);
            jacobian.fixed_view_mut::<3, 1>(3, index).copy_from(&axis);
        }
        jacobian
    }

    /// The angles near `start` at which the hand is at `target`, within the joints' ranges: weighted and damped least
    /// squares (Nakamura and Hanafusa 1986; Wampler 1986), the spare joint drawn to `rest`. None where it does not
    /// converge.
    pub(crate) fn solve(&self, target: &Pose, start: &Configuration, rest: &Configuration) -> Option<Configuration> {
        let mut angles = *start;
        for iteration in 0..ITERATIONS {
            let posture = self.posture(&angles);
            let error = error(&posture.tcp, target);
            if error.amax() < TOLERANCE {
                return self.allows(&angles).then_some(angles);
            }
            let jacobian = self.jacobian(&posture);
            let damping = DAMPING * error.norm_squared() + LEAST_DAMPING;
            let mut ready = jacobian.transpose();
            ready.row_iter_mut().zip(READINESS).for_each(|(mut row, readiness)| row *= readiness);
            let square: Matrix6<f64> = jacobian * ready + Matrix6::identity() * damping;
            let inverse = square.cholesky()?;
            let drawn = if iteration < DRAWN { REST_GAIN } else { 0.0 };
            let idle = (rest - angles).map(|way| (drawn * way).clamp(-LONGEST_DRAW, LONGEST_DRAW));
            let mut step = ready * inverse.solve(&(error - jacobian * idle)) + idle;
            let longest = step.amax();
            if longest > LONGEST_STEP {
                step *= LONGEST_STEP / longest;
            }
            for (index, joint) in self.joints.iter().enumerate() {
                angles[index] = (angles[index] + step[index]).clamp(joint.lower, joint.upper);
            }
        }
        None
    }

    /// Configurations at which the hand is at `target`: from `start`, from `rest`, and from starts drawn at random with
    /// `seed`. There are none if it is out of reach.
    pub(crate) fn solutions<'a>(
        &'a self,
        target: &'a Pose,
        start: &Configuration,
        rest: &'a Configuration,
        seed: u64,
    ) -> impl Iterator<Item = Configuration> + 'a {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let drawn = (0..RESTARTS).map(move |_| self.draw(&mut rng));
        [*start, *rest].into_iter().chain(drawn).filter_map(move |from| self.solve(target, &from, rest))
    }

    /// Any configuration within the joints' ranges, all equally likely.
    fn draw(&self, rng: &mut ChaCha8Rng) -> Configuration {
        Configuration::from_fn(|index, _| {
            let joint = &self.joints[index];
            joint.lower + (joint.upper - joint.lower) * rng.random::<f64>()
        })
    }
}

/// What is missing from one pose to another: metres, then radians about the world's axes.
fn error(from: &Pose, to: &Pose) -> Vector6<f64> {
    let way = to.translation.vector - from.translation.vector;
    let turn = (to.rotation * from.rotation.inverse()).into_inner();
    let turn = if turn.w < 0.0 { -turn } else { turn };
    let sine = turn.imag().norm();
    // The angle over its sine; both vanish together.
    let scale = if sine > 1e-12 { 2.0 * libm::atan2(sine, turn.w) / sine } else { 2.0 };
    let turn: Vector3<f64> = turn.imag() * scale;
    Vector6::new(way.x, way.y, way.z, turn.x, turn.y, turn.z)
}
