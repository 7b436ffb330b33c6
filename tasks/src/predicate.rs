//! Conditions on a world: a small closed vocabulary of physical measurements with named thresholds.

use std::fmt;

use crate::expression::{Argument, Call};
use crate::measure::{distance, fill, is_held, is_inside, is_on, is_put_down, tilt};
use crate::view::View;
use crate::vocabulary::{Arguments, Number, Role, vocabulary};

/// An object is upright while its z axis is within this angle of the vertical, in radians, unless the condition gives
/// another. It is about 17°: far from the 90° of a fallen cup, and well above the tilt of a cup that stands on a crumb.
pub const UPRIGHT_TILT: f64 = 0.3;
/// A button is pressed when it is at least this part of its travel in. Half-way is clear of a button that was only
/// touched, and leaves as much room for one that is not pushed to its stop.
pub const PRESSED_PART: f64 = 0.5;

/// Whether a word holds in a world, for these names and this number. None where an object is not
/// there.
type Holds = fn(&View<'_>, [&str; 2], f64) -> Option<bool>;

vocabulary! {
    /// A condition that measures the world.
    pub enum Condition: Holds;

    /// `held(a)`: both fingers press on `a` from either side with at least [`HELD_FORCE`](crate::HELD_FORCE).
    Held = "held(a)", [Object], Number::No, |view, [a, _], _| Some(is_held(view.world(), a));
    /// `on(a, b)`: `a` touches `b`, and in the frame of `b` the origin of `a` is within its outline (both the circle
    /// and the rectangle that hold it) and not lower than its top. `b` may be `table`.
    On = "on(a, b)", [Object, Base], Number::No, |view, [a, b], _| is_on(view, a, b);
    /// `inside(a, b)`: the origin of `a` is in the room inside the container `b`, a millimetre or more below its rim.
    Inside = "inside(a, b)", [Object, Container], Number::No, |view, [a, b], _| is_inside(view, a, b);
    /// `filled(c, fraction)`: at least this fraction of all beads is in the container `c`.
    Filled = "filled(container, fraction from 0 to 1)", [Filled], Number::Fraction,
        |view, [c, _], fraction| Some(fill(view, c)? >= fraction);
    /// `upright(a)` or `upright(a, radians)`: the z axis of `a` is within [`UPRIGHT_TILT`] or the given angle of the
    /// vertical.
    Upright = "upright(a) or upright(a, radians)", [Object], Number::PositiveOr(UPRIGHT_TILT),
        |view, [a, _], limit| Some(tilt(view, a)? <= limit);
    /// `near(a, b, metres)`: the origins are at most this far apart; either may be `gripper`.
    Near = "near(a, b, positive metres)", [Point, Point], Number::Positive,
        |view, [a, b], limit| Some(distance(view, a, b)? <= limit);
    /// `at(a, b, metres)`: `a` has been put down at the place `b`: at most this far from it in the plane, still, and
    /// not held.
    At = "at(a, b, positive metres)", [Object, Object], Number::Positive,
        |view, [a, b], limit| is_put_down(view, a, b, limit);
    /// `open(a, metres)`: `a` has slid at least this far from the start of its range.
    Open = "open(a, positive metres)", [Sliding], Number::Positive,
        |view, [a, _], metres| Some(view.world().slide_value(a)? >= metres);
    /// `pressed(a)`: `a` has slid at least [`PRESSED_PART`] of its travel.
    Pressed = "pressed(a)", [Sliding], Number::No,
        |view, [a, _], _| Some(view.world().slide_value(a)? >= PRESSED_PART * view.world().slide_travel(a)?);
    /// `turned(a, radians)`: `a` has turned on its hinge at least this far from the start of its range.
    Turned = "turned(a, positive radians)", [Turning], Number::Positive,
        |view, [a, _], radians| Some(view.world().hinge_value(a)? >= radians);
}

/// A condition on a world. Each condition is a measurement, and none knows which variation is being played.
///
/// Written as calls: `all(filled(bowl, 0.8), not(held(pitcher)))`. A count is one, too: `at_least(2, inside(a, bowl),
/// inside(b, bowl), inside(c, bowl))`.
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
    /// `at_least(n, p, …)`: `n` or more of the conditions hold. There are at least `n`, and `n` is not 0.
    AtLeast(usize, Vec<Predicate>),
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

    /// Reads a condition from a call.
    pub(crate) fn from_call(call: &Call) -> Result<Predicate, String> {
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
            ("at_least", [Argument::Number(least), parts @ ..]) => {
                let parts = conditions("at_least", parts)?;
                let least = whole(*least, parts.len()).ok_or_else(|| {
                    format!("at_least({least}, …): expected a whole number from 1 to {}, the conditions", parts.len())
                })?;
                Ok(Predicate::AtLeast(least, parts))
            }
            ("each", _) => Err("expected `each(role, p)` inside `all`, `any` or `at_least` of a task file".to_owned()),
            ("at_least", _) => Err(wrong("at_least(whole number, condition, …)")),
            (word, _) => {
                let known: Vec<&str> = Condition::ALL.iter().map(|condition| condition.declared().usage).collect();
                let known = known.join(", ");
                Err(format!(
                    "unknown condition `{word}`; expected one of {known}, not(p), all(p, …), any(p, …), at_least(n, p, …)"
                ))
            }
        }
    }

    /// Whether the condition holds in a world, or in a view of one. A condition on an object that is not there does not
    /// hold, and neither does one on a role that nothing fills.
    pub fn holds<'a>(&self, view: impl Into<View<'a>>) -> bool {
        self.holds_in(&view.into())
    }

    fn holds_in(&self, view: &View<'_>) -> bool {
        match self {
            Predicate::Measured(Measured { condition, arguments }) => {
                let number = arguments.number.unwrap_or_default();
                let names = arguments.names_in(view);
                names.and_then(|names| (condition.declared().measure)(view, names, number)).unwrap_or(false)
            }
            Predicate::Not(p) => !p.holds_in(view),
            Predicate::All(parts) => parts.iter().all(|p| p.holds_in(view)),
            Predicate::Any(parts) => parts.iter().any(|p| p.holds_in(view)),
            Predicate::AtLeast(least, parts) => parts.iter().filter(|p| p.holds_in(view)).nth(least - 1).is_some(),
        }
    }

    /// Calls `visit` with each name in the condition and the part it plays.
    pub(crate) fn visit_names(&self, visit: &mut dyn FnMut(&str, Role)) {
        match self {
            Predicate::Measured(Measured { condition, arguments }) => {
                condition.declared().visit_names(arguments, visit)
            }
            Predicate::Not(p) => p.visit_names(visit),
            Predicate::All(parts) | Predicate::Any(parts) | Predicate::AtLeast(_, parts) => {
                parts.iter().for_each(|p| p.visit_names(visit));
            }
        }
    }
}

/// A whole number from 1 to `most`, written as any number.
fn whole(number: f64, most: usize) -> Option<usize> {
    (1..=most).find(|whole| *whole as f64 == number)
}

/// The conditions between the brackets of `all`, `any` or `at_least`.
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
            Predicate::AtLeast(least, parts) => write!(f, "at_least({least}, {})", list(parts)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back() {
        let text = "all(filled(bowl, 0.8), not(on(lid, pitcher)), any(upright(cup, 0.5), near(gripper, cup, 0.1), open(box, 0.05), pressed(bell)), at_least(2, held(a), on(a, table), all()), all())";
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
            ("at_least(held(cup))", "expected `at_least(whole number, condition, …)`"),
            ("at_least(0, held(cup))", "expected a whole number from 1 to 1"),
            ("at_least(1.5, held(cup), held(bowl))", "expected a whole number from 1 to 2"),
            ("at_least(3, held(cup), held(bowl))", "expected a whole number from 1 to 2"),
            ("at_least(1)", "expected a whole number from 1 to 0"),
            ("at_least(1, cup)", "expected a condition in `at_least`"),
        ] {
            let message = Predicate::parse(text).expect_err("malformed");
            assert!(message.contains(expected), "{text}: {message}");
        }
    }
}
