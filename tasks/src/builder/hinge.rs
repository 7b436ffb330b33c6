//! What turns on what: `[[hinge]]`.

use situ_sim::Hinge;

use super::check::Builder;
use super::coupling::Coupling;
use super::layers::Located;
use super::names::Names;
use crate::error::TaskError;
use crate::key::KeyPath;
use crate::placement::Placed;
use crate::vocabulary::Role;

impl<'a> Builder<'a> {
    /// The hinges of the file with those of a variation: one of the same object replaces.
    pub(super) fn merged_hinges(&self, lists: [Located<'a, Hinge>; 2]) -> Result<Located<'a, Hinge>, TaskError> {
        self.merged_couplings(lists, |hinge| &hinge.child, ("turns", "hinge"))
    }

    /// A hinge of the file.
    pub(super) fn hinge(
        &self,
        key: &KeyPath,
        file: &Hinge,
        placed: &[Placed],
        names: &Names,
    ) -> Result<Hinge, TaskError> {
        if names.mistake(&file.child, Role::Sliding).is_none() {
            let expected = format!("`{}` slides, by a `[[joint]]`; expected an object that does not", file.child);
            return self.wrong(&key.field("object"), expected);
        }
        self.check_coupling(key, &Coupling::hinge(file, &|world| world.hinge(file)), placed, names)?;
        Ok(file.clone())
    }
}
