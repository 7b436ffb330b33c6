//! Teacher profiles: rates of erring, read from a file.

use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use crate::error::TeacherError;

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
    /// Share of corrections that are stopped once back on the model, instead of carried on to the end.
    #[serde(default)]
    pub stop_early: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    profile: Vec<Spanned<Profile>>,
}

/// The profiles that come with the crate.
const BUILTIN: &str = include_str!("profiles.toml");

impl Profile {
    /// The profiles that come with the crate.
    ///
    /// # Errors
    /// Never, unless the crate was built with a broken file; the tests read it.
    pub fn builtin() -> Result<Vec<Self>, TeacherError> {
        Self::parse(BUILTIN, Path::new("profiles.toml"))
    }

    /// The built-in profile of this name.
    ///
    /// # Errors
    /// [`TeacherError::UnknownProfile`] names the known ones.
    pub fn named(name: &str) -> Result<Self, TeacherError> {
        let profiles = Self::builtin()?;
        let known = profiles.iter().map(|profile| profile.name.clone()).collect::<Vec<_>>().join(", ");
        let found = profiles.into_iter().find(|profile| profile.name == name);
        found.ok_or_else(|| TeacherError::UnknownProfile { name: name.to_owned(), known })
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
            let rates = [
                ("spurious", profile.spurious),
                ("missing", profile.missing),
                ("pause.rate", profile.pause.rate),
                ("stop_early", profile.stop_early),
            ];
            for (key, rate) in rates {
                if !(0.0..=1.0).contains(&rate) {
                    let problem = format!("profile `{}`: `{key}` is {rate}, expected a rate from 0 to 1", profile.name);
                    return Err(refuse(offset, problem));
                }
            }
            let sizes = [
                ("contact.position", profile.contact.position),
                ("contact.rotation", profile.contact.rotation),
                ("free.position", profile.free.position),
                ("free.rotation", profile.free.rotation),
                ("pause.seconds", profile.pause.seconds),
            ];
            for (key, size) in sizes {
                if !(size.is_finite() && size >= 0.0) {
                    let problem =
                        format!("profile `{}`: `{key}` is {size}, expected a finite number, 0 or more", profile.name);
                    return Err(refuse(offset, problem));
                }
            }
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
