//! Conditions on a world: a small closed vocabulary of physical measurements with named thresholds.

use std::fmt;

use nalgebra::Vector3;
use situ_sim::{Convex, Part, World};

use crate::expression::{Argument, Call};

/// An object is held when both fingers press on it with at least this force, in newtons: an accidental touch of one finger is
/// no grasp, and a grasp squeezes with 10 N or more.
pub const HELD_FORCE: f64 = 1.0;
/// An object is upright while its z axis is within this angle of the vertical, in radians, unless the condition says otherwise:
/// about 17°, far from the 90° of a fallen cup and well above the tilt of one that stands on a crumb.
pub const UPRIGHT_TILT: f64 = 0.3;
/// An object stands still below this speed, in m/s: a fall of one millimetre reaches 0.14 m/s.
pub const REST_SPEED: f64 = 0.05;
/// How far an object's origin may be below the top of what it is on, in metres: the give of contacts and of a plug in a rim.
pub const ON_SLACK: f64 = 0.005;
/// How far an object's origin must be below the rim of what it is inside, in metres: the origin of a lid lies at the rim that the lid is on, and
/// contacts give.
const INSIDE_MARGIN: f64 = 0.001;
/// A button is pressed when it is at least this part of its travel in: half-way is clear of one that was only touched, and leaves as much
/// room for one that is not pushed to its stop.
pub const PRESSED_PART: f64 = 0.5;
/// The name by which conditions and features speak of the point between the finger tips (TCP).
pub const GRIPPER: &str = "gripper";

/// A condition on a world. Each one is a measurement: none knows which variation is being played.
///
/// Written as calls: `all(filled(bowl, 0.8), not(held(pitcher)))`.
#[derive(Debug, Clone, PartialEq)]
pub enum Predicate {
    /// `held(a)`: both fingers press on `a` from either side with at least [`HELD_FORCE`].
    Held(String),
    /// `on(a, b)`: `a` touches `b`, and in the frame of `b` the origin of `a` is within its outline (both the circle and the rectangle that
    /// hold it) and not lower than its top.
    On(String, String),
    /// `inside(a, b)`: the origin of `a` is in the room inside the container `b`, a millimetre or more below its rim.
    Inside(String, String),
    /// `filled(c, fraction)`: at least this fraction of all beads is in the container `c`.
    Filled(String, f64),
    /// `upright(a)` or `upright(a, radians)`: the z axis of `a` is within [`UPRIGHT_TILT`] or the given angle of the vertical.
    Upright(String, f64),
    /// `near(a, b, metres)`: the origins are at most this far apart; either may be `gripper`.
    Near(String, String, f64),
    /// `at(a, b, metres)`: `a` has been put down at the place `b`: at most this far from it in the plane, still, and not held.
    At(String, String, f64),
    /// `open(a, metres)`: `a` has slid at least this far from the start of its range.
    Open(String, f64),
    /// `pressed(a)`: `a` has slid at least [`PRESSED_PART`] of its travel.
    Pressed(String),
    /// `not(p)`.
    Not(Box<Predicate>),
    /// `all(p, …)`; `all()` always holds.
    All(Vec<Predicate>),
    /// `any(p, …)`; `any()` never holds.
    Any(Vec<Predicate>),
}

/// The words of the vocabulary, with their arguments, for messages.
const WORDS: &str = "held(a), on(a, b), inside(a, b), filled(c, fraction), upright(a[, radians]), near(a, b, metres), \
                     at(a, b, metres), open(a, metres), pressed(a), not(p), all(p, …), any(p, …)";

impl Predicate {
    /// Reads a condition. The error says what was expected.
    pub fn parse(text: &str) -> Result<Predicate, String> {
        Predicate::from_call(&Call::parse(text)?)
    }

