//! The hand: a palm that goes where it is told, and two fingers that press with a given force.
//!
//! The palm is kinematic. Each finger is a dynamic body on a rail with a force-based motor. The motors are coupled in
//! software, as one spindle couples the jaws of a real gripper. When they close, their common target is the *mean*
//! position of the fingers less F/k, so both press with F. The stiffness k holds the difference of the two: uncoupled
//! fingers drift sideways by a centimetre.
//!
//! Where nothing is near the fingers there is nothing to press on, and the palm carries them: they are kinematic, move
//! along their rails at the speed of the motors' target, and cost the solver nothing. They are dynamic again from the
//! step on that follows the one in which the broad phase finds a neighbour: before anything touches them, or at most
//! one step after that.

use nalgebra::{Translation3, Vector3};
use rapier3d::geometry::{Group, InteractionGroups, InteractionTestMode};
use rapier3d::prelude::{
    ActiveCollisionTypes, ColliderBuilder, ColliderHandle, GenericJointBuilder, ImpulseJointHandle, JointAxesMask,
    JointAxis, MotorModel, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle, RigidBodyPosition, RigidBodyType, Vector,
};
use serde::{Deserialize, Serialize};

use crate::error::{SimError, within};
use crate::frame::{Pose, from_engine, from_engine_vector, to_engine, to_engine_near};
use crate::step::DT;
use crate::tag::{HAND, Tag};

/// Half extents of the palm in metres.
const PALM_HALF: [f32; 3] = [0.020, 0.055, 0.015];
/// The palm's centre above the tool centre point in metres: its underside is 51 mm above.
const PALM_ABOVE_TCP: f64 = 0.066;
/// Half extents of a finger in metres.
const FINGER_HALF: [f32; 3] = [0.010, 0.006, 0.030];
/// A finger's centre above the tool centre point in metres: the tips reach 12 mm below it.
const FINGER_ABOVE_TCP: f64 = 0.018;
/// Mass of a finger in kg. The stiffness of contacts scales with mass: a lighter finger sinks into what it presses on.
const FINGER_MASS: f32 = 1.0;
/// Friction of palm and fingers: rubber pads.
const HAND_FRICTION: f32 = 1.0;
/// Stiffness of a finger's motor, N/m.
const STIFFNESS: f64 = 2e4;
/// Damping of a finger's motor, N·s/m.
const DAMPING: f64 = 200.0;
/// Speed of the motors' target, m/s for each finger.
const FINGER_SPEED: f64 = 0.15;
/// The motors' target moves by so much in a step, metres.
const FINGER_STEP: f64 = FINGER_SPEED * DT;
/// A motor's limit as a multiple of the squeeze asked for: room to centre an object that lies to one side.
const FORCE_HEADROOM: f64 = 3.0;
/// A motor's limit while opening, newtons.
const OPENING_FORCE: f64 = 60.0;
/// Fingers this near to the distance that they are to open to are there, metres.
const OPEN_WITHIN: f64 = 1e-3;
/// How deep the palm may be in what is fixed, in metres. A real palm gives so much before the force is felt.
const PALM_GIVES: f64 = 0.003;
/// Time constant of the low-passed contact forces, in steps.
const SMOOTHING_STEPS: f64 = 12.0;
/// After so many steps without a neighbour the palm carries the fingers: a twentieth of a second.
const ALONE_STEPS: u32 = 12;
/// Hand and arm collide with everything but each other.
const HAND_GROUP: Group = Group::GROUP_2;

/// Bodies and controller of the hand.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Hand {
    palm: RigidBodyHandle,
    fingers: [RigidBodyHandle; 2],
    /// What the fingers slide on.
    rails: [ImpulseJointHandle; 2],
    colliders: [ColliderHandle; 3],
    /// Where the tool centre point is to be after the next step.
    target: Pose,
    command: GripperCommand,
    /// The moving target of each finger: distance of its pad from the middle, metres.
    ramp: f64,
    /// Mean distance of the pads from the middle before the last step, metres.
    mean: f64,
    /// Steps since anything was near a finger; from [`ALONE_STEPS`] on the palm carries them.
    alone: u32,
    /// Low-passed force of the surroundings on the hand, newtons; a squeeze cancels.
    force: Vector3<f64>,
}

