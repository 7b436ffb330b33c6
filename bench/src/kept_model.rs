//! A task model that is kept in a file from one correction to the next, with what it was made of.
//!
//! ```json
//! {
//!   "version": 1,
//!   "method": "situ",
//!   "seed": 0,
//!   "schema": [{"name": "cup_x", "scale": 0.2}],
//!   "half_turn": null,
//!   "observe": null,
//!   "demonstrations": [{"name": "tea-1", "segments": 2, "sha256": "…"}],
//!   "model": {}
//! }
//! ```
//!
//! `observe` says how the states follow from poses, where the first demonstration was given by poses. `demonstrations`
//! are those that the model has seen, in order: a correction names what ran before it by their segments. `model` is the
//! method's own ([`Learned::to_json`]). Two models that were shown the same are the same bytes, in however many steps.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use situ::edit::{self, Difference};
use situ::error::SituError;
use situ::graph::Graph;
use situ::method::{Learned, Method};
use situ::place::{NodeId, Place};
use situ::segmentation::by_reference_object;
use situ::state::{Axis, Feature, Schema};
use situ::trace::Trace;
use situ_tasks::PoseSchema;
use situ_tasks::name::shown;

use crate::demonstration_file::DemonstrationFile;
use crate::earlier::{Earlier, EarlierDemonstration};
use crate::error::BenchError;
use crate::external::Methods;
use crate::json_lines::line_of;
use crate::stop::{StopPoint, Unheld};
use crate::strict_json::StrictJson;
use crate::tally::count;

/// The version of the format that is written, the only one that is read.
const VERSION: u32 = 1;

/// The effect of one correction.
#[derive(Clone, Debug, PartialEq)]
pub struct Corrected {
    /// The corrective demonstration's name.
    pub name: String,
    /// How the model changed.
    pub difference: Difference,
    /// The trace of the update.
    pub trace: Trace,
    /// Where the correction ends before the task does, and the model would then begin it anew: the node that it begins
    /// with.
    pub begins_again: Option<NodeId>,
}

/// A demonstration that a model has seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeptDemonstration {
    /// Its name.
    pub name: String,
    /// The number of its segments: runs of keyframes about one object.
    pub segments: u32,
    /// The hash of its file.
    pub sha256: String,
}

impl KeptDemonstration {
    fn of(file: &DemonstrationFile) -> Self {
        let segments = count(by_reference_object(&file.demonstration).len());
        Self { name: file.demonstration.name().to_string(), segments, sha256: file.hash() }
    }
}

/// The file, key for key.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    version: u32,
    method: String,
    seed: u64,
    schema: Vec<Feature>,
    #[serde(deserialize_with = "Option::deserialize")]
    half_turn: Option<Axis>,
    #[serde(deserialize_with = "Option::deserialize")]
    observe: Option<Vec<String>>,
    demonstrations: Vec<KeptDemonstration>,
    model: Value,
}

/// A task model, and what it was made of.
pub struct KeptModel {
    /// The method that keeps it up to date.
    pub method: Box<dyn Method>,
    /// The model.
    pub learned: Box<dyn Learned>,
    /// Its structure.
    pub graph: Graph,
    /// The features of its states.
    pub schema: Schema,
    /// How its states follow from poses, where they do.
    pub features: Option<PoseSchema>,
    /// The root of whatever the method draws.
    pub seed: u64,
    /// The demonstrations that it has seen, in order.
    pub seen: Vec<KeptDemonstration>,
}

impl KeptModel {
    /// Teaches a method these originals, of which there is at least one. They were checked together.
    ///
    /// # Errors
    /// [`BenchError::Teach`].
    pub fn teach(method: Box<dyn Method>, originals: &[DemonstrationFile], seed: u64) -> Result<Self, BenchError> {
        let Some(first) = originals.first() else {
            return Err(BenchError::Argument("no original demonstration: expected at least one".to_owned()));
        };
        let demonstrations: Vec<_> = originals.iter().map(|file| file.demonstration.clone()).collect();
        let refuse = |source| BenchError::Teach { path: first.path().to_owned(), source };
        let learned = method.teach(&first.schema, &demonstrations, seed).map_err(refuse)?;
        let graph = learned.graph().map_err(refuse)?;
        let (schema, features) = (first.schema.clone(), first.features.clone());
        let seen = originals.iter().map(KeptDemonstration::of).collect();
        Ok(Self { method, learned, graph, schema, features, seed, seen })
    }

