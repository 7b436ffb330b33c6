//! The arm's description, read from URDF: a chain of seven revolute joints between where it is mounted and the hand.

use std::sync::{Arc, OnceLock};

use nalgebra::{SVector, Unit, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use urdf_rs::{Geometry, JointType, Robot};

use crate::error::SimError;
use crate::frame::{Pose, pose_at, rotation_about};
use crate::object::{Convex, Part};

/// Joints of an arm: as many as a pose has numbers, and one to spare.
pub const JOINTS: usize = 7;

/// The angles of the joints in radians, from the mount to the hand.
pub type Configuration = SVector<f64, JOINTS>;

/// Our own arm: a pedestal behind the table, 1.14 m from shoulder to wrist.
const BUILTIN: &str = include_str!("arm.urdf");
/// Density of a link, kg/m³. Links are kinematic: nothing depends on their mass.
const DENSITY: f64 = 1000.0;
/// Friction of a link's shell.
const FRICTION: f64 = 0.4;
/// An axis shorter than this has no direction.
const LEAST_AXIS: f64 = 1e-6;

/// One revolute joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// Where it is in the frame of the link before it.
    pub origin: Pose,
    /// The axis about which it turns, in its own frame.
    pub axis: Unit<Vector3<f64>>,
    /// The least angle, radians.
    pub lower: f64,
    /// The greatest angle, radians.
    pub upper: f64,
    /// The greatest speed, rad/s.
    pub speed: f64,
}

/// An arm of seven revolute joints. Metres and radians.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ArmModel {
    /// Its name.
    pub name: String,
    /// Pose of the link before the first joint, in the world.
    pub mount: Pose,
    /// The joints, from the mount to the hand.
    pub joints: [Joint; JOINTS],
    /// The shells: of what is mounted, then of the link after each joint, in the link's frame.
    pub shells: Vec<Vec<Part>>,
    /// The tool centre point in the frame of the last link.
    pub tool: Pose,
}

impl ArmModel {
    /// The arm that comes with the program.
    pub fn builtin() -> Arc<ArmModel> {
        static ARM: OnceLock<Arc<ArmModel>> = OnceLock::new();
        Arc::clone(ARM.get_or_init(|| Arc::new(ArmModel::parse(BUILTIN).expect("a test reads it"))))
    }

    /// Reads an arm from URDF: one unbranched chain from a root link to a tool link, with seven revolute joints and any
    /// number of fixed ones. Shells are the `collision` boxes, cylinders and spheres. The last link's frame is that of
    /// the hand (see [`crate::World::tcp`]).
    ///
    /// # Errors
    /// [`SimError::Arm`]: no URDF, another number of joints, a branch, a joint without a range, a shell of another
    /// shape.
    pub fn parse(urdf: &str) -> Result<ArmModel, SimError> {
        let robot = urdf_rs::read_from_string(urdf).map_err(|error| SimError::Arm { reason: error.to_string() })?;
        let refuse = |reason: String| SimError::Arm { reason };
        let mut link = root(&robot)?;
        let mut mount = Pose::identity();
        let mut joints: Vec<Joint> = Vec::new();
        let mut shells = vec![shells_of(&robot, link, &Pose::identity())?];
        // Fixed joints are folded in: `since` is the pose of the present link in the frame of the last one that moves.
        let mut since = Pose::identity();
        for _ in 0..robot.joints.len() {
            let mut after = robot.joints.iter().filter(|joint| joint.parent.link == link);
            let Some(joint) = after.next() else { break };
            if after.next().is_some() {
                return Err(refuse(format!("link `{link}` has more than one joint after it, expected a chain")));
            }
            let origin = since * pose_of(&joint.origin);
            link = &joint.child.link;
            match joint.joint_type {
                JointType::Fixed if joints.is_empty() && shells[0].is_empty() => {
                    mount *= origin;
                    since = Pose::identity();
                }
                JointType::Fixed => since = origin,
                JointType::Revolute => {
                    joints.push(revolute(joint, origin)?);
                    shells.push(Vec::new());
                    since = Pose::identity();
                }
                ref other => {
                    let name = &joint.name;
                    return Err(refuse(format!("joint `{name}` is {other:?}, expected revolute or fixed")));
                }
            }
            let shell = shells_of(&robot, link, &since)?;
            shells.last_mut().expect("there is one from the start").extend(shell);
        }
        let count = joints.len();
        let joints = <[Joint; JOINTS]>::try_from(joints)
            .map_err(|_| refuse(format!("{count} revolute joints, expected {JOINTS}")))?;
        Ok(ArmModel { name: robot.name, mount, joints, shells, tool: since })
    }