/// The direction of each finger along y.
const SIDE: [f64; 2] = [1.0, -1.0];

impl Hand {
    /// Builds the hand with its tool centre point at `tcp`, half open.
    pub(crate) fn build(physics: &mut PhysicsWorld, tcp: Pose) -> Hand {
        let collider = |half: [f32; 3]| {
            ColliderBuilder::cuboid(half[0], half[1], half[2])
                .friction(HAND_FRICTION)
                .collision_groups(hand_groups())
                .active_collision_types(ActiveCollisionTypes::all())
                .user_data(Tag::Hand.encode())
        };
        let gap = 0.5 * STROKE;
        let palm_pose = tcp * Translation3::new(0.0, 0.0, PALM_ABOVE_TCP);
        let (palm, palm_collider) = physics
            .insert(RigidBodyBuilder::kinematic_position_based().pose(to_engine(&palm_pose)), collider(PALM_HALF));
        let [(left, left_collider, left_rail), (right, right_collider, right_rail)] = SIDE.map(|side| {
            let (finger, finger_collider) = physics.insert(
                RigidBodyBuilder::dynamic()
                    .pose(to_engine(&(tcp * finger_offset(side, gap))))
                    .gravity_scale(0.0)
                    .lock_rotations()
                    .can_sleep(false),
                collider(FINGER_HALF).mass(FINGER_MASS),
            );
            let along = Vector::new(0.0, side as f32, 0.0);
            let rail = GenericJointBuilder::new(JointAxesMask::LIN_Y | JointAxesMask::LIN_Z)
                .local_axis1(along)
                .local_axis2(along)
                .local_anchor1(Vector::new(
                    0.0,
                    side as f32 * FINGER_HALF[1],
                    (FINGER_ABOVE_TCP - PALM_ABOVE_TCP) as f32,
                ))
                .limits(JointAxis::LinX, [0.0, STROKE as f32])
                .motor_model(JointAxis::LinX, MotorModel::ForceBased)
                .contacts_enabled(false)
                .build();
            (finger, finger_collider, physics.insert_impulse_joint(palm, finger, rail))
        });
        Hand {
            palm,
            fingers: [left, right],
            rails: [left_rail, right_rail],
            colliders: [palm_collider, left_collider, right_collider],
            target: tcp,
            command: GripperCommand::Open(2.0 * gap),
            ramp: gap,
            mean: gap,
            alone: 0,
            force: Vector3::zeros(),
        }
    }

    /// Puts the hand elsewhere at once, at rest, with the pads `opening` metres apart.
    pub(crate) fn place(&mut self, physics: &mut PhysicsWorld, tcp: Pose, opening: f64) {
        let gap = 0.5 * opening.clamp(0.0, MAX_OPENING);
        let palm = to_engine(&(tcp * Translation3::new(0.0, 0.0, PALM_ABOVE_TCP)));
        physics.bodies[self.palm].set_position(palm, true);
        physics.bodies[self.palm].set_next_kinematic_position(palm);
        for (finger, side) in self.fingers.iter().zip(SIDE) {
            let body = &mut physics.bodies[*finger];
            body.set_position(to_engine(&(tcp * finger_offset(side, gap))), true);
            body.set_linvel(Vector::ZERO, true);
            body.set_angvel(Vector::ZERO, true);
        }
        self.target = tcp;
        self.command = GripperCommand::Open(2.0 * gap);
        self.ramp = gap;
        self.mean = gap;
        self.force = Vector3::zeros();
    }

    /// Where the tool centre point is to be after the next step.
    pub(crate) fn aim(&mut self, tcp: Pose) {
        self.target = tcp;
    }

    pub(crate) fn target(&self) -> &Pose {
        &self.target
    }

    pub(crate) fn colliders(&self) -> &[ColliderHandle; 3] {
        &self.colliders
    }

    /// Takes a command; one that is not a number is ignored.
    pub(crate) fn obey(&mut self, physics: &PhysicsWorld, command: GripperCommand) {
        let Some(command) = command.clamped() else { return };
        if command != self.command {
            self.ramp = mean(self.gaps(physics));
            self.command = command;
        }
    }

