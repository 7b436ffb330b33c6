//! The names that conditions, features and skills may speak of, and what each of them is.

use std::collections::{BTreeMap, BTreeSet};

use situ_sim::Slide;

use super::layers::Located;
use crate::file::ObjectFile;
use crate::measure::GRIPPER;
use crate::vocabulary::Role;

/// The objects of a setting, as far as names are concerned.
pub(super) struct Names {
    /// Each object, and whether it is a container.
    objects: BTreeMap<String, bool>,
    sliding: BTreeSet<String>,
    beads: bool,
}

impl Names {
    pub(super) fn new(objects: &Located<'_, ObjectFile>, slides: &Located<'_, Slide>, beads: bool) -> Names {
        let objects = objects.iter().map(|(_, file)| (file.name.clone(), file.body().container.is_some()));
        let sliding = slides.iter().map(|(_, slide)| slide.child.clone());
        Names { objects: objects.collect(), sliding: sliding.collect(), beads }
    }

    /// These names and those of `others`.
    pub(super) fn and(mut self, others: Names) -> Names {
        self.objects.extend(others.objects);
        self.sliding.extend(others.sliding);
        self.beads |= others.beads;
        self
    }

    /// What is wrong with a name in this role, if anything.
    pub(super) fn mistake(&self, name: &str, role: Role) -> Option<String> {
        let known = || self.objects.keys().cloned().collect::<Vec<_>>().join(", ");
        match (self.objects.get(name), role) {
            (None, Role::Point) if name == GRIPPER => None,
            (None, _) => Some(format!("there is no object `{name}`; expected one of {}", known())),
            (Some(_), Role::Sliding) if !self.sliding.contains(name) => {
                Some(format!("`{name}` does not slide; expected the object of a `[[joint]]`"))
            }
            (Some(false), Role::Container | Role::Filled) => {
                Some(format!("`{name}` is no container; expected a cup, a bin or a drawer"))
            }
            (Some(_), Role::Filled) if !self.beads => {
                Some(format!("nothing can be in `{name}`: there are no beads; expected `[beads]`"))
            }
            _ => None,
        }
    }
}
