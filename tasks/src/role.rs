//! Roles: things of one kind, of which the one that is due is spoken of.

use situ_sim::World;

use crate::measure::is_held;
use crate::predicate::Predicate;
use crate::sight::Sight;
use crate::view::{GRIPPER, View};

/// The name by which the condition `done` of a role speaks of the object that it asks about.
pub(crate) const IT: &str = "it";

/// A role that several objects can fill, one at a time: the ball that is to be put away next.
///
/// The role is filled by an object that is still to be done: one that is in the hand, or for which `done` does not
/// hold. Of these it is the first in the hand; where none is, the one whose origin is nearest to the TCP; where two are
/// equally near, the one that the file lists first. Where all are done, nothing fills the role, and it is as an object
/// that is not there. A robot can know all that: what it holds, and where things are.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectRole {
    /// Its name, which stands where an object's name can stand.
    pub name: String,
    /// The objects that can fill it, in the order of the file, each with the condition under which it is done.
    pub objects: Vec<(String, Predicate)>,
}

impl ObjectRole {
    /// The object that fills the role in a view of a world.
    fn filling(&self, view: &View<'_>) -> Option<&str> {
        let mut best: Option<(&str, bool, f64)> = None;
        for (object, done) in &self.objects {
            let Some((place, tcp)) = view.position(object).zip(view.position(GRIPPER)) else { continue };
            let is_in_hand = is_held(view.world(), object);
            if !is_in_hand && done.holds(view.clone()) {
                continue;
            }
            let distance = (place - tcp).norm();
            let is_better =
                best.is_none_or(|(_, held, least)| if is_in_hand == held { distance < least } else { is_in_hand });
            if is_better {
                best = Some((object, is_in_hand, distance));
            }
        }
        best.map(|(object, ..)| object)
    }
}

/// A world as a camera has seen it, or as it is, with the objects that fill these roles.
pub(crate) fn view<'a>(roles: &'a [ObjectRole], world: &'a World, sight: Option<&'a Sight>) -> View<'a> {
    let view = View::new(world, sight);
    let filled = roles.iter().map(|role| (role.name.as_str(), role.filling(&view))).collect();
    view.with_roles(filled)
}
