//! The observed state of a task family: what a camera would give, as one vector of scalars with fixed scales.

use situ_sim::World;

use crate::expression::{Argument, Call};
use crate::predicate::{self, GRIPPER, Role};

/// Scale of offsets and distances, in metres (D16).
pub const LENGTH_SCALE: f64 = 0.2;
/// Scale of fill fractions (D16).
pub const FILL_SCALE: f64 = 0.3;
/// Scale of tilts, in radians (D16).
pub const TILT_SCALE: f64 = 0.5;
/// Scale of the gripper's opening, in metres: half of its stroke rounded up (D16 says 0.5 for the opening as a fraction).
pub const OPENING_SCALE: f64 = 0.05;
/// Scale of the values of joints, in metres: a button travels less, a drawer more.
pub const JOINT_SCALE: f64 = 0.05;
/// Scale of `seen`, which is 0 or 1.
pub const SEEN_SCALE: f64 = 1.0;

/// One scalar of the observed state.
#[derive(Debug, Clone, PartialEq)]
pub struct Feature {
    /// Its name, such as `offset(lid, pitcher).x`.
    pub name: String,
    /// The scale that makes it a number of order one, in its own unit.
    pub scale: f64,
}

/// The scalars of the observed state, in order. One schema serves a whole family, with all its variations.
#[derive(Debug, Clone, PartialEq)]
pub struct Schema {
    /// One entry a scalar.
    pub features: Vec<Feature>,
    observables: Vec<Observable>,
}

/// Something that is observed, one or three scalars.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Observable {
    /// `opening()`: metres between the finger pads.
    Opening,
    /// `offset(a, b)`: the origin of `a` in the frame of `b`, three scalars in metres; 0 where either is not there.
    Offset(String, String),
    /// `distance(a, b)`: metres between the origins; 0 where either is not there.
    Distance(String, String),
    /// `tilt(a)`: radians between the z axis of `a` and the vertical; 0 where it is not there.
    Tilt(String),
    /// `fill(c)`: fraction of all beads in the container; 0 where it is not there.
    Fill(String),
    /// `joint(a)`: metres that the object has slid from the start of its range; 0 where it is not there.
    Joint(String),
    /// `seen(a)`: 1 where the object is there, else 0.
    Seen(String),
}

impl Observable {
    /// Reads one entry of a task file's `observe`. The error says what was expected.
    pub(crate) fn parse(text: &str) -> Result<Observable, String> {
        use Argument::Name;
        let call = Call::parse(text)?;
        Ok(match (call.word.as_str(), call.arguments.as_slice()) {
            ("opening", []) => Observable::Opening,
            ("offset", [Name(a), Name(b)]) => Observable::Offset(a.clone(), b.clone()),
            ("distance", [Name(a), Name(b)]) => Observable::Distance(a.clone(), b.clone()),
            ("tilt", [Name(a)]) => Observable::Tilt(a.clone()),
            ("fill", [Name(c)]) => Observable::Fill(c.clone()),
            ("joint", [Name(a)]) => Observable::Joint(a.clone()),
            ("seen", [Name(a)]) => Observable::Seen(a.clone()),
            (word, _) => {
                return Err(format!(
                    "unknown feature `{word}` or wrong arguments; expected one of opening(), offset(a, b), distance(a, b), \
                     tilt(a), fill(container), joint(a), seen(a)"
                ));
            }
        })
    }

    /// Calls `visit` with each name and the part it plays.
    pub(crate) fn visit_names(&self, visit: &mut dyn FnMut(&str, Role)) {
        match self {
            Observable::Opening => {}
            Observable::Offset(a, b) | Observable::Distance(a, b) => {
                visit(a, Role::Point);
                visit(b, Role::Point);
            }
            Observable::Tilt(a) | Observable::Seen(a) => visit(a, Role::Object),
            Observable::Fill(c) => visit(c, Role::Filled),
            Observable::Joint(a) => visit(a, Role::Sliding),
        }
    }

    fn features(&self) -> Vec<Feature> {
        let one = |name: String, scale| vec![Feature { name, scale }];
        match self {
            Observable::Opening => one("opening()".to_owned(), OPENING_SCALE),
            Observable::Offset(a, b) => ["x", "y", "z"]
                .map(|axis| Feature { name: format!("offset({a}, {b}).{axis}"), scale: LENGTH_SCALE })
                .to_vec(),
            Observable::Distance(a, b) => one(format!("distance({a}, {b})"), LENGTH_SCALE),
            Observable::Tilt(a) => one(format!("tilt({a})"), TILT_SCALE),
            Observable::Fill(c) => one(format!("fill({c})"), FILL_SCALE),
            Observable::Joint(a) => one(format!("joint({a})"), JOINT_SCALE),
            Observable::Seen(a) => one(format!("seen({a})"), SEEN_SCALE),
        }
    }

    fn measure(&self, world: &World, values: &mut Vec<f64>) {
        match self {
            Observable::Opening => values.push(world.opening()),
            Observable::Offset(a, b) => values.extend(offset(world, a, b).unwrap_or([0.0; 3])),
            Observable::Distance(a, b) => {
                let apart = predicate::position(world, a).zip(predicate::position(world, b));
                values.push(apart.map_or(0.0, |(a, b)| (a - b).norm()));
            }
            Observable::Tilt(a) => values.push(predicate::tilt(world, a).unwrap_or(0.0)),
            Observable::Fill(c) => values.push(predicate::fill(world, c).unwrap_or(0.0)),
            Observable::Joint(a) => values.push(world.joint_value(a).unwrap_or(0.0)),
            Observable::Seen(a) => values.push(if world.pose(a).is_some() { 1.0 } else { 0.0 }),
        }
    }
}

impl Schema {
    pub(crate) fn new(observables: Vec<Observable>) -> Schema {
        let features = observables.iter().flat_map(Observable::features).collect();
        Schema { features, observables }
    }

    /// The number of scalars.
    pub fn len(&self) -> usize {
        self.features.len()
    }

    /// Whether nothing is observed.
    pub fn is_empty(&self) -> bool {
        self.features.is_empty()
    }

    /// The observed state of a world: raw physical units, one value a feature.
    pub fn observe(&self, world: &World) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.len());
        self.observables.iter().for_each(|observable| observable.measure(world, &mut values));
        values
    }
}

/// The origin of `a` in the full frame of `b` (which turns and tilts with `b`), in metres.
fn offset(world: &World, a: &str, b: &str) -> Option<[f64; 3]> {
    let frame = if b == GRIPPER { world.tcp() } else { world.pose(b)? };
    let local = frame.rotation.inverse() * (predicate::position(world, a)? - frame.translation.vector);
    Some([local.x, local.y, local.z])
}
