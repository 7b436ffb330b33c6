//! The observed state from poses alone: for a robot of one's own, whose perception says where things are and nothing
//! else. Names, units and scales are those of the tasks here.

use std::collections::{BTreeMap, BTreeSet};

use situ_sim::Pose;

use crate::feature::{Observable, Quantity, WorldFeature};
use crate::measure::{offset_in, tilt_of};
use crate::view::GRIPPER;

/// What is perceived at one moment. Poses are in the world frame, positions in metres.
#[derive(Debug, Clone, PartialEq)]
pub struct Poses {
    /// The pose of each object that is there.
    pub objects: BTreeMap<String, Pose>,
    /// The pose of the hand.
    pub hand: Pose,
    /// Metres between the finger pads, where they are known.
    pub opening: Option<f64>,
}

impl Poses {
    /// The pose of an object or of the hand.
    fn pose(&self, name: &str) -> Option<&Pose> {
        if name == GRIPPER { Some(&self.hand) } else { self.objects.get(name) }
    }
}

/// The scalars of a state that follows from [`Poses`], in order, each as an entry of a task file's `observe`:
/// `opening()`, `offset(a, b)`, `distance(a, b)`, `tilt(a)` and `seen(a)`. `gripper` is the hand.
///
/// ```
/// use situ_tasks::PoseSchema;
///
/// let schema = PoseSchema::usual(&["bowl", "cup"], true, false).unwrap();
/// assert_eq!(
///     schema.expressions(),
///     ["opening()", "offset(gripper, bowl)", "tilt(bowl)", "offset(gripper, cup)", "tilt(cup)", "distance(bowl, cup)"]
/// );
/// assert_eq!(schema.features().len(), 10);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct PoseSchema(Vec<Observable>);

impl PoseSchema {
    /// What is usual: the opening where it is known, the hand's offset from each object, each object's tilt and whether
    /// it is seen where it may be absent, and the distance of every two.
    ///
    /// # Errors
    /// What a name has to be.
    pub fn usual(objects: &[&str], has_opening: bool, may_be_absent: bool) -> Result<Self, String> {
        if let Some(name) = objects.iter().find(|name| !is_name(name)) {
            let name = name.escape_debug();
            return Err(format!(
                "`{name}`: expected a name of letters, digits, `_`, `-` and `.` that begins with a letter, and not \
                 `{GRIPPER}`"
            ));
        }
        let mut expressions: Vec<String> = if has_opening { vec!["opening()".to_owned()] } else { Vec::new() };
        for object in objects {
            expressions.extend([format!("offset({GRIPPER}, {object})"), format!("tilt({object})")]);
            if may_be_absent {
                expressions.push(format!("seen({object})"));
            }
        }
        for (index, one) in objects.iter().enumerate() {
            expressions.extend(objects[index + 1..].iter().map(|other| format!("distance({one}, {other})")));
        }
        Self::parse(&expressions).map_err(|(_, problem)| problem)
    }

    /// The schema of these expressions.
    ///
    /// # Errors
    /// The index of the first that is none, and what was expected.
    pub fn parse(expressions: &[String]) -> Result<Self, (usize, String)> {
        let read = |(index, text): (usize, &String)| {
            let observable = Observable::parse(text).map_err(|problem| (index, problem))?;
            match observable.said().0 {
                Quantity::Opening | Quantity::Offset | Quantity::Distance | Quantity::Tilt | Quantity::Seen => {
                    Ok(observable)
                }
                Quantity::Fill | Quantity::Slid | Quantity::Angle => {
                    let known = "opening(), offset(a, b), distance(a, b), tilt(a), seen(a)";
                    Err((index, format!("`{text}` does not follow from poses, expected one of {known}")))
                }
            }
        };
        expressions.iter().enumerate().map(read).collect::<Result<_, _>>().map(Self)
    }

    /// The expressions.
    pub fn expressions(&self) -> Vec<String> {
        self.0.iter().map(Observable::text).collect()
    }

    /// The scalars, in order: a name and a scale each.
    pub fn features(&self) -> Vec<WorldFeature> {
        self.0.iter().flat_map(Observable::features).collect()
    }

    /// The objects that it speaks of.
    pub fn objects(&self) -> BTreeSet<&str> {
        self.0.iter().flat_map(|observable| observable.said().1).filter(|name| *name != GRIPPER).collect()
    }

