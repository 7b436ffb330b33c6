//! The task file as it is written: plain records for serde, before anything is checked.
//!
//! Unknown keys are refused everywhere. Metres, radians, seconds, newtons, kg/m³.

use serde::Deserialize;
use situ_sim::{Guard, Hinge, Object, Shape, Slide, Symmetry};

use crate::edit::NeededEdit;
use crate::moment::Moment;
use crate::placement::{HandStart, Start};
use crate::sight::Perception;

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
    /// How well a camera sees; without it everything is seen as it is.
    pub(crate) perception: Option<Perception>,
    pub(crate) beads: Option<BeadsFile>,
    pub(crate) object: Vec<ObjectFile>,
    #[serde(default)]
    pub(crate) role: Vec<RoleFile>,
    #[serde(default)]
    pub(crate) joint: Vec<Slide>,
    #[serde(default)]
    pub(crate) hinge: Vec<Hinge>,
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
    #[serde(default)]
    pub(crate) graded: bool,
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
    pub(crate) role: Vec<RoleFile>,
    #[serde(default)]
    pub(crate) joint: Vec<Slide>,
    #[serde(default)]
    pub(crate) hinge: Vec<Hinge>,
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
    /// The role that it can fill.
    pub(crate) role: Option<String>,
    pub(crate) symmetry: Option<Symmetry>,
    pub(crate) start: Start,
}

impl ObjectFile {
    /// The body of the object.
    pub(crate) fn body(&self) -> Object {
        let body = self.shape.object(&self.name);
        let body = if self.fixed { body.fixed() } else { body };
        let body = if let Some(color) = self.color { body.with_color(color) } else { body };
        if let Some(symmetry) = self.symmetry { body.with_symmetry(symmetry) } else { body }
    }
}

/// A role that the objects with its name can fill.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RoleFile {
    pub(crate) name: String,
    /// The condition, about `it`, under which an object is done.
    pub(crate) done: String,
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

#[cfg(test)]
mod tests {
    use serde_reflection::{ContainerFormat, Samples, Tracer, TracerConfig, VariantFormat};

    use situ_sim::Shape;

    use super::TaskFile;
    use crate::edit::NeededEdit;
    use crate::feature::Quantity;
    use crate::moment::Moment;
    use crate::predicate::Condition;

    const REFERENCE: &str = include_str!("../../bench/docs/task-files.md");

    /// Where the reference names the keys of a record: the heading of the section, and the row where it has one alone.
    const PLACES: [(&str, &str, &str); 36] = [
        ("TaskFile", "## The file", ""),
        ("HandStart", "## The file", "| `[gripper]`"),
        ("Guard", "## The file", "| `[guard]`"),
        ("ObjectFile", "## Objects", ""),
        ("Symmetry", "## Objects", "| `symmetry`"),
        ("Start", "## Objects", ""),
        ("Shape", "## Shapes", ""),
        ("Block", "## Shapes", "| `block`"),
        ("Cylinder", "## Shapes", "| `cylinder`"),
        ("Sphere", "## Shapes", "| `ball`"),
        ("Cup", "## Shapes", "| `cup`"),
        ("Handle", "## Shapes", "| `handle`"),
        ("Bin", "## Shapes", "| `bin`"),
        ("Lid", "## Shapes", "| `lid`"),
        ("Cover", "## Shapes", "| `cover`"),
        ("Mat", "## Shapes", "| `mat`"),
        ("Panel", "## Shapes", "| `panel`"),
        ("Mesh", "## Shapes", "| `mesh`"),
        ("Cabinet", "## Shapes", "| `cabinet`"),
        ("Drawer", "## Shapes", "| `drawer`"),
        ("Housing", "## Shapes", "| `housing`"),
        ("BeadsFile", "## Beads", ""),
        ("RoleFile", "## Roles", ""),
        ("Slide", "## Joints", ""),
        ("Hinge", "## Hinges", ""),
        ("MagnetFile", "## Magnets", ""),
        ("Perception", "## Perception", ""),
        ("SkillFile", "## Skills", ""),
        ("KeyframeFile", "## Skills", ""),
        ("EventFile", "## Events", ""),
        ("AfterFile", "## Events", "| `after`"),
        ("InterventionFile", "## Interventions", ""),
        ("Moment", "## Interventions", "| `moment`"),
        ("VariationFile", "## Variations", ""),
        ("NeededEdit", "## Variations", "| `edit`"),
        ("SequenceFile", "## Sequences", ""),
    ];

