//! Numbers of a file that keep a rule. The error says what was found and what was expected.

use serde::de::{Deserialize, Deserializer, Error};

use crate::object::SIDES;

/// A number of more than 0.
pub(super) fn positive<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    let value = f64::deserialize(deserializer)?;
    refuse(&[value])?;
    Ok(value)
}

/// Numbers that are all of more than 0.
pub(super) fn all_positive<'de, D: Deserializer<'de>, const N: usize>(deserializer: D) -> Result<[f64; N], D::Error>
where
    [f64; N]: Deserialize<'de>,
{
    let values = <[f64; N]>::deserialize(deserializer)?;
    refuse(&values)?;
    Ok(values)
}

/// How many flat walls a cup has.
pub(super) fn sides<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u32, D::Error> {
    let sides = u32::deserialize(deserializer)?;
    if SIDES.contains(&sides) {
        return Ok(sides);
    }
    Err(D::Error::custom(format!("{sides}: expected {} to {} sides", SIDES.start(), SIDES.end())))
}

/// An error if a number is not more than 0.
fn refuse<E: Error>(values: &[f64]) -> Result<(), E> {
    values
        .iter()
        .find(|value| value.is_nan() || **value <= 0.0)
        .map_or(Ok(()), |value| Err(E::custom(format!("{value}: expected more than 0"))))
}