    /// Whether it asks if an object is seen: then the object may be absent.
    pub fn asks_whether_seen(&self, object: &str) -> bool {
        self.0.iter().any(|observable| observable.said() == (Quantity::Seen, vec![object]))
    }

    /// Whether it asks for the opening of the hand.
    pub fn has_opening(&self) -> bool {
        self.0.iter().any(|observable| observable.said().0 == Quantity::Opening)
    }

    /// The state: one number a feature, each in its own unit. It is 0 where what it speaks of is not there.
    pub fn state(&self, poses: &Poses) -> Vec<f64> {
        self.0.iter().flat_map(|observable| measured(observable, poses)).collect()
    }
}

/// Whether the notation of features takes it for the name of an object.
fn is_name(name: &str) -> bool {
    let is_fine = |letter: char| letter.is_ascii_alphanumeric() || "_-.".contains(letter);
    name.starts_with(|first: char| first.is_ascii_alphabetic()) && name.chars().all(is_fine) && name != GRIPPER
}

fn measured(observable: &Observable, poses: &Poses) -> Vec<f64> {
    let (quantity, names) = observable.said();
    let pose = |place: usize| names.get(place).and_then(|name| poses.pose(name));
    let position = |place: usize| pose(place).map(|pose| pose.translation.vector);
    let both = || position(0).zip(position(1));
    match quantity {
        Quantity::Offset => {
            let offset = position(0).zip(pose(1)).map(|(position, frame)| offset_in(frame, &position));
            offset.unwrap_or_default().to_vec()
        }
        Quantity::Opening => vec![poses.opening.unwrap_or_default()],
        Quantity::Distance => vec![both().map_or(0.0, |(one, other)| (one - other).norm())],
        Quantity::Tilt => vec![pose(0).map_or(0.0, tilt_of)],
        Quantity::Seen => vec![f64::from(u8::from(pose(0).is_some()))],
        Quantity::Fill | Quantity::Slid | Quantity::Angle => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Translation3, UnitQuaternion, Vector3};

    use super::*;
    use crate::{Episode, Registry, View};

    /// What follows from the poses of a world of ours is what a task observes of that world, bit for bit.
    #[test]
    fn it_is_what_a_task_observes() {
        let registry = Registry::builtin().unwrap();
        let task = registry.tasks().find(|task| task.name() == "stack").unwrap();
        let episode = Episode::start(&task.variation(None).unwrap(), 3).unwrap();
        let world = episode.world();
        let objects = ["base", "middle", "top"];
        let poses = Poses {
            objects: objects.iter().map(|name| ((*name).to_owned(), world.pose(name).unwrap())).collect(),
            hand: world.tcp(),
            opening: Some(world.opening()),
        };
        let expressions = PoseSchema::usual(&objects, true, true).unwrap().expressions();
        let own = PoseSchema::parse(&expressions).unwrap();
        let observables = expressions.iter().map(|text| Observable::parse(text).unwrap()).collect();
        let of_task = crate::WorldSchema::new(observables);
        assert_eq!(own.state(&poses), of_task.observe(View::from(world)));
        assert_eq!(own.features(), of_task.features);
    }

    #[test]
    fn what_is_not_there_is_0_and_what_poses_do_not_say_is_refused() {
        let at = |x: f64| Pose::from_parts(Translation3::new(x, 0.0, 0.0), UnitQuaternion::identity());
        let poses = Poses { objects: BTreeMap::from([("cup".to_owned(), at(1.0))]), hand: at(0.5), opening: None };
        let schema = PoseSchema::usual(&["cup", "lid"], false, true).unwrap();
        assert_eq!(schema.state(&poses), [-0.5, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let tilted = UnitQuaternion::from_scaled_axis(0.3 * Vector3::x());
        let cup = Pose::from_parts(Translation3::identity(), tilted);
        let poses = Poses { objects: BTreeMap::from([("cup".to_owned(), cup)]), ..poses };
        assert!((schema.state(&poses)[3] - 0.3).abs() < 1e-12);
        assert_eq!(PoseSchema::parse(&["tilt(cup)".to_owned(), "fill(cup)".to_owned()]).unwrap_err().0, 1);
        for name in ["", "a b", "a,b", "1a", "gripper", "é"] {
            assert!(PoseSchema::usual(&[name], false, false).is_err(), "{name}");
        }
    }
}
