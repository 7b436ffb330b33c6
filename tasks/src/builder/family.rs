//! What belongs to a file as a whole: names, sequences of variations, and the observed state.

use std::collections::BTreeSet;

use super::check::Builder;
use super::layers::located;
use super::names::Names;
use crate::error::TaskError;
use crate::feature::{Observable, WorldSchema};
use crate::key::KeyPath;
use crate::sequence::{ORIGINAL, VariationSequence};

impl Builder<'_> {
    /// Checks the name of the file, and those of its variations.
    pub(crate) fn check_names(&self) -> Result<(), TaskError> {
        let root = KeyPath::default();
        self.check_word(&root.field("name"), &self.file.name)?;
        let mut seen = BTreeSet::new();
        for (key, variation) in located(&root, "variation", &self.file.variation) {
            let key = key.field("name");
            self.check_word(&key, &variation.name)?;
            if variation.name == ORIGINAL {
                return self.wrong(&key, "the original task is called so; expected another name");
            }
            if !seen.insert(variation.name.as_str()) {
                let expected = format!("the variation `{}` exists already; expected another name", variation.name);
                return self.wrong(&key, expected);
            }
        }
        Ok(())
    }

    /// The sequences of variations.
    pub(crate) fn sequences(&self) -> Result<Vec<VariationSequence>, TaskError> {
        let mut seen = BTreeSet::new();
        let mut sequences = Vec::new();
        for (key, file) in located(&KeyPath::default(), "sequence", &self.file.sequence) {
            self.check_word(&key.field("name"), &file.name)?;
            if !seen.insert(&file.name) {
                let expected = format!("the sequence `{}` exists already; expected another name", file.name);
                return self.wrong(&key.field("name"), expected);
            }
            self.check_stages(&key.field("variations"), &file.variations)?;
            let analysis = file.analysis.trim().to_owned();
            sequences.push(VariationSequence { name: file.name.clone(), analysis, stages: file.variations.clone() });
        }
        Ok(sequences)
    }

    /// Checks that a sequence has at least two stages, of which each is another than the one before: a variation of the
    /// file, or, after the first, the original task.
    fn check_stages(&self, key: &KeyPath, names: &[String]) -> Result<(), TaskError> {
        if names.len() < 2 {
            return self.wrong(key, "expected at least two variations");
        }
        let variations = self.file.variation.iter().map(|variation| variation.name.as_str());
        let known: Vec<&str> = variations.chain([ORIGINAL]).collect();
        for (i, name) in names.iter().enumerate() {
            let key = key.index(i);
            if !known.contains(&name.as_str()) {
                let expected = format!("there is no variation `{name}`; expected one of {}", known.join(", "));
                return self.wrong(&key, expected);
            }
            let former = if i == 0 { ORIGINAL } else { &names[i - 1] };
            if name == former {
                return self.wrong(&key, format!("`{name}` is what was there before; expected a change"));
            }
        }
        Ok(())
    }

    /// The features of the family: names may belong to the original or to any variation.
    pub(crate) fn schema(&self) -> Result<WorldSchema, TaskError> {
        let all = self.all_names();
        let mut observables = Vec::new();
        for (key, text) in located(&KeyPath::default(), "observe", &self.file.observe) {
            let observable = Observable::parse(text).map_err(|expected| self.document.error(&key, expected))?;
            let mut unknown = None;
            observable.visit_names(&mut |name, role| unknown = unknown.take().or_else(|| all.mistake(name, role)));
            if let Some(expected) = unknown {
                return self.wrong(&key, expected);
            }
            if observables.contains(&observable) {
                return self.wrong(&key, format!("`{text}` is observed already; expected each feature once"));
            }
            observables.push(observable);
        }
        if observables.is_empty() {
            return self.wrong(&KeyPath::default().field("observe"), "expected at least one feature");
        }
        Ok(WorldSchema::new(observables))
    }

    /// The names of the original and of all variations.
    fn all_names(&self) -> Names {
        let (file, root) = (self.file, KeyPath::default());
        let names = |object, slide, hinge, beads| {
            let (slide, hinge) = (located(&root, "", slide), located(&root, "", hinge));
            Names::new(&located(&root, "", object), &slide, &hinge, beads)
        };
        let original = names(&file.object, &file.joint, &file.hinge, file.beads.is_some());
        let variations = file.variation.iter().map(|v| names(&v.object, &v.joint, &v.hinge, v.beads.is_some()));
        variations.fold(original, Names::and)
    }
}
