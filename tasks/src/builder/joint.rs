//! What slides, and how hard the hand may press on it: `[[joint]]`, `[guard]` and `solver_iterations`.

use std::collections::BTreeSet;

use situ_sim::{Guard, Motion, Pose, Slide, World};

use super::{Builder, Located, Names, located};
use crate::error::TaskError;
use crate::file::{JointFile, VariationFile};
use crate::key::Key;
use crate::predicate::Role;
use crate::setting::Placed;

/// How many iterations the physics' solver may make in a step: with more, nothing changes.
const ITERATIONS: std::ops::RangeInclusive<usize> = 1..=64;

impl<'a> Builder<'a> {
    /// The base's joints with those of the variation: one of the same object replaces.
    pub(super) fn merged_joints(
        &self,
        patch: &Option<(Key, &'a VariationFile)>,
    ) -> Result<Located<'a, JointFile>, TaskError> {
        let mut merged: Located<'a, JointFile> = Vec::new();
        let base = located(&Key::default(), "joint", &self.file.joint);
        let patches = patch.as_ref().map(|(key, variation)| located(key, "joint", &variation.joint));
        for list in std::iter::once(base).chain(patches) {
            let mut seen = BTreeSet::new();
            for (key, joint) in list {
                if !seen.insert(joint.object.as_str()) {
                    let expected = format!("`{}` slides already; expected one joint an object", joint.object);
                    return self.wrong(&key.field("object"), expected);
                }
                match merged.iter_mut().find(|(_, old)| old.object == joint.object) {
                    Some(old) => *old = (key, joint),
                    None => merged.push((key, joint)),
                }
            }
        }
        Ok(merged)
    }

    /// A joint of the file.
    pub(super) fn joint(
        &self,
        key: &Key,
        file: &JointFile,
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
        if placed.iter().any(|placed| placed.body.name == file.object && placed.body.motion == Motion::Fixed) {
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