    /// The command in force.
    pub(crate) fn command(&self) -> GripperCommand {
        self.command
    }

    /// Whether fingers that stand still have done what the command asks for. Fingers that are to close have met with
    /// something, or with each other.
    pub(crate) fn has_obeyed(&self, physics: &PhysicsWorld) -> bool {
        match self.command {
            GripperCommand::Open(width) => (self.opening(physics) - width).abs() < OPEN_WITHIN,
            GripperCommand::Close(_) => true,
        }
    }

    /// Distances of the pads from the middle, metres.
    fn gaps(&self, physics: &PhysicsWorld) -> [f64; 2] {
        let palm = physics.bodies[self.palm].position();
        [0, 1].map(|i| {
            let finger = physics.bodies[self.fingers[i]].translation();
            let local = palm.inverse_transform_point(finger);
            SIDE[i] * f64::from(local.y) - f64::from(FINGER_HALF[1])
        })
    }

    /// Distance between the pads, metres.
    pub(crate) fn opening(&self, physics: &PhysicsWorld) -> f64 {
        self.gaps(physics).iter().sum()
    }

    /// The pose of the tool centre point in the world.
    pub(crate) fn tcp(&self, physics: &PhysicsWorld) -> Pose {
        from_engine(physics.bodies[self.palm].position()) * Translation3::new(0.0, 0.0, -PALM_ABOVE_TCP)
    }

    /// Sets the palm's goal and the motors' targets for the coming step.
    pub(crate) fn drive(&mut self, physics: &mut PhysicsWorld) {
        let goal = self.target * Translation3::new(0.0, 0.0, PALM_ABOVE_TCP);
        let palm = &mut physics.bodies[self.palm];
        let next_position = to_engine_near(&goal, palm.position());
        palm.set_next_kinematic_position(next_position);
        let position = *palm.position();
        let gaps = self.gaps(physics);
        let mean = mean(gaps);
        // The motors damp the difference of the fingers and not their common motion. If that were damped too, a gentle
        // squeeze would arrive too late.
        let speed = ((mean - self.mean) / DT).clamp(-FINGER_SPEED, FINGER_SPEED);
        self.mean = mean;
        let (target, speed, limit) = match self.command {
            GripperCommand::Open(width) => {
                self.ramp += (0.5 * width - self.ramp).clamp(-FINGER_STEP, FINGER_STEP);
                (self.ramp, 0.0, OPENING_FORCE)
            }
            GripperCommand::Close(force) => {
                let reach = force / STIFFNESS;
                self.ramp = (self.ramp - FINGER_STEP).max(-reach);
                (self.ramp.max(mean - reach), speed, FORCE_HEADROOM * force)
            }
        };
        self.watch(physics);
        if self.carries() {
            return self.carry(physics, gaps);
        }
        // The fingers do not turn by forces. They turn with the palm, and have its rate of turning.
        let turning =
            RigidBodyPosition { position, next_position }.interpolate_velocity(1.0 / DT as f32, Vector::ZERO).angvel;
        for finger in self.fingers {
            let body = &mut physics.bodies[finger];
            body.set_rotation(position.rotation, false);
            body.set_angvel(turning, false);
        }
        for rail in self.rails {
            if let Some(rail) = physics.impulse_joints.get_mut(rail, false) {
                rail.data.set_motor(JointAxis::LinX, target as f32, speed as f32, STIFFNESS as f32, DAMPING as f32);
                rail.data.set_motor_max_force(JointAxis::LinX, limit as f32);
            }
        }
    }

    /// Whether the palm carries the fingers.
    fn carries(&self) -> bool {
        self.alone >= ALONE_STEPS
    }

    /// Looks whether anything is near the fingers, and makes them kinematic or dynamic where that changes.
    fn watch(&mut self, physics: &mut PhysicsWorld) {
        let carried = self.carries();
        let [_, fingers @ ..] = self.colliders;
        let near = fingers.iter().any(|&finger| physics.contact_pairs_with(finger).next().is_some());
        self.alone = if near { 0 } else { self.alone.saturating_add(1) };
        if self.carries() != carried {
            let kind = if carried { RigidBodyType::Dynamic } else { RigidBodyType::KinematicPositionBased };
            for (finger, rail) in self.fingers.into_iter().zip(self.rails) {
                physics.bodies[finger].set_body_type(kind, true);
                if let Some(rail) = physics.impulse_joints.get_mut(rail, true) {
                    rail.data.set_enabled(carried);
                }
            }
        }
    }

