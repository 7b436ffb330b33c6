//! The words of conditions and features. The macro [`vocabulary!`] declares a word once, with its meaning, use and
//! measurement.

use crate::expression::{Argument, Call};
use crate::view::View;

/// What a name in a condition or a feature has to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// An object, or a role that objects can fill.
    Object,
    /// An object itself, and no role.
    Body,
    /// An object or the gripper.
    Point,
    /// An object or the table.
    Base,
    /// A container.
    Container,
    /// A container, in a task with beads.
    Filled,
    /// An object that slides.
    Sliding,
    /// An object that turns on a hinge.
    Turning,
}

/// The number that a word takes after its names.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Number {
    /// None.
    No,
    /// A fraction from 0 to 1.
    Fraction,
    /// A number above 0.
    Positive,
    /// A number above 0, which may be left out: then it is this one.
    PositiveOr(f64),
}

/// A word, and how it is used. `M` is the type of its measurement.
pub(crate) struct Word<M> {
    /// The word with its arguments, as a message shows it: `held(a)`.
    pub(crate) usage: &'static str,
    /// What its names have to be, in order: two at most.
    pub(crate) roles: &'static [Role],
    /// The number after them.
    pub(crate) number: Number,
    /// Its measurement. It gets two names, and one that the word does not take is empty.
    pub(crate) measure: M,
}

/// The names and the number that a word was written with.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Arguments {
    names: Vec<String>,
    /// None where the word takes no number.
    pub(crate) number: Option<f64>,
}

impl<M> Word<M> {
    /// The word alone.
    pub(crate) fn word(&self) -> &'static str {
        self.usage.split('(').next().unwrap_or_default()
    }

    /// The arguments of a call of this word. None where it is not used as it should be.
    pub(crate) fn read(&self, call: &Call) -> Option<Arguments> {
        let (names, rest) = call.arguments.split_at_checked(self.roles.len())?;
        let name = |argument: &Argument| match argument {
            Argument::Name(name) => Some(name.clone()),
            _ => None,
        };
        let names = names.iter().map(name).collect::<Option<Vec<String>>>()?;
        let number = match (self.number, rest) {
            (Number::No, []) => None,
            (Number::PositiveOr(usual), []) => Some(usual),
            (Number::Fraction, [Argument::Number(f)]) if (0.0..=1.0).contains(f) => Some(*f),
            (Number::Positive | Number::PositiveOr(_), [Argument::Number(x)]) if *x > 0.0 => Some(*x),
            _ => return None,
        };
        Some(Arguments { names, number })
    }

    /// The word with these arguments, as it is written.
    pub(crate) fn write(&self, arguments: &Arguments) -> String {
        let number = arguments.number.map(|number| number.to_string());
        let all: Vec<&str> = arguments.names.iter().map(String::as_str).chain(number.as_deref()).collect();
        format!("{}({})", self.word(), all.join(", "))
    }

    /// Calls `visit` with each name and the part it plays.
    pub(crate) fn visit_names(&self, arguments: &Arguments, visit: &mut dyn FnMut(&str, Role)) {
        arguments.names.iter().zip(self.roles).for_each(|(name, role)| visit(name, *role));
    }
}

impl Arguments {
    /// The names, as they are written.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    /// The two objects that the names speak of in a view. One that the word does not take is empty. None where a role
    /// is filled by nothing.
    pub(crate) fn names_in<'a>(&'a self, view: &View<'a>) -> Option<[&'a str; 2]> {
        let name = |place: usize| self.names.get(place).map_or(Some(""), |name| view.object(name));
        Some([name(0)?, name(1)?])
    }
}

/// Declares a vocabulary: an enum with one variant for each word. Each line gives the variant, how the word is written,
/// what its names have to be, the number after them, and the measurement. The type of the measurement stands after the
/// name of the enum.
macro_rules! vocabulary {
    ($(#[$about:meta])* $visible:vis enum $vocabulary:ident: $measure:ty;
     $($(#[$meaning:meta])* $variant:ident = $usage:literal, [$($role:ident),*], $number:expr, $measured:expr;)*) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        $visible enum $vocabulary { $($(#[$meaning])* $variant),* }

        impl $vocabulary {
            /// All of them, in the order of their declaration.
            pub(crate) const ALL: &[$vocabulary] = &[$($vocabulary::$variant),*];

            /// The word, as it is declared.
            pub(crate) fn declared(self) -> $crate::vocabulary::Word<$measure> {
                use $crate::vocabulary::{Role, Word};
                match self {
                    $($vocabulary::$variant =>
                        Word { usage: $usage, roles: &[$(Role::$role),*], number: $number, measure: $measured },)*
                }
            }

            /// The word of a call, if it is one of these.
            pub(crate) fn of(call: &$crate::expression::Call) -> Option<$vocabulary> {
                Self::ALL.iter().copied().find(|word| word.declared().word() == call.word)
            }
        }
    };
}
pub(crate) use vocabulary;
