//! A task with one variation applied, or none: all that an episode needs.

use serde::Deserialize;
use situ_sim::{Beads, Guard, Magnet, Object, Slide, World};

use crate::feature::Schema;
use crate::plant::Plant;
use crate::predicate::Predicate;
use crate::skill::Skill;

/// The edit to a task model that a variation needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Edit {
    /// A primitive that the model does not have.
    NodeAddition,
    /// A transition that the model does not have, between primitives that it has.
    EdgeAddition,
    /// A primitive must be performed in another way.
    NodeModification,
    /// None: the model's relative keyframes absorb the change. The control.
    None,
}

impl Edit {
    /// The word that files use.
    pub fn word(self) -> &'static str {
        match self {
            Edit::NodeAddition => "node-addition",
            Edit::EdgeAddition => "edge-addition",
            Edit::NodeModification => "node-modification",
            Edit::None => "none",
        }
    }
}

/// When an attentive teacher looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Moment {
    /// Before a primitive begins.
    Before,
    /// After a primitive has ended.
    After,
    /// When the guard has stopped a motion of a primitive.
    Guard,
}

/// A moment at which a watching teacher stops the robot. For teaching alone: an evaluation is never interrupted, and no feature shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Intervention {
    /// What the teacher would say.
    pub name: String,
    /// When the teacher looks.
    pub moment: Moment,
    /// The reference object of the primitive that is about to run, runs, or has just run; none for any.
    pub reference: Option<String>,
    /// What the teacher then sees.
    pub when: Predicate,
}

/// Something that happens once, after the hand has reached a keyframe of a primitive on some object.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Its name.
    pub name: String,
    /// The reference object of the primitive…
    pub reference: String,
    /// …and the index of the keyframe that must have been reached. A drop also waits until the object hangs free in the hand.
    pub keyframe: usize,
    /// What happens.
    pub happening: Happening,
    /// In how many seconds; the hand stands still meanwhile.
    pub seconds: f64,
}

/// What happens in an [`Event`].
#[derive(Debug, Clone, PartialEq)]
pub enum Happening {
    /// Somebody bumps into an object, which slides over the table.
    Push {
        /// The object that is pushed.
        object: String,
        /// How far, in metres, world frame.
        by: [f64; 3],
    },
    /// An object slips from the hand: the gripper opens all the way and, when the object has fallen, closes on nothing. The command in
    /// force is then the same as before, as it is after a real slip: only the opening shows that the hand is empty.
    Drop {
        /// The object that is dropped.
        object: String,
    },
}

impl Happening {
    /// The object that it happens to.
    pub fn object(&self) -> &str {
        match self {
            Happening::Push { object, .. } | Happening::Drop { object } => object,
        }
    }
}

/// Where an object starts: anywhere in a region, all places equally likely.
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    /// The object in whose frame the region is; none for the world's.
    pub on: Option<String>,
    /// Least and largest x of the object's origin, in metres.
    pub x: [f64; 2],
    /// Least and largest y of the object's origin, in metres.
    pub y: [f64; 2],
    /// Height of the object's origin, in metres.
    pub z: f64,
    /// Least and largest turn about z, in radians.
    pub yaw: [f64; 2],
    /// Least distance of the origin from those of all objects listed before, in the plane, in metres.
    pub apart: Option<f64>,
}

/// An object, and where it starts.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// Its body.
    pub body: Object,
    /// Where it starts.
    pub start: Start,
}

/// Where the hand starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandStart {
    /// Position of the TCP in the world, in metres; the hand points straight down.
    pub at: [f64; 3],
    /// Metres between the pads.
    pub open: f64,
}

/// A task with one variation applied, or none (the original).
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// The task's name.
    pub task: String,
    /// The variation's name; none for the original.
    pub variation: Option<String>,
    /// The edit that the variation needs; none for the original.
    pub edit: Edit,
    /// Why the variation is as it is, in prose (for the original: the task's).
    pub analysis: String,
    /// The transitions, from skill to skill, that an edge edit may add; `start` and `end` are names here, too.
    pub accepts_edges: Vec<[String; 2]>,
    /// The objects, in the order in which they are put down.
    pub objects: Vec<Placed>,
    /// The container that is filled at the start, and with what.
    pub beads: Option<(String, Beads)>,
    /// What slides along what.
    pub joints: Vec<Slide>,
    /// Magnets between objects.
    pub magnets: Vec<Magnet>,
    /// What happens during an episode, once each.
    pub events: Vec<Event>,
    /// What must hold after settling, whatever the seed.
    pub premise: Predicate,
    /// What is to be achieved.
    pub goal: Predicate,
    /// The competent teacher's program for this setting; the first skill that may run does.
    pub skills: Vec<Skill>,
    /// The program for the original task, which knows nothing of the variation.
    pub original_skills: Vec<Skill>,
    /// The observed state; the same for all settings of a task.
    pub schema: Schema,
    /// When a watching teacher stops the robot.
    pub interventions: Vec<Intervention>,
    /// Simulated seconds after which an episode has failed.
    pub time_limit: f64,
    /// Forces at which a motion of the hand ends early.
    pub guard: Guard,
    /// Iterations of the physics' solver in a step, where it is not the usual number.
    pub solver_iterations: Option<usize>,
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

    /// Whether a condition holds in a world of this setting.
    pub fn holds(&self, predicate: &Predicate, world: &World) -> bool {
        predicate.holds(world)
    }

    /// Whether the competent program performs a skill twice on end: an edge from it to itself is what the setting needs.
    pub fn repeats(&self, skill: &str) -> bool {
        self.accepts_edges.iter().any(|[from, to]| from == skill && to == skill)
    }

    /// The teleo-reactive choice: the first of `skills` whose `when` holds and whose `until` does not.
    pub fn choose<'a>(&self, skills: &'a [Skill], world: &World) -> Option<&'a Skill> {
        skills.iter().find(|skill| self.holds(&skill.when, world) && !self.holds(&skill.until, world))
    }
}
