//! The names that conditions, features and skills may speak of, and what each of them is.

use std::collections::{BTreeMap, BTreeSet};

use situ_sim::{Hinge, Slide, TABLE};

use super::layers::Located;
use crate::file::ObjectFile;
use crate::view::GRIPPER;
use crate::vocabulary::Role;

/// The objects of a setting, as far as names are concerned.
pub(super) struct Names {
    /// Each object, and whether it is a container.
    objects: BTreeMap<String, bool>,
    sliding: BTreeSet<String>,
    turning: BTreeSet<String>,
    /// Each role, and the objects that can fill it.
    roles: BTreeMap<String, Vec<String>>,
    beads: bool,
}

impl Names {
    pub(super) fn new(
        objects: &Located<'_, ObjectFile>,
        slides: &Located<'_, Slide>,
        hinges: &Located<'_, Hinge>,
        beads: bool,
    ) -> Names {
        let mut roles: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for (_, file) in objects {
            if let Some(role) = &file.role {
                roles.entry(role.clone()).or_default().push(file.name.clone());
            }
        }
        let objects = objects.iter().map(|(_, file)| (file.name.clone(), file.body().container.is_some()));
        let sliding = slides.iter().map(|(_, slide)| slide.child.clone());
        let turning = hinges.iter().map(|(_, hinge)| hinge.child.clone()).collect();
        Names { objects: objects.collect(), sliding: sliding.collect(), turning, roles, beads }
    }

    /// These names and those of `others`.
    pub(super) fn and(mut self, others: Names) -> Names {
        self.objects.extend(others.objects);
        self.sliding.extend(others.sliding);
        self.turning.extend(others.turning);
        self.beads |= others.beads;
        for (role, objects) in others.roles {
            self.roles.entry(role).or_default().extend(objects);
        }
        self
    }

    /// The objects that can fill a role; none where there is no such role.
    pub(super) fn objects_of(&self, role: &str) -> Option<&[String]> {
        self.roles.get(role).map(Vec::as_slice)
    }

    pub(super) fn is_role(&self, name: &str) -> bool {
        self.roles.contains_key(name)
    }

    /// What is wrong with a name in this role, if anything.
    pub(super) fn mistake(&self, name: &str, role: Role) -> Option<String> {
        // An object's own name stands for the object, even where a role has the same by mistake.
        if role != Role::Body
            && !self.objects.contains_key(name)
            && let Some(objects) = self.roles.get(name)
        {
            return objects.iter().find_map(|object| self.mistake(object, role));
        }
        let roles = self.roles.keys().filter(|_| role != Role::Body);
        let known = || self.objects.keys().chain(roles).cloned().collect::<Vec<_>>().join(", ");
        match (self.objects.get(name), role) {
            (None, Role::Point) if name == GRIPPER => None,
            (None, Role::Base) if name == TABLE => None,
            (None, Role::Base) => Some(format!("there is no object `{name}`; expected `table` or one of {}", known())),
            (None, _) => Some(format!("there is no object `{name}`; expected one of {}", known())),
            (Some(_), Role::Sliding) if !self.sliding.contains(name) => {
                Some(format!("`{name}` does not slide; expected the object of a `[[joint]]`"))
            }
            (Some(_), Role::Turning) if !self.turning.contains(name) => {
                Some(format!("`{name}` does not turn; expected the object of a `[[hinge]]`"))
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
