//! What was shown before a demonstration: it names the primitives before it by segments of earlier demonstrations.

use std::path::{Path, PathBuf};

use situ::place::SegmentId;
use situ::segmentation::by_reference_object;
use situ::state::Schema;
use situ::trail::PastStep;
use situ_tasks::name::shown;

use crate::demonstration_file::{DemonstrationFile, Instance};
use crate::error::BenchError;
use crate::stop::StopPoint;
use crate::tally::count;

/// The demonstrations that a model has seen or is about to see, in order.
#[derive(Clone, Debug, Default)]
pub struct Earlier {
    /// The schema of all, and the file that it is known from.
    schema: Option<(Schema, PathBuf)>,
    shown: Vec<EarlierDemonstration>,
}

/// One of them.
#[derive(Clone, Debug, PartialEq)]
pub struct EarlierDemonstration {
    /// Its name.
    pub name: String,
    /// The number of its segments: runs of keyframes about one object.
    pub segments: u32,
    /// The file that it is known from.
    pub path: PathBuf,
}

impl Earlier {
    /// Those that a model has seen, by the file of the model.
    pub fn of_model(schema: &Schema, shown: Vec<EarlierDemonstration>, path: &Path) -> Self {
        Self { schema: Some((schema.clone(), path.to_owned())), shown }
    }

    /// Takes the next demonstration in, and returns where the robot had stopped before it.
    ///
    /// # Errors
    /// [`BenchError::Demonstration`] where its name is taken, its schema is another, or what it says to have run is no
    /// segment of an earlier one.
    pub fn stop(&mut self, file: &DemonstrationFile) -> Result<StopPoint, BenchError> {
        let name = file.demonstration.name();
        if let Some(other) = self.shown.iter().find(|other| *other.name == **name) {
            let problem = format!("`{name}` is the name in {} as well, expected another", other.path.display());
            return Err(file.refuse("name", problem));
        }
        self.check_schema(file)?;
        let mut named = file.before.named().into_iter().map(|(key, instance)| self.segment(file, &key, instance));
        let mut next = |is_there: bool| is_there.then(|| named.next()).flatten().transpose();
        let (last, interrupted) = (next(file.before.after.is_some())?, next(file.before.interrupted.is_some())?);
        let steps = file.before.trail.iter().zip(named);
        let trail = steps.map(|(step, of)| Ok(PastStep { state: step.state.clone(), of: of?, end: step.end }));
        let trail = trail.collect::<Result<_, BenchError>>()?;
        self.shown.push(EarlierDemonstration {
            name: name.to_string(),
            segments: count(by_reference_object(&file.demonstration).len()),
            path: file.path().to_owned(),
        });
        Ok(StopPoint { last, interrupted, trail })
    }

    /// The first schema is that of all.
    fn check_schema(&mut self, file: &DemonstrationFile) -> Result<(), BenchError> {
        let (first, path) = self.schema.get_or_insert_with(|| (file.schema.clone(), file.path().to_owned()));
        if *first == file.schema {
            return Ok(());
        }
        let (here, there) = (file.schema.features(), first.features());
        let differs = here.iter().zip(there).position(|(here, there)| here != there);
        let other = if here.len() == there.len() { "half_turn" } else { "schema" };
        let path = path.display();
        if file.features.is_none() {
            let key = differs.map_or(other.to_owned(), |feature| format!("schema[{feature}]"));
            return Err(file.refuse(&key, format!("expected the schema of {path}: all files of one call share it")));
        }
        // It follows from what is seen.
        let key = if other == "half_turn" && differs.is_none() { other } else { "objects" };
        let problem = format!(
            "expected the schema of {path}, and other features follow from what is seen here; where an object may be \
             absent, name all objects of the task under `objects` in every file"
        );
        Err(file.refuse(key, problem))
    }

    /// The segment that `instance`, the value of a key of a file, names.
    fn segment(&self, file: &DemonstrationFile, key: &str, instance: &Instance) -> Result<SegmentId, BenchError> {
        let Instance { demonstration, segment } = instance;
        let Some(number) = self.shown.iter().position(|other| other.name == *demonstration) else {
            let known: Vec<String> = self.shown.iter().map(|other| format!("`{}`", shown(&other.name))).collect();
            let known = known.join(", ");
            let problem = format!("no demonstration `{demonstration}` before this one, expected one of {known}");
            return Err(file.refuse(&format!("{key}.demonstration"), problem));
        };
        let segments = self.shown[number].segments;
        if *segment >= segments {
            let problem = format!(
                "{segment}, expected 0 to {} (`{demonstration}` has {segments} segments)",
                segments.saturating_sub(1)
            );
            return Err(file.refuse(&format!("{key}.segment"), problem));
        }
        Ok(SegmentId { demonstration: count(number), index: *segment })
    }
}
