//! How a demonstration file says what the world is like: by states, or by the poses of everything, from which the
//! states follow.

use situ::demonstration::Pose;
use situ::state::{Feature, Schema, State};
use situ_tasks::{PoseSchema, Poses};

use super::content::{FileContent, FileKeyframe, FilePose, FileWorld};
use super::rules::{FARTHEST, Mistake, mistake, pose, schema, state};

/// What is required of a file's worlds or states.
pub(super) enum Perceived {
    /// One number for each feature of a schema that the file gives.
    States(Schema),
    /// Poses, and what follows from them.
    Worlds {
        /// The schema that follows.
        schema: Schema,
        /// How its features follow.
        features: PoseSchema,
        /// The objects of the task.
        objects: Vec<String>,
        /// Whether one of them may be absent.
        may_be_absent: bool,
    },
}

/// The keys that only version 2 has, where they are there.
fn of_version_2(file: &FileContent) -> Option<String> {
    let keyframe = file.keyframes.iter().position(|keyframe| keyframe.world.is_some());
    let step = file.trail.iter().position(|step| step.world.is_some());
    [
        (file.objects.is_some(), "objects"),
        (file.observe.is_some(), "observe"),
        (file.final_world.is_some(), "final_world"),
    ]
    .into_iter()
    .find_map(|(is_there, key)| is_there.then(|| key.to_owned()))
    .or_else(|| keyframe.map(|index| format!("keyframes[{index}].world")))
    .or_else(|| step.map(|index| format!("trail[{index}].world")))
}

impl Perceived {
    /// What a file of this content is to say.
    pub(super) fn of(file: &FileContent) -> Result<Self, Mistake> {
        match file.version {
            None | Some(1) => {
                if let Some(key) = of_version_2(file) {
                    return Err(mistake(
                        key,
                        "a key of version 2, expected `\"version\": 2` at the top, or no such key",
                    ));
                }
            }
            Some(2) => {}
            Some(other) => {
                return Err(mistake("version", format!("{other}, expected 1 or 2: this program knows no other")));
            }
        }
        match &file.schema {
            Some(features) => {
                if let Some(key) = of_version_2(file) {
                    return Err(mistake(key, "with a `schema` every keyframe has its `state`, expected no such key"));
                }
                Ok(Self::States(schema(features)?.with_half_turn(file.half_turn)))
            }
            None if file.version == Some(2) => Self::of_worlds(file),
            None => Err(mistake(".", "missing field `schema`")),
        }
    }

