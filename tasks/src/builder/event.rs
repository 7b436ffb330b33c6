//! What happens during an episode, and when a watching teacher stops the robot: `[[event]]` and `[[intervention]]`.

use std::collections::BTreeSet;

use super::check::Builder;
use super::names::Names;
use crate::error::TaskError;
use crate::event::{Event, Happening};
use crate::file::{EventFile, InterventionFile};
use crate::intervention::Intervention;
use crate::key::KeyPath;
use crate::skill::Skill;
use crate::vocabulary::Role;

impl Builder<'_> {
    pub(super) fn event(
        &self,
        key: &KeyPath,
        file: &EventFile,
        names: &Names,
        skills: &[Skill],
    ) -> Result<Event, TaskError> {
        let after = key.field("after");
        self.check_name(&after.field("reference"), &file.after.reference, Role::Object, names)?;
        self.check_positive(&key.field("seconds"), file.seconds)?;
        let happening = self.happening(key, file, names)?;
        let about = skills.iter().filter(|skill| skill.reference == file.after.reference);
        let most = about.map(|skill| skill.keyframes.len()).max().unwrap_or(0);
        if most == 0 {
            let about: BTreeSet<&str> = skills.iter().map(|skill| &*skill.reference).collect();
            let known = about.into_iter().collect::<Vec<_>>().join(", ");
            let expected = format!("no skill is about `{}`; expected one of {known}", file.after.reference);
            return self.wrong(&after.field("reference"), expected);
        }
        if file.after.keyframe >= most {
            let expected = format!(
                "{}: expected less than {most}, the most keyframes of a skill on `{}`",
                file.after.keyframe, file.after.reference
            );
            return self.wrong(&after.field("keyframe"), expected);
        }
        Ok(Event {
            name: file.name.clone(),
            reference: file.after.reference.clone(),
            keyframe: file.after.keyframe,
            happening,
            seconds: file.seconds,
        })
    }

    /// Either a push with its displacement or a drop.
    pub(super) fn happening(&self, key: &KeyPath, file: &EventFile, names: &Names) -> Result<Happening, TaskError> {
        for (field, name) in [("push", &file.push), ("drop", &file.drop)] {
            if let Some(name) = name {
                self.check_name(&key.field(field), name, Role::Body, names)?;
                if names.mistake(name, Role::Turning).is_none() {
                    let expected = format!("`{name}` turns on a hinge; expected an object that moves freely");
                    return self.wrong(&key.field(field), expected);
                }
            }
        }
        match (&file.push, file.by, &file.drop) {
            (Some(object), Some(by), None) => Ok(Happening::Push { object: object.clone(), by }),
            (None, None, Some(object)) => Ok(Happening::Drop { object: object.clone() }),
            (Some(_), _, Some(_)) => self.wrong(&key.field("drop"), "expected either `push` or `drop`, not both"),
            (Some(_), None, None) => {
                self.wrong(&key.field("push"), "expected `by`, how far it is pushed, beside `push`")
            }
            (None, Some(_), _) => self.wrong(&key.field("by"), "expected `by` only beside `push`"),
            (None, None, None) => self.wrong(key, "expected what happens: `push` with `by`, or `drop`"),
        }
    }

    pub(super) fn intervention(
        &self,
        key: &KeyPath,
        file: &InterventionFile,
        names: &Names,
    ) -> Result<Intervention, TaskError> {
        if let Some(reference) = &file.reference {
            self.check_name(&key.field("reference"), reference, Role::Object, names)?;
        }
        let when = self.predicate(&key.field("when"), &file.when, names)?;
        Ok(Intervention { name: file.name.clone(), moment: file.moment, reference: file.reference.clone(), when })
    }
}
