//! A task family: the original and its variations, read from one file.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use crate::builder::{Builder, mesh};
use crate::error::TaskError;
use crate::feature::WorldSchema;
use crate::file::TaskFile;
use crate::file_kind::FileKind;
use crate::key::Document;
use crate::name::shown;
use crate::plant::Plant;
use crate::sequence::{ORIGINAL, VariationSequence};
use crate::setting::Setting;

/// A task family, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    name: String,
    analysis: String,
    schema: WorldSchema,
    original: Arc<Setting>,
    variations: Vec<Arc<Setting>>,
    sequences: Vec<VariationSequence>,
    /// The SHA-256 of each file of a mesh, by its name.
    meshes: BTreeMap<String, String>,
}

impl Task {
    /// Reads a task from the text of its file. `file` is for messages, and files of meshes are looked for beside it.
    ///
    /// # Errors
    /// [`TaskError::File`] with line, key and what was expected. The text is no TOML; a key is missing, unknown or of
    /// the wrong type; a name is unknown or given twice; a number is not finite or out of range; a mesh cannot be read;
    /// or a variation does not change what its edit says.
    pub fn parse(text: &str, file: &Path) -> Result<Task, TaskError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let document = Document::parse(text, file)?;
        document.check_kind(FileKind::Task)?;
        document.check_finite()?;
        let mut content: TaskFile = toml::from_str(text).map_err(|error| document.serde_error(&error))?;
        let meshes = mesh::read(&mut content, &document, file.parent().unwrap_or(Path::new("")))?;
        let builder = Builder { document: &document, file: &content };
        builder.check_names()?;
        let schema = builder.schema()?;
        let original = Arc::new(builder.setting(&schema, None)?);
        let variations: Result<Vec<_>, _> =
            (0..content.variation.len()).map(|i| builder.setting(&schema, Some(i)).map(Arc::new)).collect();
        let sequences = builder.sequences()?;
        let analysis = content.analysis.trim().to_owned();
        Ok(Task { name: content.name, analysis, schema, original, variations: variations?, sequences, meshes })
    }

    /// The same task with something else to carry the hand.
    #[must_use]
    pub fn with_plant(self, plant: Plant) -> Task {
        let carried = |setting: Arc<Setting>| Arc::new(Setting { plant, ..Arc::unwrap_or_clone(setting) });
        let variations = self.variations.into_iter().map(carried).collect();
        Task { original: carried(self.original), variations, ..self }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What the task is about, in prose.
    pub fn analysis(&self) -> &str {
        &self.analysis
    }

    /// The observed state, the same for the original and all variations.
    pub fn schema(&self) -> &WorldSchema {
        &self.schema
    }

    /// The names of the variations, in the order of the file.
    pub fn variations(&self) -> impl Iterator<Item = &str> {
        self.variations.iter().filter_map(|setting| setting.variation.as_deref())
    }

    /// The sequences of variations, in the order of the file.
    pub fn sequences(&self) -> &[VariationSequence] {
        &self.sequences
    }

    /// The SHA-256 of each file of a mesh that the task uses, in hexadecimal digits, by the file's name.
    pub fn meshes(&self) -> &BTreeMap<String, String> {
        &self.meshes
    }

    /// All settings: the original, then the variations in the order of the file.
    pub fn settings(&self) -> impl Iterator<Item = &Arc<Setting>> {
        std::iter::once(&self.original).chain(&self.variations)
    }

    /// What a sequence has at a stage of this name.
    ///
    /// # Errors
    /// [`TaskError::UnknownVariation`].
    pub fn stage(&self, name: &str) -> Result<Arc<Setting>, TaskError> {
        self.variation((name != ORIGINAL).then_some(name))
    }

    /// The task with a variation applied, or the original.
    ///
    /// # Errors
    /// [`TaskError::UnknownVariation`].
    pub fn variation(&self, name: Option<&str>) -> Result<Arc<Setting>, TaskError> {
        let found = self.settings().find(|setting| setting.variation.as_deref() == name);
        found.cloned().ok_or_else(|| TaskError::UnknownVariation {
            task: self.name.clone(),
            name: shown(name.unwrap_or_default()),
            known: if self.variations.is_empty() {
                "none".to_owned()
            } else {
                self.variations().collect::<Vec<_>>().join(", ")
            },
        })
    }
}
