//! The observed state of a task family: what a camera would give, as one vector of scalars with fixed scales.

use crate::expression::Call;
use crate::measure::{distance, fill, offset, tilt};
use crate::view::View;
use crate::vocabulary::{Arguments, Number, Role, vocabulary};

/// Scale of offsets and distances, in metres (D16).
pub const LENGTH_SCALE: f64 = 0.2;
/// Scale of fill fractions: a tenth of the beads, about what a ladle holds, is a difference that matters (D16 says 0.3,
/// in which one ladle and two look alike).
pub const FILL_SCALE: f64 = 0.1;
/// Scale of tilts, in radians (D16).
pub const TILT_SCALE: f64 = 0.5;
/// Scale of the gripper's opening, in metres: half of its stroke rounded up (D16 says 0.5 for the opening as a
/// fraction).
pub const OPENING_SCALE: f64 = 0.05;
/// Scale of the values of slides, in metres: a button travels less, a drawer more.
pub const SLIDE_SCALE: f64 = 0.05;
/// Scale of the values of hinges, in radians: that of tilts.
pub const ANGLE_SCALE: f64 = TILT_SCALE;
/// Scale of `seen`, which is 0 or 1.
pub const SEEN_SCALE: f64 = 1.0;

/// One scalar of the observed state.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldFeature {
    /// Its name, such as `offset(lid, pitcher).x`.
    pub name: String,
    /// The scale that makes it a number of order one, in its own unit.
    pub scale: f64,
}

/// The scalars of the observed state, in order, and how a world is measured for them. One schema serves a whole family,
/// with all its variations.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldSchema {
    /// One entry for each scalar.
    pub features: Vec<WorldFeature>,
    observables: Vec<Observable>,
}

/// What is measured of a world for two names, of which a word may take fewer: one scalar or three, with their scale.
pub(crate) enum Measure {
    One(f64, fn(&View<'_>, [&str; 2]) -> Option<f64>),
    Three(f64, fn(&View<'_>, [&str; 2]) -> Option<[f64; 3]>),
}

vocabulary! {
    /// What can be observed. Each scalar is 0 where something that it speaks of is not there.
    pub(crate) enum Quantity: Measure;

    /// `opening()`: metres between the finger pads.
    Opening = "opening()", [], Number::No, Measure::One(OPENING_SCALE, |view, _| Some(view.world().opening()));
    /// `offset(a, b)`: the origin of `a` in the frame of `b`, three scalars in metres.
    Offset = "offset(a, b)", [Point, Point], Number::No,
        Measure::Three(LENGTH_SCALE, |view, [a, b]| offset(view, a, b));
    /// `distance(a, b)`: metres between the origins.
    Distance = "distance(a, b)", [Point, Point], Number::No,
        Measure::One(LENGTH_SCALE, |view, [a, b]| distance(view, a, b));
    /// `tilt(a)`: radians between the z axis of `a` and the vertical.
    Tilt = "tilt(a)", [Object], Number::No, Measure::One(TILT_SCALE, |view, [a, _]| tilt(view, a));
    /// `fill(c)`: fraction of all beads in the container.
    Fill = "fill(container)", [Filled], Number::No, Measure::One(FILL_SCALE, |view, [c, _]| fill(view, c));
    /// `joint(a)`: metres that the object has slid from the start of its range.
    Slid = "joint(a)", [Sliding], Number::No, Measure::One(SLIDE_SCALE, |view, [a, _]| view.world().slide_value(a));
    /// `angle(a)`: radians that the object has turned on its hinge from the start of its range.
    Angle = "angle(a)", [Turning], Number::No,
        Measure::One(ANGLE_SCALE, |view, [a, _]| view.world().hinge_value(a));
    /// `seen(a)`: 1 where the object is there.
    Seen = "seen(a)", [Object], Number::No, Measure::One(SEEN_SCALE, |view, [a, _]| view.pose(a).map(|_| 1.0));
}

/// Something that is observed, one or three scalars.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Observable {
    quantity: Quantity,
    arguments: Arguments,
}

impl Observable {
    /// Reads one entry of a task file's `observe`. The error says what was expected.
    pub(crate) fn parse(text: &str) -> Result<Observable, String> {
        let call = Call::parse(text)?;
        let read = Quantity::of(&call)
            .and_then(|quantity| Some(Observable { quantity, arguments: quantity.declared().read(&call)? }));
        read.ok_or_else(|| {
            let known: Vec<&str> = Quantity::ALL.iter().map(|quantity| quantity.declared().usage).collect();
            format!("unknown feature `{}` or wrong arguments; expected one of {}", call.word, known.join(", "))
        })
    }

    /// Calls `visit` with each name and the part it plays.
    pub(crate) fn visit_names(&self, visit: &mut dyn FnMut(&str, Role)) {
        self.quantity.declared().visit_names(&self.arguments, visit);
    }

    /// What is observed, and of which names.
    pub(crate) fn said(&self) -> (Quantity, Vec<&str>) {
        (self.quantity, self.arguments.names().collect())
    }

    /// As it is written.
    pub(crate) fn text(&self) -> String {
        self.quantity.declared().write(&self.arguments)
    }

    /// Its scalars.
    pub(crate) fn features(&self) -> Vec<WorldFeature> {
        let word = self.quantity.declared();
        let name = word.write(&self.arguments);
        match word.measure {
            Measure::One(scale, _) => vec![WorldFeature { name, scale }],
            Measure::Three(scale, _) => {
                ["x", "y", "z"].map(|axis| WorldFeature { name: format!("{name}.{axis}"), scale }).to_vec()
            }
        }
    }

    fn measure(&self, view: &View<'_>, values: &mut Vec<f64>) {
        let names = self.arguments.names_in(view);
        match self.quantity.declared().measure {
            Measure::One(_, scalar) => values.push(names.and_then(|names| scalar(view, names)).unwrap_or(0.0)),
            Measure::Three(_, vector) => {
                values.extend(names.and_then(|names| vector(view, names)).unwrap_or([0.0; 3]));
            }
        }
    }
}

impl WorldSchema {
    pub(crate) fn new(observables: Vec<Observable>) -> WorldSchema {
        let features = observables.iter().flat_map(Observable::features).collect();
        WorldSchema { features, observables }
    }

    /// The number of scalars.
    pub fn len(&self) -> usize {
        self.features.len()
    }

    /// Whether nothing is observed.
    pub fn is_empty(&self) -> bool {
        self.features.is_empty()
    }

    /// The observed state of a world, or of a view of one: raw physical units, one value for each feature.
    pub fn observe<'a>(&self, view: impl Into<View<'a>>) -> Vec<f64> {
        let view = view.into();
        let mut values = Vec::with_capacity(self.len());
        self.observables.iter().for_each(|observable| observable.measure(&view, &mut values));
        values
    }
}
