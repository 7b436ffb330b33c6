//! What slides, and how hard the hand may press on it: `[[joint]]`, `[guard]` and `solver_iterations`.

use situ_sim::{Guard, Slide};

use super::check::Builder;
use super::coupling::Coupling;
use super::layers::Located;
use super::names::Names;
use crate::error::TaskError;
use crate::key::KeyPath;
use crate::placement::Placed;

/// How many iterations the solver of the physics may make in a step. More than these change nothing.
const ITERATIONS: std::ops::RangeInclusive<usize> = 1..=64;

impl<'a> Builder<'a> {
    /// The slides of the file with those of a variation: one of the same object replaces.
    pub(super) fn merged_slides(&self, lists: [Located<'a, Slide>; 2]) -> Result<Located<'a, Slide>, TaskError> {
        self.merged_couplings(lists, |slide| &slide.child, ("slides", "joint"))
    }

    /// A slide of the file: `[[joint]]`.
    pub(super) fn slide(
        &self,
        key: &KeyPath,
        file: &Slide,
        placed: &[Placed],
        names: &Names,
    ) -> Result<Slide, TaskError> {
        self.check_coupling(key, &Coupling::slide(file, &|world| world.slide(file)), placed, names)?;
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