    /// What is said of all shapes at once.
    const OF_ALL_SHAPES: [&str; 2] = ["density", "friction"];

    /// The words in code spans of a section of the reference, or of one row of it.
    fn words(heading: &str, row: &str) -> Vec<&'static str> {
        let section = REFERENCE.split_once(heading).unwrap_or_else(|| panic!("no section `{heading}`")).1;
        let section = section.split("\n## ").next().unwrap_or_default();
        let lines = section.lines().filter(|line| line.starts_with(row));
        let spans = lines.flat_map(|line| line.split('`').skip(1).step_by(2));
        spans.flat_map(|span| span.split(|c: char| !(c.is_ascii_alphanumeric() || "_-".contains(c)))).collect()
    }

    #[test]
    fn the_reference_names_every_key_that_is_read() {
        // Numbers that every rule of the shapes allows.
        let config = TracerConfig::default().default_f64_value(0.5).default_u32_value(4);
        let mut tracer = Tracer::new(config);
        let samples = Samples::new();
        // All variants of an enum are met only where it is traced for itself.
        let traced = [
            tracer.trace_type::<Shape>(&samples).map(drop),
            tracer.trace_type::<Moment>(&samples).map(drop),
            tracer.trace_type::<NeededEdit>(&samples).map(drop),
            tracer.trace_type::<TaskFile>(&samples).map(drop),
        ];
        assert_eq!(traced, [Ok(()), Ok(()), Ok(()), Ok(())]);
        let registry = tracer.registry().expect("the records can be traced");
        let mut keys = 0;
        for (record, format) in &registry {
            let place = PLACES.iter().find(|(name, ..)| name == record);
            let (_, heading, row) = place.unwrap_or_else(|| panic!("`{record}` has no place in the reference"));
            let known = words(heading, row);
            let own: Vec<&str> = match format {
                ContainerFormat::Struct(fields) => fields.iter().map(|field| field.name.as_str()).collect(),
                ContainerFormat::Enum(variants) => {
                    let is_unit = |variant: &VariantFormat| !matches!(variant, VariantFormat::Variable(_));
                    assert!(variants.values().all(|variant| is_unit(&variant.value)), "{record}");
                    variants.values().map(|variant| variant.name.as_str()).collect()
                }
                other => panic!("`{record}` is {other:?}"),
            };
            for key in own.into_iter().filter(|key| *heading != "## Shapes" || !OF_ALL_SHAPES.contains(key)) {
                assert!(known.contains(&key), "`{key}` of `{record}` is not in {heading} {row}");
                keys += 1;
            }
        }
        assert_eq!(registry.len(), PLACES.len(), "a place that no record has");
        assert!(keys > 100, "{keys}");
    }

    #[test]
    fn the_reference_names_every_condition_and_feature() {
        let conditions = words("## Conditions", "| `");
        for word in Condition::ALL.iter().map(|condition| condition.declared().word()) {
            assert!(conditions.contains(&word), "{word}");
        }
        assert!(["not", "all", "any", "at_least", "each", "it", "table"].iter().all(|word| conditions.contains(word)));
        let features = words("## Features", "| `");
        for word in Quantity::ALL.iter().map(|quantity| quantity.declared().word()) {
            assert!(features.contains(&word), "{word}");
        }
    }
}
