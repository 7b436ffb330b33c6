//! What the numbers and the names of a demonstration file have to be.

use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use situ::demonstration::{Gripper, Pose};
use situ::state::{Feature, Schema, State};

use super::content::FilePose;

/// How far the length of a quaternion may be from 1. A few printed decimals lose so much.
const QUATERNION_TOLERANCE: f64 = 1e-3;
/// The greatest number of metres, seconds and newtons that is taken for one. Far beyond it a square is infinite.
pub(super) const FARTHEST: f64 = 1e6;
/// The most scales of its feature that a number of a state may be.
const MOST_SCALES: f64 = 1e9;
/// The most features of a schema. The work of a fit grows with them.
const MOST_FEATURES: usize = 10_000;
/// The scales that a feature may have.
const SCALES: std::ops::RangeInclusive<f64> = 1e-9..=1e9;

/// The most letters of a name.
const LONGEST_NAME: usize = 200;

/// A length this near to 1 differs by rounding alone. The quaternion then stays as it was written.
const QUATERNION_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// A mistake: its key, what is wrong, and what was expected.
pub(crate) type Mistake = (String, String);

pub(super) fn mistake(key: impl Into<String>, problem: impl Into<String>) -> Mistake {
    (key.into(), problem.into())
}

/// A pose whose quaternion has the length 1.
pub(crate) fn pose(pose: &FilePose, key: &str) -> Result<Pose, Mistake> {
    let [w, x, y, z] = pose.quaternion;
    let quaternion = Quaternion::new(w, x, y, z);
    let length = libm::sqrt(quaternion.coords.dot(&quaternion.coords));
    if (length - 1.0).abs() > QUATERNION_TOLERANCE {
        let problem = format!("a quaternion of length {length}, expected length 1 (order w, x, y, z)");
        return Err(mistake(format!("{key}.quaternion"), problem));
    }
    let is_unit = (length - 1.0).abs() <= QUATERNION_ROUNDING;
    let rotation = UnitQuaternion::new_unchecked(if is_unit { quaternion } else { quaternion / length });
    if let Some(axis) = pose.position.iter().position(|value| value.abs() > FARTHEST) {
        let problem = format!("{:e} metres, expected at most {FARTHEST} either way", pose.position[axis]);
        return Err(mistake(format!("{key}.position[{axis}]"), problem));
    }
    let [x, y, z] = pose.position;
    Ok(Pose::from_parts(Translation3::new(x, y, z), rotation))
}

pub(super) fn state(values: &[f64], schema: &Schema, key: String) -> Result<State, Mistake> {
    if values.len() != schema.len() {
        let problem = format!("{} numbers, expected {} (one a feature of the schema)", values.len(), schema.len());
        return Err(mistake(key, problem));
    }
    let scales = schema.features().iter().map(|feature| feature.scale);
    if let Some(index) = values.iter().zip(scales).position(|(value, scale)| (value / scale).abs() > MOST_SCALES) {
        let problem = format!("{:e}, expected at most {MOST_SCALES} times the feature's scale", values[index]);
        return Err(mistake(format!("{key}[{index}]"), problem));
    }
    Ok(State::new(values))
}

pub(super) fn schema(features: &[Feature]) -> Result<Schema, Mistake> {
    if features.len() > MOST_FEATURES {
        return Err(mistake("schema", format!("{} features, expected at most {MOST_FEATURES}", features.len())));
    }
    for (index, feature) in features.iter().enumerate() {
        if !SCALES.contains(&feature.scale) {
            let problem = format!("{}, expected a scale of {} to {}", feature.scale, SCALES.start(), SCALES.end());
            return Err(mistake(format!("schema[{index}].scale"), problem));
        }
        if let Some(first) = features[..index].iter().position(|other| other.name == feature.name) {
            let problem = format!("`{}` is the name of schema[{first}] as well, expected another", feature.name);
            return Err(mistake(format!("schema[{index}].name"), problem));
        }
    }
    Schema::new(features.to_vec()).map_err(|error| mistake("schema", error.to_string()))
}

/// Refuses a command that no gripper has, and a rest that has no end.
pub(crate) fn check_gripper(gripper: Gripper, hold: f64) -> Result<(), Mistake> {
    let (is_fine, rule) = match gripper {
        Gripper::Opening(share) => ((0.0..=1.0).contains(&share), "an opening from 0 (closed) to 1 (open)"),
        Gripper::Open(metres) => ((0.0..=FARTHEST).contains(&metres), "a width of 0 to 1000000 metres"),
        Gripper::Close(newtons) => ((0.0..=FARTHEST).contains(&newtons), "a force of 0 to 1000000 newtons"),
    };
    if !is_fine {
        return Err(mistake("gripper", format!("{}, expected {rule}", gripper.value())));
    }
    if !(0.0..=FARTHEST).contains(&hold) {
        return Err(mistake("hold", format!("{hold}, expected 0 to {FARTHEST} seconds")));
    }
    Ok(())
}

/// Refuses a text that is no name: pictures and reports of the model show it on a line of its own.
pub(super) fn word(text: &str, key: String, expected: &str) -> Result<(), Mistake> {
    if text.is_empty() {
        return Err(mistake(key, format!("an empty name, expected {expected}")));
    }
    if text.chars().any(char::is_control) || text.chars().count() > LONGEST_NAME {
        let problem = format!("`{text}`: expected a name of at most {LONGEST_NAME} letters and no control character");
        return Err(mistake(key, problem));
    }
    Ok(())
}