    /// Moves carried fingers along their rails towards the ramp, and with the palm.
    fn carry(&self, physics: &mut PhysicsWorld, gaps: [f64; 2]) {
        for ((finger, side), gap) in self.fingers.iter().zip(SIDE).zip(gaps) {
            let gap = (gap + (self.ramp - gap).clamp(-FINGER_STEP, FINGER_STEP)).clamp(0.0, STROKE);
            let body = &mut physics.bodies[*finger];
            let next = to_engine_near(&(self.target * finger_offset(side, gap)), body.position());
            body.set_next_kinematic_position(next);
        }
    }

    /// Reads the contact forces of the step just done: on the hand, and on the links of the arm that carries it.
    pub(crate) fn feel(&mut self, physics: &PhysicsWorld, links: &[ColliderHandle]) {
        let mut impulse = Vector3::zeros();
        for &collider in self.colliders.iter().chain(links) {
            // A pair that has come apart keeps the impulses of its last touch: only those of this step count.
            for pair in physics.contact_pairs_with(collider).filter(|pair| pair.has_any_active_contact()) {
                let on_second = from_engine_vector(pair.total_impulse());
                impulse += if pair.collider1 == collider { -on_second } else { on_second };
            }
        }
        self.force += (impulse / DT - self.force) / SMOOTHING_STEPS;
    }

    /// Whether the palm is in something that nothing moves. The engine finds that contact and gives it no force, since
    /// neither of the two yields.
    pub(crate) fn is_blocked(&self, physics: &PhysicsWorld) -> bool {
        let [palm, ..] = self.colliders;
        let is_fixed = |collider: ColliderHandle| {
            physics.colliders[collider].parent().is_some_and(|body| physics.bodies[body].is_fixed())
        };
        physics.contact_pairs_with(palm).any(|pair| {
            let other = if pair.collider1 == palm { pair.collider2 } else { pair.collider1 };
            is_fixed(other)
                && pair.find_deepest_contact().is_some_and(|(_, contact)| f64::from(contact.dist) < -PALM_GIVES)
        })
    }

    /// Magnitude of the low-passed force on the hand, newtons.
    pub(crate) fn force(&self) -> f64 {
        self.force.norm()
    }
}

/// Collides with everything but the hand and the arm.
pub(crate) fn hand_groups() -> InteractionGroups {
    InteractionGroups::new(HAND_GROUP, Group::ALL & !HAND_GROUP, InteractionTestMode::And)
}

fn mean(gaps: [f64; 2]) -> f64 {
    0.5 * (gaps[0] + gaps[1])
}

/// A finger's centre in the frame of the tool centre point.
fn finger_offset(side: f64, gap: f64) -> Translation3<f64> {
    Translation3::new(0.0, side * (gap + f64::from(FINGER_HALF[1])), FINGER_ABOVE_TCP)
}

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
        let (number, clamped) = match self {
            GripperCommand::Open(width) => (width, GripperCommand::Open(width.clamp(0.0, MAX_OPENING))),
            GripperCommand::Close(force) => (force, GripperCommand::Close(force.clamp(0.0, MAX_SQUEEZE))),
        };
        number.is_finite().then_some(clamped)
    }
}

/// [`Guard::rise`] unless it is set, newtons.
pub const GUARD_FORCE: f64 = 30.0;
/// [`Guard::abort`] unless it is set, newtons.
pub const ABORT_FORCE: f64 = 120.0;
/// The greatest force to which a guard can be set, newtons.
const MAX_GUARD: f64 = 1e3;

/// The forces at which a motion of the hand ends early, in newtons.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Guard {
    /// A motion ends when the force on the hand rises by so much above its least value since the start.
    pub rise: f64,
    /// A motion is aborted at this force on the hand.
    pub abort: f64,
}

impl Default for Guard {
    fn default() -> Guard {
        Guard { rise: GUARD_FORCE, abort: ABORT_FORCE }
    }
}