    /// Folds a correction in.
    ///
    /// # Errors
    /// [`BenchError::Demonstration`] where the model holds no node of the stop; [`BenchError::Learn`]. The model is as
    /// it was then.
    pub fn correct(&mut self, file: &DemonstrationFile, stop: &StopPoint) -> Result<Corrected, BenchError> {
        let refuse = |source| BenchError::Learn { path: file.path().to_owned(), source };
        let stop = stop.in_model(&self.graph).map_err(|unheld| self.unheld(file, &unheld))?;
        let trace = self.learned.correct(stop.correction(&file.demonstration)).map_err(refuse)?;
        let after = self.learned.graph().map_err(refuse)?;
        let difference = edit::difference(&self.graph, &after);
        self.graph = after;
        self.seen.push(KeptDemonstration::of(file));
        let begins_again = self.begins_again(file, &trace).map_err(refuse)?;
        Ok(Corrected { name: file.demonstration.name().to_string(), difference, trace, begins_again })
    }

    /// The first node of a correction, where the model would go back to it from its end.
    fn begins_again(&self, file: &DemonstrationFile, trace: &Trace) -> Result<Option<NodeId>, SituError> {
        let shown = &file.demonstration;
        let (Some(first), Some(last)) = (trace.steps.first(), trace.steps.last()) else { return Ok(None) };
        if shown.carried_to_end() {
            return Ok(None);
        }
        let next = self.learned.next(Place::Node(last.node), shown.final_state())?;
        Ok(next.and_then(|(place, _)| place.node()).filter(|node| *node == first.node))
    }

    /// The error of a stop that the model does not hold.
    fn unheld(&self, file: &DemonstrationFile, unheld: &Unheld) -> BenchError {
        let problem = format!("`{}` keeps no node that holds this segment", self.method.name());
        file.refuse(&format!("{}.segment", unheld.key), problem)
    }

