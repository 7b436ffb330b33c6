//! What a slide and a hinge have in common: one object moves on another, in one way.

use std::collections::BTreeSet;

use situ_sim::{Hinge, Mobility, Pose, SimError, Slide, World};

use super::check::Builder;
use super::layers::{Located, New, laid_over};
use super::names::Names;
use crate::error::TaskError;
use crate::key::KeyPath;
use crate::placement::Placed;
use crate::vocabulary::Role;

/// A slide or a hinge, as far as they are alike.
pub(super) struct Coupling<'a> {
    parent: &'a String,
    child: &'a String,
    axis: [f64; 3],
    travel: f64,
    value: f64,
    /// Friction, damping and spring, with their keys.
    resists: [(&'static str, f64); 3],
    /// How the physics takes it.
    join: &'a dyn Fn(&mut World) -> Result<(), SimError>,
}

impl<'a> Coupling<'a> {
    pub(super) fn slide(file: &'a Slide, join: &'a dyn Fn(&mut World) -> Result<(), SimError>) -> Self {
        let resists = [("friction", file.friction), ("damping", file.damping), ("spring", file.spring)];
        let Slide { parent, child, axis, travel, value, .. } = file;
        Self { parent, child, axis: *axis, travel: *travel, value: *value, resists, join }
    }

    pub(super) fn hinge(file: &'a Hinge, join: &'a dyn Fn(&mut World) -> Result<(), SimError>) -> Self {
        let resists = [("friction", file.friction), ("damping", file.damping), ("spring", file.spring)];
        let Hinge { parent, child, axis, travel, value, .. } = file;
        Self { parent, child, axis: *axis, travel: *travel, value: *value, resists, join }
    }
}

impl<'a> Builder<'a> {
    /// The slides or hinges of the file with those of a variation: one of the same object replaces. `verb` and `table`
    /// are for the message where an object has two.
    pub(super) fn merged_couplings<T>(
        &self,
        lists: [Located<'a, T>; 2],
        child: fn(&T) -> &String,
        (verb, table): (&str, &str),
    ) -> Result<Located<'a, T>, TaskError> {
        for list in &lists {
            let mut seen = BTreeSet::new();
            for (key, coupling) in list {
                let name = child(coupling);
                if !seen.insert(name.as_str()) {
                    let expected = format!("`{name}` {verb} already; expected one `[[{table}]]` for an object");
                    return self.wrong(&key.field("object"), expected);
                }
            }
        }
        Ok(laid_over(lists, child, New::Last))
    }

    /// Checks what a slide and a hinge must both be.
    pub(super) fn check_coupling(
        &self,
        key: &KeyPath,
        coupling: &Coupling<'_>,
        placed: &[Placed],
        names: &Names,
    ) -> Result<(), TaskError> {
        let Coupling { parent, child, axis, travel, value, resists, join } = coupling;
        for (field, name) in [("object", child), ("parent", parent)] {
            self.check_name(&key.field(field), name, Role::Body, names)?;
        }
        let place = |name: &String| placed.iter().position(|placed| &placed.body.name == name);
        if place(parent) >= place(child) {
            let expected = format!("`{parent}`: expected an object listed before `{child}`");
            return self.wrong(&key.field("parent"), expected);
        }
        if placed.iter().any(|placed| placed.body.name == **child && placed.body.mobility == Mobility::Fixed) {
            return self.wrong(&key.field("object"), format!("`{child}` is fixed; expected one that moves"));
        }
        if axis.iter().all(|&part| part == 0.0) {
            return self.wrong(&key.field("axis"), "[0, 0, 0]: expected a direction");
        }
        self.check_positive(&key.field("travel"), *travel)?;
        if !(0.0..=*travel).contains(value) {
            return self.wrong(&key.field("value"), format!("{value}: expected 0 to {travel}"));
        }
        for (name, value) in *resists {
            self.check_not_negative(&key.field(name), value)?;
        }
        // As with shapes, the physics is asked for what else it knows.
        let mut world = World::new();
        let bodies = placed.iter().filter(|placed| [*child, *parent].contains(&&placed.body.name));
        let added: Result<Vec<()>, _> = bodies.map(|placed| world.add(placed.body.clone(), Pose::identity())).collect();
        added.and_then(|_| join(&mut world)).map_err(|error| self.document.error(key, error.to_string()))
    }
}
