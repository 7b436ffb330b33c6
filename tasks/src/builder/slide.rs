//! What slides, and how hard the hand may press on it: `[[joint]]`, `[guard]` and `solver_iterations`.

use std::collections::BTreeSet;

use situ_sim::{Guard, Mobility, Pose, Slide, World};

use super::check::Builder;
use super::layers::{Located, New, laid_over};
use super::names::Names;
use crate::error::TaskError;
use crate::file::SlideFile;
use crate::key::Key;
use crate::placement::Placed;
use crate::vocabulary::Role;

/// How many iterations the solver of the physics may make in a step. More than these change nothing.
const ITERATIONS: std::ops::RangeInclusive<usize> = 1..=64;

impl<'a> Builder<'a> {
    /// The slides of the file with those of a variation: one of the same object replaces.
    pub(super) fn merged_slides(
        &self,
        lists: [Located<'a, SlideFile>; 2],
    ) -> Result<Located<'a, SlideFile>, TaskError> {
        for list in &lists {
            let mut seen = BTreeSet::new();
            for (key, slide) in list {
                if !seen.insert(slide.object.as_str()) {
                    let expected = format!("`{}` slides already; expected one `[[joint]]` for an object", slide.object);
                    return self.wrong(&key.field("object"), expected);
                }
            }
        }
        Ok(laid_over(lists, |slide| &slide.object, New::Last))
    }

    /// A slide of the file: `[[joint]]`.
    pub(super) fn slide(
        &self,
        key: &Key,
        file: &SlideFile,
        placed: &[Placed],
        names: &Names,
    ) -> Result<Slide, TaskError> {
        for (field, name) in [("object", &file.object), ("parent", &file.parent)] {
            self.check_name(&key.field(field), name, Role::Object, names)?;
        }
        let place = |name: &String| placed.iter().position(|placed| &placed.body.name == name);
        if place(&file.parent) >= place(&file.object) {
            let expected = format!("`{}`: expected an object listed before `{}`", file.parent, file.object);
            return self.wrong(&key.field("parent"), expected);
        }
        if placed.iter().any(|placed| placed.body.name == file.object && placed.body.mobility == Mobility::Fixed) {
            return self.wrong(&key.field("object"), format!("`{}` is fixed; expected one that moves", file.object));
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
        let slide = Slide {
            parent: file.parent.clone(),
            child: file.object.clone(),
            axis: file.axis,
            travel: file.travel,
            value: file.value,
            friction: file.friction,
            damping: file.damping,
            spring: file.spring,
        };
        // As with shapes, the physics is asked for what else it knows.
        let mut world = World::new();
        let bodies = placed.iter().filter(|placed| [&file.object, &file.parent].contains(&&placed.body.name));
        let added: Result<Vec<()>, _> = bodies.map(|placed| world.add(placed.body.clone(), Pose::identity())).collect();
        added.and_then(|_| world.slide(&slide)).map_err(|e| self.document.error(key, e.to_string()))?;
        Ok(slide)
    }

    /// The forces at which a motion ends, and whether the solver's iterations are possible.
    pub(super) fn guard(&self, root: &Key) -> Result<Guard, TaskError> {
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
        Ok(Guard { rise: file.rise, abort: file.abort })
    }
}