    /// A copy of the model, by the same method.
    pub fn copied(&self) -> CopiedModel<'_> {
        CopiedModel { of: self, learned: self.learned.boxed() }
    }

    /// What the next correction may name; `path` is the model's file, for messages.
    pub fn earlier(&self, path: &Path) -> Earlier {
        let each = |seen: &KeptDemonstration| EarlierDemonstration {
            name: seen.name.clone(),
            segments: seen.segments,
            path: path.to_owned(),
        };
        Earlier::of_model(&self.schema, self.seen.iter().map(each).collect(), path)
    }

    /// Reads a model of one of these methods.
    ///
    /// # Errors
    /// [`BenchError::Read`]; [`BenchError::Malformed`] for a mistake in the file, or where models of its method cannot
    /// be read again; [`BenchError::Situ`] where a method of one's own fails.
    pub fn read(path: &Path, methods: &Methods) -> Result<Self, BenchError> {
        let text = fs::read_to_string(path).map_err(|source| BenchError::Read { path: path.to_owned(), source })?;
        Self::parse(&text, path, methods)
    }

    /// The model of a file's text; `path` is for messages.
    ///
    /// # Errors
    /// As [`KeptModel::read`].
    pub fn parse(text: &str, path: &Path, methods: &Methods) -> Result<Self, BenchError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let refuse = |key: &str, problem: String| mistaken(path, line_of(text, key), key, &problem);
        let content = content(text, path)?;
        let schema = Schema::new(content.schema).map_err(|error| refuse("schema", error.to_string()))?;
        let schema = schema.with_half_turn(content.half_turn);
        let features = content.observe.as_deref().map(PoseSchema::parse).transpose();
        let features = features.map_err(|(index, problem)| refuse(&format!("observe[{index}]"), problem))?;
        let follow = |features: &PoseSchema| {
            let own = features.features();
            let same = own.iter().zip(schema.features()).all(|(one, other)| one.name == other.name);
            same && own.len() == schema.len()
        };
        if !features.as_ref().is_none_or(follow) {
            return Err(refuse("observe", "expected what the features of `schema` follow from".to_owned()));
        }
        let method = methods.named(&content.method).map_err(|error| refuse("method", error.to_string()))?;
        let learned = match method.read(&schema, content.model, content.seed) {
            Ok(learned) => learned,
            Err(SituError::Model { place, problem }) => return Err(refuse(&place, problem)),
            Err(error @ SituError::Unreadable { .. }) => return Err(refuse("method", error.to_string())),
            Err(error) => return Err(error.into()),
        };
        let graph = learned.graph()?;
        let seen = content.demonstrations;
        if seen.len() != graph.lengths.len() {
            let problem =
                format!("{} of them, expected {}: the model has seen so many", seen.len(), graph.lengths.len());
            return Err(refuse("demonstrations", problem));
        }
        Ok(Self { method, learned, graph, schema, features, seed: content.seed, seen })
    }

    /// The text of its file.
    pub fn render(&self) -> String {
        let content = Content {
            version: VERSION,
            method: self.method.name().to_owned(),
            seed: self.seed,
            schema: self.schema.features().to_vec(),
            half_turn: self.schema.half_turn(),
            observe: self.features.as_ref().map(PoseSchema::expressions),
            demonstrations: self.seen.clone(),
            model: self.learned.to_json(),
        };
        serde_json::to_string_pretty(&content).expect("finite numbers and string keys") + "\n"
    }
}

/// A copy of a model, to be corrected and given up.
pub struct CopiedModel<'a> {
    of: &'a KeptModel,
    learned: Box<dyn Learned>,
}

impl CopiedModel<'_> {
    /// Folds a correction in, as [`KeptModel::correct`], and says nothing about it.
    ///
    /// # Errors
    /// As there.
    pub fn correct(&mut self, file: &DemonstrationFile, stop: &StopPoint) -> Result<(), BenchError> {
        let stop = stop.in_model(&self.of.graph).map_err(|unheld| self.of.unheld(file, &unheld))?;
        let corrected = self.learned.correct(stop.correction(&file.demonstration));
        corrected.map(drop).map_err(|source| BenchError::Learn { path: file.path().to_owned(), source })
    }
}

/// A mistake in the file of a model. Both texts may repeat what the file says.
fn mistaken(path: &Path, line: usize, key: &str, problem: &str) -> BenchError {
    let problem = format!("key `{}`: {}", shown(key), shown(problem));
    BenchError::Malformed { path: PathBuf::from(path), line, problem }
}

/// What a file says, key for key.
fn content(text: &str, path: &Path) -> Result<Content, BenchError> {
    let plain = |error: &serde_json::Error| {
        let place = format!(" at line {} column {}", error.line(), error.column());
        error.to_string().replace(&place, "")
    };
    let StrictJson(value) = serde_json::from_str(text)
        .map_err(|error: serde_json::Error| mistaken(path, error.line().max(1), ".", &plain(&error)))?;
    let version = value.get("version");
    if version.and_then(Value::as_u64) != Some(VERSION.into()) {
        let problem = match version {
            None => {
                format!("missing, expected {VERSION}: this is no model, or an earlier program wrote it; learn it anew")
            }
            Some(other) => format!("{other}, expected {VERSION}: this program reads no other"),
        };
        return Err(mistaken(path, line_of(text, "version"), "version", &problem));
    }
    serde_path_to_error::deserialize(value).map_err(|error| {
        let key = error.path().to_string();
        mistaken(path, line_of(text, &key), &key, &error.into_inner().to_string())
    })
}
