//! A task with one variation applied, or none: all that an episode needs.

use situ_sim::{Beads, Guard, Hinge, Magnet, Slide, World};

use crate::edit::NeededEdit;
use crate::event::Event;
use crate::feature::WorldSchema;
use crate::intervention::Intervention;
use crate::placement::{HandStart, Placed};
use crate::plant::Plant;
use crate::predicate::Predicate;
use crate::role::{self, ObjectRole};
use crate::sight::{Perception, Sight};
use crate::skill::Skill;
use crate::view::View;

/// A task with one variation applied, or none (the original).
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// The task's name.
    pub task: String,
    /// The variation's name; none for the original.
    pub variation: Option<String>,
    /// The edit that the variation needs. `None` for the original.
    pub edit: NeededEdit,
    /// Whether it is one of a series of growing changes, of which small ones may not need their edit.
    pub graded: bool,
    /// Why the variation is as it is, in prose. For the original: the prose of the task.
    pub analysis: String,
    /// The transitions, from skill to skill, that an edge edit may add. `start` and `end` are names here, too.
    pub accepts_edges: Vec<[String; 2]>,
    /// The objects, in the order in which they are put down.
    pub objects: Vec<Placed>,
    /// The roles that objects can fill.
    pub roles: Vec<ObjectRole>,
    /// The container that is filled at the start, and its beads.
    pub beads: Option<(String, Beads)>,
    /// What slides along what.
    pub slides: Vec<Slide>,
    /// What turns on what.
    pub hinges: Vec<Hinge>,
    /// Magnets between objects.
    pub magnets: Vec<Magnet>,
    /// What happens during an episode, once each.
    pub events: Vec<Event>,
    /// What must hold after settling, whatever the seed.
    pub premise: Predicate,
    /// What is to be achieved.
    pub goal: Predicate,
    /// The competent teacher's program for this setting. The first skill that may run does.
    pub skills: Vec<Skill>,
    /// The program for the original task, which knows nothing of the variation.
    pub original_skills: Vec<Skill>,
    /// The observed state; the same for all settings of a task.
    pub schema: WorldSchema,
    /// When a watching teacher stops the robot.
    pub interventions: Vec<Intervention>,
    /// Simulated seconds after which an episode has failed.
    pub time_limit: f64,
    /// Forces at which a motion of the hand ends early.
    pub guard: Guard,
    /// Iterations of the physics' solver in each step, if they are not the usual number.
    pub solver_iterations: Option<usize>,
    /// How well a camera sees. None: it sees everything as it is.
    pub perception: Option<Perception>,
    /// Where the hand starts.
    pub hand: HandStart,
    /// What carries it.
    pub plant: Plant,
}

impl Setting {
    /// `task` or `task/variation`, for messages and tables.
    pub fn label(&self) -> String {
        match &self.variation {
            Some(variation) => format!("{}/{variation}", self.task),
            None => self.task.clone(),
        }
    }

    /// A world of this setting as it is, for conditions and features that speak of roles.
    pub fn view<'a>(&'a self, world: &'a World) -> View<'a> {
        role::view(&self.roles, world, None)
    }

    /// The same as a camera has seen it, if there is one.
    pub(crate) fn seen<'a>(&'a self, world: &'a World, sight: Option<&'a Sight>) -> View<'a> {
        role::view(&self.roles, world, sight)
    }

    /// The reference that an object is: the role that it can fill, or itself.
    pub fn reference_of<'a>(&'a self, object: &'a str) -> &'a str {
        let fills = |role: &&ObjectRole| role.objects.iter().any(|(name, _)| name == object);
        self.roles.iter().find(fills).map_or(object, |role| &role.name)
    }

    /// Whether the original task's program has this very skill. If it has, a model of the original task knows how to go
    /// on after it.
    pub fn is_original(&self, skill: &Skill) -> bool {
        let is_same = |original: &Skill| original.reference == skill.reference && original.keyframes == skill.keyframes;
        self.original_skills.iter().any(is_same)
    }

    /// Whether the competent program performs a skill twice in a row: then the setting needs an edge from the skill to
    /// itself.
    pub fn repeats(&self, skill: &str) -> bool {
        self.accepts_edges.iter().any(|[from, to]| from == skill && to == skill)
    }
}
