//! Teacher profiles: rates of erring, read from a file.

use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use crate::error::TeacherError;
use crate::tally::Way;

/// Gaussian noise on a pose, a standard deviation an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Noise {
    /// Metres.
    pub position: f64,
    /// Degrees, of the rotation vector.
    pub rotation: f64,
}

/// Pauses to think.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pause {
    /// Share of keyframes with a pause.
    pub rate: f64,
    /// Its length, simulated seconds.
    pub seconds: f64,
}

/// Excursions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Detour {
    /// Share of keyframes before which there is one.
    pub rate: f64,
    /// How far it leads away from the middle of the way, in metres: sideways or up, never down.
    pub reach: f64,
}

/// A gripper that is not aligned with what it takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Misaligned {
    /// Share of skills that are performed so.
    pub rate: f64,
    /// The turn of the gripper about its own z axis, either way, in degrees.
    pub turn: f64,
}

/// A teacher's ways of erring. All zero is the expert.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Its name.
    pub name: String,
    /// Whom it stands for, in prose.
    pub analysis: String,
    /// Noise where the gripper touches something.
    #[serde(default)]
    pub contact: Noise,
    /// Noise in free space.
    #[serde(default)]
    pub free: Noise,
    /// Share of keyframes before which a needless one is given, half way and off the path by the free noise.
    #[serde(default)]
    pub spurious: f64,
    /// Share of free keyframes that are passed but not recorded. One with a gripper command is never missed: the command records it.
    #[serde(default)]
    pub missing: f64,
    /// Pauses.
    #[serde(default)]
    pub pause: Pause,
    /// Excursions.
    #[serde(default)]
    pub detour: Detour,
    /// Share of keyframes that are approached along one axis after the other, with a keyframe at each corner.
    #[serde(default)]
    pub one_axis: f64,
    /// Misalignment.
    #[serde(default)]
    pub misaligned: Misaligned,
    /// Share of skills whose reference object is named wrongly: another object of the scene, all equally likely.
    #[serde(default)]
    pub wrong_reference: f64,
    /// Share of corrections that are stopped once back on the model, instead of carried on to the end.
    #[serde(default)]
    pub stops_early: f64,
    /// Share of corrections that begin one primitive too early: the robot is stopped before it has gone wrong.
    #[serde(default)]
    pub begins_early: f64,
    /// Share of corrections that begin too late: the first moment at which the robot should have been stopped passes.
    #[serde(default)]
    pub begins_late: f64,
}

impl Profile {
    /// Err with a key and what is wrong with its value.
    fn check(&self) -> Result<(), String> {
        for way in Way::ALL {
            let rate = way.rate(self);
            if !(0.0..=1.0).contains(&rate) {
                let key = match way {
                    Way::Pause | Way::Detour | Way::Misaligned => format!("{}.rate", way.name()),
                    _ => way.name().to_owned(),
                };
                return Err(format!("`{key}` is {rate}, expected a rate from 0 to 1"));
            }
        }
        if self.begins_early + self.begins_late > 1.0 {
            return Err(format!(
                "`begins_early` and `begins_late` are {} together, expected at most 1: no correction is both",
                self.begins_early + self.begins_late
            ));
        }
        let sizes = [
            ("contact.position", self.contact.position, "metres", 1.0),
            ("contact.rotation", self.contact.rotation, "degrees", 180.0),
            ("free.position", self.free.position, "metres", 1.0),
            ("free.rotation", self.free.rotation, "degrees", 180.0),
            ("pause.seconds", self.pause.seconds, "seconds", 60.0),
            ("detour.reach", self.detour.reach, "metres", 1.0),
            ("misaligned.turn", self.misaligned.turn, "degrees", 180.0),
        ];
        match sizes.into_iter().find(|(_, size, _, most)| !(0.0..=*most).contains(size)) {
            Some((key, size, unit, most)) => Err(format!("`{key}` is {size}, expected 0 to {most} {unit}")),
            None => Ok(()),
        }
    }

    /// Reads profiles from the text of a file; `path` is for messages.
    ///
    /// # Errors
    /// [`TeacherError::File`] with the line, and what was expected.
    pub fn parse(text: &str, path: &Path) -> Result<Vec<Self>, TeacherError> {
        let refuse = |offset: usize, problem: String| TeacherError::File {
            path: path.to_owned(),
            line: text[..offset.min(text.len())].matches('\n').count() + 1,
            problem,
        };
        let file: File = toml::from_str(text)
            .map_err(|error| refuse(error.span().map_or(0, |span| span.start), error.message().to_owned()))?;
        for (index, spanned) in file.profile.iter().enumerate() {
            let (offset, profile) = (spanned.span().start, spanned.as_ref());
            profile.check().map_err(|problem| refuse(offset, format!("profile `{}`: {problem}", profile.name)))?;
            if file.profile[..index].iter().any(|other| other.as_ref().name == profile.name) {
                return Err(refuse(offset, format!("profile `{}` appears twice, expected unique names", profile.name)));
            }
        }
        Ok(file.profile.into_iter().map(Spanned::into_inner).collect())
    }

    /// Reads profiles from a file.
    ///
    /// # Errors
    /// Where it cannot be read, or as for [`Profile::parse`].
    pub fn load(path: &Path) -> Result<Vec<Self>, TeacherError> {
        let text =
            std::fs::read_to_string(path).map_err(|source| TeacherError::Read { path: path.to_owned(), source })?;
        Self::parse(&text, path)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    profile: Vec<Spanned<Profile>>,
}