impl Guard {
    /// Says what is wrong with the forces, if anything.
    pub(crate) fn check(&self) -> Result<(), SimError> {
        within(HAND, "the force of an abort must be more than 0 and at most 1000 N", &[self.abort], 1e-3, MAX_GUARD)?;
        within(HAND, "the guard must be more than 0 N and not above the abort", &[self.rise], 1e-3, self.abort)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{pose_at, rotation_about};
    use crate::shape::Block;
    use crate::world::World;
    use proptest::prelude::*;

    /// A block of 4 cm that stands at `[x, y]`, turned by `yaw`, and an open gripper above the middle of the table.
    fn scene(at: [f64; 2], yaw: f64) -> World {
        let mut world = World::new();
        let block = Block { half: [0.02; 3], density: 800.0, friction: 0.6 };
        world
            .add(block.object("block"), pose_at([at[0], at[1], 0.0201], rotation_about([0.0, 0.0, 1.0], yaw)))
            .unwrap();
        world.place_gripper(pose_at([0.0, 0.0, 0.2], Default::default()), 0.07);
        world
    }

    /// Fingers that are carried although something touched them before this step, or that are not where the rails let
    /// them be. The rails give where the fingers press, and not where they are carried.
    fn astray(world: &World, touched_before: &mut bool) -> Option<String> {
        let (hand, physics) = (&world.hand, &world.physics);
        let [_, fingers @ ..] = hand.colliders;
        let touched =
            |finger: &ColliderHandle| physics.contact_pairs_with(*finger).any(|pair| pair.has_any_active_contact());
        let touched = fingers.iter().any(touched);
        let touched_again = std::mem::replace(touched_before, touched) && touched;
        if hand.carries() && touched_again {
            return Some("carried fingers are touched".to_owned());
        }
        let gives = if hand.carries() { 1e-6 } else { 5e-3 };
        let gaps = hand.gaps(physics);
        if gaps.iter().any(|gap| !(-gives..=STROKE + gives).contains(gap)) {
            return Some(format!("the pads are {gaps:?} m from the middle"));
        }
        let palm = physics.bodies[hand.palm].position();
        let height = f64::from(palm.inverse_transform_point(physics.bodies[hand.fingers[0]].translation()).z);
        let off = height - (FINGER_ABOVE_TCP - PALM_ABOVE_TCP);
        (off.abs() > gives).then(|| format!("a finger is {off} m off its rail"))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// Wherever the hand goes and whatever it comes upon, fingers are not carried for a second step after something
        /// touched them, and they stay on their rails.
        #[test]
        fn fingers_that_are_touched_are_not_carried(
            (x, y) in (-0.1..0.1f64, -0.1..0.1f64),
            yaw in -1.5..1.5f64,
            ways in prop::collection::vec(
                ((-0.15..0.15f64, -0.15..0.15f64, 0.0..0.25f64), -1.5..1.5f64, any::<bool>()), 1..6),
        ) {
            let mut world = scene([x, y], yaw);
            let (mut wrong, mut touched) = (None, false);
            for ((x, y, z), yaw, close) in ways {
                let target = pose_at([x, y, z], rotation_about([0.0, 0.0, 1.0], yaw));
                let observer = &mut |world: &World| wrong = wrong.take().or_else(|| astray(world, &mut touched));
                world.move_hand(target, observer);
                let gripper = if close { GripperCommand::Close(15.0) } else { GripperCommand::Open(0.07) };
                world.grip(gripper, observer);
            }
            prop_assert_eq!(wrong, None);
        }
    }

    #[test]
    fn carried_fingers_close_at_their_speed_and_meet_in_the_middle() {
        let mut world = scene([0.3, 0.3], 0.0);
        world.settle(0.1);
        assert!(world.hand.carries());
        let before = world.opening();
        world.command(GripperCommand::Close(10.0));
        world.settle(0.1);
        let closed = before - world.opening();
        assert!((closed - 2.0 * 0.1 * FINGER_SPEED).abs() < 1e-5, "closed by {closed} m in a tenth of a second");
        world.settle(0.5);
        assert!(world.hand.carries() && world.opening().abs() < 1e-5, "{} m apart", world.opening());
    }
}
