//! The task file as it is written: plain records for serde, before anything is checked.
//!
//! Unknown keys are refused everywhere. Metres, radians, seconds, newtons, kg/m³.

use serde::Deserialize;
use situ_sim::{Guard, Object, Shape, Slide};

use crate::edit::NeededEdit;
use crate::moment::Moment;
use crate::placement::{HandStart, Start};

/// A whole task file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TaskFile {
    pub(crate) name: String,
    pub(crate) analysis: String,
    pub(crate) time_limit: f64,
    pub(crate) premise: String,
    pub(crate) goal: String,
    pub(crate) observe: Vec<String>,
    pub(crate) gripper: HandStart,
    /// Forces at which a motion ends; those of the physics unless given.
    pub(crate) guard: Option<Guard>,
    /// Iterations of the physics' solver; its own number unless given.
    pub(crate) solver_iterations: Option<usize>,
    pub(crate) beads: Option<BeadsFile>,
    pub(crate) object: Vec<ObjectFile>,
    #[serde(default)]
    pub(crate) joint: Vec<Slide>,
    #[serde(default)]
    pub(crate) magnet: Vec<MagnetFile>,
    pub(crate) skill: Vec<SkillFile>,
    #[serde(default)]
    pub(crate) event: Vec<EventFile>,
    #[serde(default)]
    pub(crate) intervention: Vec<InterventionFile>,
    #[serde(default)]
    pub(crate) variation: Vec<VariationFile>,
    #[serde(default)]
    pub(crate) sequence: Vec<SequenceFile>,
}

/// Variations that are met one after another.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SequenceFile {
    pub(crate) name: String,
    pub(crate) analysis: String,
    pub(crate) variations: Vec<String>,
}

/// What a variation changes; what it does not name stays as it is.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct VariationFile {
    pub(crate) name: String,
    pub(crate) edit: NeededEdit,
    pub(crate) analysis: String,
    #[serde(default)]
    pub(crate) accepts_edges: Vec<[String; 2]>,
    pub(crate) time_limit: Option<f64>,
    pub(crate) premise: Option<String>,
    pub(crate) goal: Option<String>,
    pub(crate) beads: Option<BeadsFile>,
    #[serde(default)]
    pub(crate) object: Vec<ObjectFile>,
    #[serde(default)]
    pub(crate) joint: Vec<Slide>,
    #[serde(default)]
    pub(crate) magnet: Vec<MagnetFile>,
    #[serde(default)]
    pub(crate) skill: Vec<SkillFile>,
    #[serde(default)]
    pub(crate) event: Vec<EventFile>,
    #[serde(default)]
    pub(crate) intervention: Vec<InterventionFile>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BeadsFile {
    pub(crate) container: String,
    pub(crate) count: usize,
    pub(crate) radius: f64,
    pub(crate) density: f64,
    pub(crate) friction: f64,
    pub(crate) angular_damping: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObjectFile {
    pub(crate) name: String,
    pub(crate) shape: Shape,
    #[serde(default)]
    pub(crate) fixed: bool,
    pub(crate) color: Option<[u8; 3]>,
    pub(crate) start: Start,
}

impl ObjectFile {
    /// The body of the object.
    pub(crate) fn body(&self) -> Object {
        let body = self.shape.object(&self.name);
        let body = if self.fixed { body.fixed() } else { body };
        if let Some(color) = self.color { body.with_color(color) } else { body }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MagnetFile {
    pub(crate) a: String,
    pub(crate) b: String,
    pub(crate) seat: [f64; 3],
    pub(crate) force: f64,
    pub(crate) range: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SkillFile {
    pub(crate) name: String,
    pub(crate) reference: String,
    pub(crate) when: String,
    pub(crate) until: String,
    /// The point of the hand, in the frame of the TCP, that the keyframes' positions speak of: the lip of a held
    /// pitcher.
    #[serde(default)]
    pub(crate) tool: [f64; 3],
    pub(crate) keyframes: Vec<KeyframeFile>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct KeyframeFile {
    pub(crate) at: [f64; 3],
    /// Roll, pitch, yaw: turned about x, then y, then z of the reference frame.
    #[serde(default)]
    pub(crate) rpy: [f64; 3],
    pub(crate) open: Option<f64>,
    pub(crate) close: Option<f64>,
    #[serde(default)]
    pub(crate) hold: f64,
    #[serde(default)]
    pub(crate) contact: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct EventFile {
    pub(crate) name: String,
    pub(crate) after: AfterFile,
    /// The object that is pushed, and how far; or the one that slips from the hand.
    pub(crate) push: Option<String>,
    pub(crate) by: Option<[f64; 3]>,
    pub(crate) drop: Option<String>,
    pub(crate) seconds: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct AfterFile {
    pub(crate) reference: String,
    pub(crate) keyframe: usize,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct InterventionFile {
    pub(crate) name: String,
    pub(crate) moment: Moment,
    pub(crate) reference: Option<String>,
    pub(crate) when: String,
}