    fn from_call(call: &Call) -> Result<Predicate, String> {
        use Argument::{Name, Number};
        let wrong = |usage: &str| {
            let found: Vec<String> = call.arguments.iter().map(ToString::to_string).collect();
            format!("expected `{usage}`, found `{}` with the arguments [{}]", call.word, found.join(", "))
        };
        Ok(match (call.word.as_str(), call.arguments.as_slice()) {
            ("held", [Name(a)]) => Predicate::Held(a.clone()),
            ("held", _) => return Err(wrong("held(a)")),
            ("on", [Name(a), Name(b)]) => Predicate::On(a.clone(), b.clone()),
            ("on", _) => return Err(wrong("on(a, b)")),
            ("inside", [Name(a), Name(b)]) => Predicate::Inside(a.clone(), b.clone()),
            ("inside", _) => return Err(wrong("inside(a, b)")),
            ("filled", [Name(c), Number(f)]) if (0.0..=1.0).contains(f) => Predicate::Filled(c.clone(), *f),
            ("filled", _) => return Err(wrong("filled(container, fraction from 0 to 1)")),
            ("upright", [Name(a)]) => Predicate::Upright(a.clone(), UPRIGHT_TILT),
            ("upright", [Name(a), Number(t)]) if *t > 0.0 => Predicate::Upright(a.clone(), *t),
            ("upright", _) => return Err(wrong("upright(a) or upright(a, radians)")),
            ("near", [Name(a), Name(b), Number(d)]) if *d > 0.0 => Predicate::Near(a.clone(), b.clone(), *d),
            ("near", _) => return Err(wrong("near(a, b, positive metres)")),
            ("at", [Name(a), Name(b), Number(d)]) if *d > 0.0 => Predicate::At(a.clone(), b.clone(), *d),
            ("at", _) => return Err(wrong("at(a, b, positive metres)")),
            ("open", [Name(a), Number(d)]) if *d > 0.0 => Predicate::Open(a.clone(), *d),
            ("open", _) => return Err(wrong("open(a, positive metres)")),
            ("pressed", [Name(a)]) => Predicate::Pressed(a.clone()),
            ("pressed", _) => return Err(wrong("pressed(a)")),
            ("not", [Argument::Call(p)]) => Predicate::Not(Box::new(Predicate::from_call(p)?)),
            ("not", _) => return Err(wrong("not(condition)")),
            (word @ ("all" | "any"), parts) => {
                let parts: Result<Vec<Predicate>, String> = parts
                    .iter()
                    .map(|part| match part {
                        Argument::Call(call) => Predicate::from_call(call),
                        other => Err(format!("expected a condition in `{word}`, found {other}")),
                    })
                    .collect();
                if word == "all" { Predicate::All(parts?) } else { Predicate::Any(parts?) }
            }
            (word, _) => return Err(format!("unknown condition `{word}`; expected one of {WORDS}")),
        })
    }

    /// Whether the condition holds in `world`. An object that is not there fulfils nothing.
    pub fn holds(&self, world: &World) -> bool {
        self.measure(world).unwrap_or(false)
    }

    /// None where an object is not in the world.
    fn measure(&self, world: &World) -> Option<bool> {
        Some(match self {
            Predicate::Held(a) => is_held(world, a),
            Predicate::On(a, b) => {
                let offset = world.pose(b)?.inverse() * world.pose(a)?;
                let (place, base) = (offset.translation.vector, world.object(b)?);
                world.touching(a, b)
                    && place.z >= base.outline.top - ON_SLACK
                    && place.xy().norm() <= base.outline.reach
                    && is_within_rectangle(&base.parts, &place)
            }
            Predicate::Inside(a, b) => {
                let room = world.object(b)?.container?;
                let place = (world.pose(b)?.inverse() * world.pose(a)?).translation.vector;
                room.contains([place.x, place.y, place.z], -INSIDE_MARGIN)
            }
            Predicate::Filled(container, fraction) => fill(world, container)? >= *fraction,
            Predicate::Upright(a, limit) => tilt(world, a)? <= *limit,
            Predicate::Near(a, b, limit) => (position(world, a)? - position(world, b)?).norm() <= *limit,
            Predicate::At(a, b, limit) => {
                let apart = (position(world, a)? - position(world, b)?).xy().norm();
                apart <= *limit && world.speed(a)? <= REST_SPEED && !is_held(world, a)
            }
            Predicate::Open(a, metres) => world.joint_value(a)? >= *metres,
            Predicate::Pressed(a) => world.joint_value(a)? >= PRESSED_PART * world.joint_travel(a)?,
            Predicate::Not(p) => !p.holds(world),
            Predicate::All(parts) => parts.iter().all(|p| p.holds(world)),
            Predicate::Any(parts) => parts.iter().any(|p| p.holds(world)),
        })
    }

    /// Calls `visit` with each name in the condition and the part it plays.
    pub(crate) fn visit_names(&self, visit: &mut dyn FnMut(&str, Role)) {
        match self {
            Predicate::Held(a) | Predicate::Upright(a, _) => visit(a, Role::Object),
            Predicate::On(a, b) | Predicate::At(a, b, _) => {
                visit(a, Role::Object);
                visit(b, Role::Object);
            }
            Predicate::Inside(a, b) => {
                visit(a, Role::Object);
                visit(b, Role::Container);
            }
            Predicate::Filled(c, _) => visit(c, Role::Filled),
            Predicate::Near(a, b, _) => {
                visit(a, Role::Point);
                visit(b, Role::Point);
            }
            Predicate::Open(a, _) | Predicate::Pressed(a) => visit(a, Role::Sliding),
            Predicate::Not(p) => p.visit_names(visit),
            Predicate::All(parts) | Predicate::Any(parts) => parts.iter().for_each(|p| p.visit_names(visit)),
        }
    }
}

/// What a name in a condition or a feature has to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// An object.
    Object,
    /// An object or the gripper.
    Point,
    /// A container.
    Container,
    /// A container, in a task with beads.
    Filled,
    /// An object that slides.
    Sliding,
}

