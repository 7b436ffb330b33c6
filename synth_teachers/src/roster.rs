//! The teachers that are known by name.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use situ_tasks::name::shown;

use crate::error::TeacherError;
use crate::profile::Profile;

/// The profiles that come with the crate.
const BUILTIN: &str = include_str!("profiles.toml");

/// The teachers that are known by name, in the order of their files.
#[derive(Clone, Debug, Default)]
pub struct Roster {
    profiles: Vec<Profile>,
    /// Where in `profiles` a name stands.
    places: BTreeMap<String, usize>,
    /// The text of the file of each profile.
    texts: Vec<Arc<str>>,
}

impl Roster {
    /// The teachers of this crate.
    ///
    /// # Errors
    /// Never, unless the crate was built with a broken file; the tests read it.
    pub fn builtin() -> Result<Self, TeacherError> {
        let path = Path::new("synth_teachers/src/profiles.toml");
        Self::default().with(BUILTIN, path)
    }

    /// The same with the profiles of a file.
    ///
    /// # Errors
    /// The file cannot be read, it has a mistake, or a teacher of that name is known already.
    pub fn with_file(self, path: &Path) -> Result<Self, TeacherError> {
        let text =
            std::fs::read_to_string(path).map_err(|source| TeacherError::Read { path: path.to_owned(), source })?;
        self.with(&text, path)
    }

    fn with(mut self, text: &str, path: &Path) -> Result<Self, TeacherError> {
        let source: Arc<str> = Arc::from(text);
        for profile in Profile::parse(text, path)? {
            if self.places.insert(profile.name.clone(), self.profiles.len()).is_some() {
                return Err(TeacherError::DuplicateProfile { path: path.to_owned(), name: profile.name });
            }
            self.profiles.push(profile);
            self.texts.push(Arc::clone(&source));
        }
        Ok(self)
    }

    /// The profiles, in the order of their files.
    pub fn profiles(&self) -> &[Profile] {
        &self.profiles
    }

    /// The text of the file that the profile of this name was read from; `None` where there is no such profile.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.places.get(name).map(|place| &*self.texts[*place])
    }

    /// The profile of this name.
    ///
    /// # Errors
    /// [`TeacherError::UnknownProfile`] names the known ones.
    pub fn get(&self, name: &str) -> Result<&Profile, TeacherError> {
        self.places.get(name).map(|place| &self.profiles[*place]).ok_or_else(|| TeacherError::UnknownProfile {
            name: shown(name),
            known: self.profiles.iter().map(|profile| profile.name.as_str()).collect::<Vec<_>>().join(", "),
        })
    }
}
