//! What slides, and how hard the hand may press on it: `[[joint]]`, `[guard]` and `solver_iterations`.

use std::collections::BTreeSet;

use situ_sim::{Guard, Mobility, Pose, Slide, World};

use super::check::Builder;
use super::layers::{Located, New, laid_over};
use super::names::Names;
use crate::error::TaskError;
use crate::key::KeyPath;
use crate::placement::Placed;
use crate::vocabulary::Role;

/// How many iterations the solver of the physics may make in a step. More than these change nothing.
const ITERATIONS: std::ops::RangeInclusive<usize> = 1..=64;

impl<'a> Builder<'a> {
    /// The slides of the file with those of a variation: one of the same object replaces.
    pub(super) fn merged_slides(&self, lists: [Located<'a, Slide>; 2]) -> Result<Located<'a, Slide>, TaskError> {
        for list in &lists {
            let mut seen = BTreeSet::new();
            for (key, slide) in list {
                if !seen.insert(slide.child.as_str()) {
                    let expected = format!("`{}` slides already; expected one `[[joint]]` for an object", slide.child);
                    return self.wrong(&key.field("object"), expected);
                }
            }
        }
        Ok(laid_over(lists, |slide| &slide.child, New::Last))
    }

    /// A slide of the file: `[[joint]]`.
    pub(super) fn slide(
        &self,
        key: &KeyPath,
        file: &Slide,
        placed: &[Placed],
        names: &Names,
    ) -> Result<Slide, TaskError> {
        for (field, name) in [("object", &file.child), ("parent", &file.parent)] {
            self.check_name(&key.field(field), name, Role::Body, names)?;
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
        added.and_then(|_| world.slide(file)).map_err(|e| self.document.error(key, e.to_string()))?;
        Ok(file.clone())
    }

    /// The forces at which a motion ends, and whether the solver's iterations are possible.
    pub(super) fn guard(&self, root: &KeyPath) -> Result<Guard, TaskError> {
        if let Some(iterations) = self.file.solver_iterations.filter(|n| !ITERATIONS.contains(n)) {
            let expected = format!("{iterations}: expected {} to {}", ITERATIONS.start(), ITERATIONS.end());
            return self.wrong(&root.field("solver_iterations"), expected);
        }
        let Some(file) = &self.file.guard else { return Ok(Guard::default()) };
        let key = root.field("guard");
        self.check_positive(&key.field("rise"), file.rise)?;
        if file.abort < file.rise {
            let expected = format!("{}: expected a force of at least `rise`, {} newtons", file.abort, file.rise);
            return self.wrong(&key.field("abort"), expected);
        }
        Ok(*file)
    }
}