impl fmt::Display for Predicate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |f: &mut fmt::Formatter<'_>, word: &str, parts: &[Predicate]| {
            write!(f, "{word}(")?;
            for (i, part) in parts.iter().enumerate() {
                write!(f, "{}{part}", if i == 0 { "" } else { ", " })?;
            }
            f.write_str(")")
        };
        match self {
            Predicate::Held(a) => write!(f, "held({a})"),
            Predicate::On(a, b) => write!(f, "on({a}, {b})"),
            Predicate::Inside(a, b) => write!(f, "inside({a}, {b})"),
            Predicate::Filled(c, fraction) => write!(f, "filled({c}, {fraction})"),
            Predicate::Upright(a, limit) => write!(f, "upright({a}, {limit})"),
            Predicate::Near(a, b, d) => write!(f, "near({a}, {b}, {d})"),
            Predicate::At(a, b, d) => write!(f, "at({a}, {b}, {d})"),
            Predicate::Open(a, metres) => write!(f, "open({a}, {metres})"),
            Predicate::Pressed(a) => write!(f, "pressed({a})"),
            Predicate::Not(p) => write!(f, "not({p})"),
            Predicate::All(parts) => list(f, "all", parts),
            Predicate::Any(parts) => list(f, "any", parts),
        }
    }
}

/// Both fingers press on the object from either side.
fn is_held(world: &World, object: &str) -> bool {
    world.grip_force(object).iter().all(|&force| force >= HELD_FORCE)
}

/// Whether a place in the object's frame is above or below the upright rectangle that holds its parts. The circle about a plank alone would
/// hold places beside its long sides, where nothing can lie on it.
fn is_within_rectangle(parts: &[Part], place: &Vector3<f64>) -> bool {
    [0, 1].iter().all(|&axis| {
        let ends = parts.iter().map(|part| (part.pose.translation.vector[axis], half_extent(part, axis)));
        let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (middle, half)| {
            (low.min(middle - half), high.max(middle + half))
        });
        (low..=high).contains(&place[axis])
    })
}

/// How far a part reaches to either side of its middle along an axis of its object, in metres.
fn half_extent(part: &Part, axis: usize) -> f64 {
    let turn = part.pose.rotation.to_rotation_matrix();
    let along = |half: [f64; 3]| (0..3).map(|k| turn[(axis, k)].abs() * half[k]).sum();
    match part.shape {
        Convex::Cuboid { half } => along(half),
        Convex::Ball { radius } => radius,
        // The box about it.
        Convex::Cylinder { radius, half_height } | Convex::Prism { radius, half_height, .. } => {
            along([radius, radius, half_height])
        }
    }
}

/// Where the origin of an object, or the gripper's TCP, is: metres, world frame.
pub(crate) fn position(world: &World, name: &str) -> Option<Vector3<f64>> {
    if name == GRIPPER { Some(world.tcp().translation.vector) } else { Some(world.pose(name)?.translation.vector) }
}

/// The angle between an object's z axis and the vertical, in radians.
pub(crate) fn tilt(world: &World, object: &str) -> Option<f64> {
    let axis = world.pose(object)?.rotation * Vector3::z();
    Some(libm::acos(axis.z.clamp(-1.0, 1.0)))
}

/// The fraction of all beads that is in the container; none are in it where there are no beads.
pub(crate) fn fill(world: &World, container: &str) -> Option<f64> {
    let (inside, all) = (world.beads_inside(container)?, world.beads().len());
    Some(if all == 0 { 0.0 } else { inside as f64 / all as f64 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back() {
        let text = "all(filled(bowl, 0.8), not(on(lid, pitcher)), any(upright(cup, 0.5), near(gripper, cup, 0.1), open(box, 0.05), pressed(bell)), all())";
        let predicate = Predicate::parse(text).expect("a condition");
        assert_eq!(predicate.to_string(), text);
        assert_eq!(Predicate::parse(&predicate.to_string()), Ok(predicate));
    }

    #[test]
    fn mistakes_name_the_usage() {
        for (text, expected) in [
            ("hold(cup)", "unknown condition `hold`; expected one of held(a)"),
            ("on(lid)", "expected `on(a, b)`"),
            ("filled(bowl, 8)", "fraction from 0 to 1"),
            ("near(a, b, -1)", "positive metres"),
            ("open(drawer)", "expected `open(a, positive metres)`"),
            ("pressed(button, 0.5)", "expected `pressed(a)`"),
            ("not(cup)", "expected `not(condition)`"),
            ("all(held(cup), cup)", "expected a condition in `all`"),
            ("near(a, b, NaN)", "positive metres"),
        ] {
            let message = Predicate::parse(text).expect_err("malformed");
            assert!(message.contains(expected), "{text}: {message}");
        }
    }
}
