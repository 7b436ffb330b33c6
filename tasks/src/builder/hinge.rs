//! What turns on what: `[[hinge]]`.

use std::collections::BTreeSet;

use situ_sim::{Hinge, Mobility, Pose, World};

use super::check::Builder;
use super::layers::{Located, New, laid_over};
use super::names::Names;
use crate::error::TaskError;
use crate::key::KeyPath;
use crate::placement::Placed;
use crate::vocabulary::Role;

impl<'a> Builder<'a> {
    /// The hinges of the file with those of a variation: one of the same object replaces.
    pub(super) fn merged_hinges(&self, lists: [Located<'a, Hinge>; 2]) -> Result<Located<'a, Hinge>, TaskError> {
        for list in &lists {
            let mut seen = BTreeSet::new();
            for (key, hinge) in list {
                if !seen.insert(hinge.child.as_str()) {
                    let expected = format!("`{}` turns already; expected one `[[hinge]]` for an object", hinge.child);
                    return self.wrong(&key.field("object"), expected);
                }
            }
        }
        Ok(laid_over(lists, |hinge| &hinge.child, New::Last))
    }

    /// A hinge of the file.
    pub(super) fn hinge(
        &self,
        key: &KeyPath,
        file: &Hinge,
        placed: &[Placed],
        names: &Names,
    ) -> Result<Hinge, TaskError> {
        for (field, name) in [("object", &file.child), ("parent", &file.parent)] {
            self.check_name(&key.field(field), name, Role::Body, names)?;
        }
        if names.mistake(&file.child, Role::Sliding).is_none() {
            let expected = format!("`{}` slides, by a `[[joint]]`; expected an object that does not", file.child);
            return self.wrong(&key.field("object"), expected);
        }
        let place = |name: &String| placed.iter().position(|placed| &placed.body.name == name);
        if place(&file.parent) >= place(&file.child) {
            let expected = format!("`{}`: expected an object listed before `{}`", file.parent, file.child);
            return self.wrong(&key.field("parent"), expected);
        }
        if placed.iter().any(|placed| placed.body.name == file.child && placed.body.mobility == Mobility::Fixed) {
            return self.wrong(&key.field("object"), format!("`{}` is fixed; expected one that moves", file.child));
        }
        if file.axis.iter().all(|&part| part == 0.0) {
            return self.wrong(&key.field("axis"), "[0, 0, 0]: expected a direction");
        }
        self.check_positive(&key.field("travel"), file.travel)?;
        if !(0.0..=file.travel).contains(&file.value) {
            return self.wrong(&key.field("value"), format!("{}: expected 0 to {}", file.value, file.travel));
        }
        for (name, value) in [("friction", file.friction), ("damping", file.damping), ("spring", file.spring)] {
            self.check_not_negative(&key.field(name), value)?;
        }
        // As with shapes, the physics is asked for what else it knows.
        let mut world = World::new();
        let bodies = placed.iter().filter(|placed| [&file.child, &file.parent].contains(&&placed.body.name));
        let added: Result<Vec<()>, _> = bodies.map(|placed| world.add(placed.body.clone(), Pose::identity())).collect();
        added.and_then(|_| world.hinge(file)).map_err(|e| self.document.error(key, e.to_string()))?;
        Ok(file.clone())
    }
}
