//! The content of a demonstration file, held to its rules.

use situ::demonstration::{Demonstration, Keyframe, Kind};
use situ::state::Schema;
use situ_tasks::{PoseSchema, Poses};

use super::before::{Before, BeforeStep};
use super::content::{FileContent, FileKeyframe, FileStep};
use super::perceived::Perceived;
use super::rules::{Mistake, check_gripper, mistake, pose, word};

/// What a file says, once it is known to be sound.
pub(super) struct Checked {
    pub(super) demonstration: Demonstration,
    pub(super) schema: Schema,
    pub(super) before: Before,
    pub(super) version: u32,
    /// How states follow from poses, where they do.
    pub(super) features: Option<PoseSchema>,
    /// The poses before each keyframe and after the last, where the file gives them.
    pub(super) worlds: Vec<Poses>,
}

fn keyframe(keyframe: &FileKeyframe, perceived: &Perceived, key: &str) -> Result<Keyframe, Mistake> {
    check_gripper(keyframe.gripper.0, keyframe.hold)
        .map_err(|(own, problem)| mistake(format!("{key}.{own}"), problem))?;
    word(&keyframe.reference, format!("{key}.reference"), "that of an object")?;
    if let Some(narration) = &keyframe.narration {
        word(narration, format!("{key}.narration"), "that of a skill")?;
    }
    let keys = (format!("{key}.state"), format!("{key}.world"));
    let state = perceived.state(keyframe.state.as_deref(), keyframe.world.as_ref(), keys)?;
    Ok(Keyframe {
        reference: keyframe.reference.as_str().into(),
        reference_pose: perceived.reference_pose(keyframe, key)?,
        gripper_pose: pose(&keyframe.gripper_pose, &format!("{key}.gripper_pose"))?,
        gripper: keyframe.gripper.0,
        hold: keyframe.hold,
        state,
        announced: keyframe.announced,
        narration: keyframe.narration.as_deref().map(Into::into),
    })
}

pub(super) fn checked(file: FileContent) -> Result<Checked, Mistake> {
    word(&file.name, "name".to_owned(), "one that no other demonstration has")?;
    for (index, feature) in file.schema.iter().flatten().enumerate() {
        word(&feature.name, format!("schema[{index}].name"), "that of a feature")?;
    }
    if file.keyframes.is_empty() {
        return Err(mistake("keyframes", "an empty demonstration, expected at least one keyframe"));
    }
    let perceived = Perceived::of(&file)?;
    let worlds = perceived.worlds(&file)?;
    let step = |(index, step): (usize, FileStep)| {
        let keys = (format!("trail[{index}].state"), format!("trail[{index}].world"));
        let state = perceived.state(step.state.as_deref(), step.world.as_ref(), keys)?;
        Ok(BeforeStep { state, primitive: step.primitive, end: step.end })
    };
    let trail = file.trail.into_iter().enumerate().map(step).collect::<Result<_, Mistake>>()?;
    let before = Before { after: file.after, interrupted: file.interrupted, trail };
    if file.kind == Kind::Original
        && let Some((key, _)) = before.named().first()
    {
        return Err(mistake(key, "an original demonstration begins at START, expected null, or no such key"));
    }
    let keyframes = (file.keyframes.iter().enumerate())
        .map(|(index, each)| keyframe(each, &perceived, &format!("keyframes[{index}]")))
        .collect::<Result<Vec<_>, _>>()?;
    let keys = ("final_state".to_owned(), "final_world".to_owned());
    let final_state = perceived.state(file.final_state.as_deref(), file.final_world.as_ref(), keys)?;
    let schema = perceived.schema().clone();
    let demonstration = Demonstration::new(file.name, file.kind, &schema, keyframes, final_state, file.carried_to_end)
        .map_err(|error| mistake(".", error.to_string()))?;
    let (version, features) = (file.version.unwrap_or(1), perceived.features().cloned());
    Ok(Checked { demonstration, schema, before, version, features, worlds })
}