    fn of_worlds(file: &FileContent) -> Result<Self, Mistake> {
        let Some(first) = file.keyframes.first().and_then(|keyframe| keyframe.world.as_ref()) else {
            let problem = "expected the poses of all objects and of the hand; or a `schema`, and a `state` here";
            return Err(mistake("keyframes[0].world", problem));
        };
        let mut objects: Vec<String> = file.objects.clone().unwrap_or_else(|| first.objects.keys().cloned().collect());
        objects.sort();
        if let Some(pair) = objects.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(mistake("objects", format!("`{}` stands there twice, expected once", pair[0])));
        }
        let may_be_absent = file.objects.is_some();
        let key = if may_be_absent { "objects" } else { "keyframes[0].world.objects" };
        let names: Vec<&str> = objects.iter().map(String::as_str).collect();
        let usual = PoseSchema::usual(&names, first.opening.is_some(), may_be_absent);
        let usual = usual.map_err(|problem| mistake(key, problem))?;
        let features = match &file.observe {
            Some(expressions) => PoseSchema::parse(expressions)
                .map_err(|(index, problem)| mistake(format!("observe[{index}]"), problem))?,
            None => usual,
        };
        if let Some(name) = features.objects().into_iter().find(|name| !names.contains(name)) {
            let known = names.join(", ");
            return Err(mistake("observe", format!("`{name}` is no object of the file, expected one of {known}")));
        }
        if features.has_opening() && first.opening.is_none() {
            return Err(mistake("keyframes[0].world.opening", "`observe` asks for it, expected metres"));
        }
        let key = if file.observe.is_some() { "observe" } else { key };
        let entries = features.features().into_iter();
        let entries: Vec<Feature> = entries.map(|each| Feature { name: each.name, scale: each.scale }).collect();
        let schema = schema(&entries).map_err(|(_, problem)| mistake(key, problem))?.with_half_turn(file.half_turn);
        Ok(Self::Worlds { schema, features, objects, may_be_absent })
    }

    /// The schema of the states.
    pub(super) fn schema(&self) -> &Schema {
        let (Self::States(schema) | Self::Worlds { schema, .. }) = self;
        schema
    }

    /// How states follow from poses, where they do.
    pub(super) fn features(&self) -> Option<&PoseSchema> {
        if let Self::Worlds { features, .. } = self { Some(features) } else { None }
    }

    /// A state that the file gives under one of two keys, which begin alike.
    pub(super) fn state(
        &self,
        values: Option<&[f64]>,
        world: Option<&FileWorld>,
        (key, of_world): (String, String),
    ) -> Result<State, Mistake> {
        let missing = |key: String| mistake(key, "missing, expected it in this file");
        match self {
            Self::States(schema) => state(values.ok_or_else(|| missing(key.clone()))?, schema, key),
            Self::Worlds { schema, features, .. } => {
                if values.is_some() {
                    return Err(mistake(key, "follows from the poses, expected no such key"));
                }
                let world = world.ok_or_else(|| missing(of_world.clone()))?;
                state(&features.state(&self.poses(world, &of_world)?), schema, of_world)
            }
        }
    }

    /// The pose of a keyframe's reference object.
    pub(super) fn reference_pose(&self, keyframe: &FileKeyframe, key: &str) -> Result<Pose, Mistake> {
        let own = format!("{key}.reference_pose");
        match (self, &keyframe.reference_pose, &keyframe.world) {
            (Self::States(_), Some(given), _) => pose(given, &own),
            (Self::States(_), None, _) => Err(mistake(own, "missing, expected the pose of the reference object")),
            (Self::Worlds { .. }, Some(_), _) => {
                Err(mistake(own, "it is that of the reference object in `world`, expected no such key"))
            }
            (Self::Worlds { .. }, None, Some(FileWorld { objects, .. })) => match objects.get(&keyframe.reference) {
                Some(given) => pose(given, &format!("{key}.world.objects.{}", keyframe.reference)),
                None => {
                    let known = objects.keys().cloned().collect::<Vec<_>>().join(", ");
                    let problem = format!("`{}` is not in this keyframe's world: {known}", keyframe.reference);
                    Err(mistake(format!("{key}.reference"), problem))
                }
            },
            (Self::Worlds { .. }, None, None) => Err(mistake(format!("{key}.world"), "missing, expected the poses")),
        }
    }

    /// The poses before the motion to each keyframe, and those after the last; none where the file gives states.
    pub(super) fn worlds(&self, file: &FileContent) -> Result<Vec<Poses>, Mistake> {
        let Self::Worlds { .. } = self else { return Ok(Vec::new()) };
        let before = file.keyframes.iter().enumerate();
        let before = before.map(|(index, keyframe)| (format!("keyframes[{index}].world"), keyframe.world.as_ref()));
        let all = before.chain([("final_world".to_owned(), file.final_world.as_ref())]);
        all.filter_map(|(key, world)| Some(self.poses(world?, &key))).collect()
    }

    /// The poses of a world of the file.
    fn poses(&self, world: &FileWorld, key: &str) -> Result<Poses, Mistake> {
        let Self::Worlds { features, objects, may_be_absent, .. } = self else { unreachable!("it has worlds") };
        let name = |name: &String| format!("`{name}`");
        if let Some(other) = world.objects.keys().find(|name| !objects.contains(name)) {
            let known = objects.iter().map(name).collect::<Vec<_>>().join(", ");
            let problem = format!("`{other}` is no object of the task, expected {known}: `objects` names all of them");
            return Err(mistake(format!("{key}.objects"), problem));
        }
        if let Some(absent) = objects.iter().find(|name| !may_be_absent && !world.objects.contains_key(*name)) {
            let problem = format!(
                "`{absent}` is not there, expected its pose; where an object may be absent, name all objects of the \
                 task under `objects` in every file"
            );
            return Err(mistake(format!("{key}.objects"), problem));
        }
        if world.opening.is_none() && features.has_opening() {
            return Err(mistake(format!("{key}.opening"), "missing, expected metres between the fingers"));
        }
        poses_of(world, key)
    }
}

/// The poses of a world that stands under `key`.
pub(crate) fn poses_of(world: &FileWorld, key: &str) -> Result<Poses, Mistake> {
    if let Some(metres) = world.opening.filter(|metres| !(0.0..=FARTHEST).contains(metres)) {
        let problem = format!("{metres}, expected metres between the fingers, 0 or more");
        return Err(mistake(format!("{key}.opening"), problem));
    }
    let each = |(name, given): (&String, &FilePose)| Ok((name.clone(), pose(given, &format!("{key}.objects.{name}"))?));
    let objects = world.objects.iter().map(each).collect::<Result<_, Mistake>>()?;
    Ok(Poses { objects, hand: pose(&world.hand, &format!("{key}.hand"))?, opening: world.opening })
}
