//! Conditions on a world: a small closed vocabulary of physical measurements with named thresholds.

use std::fmt;

use situ_sim::World;

use crate::expression::{Argument, Call};
use crate::measure::{distance, fill, is_held, is_inside, is_on, is_put_down, tilt};
use crate::vocabulary::{Arguments, Number, Role, vocabulary};

/// An object is upright while its z axis is within this angle of the vertical, in radians, unless the condition gives
/// another. It is about 17°: far from the 90° of a fallen cup, and well above the tilt of a cup that stands on a crumb.
pub const UPRIGHT_TILT: f64 = 0.3;
/// A button is pressed when it is at least this part of its travel in. Half-way is clear of a button that was only
/// touched, and leaves as much room for one that is not pushed to its stop.
pub const PRESSED_PART: f64 = 0.5;

/// Whether a word holds in a world, for these names and this number. None where an object is not
/// there.
type Holds = fn(&World, [&str; 2], f64) -> Option<bool>;

vocabulary! {
    /// A condition that measures the world.
    pub enum Condition: Holds;

    /// `held(a)`: both fingers press on `a` from either side with at least [`HELD_FORCE`](crate::HELD_FORCE).
    Held = "held(a)", [Object], Number::No, |world, [a, _], _| Some(is_held(world, a));
    /// `on(a, b)`: `a` touches `b`, and in the frame of `b` the origin of `a` is within its outline (both the circle
    /// and the rectangle that hold it) and not lower than its top.
    On = "on(a, b)", [Object, Object], Number::No, |world, [a, b], _| is_on(world, a, b);
    /// `inside(a, b)`: the origin of `a` is in the room inside the container `b`, a millimetre or more below its rim.
    Inside = "inside(a, b)", [Object, Container], Number::No, |world, [a, b], _| is_inside(world, a, b);
    /// `filled(c, fraction)`: at least this fraction of all beads is in the container `c`.
    Filled = "filled(container, fraction from 0 to 1)", [Filled], Number::Fraction,
        |world, [c, _], fraction| Some(fill(world, c)? >= fraction);
    /// `upright(a)` or `upright(a, radians)`: the z axis of `a` is within [`UPRIGHT_TILT`] or the given angle of the
    /// vertical.
    Upright = "upright(a) or upright(a, radians)", [Object], Number::PositiveOr(UPRIGHT_TILT),
        |world, [a, _], limit| Some(tilt(world, a)? <= limit);
    /// `near(a, b, metres)`: the origins are at most this far apart; either may be `gripper`.
    Near = "near(a, b, positive metres)", [Point, Point], Number::Positive,
        |world, [a, b], limit| Some(distance(world, a, b)? <= limit);
    /// `at(a, b, metres)`: `a` has been put down at the place `b`: at most this far from it in the plane, still, and
    /// not held.
    At = "at(a, b, positive metres)", [Object, Object], Number::Positive,
        |world, [a, b], limit| is_put_down(world, a, b, limit);
    /// `open(a, metres)`: `a` has slid at least this far from the start of its range.
    Open = "open(a, positive metres)", [Sliding], Number::Positive,
        |world, [a, _], metres| Some(world.slide_value(a)? >= metres);
    /// `pressed(a)`: `a` has slid at least [`PRESSED_PART`] of its travel.
    Pressed = "pressed(a)", [Sliding], Number::No,
        |world, [a, _], _| Some(world.slide_value(a)? >= PRESSED_PART * world.slide_travel(a)?);
}

/// A condition on a world. Each condition is a measurement, and none knows which variation is being played.
///
/// Written as calls: `all(filled(bowl, 0.8), not(held(pitcher)))`.
#[derive(Debug, Clone, PartialEq)]
pub enum Predicate {
    /// A measurement, such as `filled(bowl, 0.8)`.
    Measured(Measured),
    /// `not(p)`.
    Not(Box<Predicate>),
    /// `all(p, …)`; `all()` always holds.
    All(Vec<Predicate>),
    /// `any(p, …)`; `any()` never holds.
    Any(Vec<Predicate>),
}

/// A condition that measures the world, with what it is about.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// What is measured.
    pub condition: Condition,
    arguments: Arguments,
}

impl Predicate {
    /// Reads a condition. The error says what was expected.
    pub fn parse(text: &str) -> Result<Predicate, String> {
        Predicate::from_call(&Call::parse(text)?)
    }

    fn from_call(call: &Call) -> Result<Predicate, String> {
        let wrong = |usage: &str| {
            let found: Vec<String> = call.arguments.iter().map(ToString::to_string).collect();
            format!("expected `{usage}`, found `{}` with the arguments [{}]", call.word, found.join(", "))
        };
        if let Some(condition) = Condition::of(call) {
            let word = condition.declared();
            let arguments = word.read(call).ok_or_else(|| wrong(word.usage))?;
            return Ok(Predicate::Measured(Measured { condition, arguments }));
        }
        match (call.word.as_str(), call.arguments.as_slice()) {
            ("not", [Argument::Call(p)]) => Ok(Predicate::Not(Box::new(Predicate::from_call(p)?))),
            ("not", _) => Err(wrong("not(condition)")),
            ("all", parts) => Ok(Predicate::All(conditions("all", parts)?)),
            ("any", parts) => Ok(Predicate::Any(conditions("any", parts)?)),
            (word, _) => {
                let known: Vec<&str> = Condition::ALL.iter().map(|condition| condition.declared().usage).collect();
                let known = known.join(", ");
                Err(format!("unknown condition `{word}`; expected one of {known}, not(p), all(p, …), any(p, …)"))
            }
        }
    }

    /// Whether the condition holds in `world`. A condition on an object that is not there does not hold.
    pub fn holds(&self, world: &World) -> bool {
        match self {
            Predicate::Measured(Measured { condition, arguments }) => {
                let number = arguments.number.unwrap_or_default();
                (condition.declared().measure)(world, arguments.names(), number).unwrap_or(false)
            }
            Predicate::Not(p) => !p.holds(world),
            Predicate::All(parts) => parts.iter().all(|p| p.holds(world)),
            Predicate::Any(parts) => parts.iter().any(|p| p.holds(world)),
        }
    }

    /// Calls `visit` with each name in the condition and the part it plays.
    pub(crate) fn visit_names(&self, visit: &mut dyn FnMut(&str, Role)) {
        match self {
            Predicate::Measured(Measured { condition, arguments }) => {
                condition.declared().visit_names(arguments, visit)
            }
            Predicate::Not(p) => p.visit_names(visit),
            Predicate::All(parts) | Predicate::Any(parts) => parts.iter().for_each(|p| p.visit_names(visit)),
        }
    }
}

/// The conditions between the brackets of `all` or `any`.
fn conditions(word: &str, parts: &[Argument]) -> Result<Vec<Predicate>, String> {
    let condition = |part: &Argument| match part {
        Argument::Call(call) => Predicate::from_call(call),
        other => Err(format!("expected a condition in `{word}`, found {other}")),
    };
    parts.iter().map(condition).collect()
}

impl fmt::Display for Predicate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |parts: &[Predicate]| parts.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        match self {
            Predicate::Measured(Measured { condition, arguments }) => {
                f.write_str(&condition.declared().write(arguments))
            }
            Predicate::Not(p) => write!(f, "not({p})"),
            Predicate::All(parts) => write!(f, "all({})", list(parts)),
            Predicate::Any(parts) => write!(f, "any({})", list(parts)),
        }
    }
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
