//! What a competent teacher does: `[[skill]]`.

use situ_sim::{GripperCommand, MAX_SQUEEZE, pose_at, rotation_about};

use super::check::Builder;
use super::layers::Located;
use super::names::Names;
use crate::error::TaskError;
use crate::file::{KeyframeFile, SkillFile};
use crate::key::KeyPath;
use crate::skill::{KeyframeCommand, Skill};
use crate::vocabulary::Role;

impl Builder<'_> {
    pub(super) fn skills(&self, files: &Located<'_, SkillFile>, names: &Names) -> Result<Vec<Skill>, TaskError> {
        let mut skills = Vec::new();
        for (key, file) in files {
            self.check_name(&key.field("reference"), &file.reference, Role::Object, names)?;
            if file.keyframes.is_empty() {
                return self.wrong(&key.field("keyframes"), "expected at least one keyframe");
            }
            let mut keyframes = Vec::new();
            for (i, keyframe) in file.keyframes.iter().enumerate() {
                keyframes.push(self.keyframe(&key.field("keyframes").index(i), keyframe, file.tool)?);
            }
            skills.push(Skill {
                name: file.name.clone(),
                reference: file.reference.clone(),
                when: self.predicate(&key.field("when"), &file.when, names)?,
                until: self.predicate(&key.field("until"), &file.until, names)?,
                keyframes,
            });
        }
        if skills.is_empty() {
            return self.wrong(&KeyPath::default().field("skill"), "expected at least one skill");
        }
        Ok(skills)
    }

    pub(super) fn keyframe(
        &self,
        key: &KeyPath,
        file: &KeyframeFile,
        tool: [f64; 3],
    ) -> Result<KeyframeCommand, TaskError> {
        let gripper = match (file.open, file.close) {
            (Some(_), Some(_)) => {
                return self.wrong(&key.field("close"), "expected either `open` or `close`, not both");
            }
            (Some(width), None) => {
                self.check_opening(&key.field("open"), width)?;
                Some(GripperCommand::Open(width))
            }
            (None, Some(force)) => {
                if !(force > 0.0 && force <= MAX_SQUEEZE) {
                    let expected =
                        format!("{force}: expected a force of more than 0 and at most {MAX_SQUEEZE} newtons");
                    return self.wrong(&key.field("close"), expected);
                }
                Some(GripperCommand::Close(force))
            }
            (None, None) => None,
        };
        self.check_not_negative(&key.field("hold"), file.hold)?;
        let [roll, pitch, yaw] = file.rpy;
        let rotation = rotation_about([0.0, 0.0, 1.0], yaw)
            * rotation_about([0.0, 1.0, 0.0], pitch)
            * rotation_about([1.0, 0.0, 0.0], roll);
        let tool = pose_at(tool, Default::default());
        let pose = pose_at(file.at, rotation) * tool.inverse();
        Ok(KeyframeCommand { pose, gripper, hold: file.hold, contact: file.contact })
    }
}