    /// Whether every joint is within its range.
    pub fn allows(&self, configuration: &Configuration) -> bool {
        self.joints.iter().zip(configuration.iter()).all(|(joint, angle)| (joint.lower..=joint.upper).contains(angle))
    }

    /// The configuration with every joint in the middle of its range.
    pub fn middle(&self) -> Configuration {
        Configuration::from_fn(|joint, _| 0.5 * (self.joints[joint].lower + self.joints[joint].upper))
    }

    /// Seconds that the slowest joint takes between two configurations at full speed.
    pub fn seconds_between(&self, from: &Configuration, to: &Configuration) -> f64 {
        let way = to - from;
        self.joints.iter().zip(way.iter()).map(|(joint, way)| way.abs() / joint.speed).fold(0.0, f64::max)
    }
}

/// The one link that no joint leads to.
fn root(robot: &Robot) -> Result<&str, SimError> {
    let is_child = |name: &str| robot.joints.iter().any(|joint| joint.child.link == name);
    let mut roots = robot.links.iter().map(|link| link.name.as_str()).filter(|name| !is_child(name));
    match (roots.next(), roots.next()) {
        (Some(root), None) => Ok(root),
        _ => Err(SimError::Arm { reason: "expected one link that no joint leads to".to_owned() }),
    }
}

fn revolute(joint: &urdf_rs::Joint, origin: Pose) -> Result<Joint, SimError> {
    let name = &joint.name;
    let axis = Unit::try_new(Vector3::from(*joint.axis.xyz), LEAST_AXIS)
        .ok_or_else(|| SimError::Arm { reason: format!("joint `{name}`: its axis has no direction") })?;
    let (lower, upper, speed) = (joint.limit.lower, joint.limit.upper, joint.limit.velocity);
    if !(lower < upper && speed > 0.0 && lower.is_finite() && upper.is_finite() && speed.is_finite()) {
        let reason = format!("joint `{name}`: expected a limit with lower < upper and a velocity of more than 0");
        return Err(SimError::Arm { reason });
    }
    Ok(Joint { name: name.clone(), origin, axis, lower, upper, speed })
}

/// The collision shapes of a link that has this pose in the frame of the last link that moves.
fn shells_of(robot: &Robot, link: &str, at: &Pose) -> Result<Vec<Part>, SimError> {
    let found = robot.links.iter().find(|other| other.name == link);
    let found = found.ok_or_else(|| SimError::Arm { reason: format!("there is no link `{link}`") })?;
    let shell = |collision: &urdf_rs::Collision| {
        let shape = match &collision.geometry {
            Geometry::Box { size } => Convex::Cuboid { half: size.0.map(|extent| 0.5 * extent) },
            Geometry::Cylinder { radius, length } => Convex::Cylinder { radius: *radius, half_height: 0.5 * length },
            Geometry::Sphere { radius } => Convex::Ball { radius: *radius },
            other => {
                let reason = format!("link `{link}`: a shell is {other:?}, expected a box, a cylinder or a sphere");
                return Err(SimError::Arm { reason });
            }
        };
        Ok(Part::new(shape, at * pose_of(&collision.origin), DENSITY, FRICTION))
    };
    found.collision.iter().map(shell).collect()
}

/// A pose as URDF writes it: roll about x, then pitch about y, then yaw about z, all of the parent's axes.
fn pose_of(pose: &urdf_rs::Pose) -> Pose {
    let [roll, pitch, yaw] = *pose.rpy;
    let turn: UnitQuaternion<f64> = rotation_about([0.0, 0.0, 1.0], yaw)
        * rotation_about([0.0, 1.0, 0.0], pitch)
        * rotation_about([1.0, 0.0, 0.0], roll);
    pose_at(*pose.xyz, turn)
}
