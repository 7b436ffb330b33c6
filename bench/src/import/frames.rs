//! The frames of a recording: its columns in our units, episode by episode.

use std::collections::BTreeSet;

use nalgebra::{Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use situ::demonstration::{Gripper, Pose};
use situ_tasks::key::KeyPath;

use crate::error::BenchError;
use crate::import::mapping::{Mapping, key};
use crate::import::mapping_keys::{AngleUnit, OpeningKeys, PoseKeys, QuaternionOrder};
use crate::import::sheet::Sheet;

/// How far the length of a recorded quaternion may be from 1. Two printed decimals lose so much.
const QUATERNION_TOLERANCE: f64 = 0.02;
/// How far the columns of a matrix may be from unit vectors at right angles.
const MATRIX_TOLERANCE: f64 = 0.02;
/// The most metres from the origin.
const FARTHEST: f64 = 1e6;
/// A length this near to 1 differs by rounding alone. The quaternion then stays as it was written.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// A moment of a recording. Poses are in the world frame, metres.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// Seconds since the episode's first frame.
    pub(super) seconds: f64,
    pub(super) hand: Pose,
    /// Share of the stroke or metres, as the mapping's unit says.
    pub(super) opening: Option<f64>,
    pub(super) command: Option<Gripper>,
    /// In the order of the mapping's objects.
    pub(super) objects: Vec<Pose>,
    /// Not 0 at a marked frame.
    pub(super) mark: Option<f64>,
    pub(super) reference: Option<String>,
    pub(super) narration: Option<String>,
    pub(super) announced: bool,
    pub(super) intervention: bool,
    pub(super) hold: Option<f64>,
}

/// The frames of an episode, at least one.
#[derive(Clone, Debug)]
pub(super) struct Take {
    /// What the recording calls it.
    pub(super) label: String,
    pub(super) frames: Vec<Frame>,
}

/// What is known of the gripper in each row.
struct Openings {
    measured: Option<Vec<f64>>,
    commands: Option<Vec<Gripper>>,
}

/// Reads the columns that a mapping names.
struct Reader<'a> {
    sheet: &'a Sheet,
    mapping: &'a Mapping,
}

impl Reader<'_> {
    fn missing(&self, name: &str, at: &KeyPath) -> BenchError {
        let mut known = self.sheet.names();
        // A long list is cut, so what begins alike comes first.
        let alike = |other: &&str| other.chars().zip(name.chars()).take_while(|(one, other)| one == other).count();
        known.sort_by_key(|other| std::cmp::Reverse(alike(other)));
        let (path, known) = (self.sheet.path().display(), known.join(", "));
        self.mapping.refuse(at, format!("no column `{name}` in {path}: expected one of {known}"))
    }

    fn numbers(&self, name: &str, at: &KeyPath) -> Result<Vec<f64>, BenchError> {
        self.sheet.numbers(name).unwrap_or_else(|| Err(self.missing(name, at)))
    }

    fn all<const N: usize>(&self, names: &[String; N], at: &KeyPath) -> Result<Vec<Vec<f64>>, BenchError> {
        names.iter().enumerate().map(|(index, name)| self.numbers(name, &at.index(index))).collect()
    }

    fn flags(&self, name: Option<&str>, word: &str) -> Result<Option<Vec<f64>>, BenchError> {
        let read = |name| self.sheet.flags(name).unwrap_or_else(|| Err(self.missing(name, &key(&["columns", word]))));
        name.map(read).transpose()
    }

    fn words(&self, name: Option<&String>, at: &KeyPath) -> Result<Option<Vec<String>>, BenchError> {
        name.map(|name| self.sheet.words(name).ok_or_else(|| self.missing(name, at))).transpose()
    }

    /// The poses of a thing, one a row.
    fn poses(&self, pose: &PoseKeys, at: &KeyPath) -> Result<Vec<Pose>, BenchError> {
        let rows = self.sheet.rows();
        let per_metre = self.mapping.keys.units.length.per_metre();
        let order = self.mapping.order(pose).unwrap_or(QuaternionOrder::Wxyz);
        if let Some(fixed) = &pose.fixed {
            let [x, y, z] = fixed.position.map(|value| value / per_metre);
            let rotation = fixed.quaternion.map_or(UnitQuaternion::identity(), |parts| unit(ordered(parts, order)));
            return Ok(vec![Pose::from_parts(Translation3::new(x, y, z), rotation); rows]);
        }
        if let Some(columns) = pose.topic_columns() {
            let topic = at.field("topic");
            if self.sheet.column(&columns[0]).is_none() {
                let (path, known) = (self.sheet.path().display(), self.sheet.names().join(", "));
                let problem = format!("no pose of this topic in {path} (topics are of MCAP files): it has {known}");
                return Err(self.mapping.refuse(&topic, problem));
            }
            let parts = columns.iter().map(|name| self.numbers(name, &topic)).collect::<Result<Vec<_>, _>>()?;
            let rotations = self.quaternions(&parts[3..], &columns[3], QuaternionOrder::Wxyz)?;
            return self.joined(&parts[..3], rotations, 1.0, &columns[0]);
        }
        let names = pose.position.as_ref().ok_or_else(|| self.mapping.refuse(at, "expected a position"))?;
        let position = self.all(names, &at.field("position"))?;
        let rotations = self.rotations(pose, at, order)?;
        self.joined(&position, rotations, per_metre, &names[0])
    }

    fn joined(
        &self,
        position: &[Vec<f64>],
        rotations: Vec<UnitQuaternion<f64>>,
        per_metre: f64,
        name: &str,
    ) -> Result<Vec<Pose>, BenchError> {
        let pose = |(row, rotation)| {
            let at = Vector3::from_fn(|axis, _| position[axis][row] / per_metre);
            match at.amax() <= FARTHEST {
                true => Ok(Pose::from_parts(at.into(), rotation)),
                false => Err(self.sheet.refuse_at(row, name, format!("expected at most {FARTHEST} metres"))),
            }
        };
        rotations.into_iter().enumerate().map(pose).collect()
    }

    fn rotations(
        &self,
        pose: &PoseKeys,
        at: &KeyPath,
        order: QuaternionOrder,
    ) -> Result<Vec<UnitQuaternion<f64>>, BenchError> {
        let rows = 0..self.sheet.rows();
        let turn = match self.mapping.keys.units.angle {
            AngleUnit::Rad => 1.0,
            AngleUnit::Deg => std::f64::consts::PI / 180.0,
        };
        if let Some(names) = &pose.quaternion {
            let parts = self.all(names, &at.field("quaternion"))?;
            return self.quaternions(&parts, &names[0], order);
        }
        if let Some(names) = &pose.rotation_vector {
            let parts = self.all(names, &at.field("rotation_vector"))?;
            let vector = |row: usize| Vector3::new(parts[0][row], parts[1][row], parts[2][row]) * turn;
            let far = rows.clone().find(|row| vector(*row).amax() > FARTHEST);
            if let Some(row) = far {
                return Err(self.sheet.refuse_at(row, &names[0], "expected an angle of at most 1000000 radians"));
            }
            return Ok(rows.map(|row| UnitQuaternion::from_scaled_axis(vector(row))).collect());
        }
        if let Some(names) = &pose.roll_pitch_yaw {
            let parts = self.all(names, &at.field("roll_pitch_yaw"))?;
            let angle = |part: usize, row: usize| parts[part][row] * turn;
            let euler = |row| UnitQuaternion::from_euler_angles(angle(0, row), angle(1, row), angle(2, row));
            return Ok(rows.map(euler).collect());
        }
        if let Some(names) = &pose.matrix {
            let parts = self.all(names, &at.field("matrix"))?;
            let matrix = |row: usize| Matrix3::from_fn(|line, column| parts[3 * line + column][row]);
            return rows.map(|row| self.rotation(&matrix(row), row, &names[0])).collect();
        }
        Ok(vec![UnitQuaternion::identity(); rows.len()])
    }

    fn rotation(&self, matrix: &Matrix3<f64>, row: usize, name: &str) -> Result<UnitQuaternion<f64>, BenchError> {
        let is_near = matrix.amax() <= 2.0
            && (matrix * matrix.transpose() - Matrix3::identity()).amax() <= MATRIX_TOLERANCE
            && matrix.determinant() > 0.0;
        if !is_near {
            let problem = "no rotation matrix: expected right-handed unit vectors at right angles, row after row";
            return Err(self.sheet.refuse_at(row, name, problem));
        }
        Ok(UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*matrix)))
    }

    fn quaternions(
        &self,
        parts: &[Vec<f64>],
        name: &str,
        order: QuaternionOrder,
    ) -> Result<Vec<UnitQuaternion<f64>>, BenchError> {
        let quaternion = |row: usize| {
            let quaternion = ordered([0, 1, 2, 3].map(|part| parts[part][row]), order);
            let length = libm::sqrt(quaternion.coords.dot(&quaternion.coords));
            if (length - 1.0).abs() <= QUATERNION_TOLERANCE {
                return Ok(unit(quaternion));
            }
            Err(self.sheet.refuse_at(row, name, format!("a quaternion of length {length}: expected length 1")))
        };
        (0..self.sheet.rows()).map(quaternion).collect()
    }

    /// Seconds of each row, from whatever moment on.
    fn seconds(&self) -> Result<Vec<f64>, BenchError> {
        let columns = &self.mapping.keys.columns;
        if let Some(name) = &columns.time {
            let per_second = self.mapping.keys.units.time.per_second();
            let times = self.numbers(name, &key(&["columns", "time"]))?;
            return Ok(times.into_iter().map(|time| time / per_second).collect());
        }
        if let Some(rate) = columns.rate {
            return Ok((0..self.sheet.rows()).map(|row| row as f64 / rate).collect());
        }
        match self.sheet.usual().time {
            Some(name) => self.numbers(name, &key(&["columns", "time"])),
            None => {
                let problem = "expected `time` (the column of the time) or `rate` (frames a second)";
                Err(self.mapping.refuse(&key(&["columns"]), problem))
            }
        }
    }

    /// The opening of each row, and the command to the gripper.
    fn openings(&self) -> Result<Openings, BenchError> {
        let OpeningKeys { column, command, command_kind, unit, closed, open, .. } = &self.mapping.keys.opening;
        let (closed, open) = (closed.unwrap_or(0.0), open.unwrap_or(1.0));
        let scaled = |value: f64| match unit.length() {
            None => ((value - closed) / (open - closed)).clamp(0.0, 1.0),
            Some(length) => value / length.per_metre(),
        };
        let at = |name| key(&["opening", name]);
        let read = |name: &Option<String>, word| name.as_ref().map(|name| self.numbers(name, &at(word))).transpose();
        let opening = read(column, "column")?.map(|values| values.into_iter().map(scaled).collect::<Vec<_>>());
        let values = read(command, "command")?;
        let kinds = self.words(command_kind.as_ref(), &at("command_kind"))?;
        let commands = match (values, kinds) {
            (Some(values), Some(kinds)) => {
                let name = command_kind.as_deref().unwrap_or_default();
                let rows = values.into_iter().zip(kinds).enumerate();
                Some(rows.map(|(row, (value, kind))| self.command(row, value, &kind, name)).collect::<Result<_, _>>()?)
            }
            (Some(values), None) => {
                let is_share = unit.length().is_none();
                let command = |value| if is_share { Gripper::Opening(value) } else { Gripper::Open(value) };
                Some(values.into_iter().map(scaled).map(command).collect())
            }
            (None, _) => None,
        };
        Ok(Openings { measured: opening, commands })
    }

    fn command(&self, row: usize, value: f64, kind: &str, name: &str) -> Result<Gripper, BenchError> {
        let (command, is_fine) = match kind {
            "share" => (Gripper::Opening(value), (0.0..=1.0).contains(&value)),
            "open" => (Gripper::Open(value), (0.0..=FARTHEST).contains(&value)),
            "close" => (Gripper::Close(value), (0.0..=FARTHEST).contains(&value)),
            _ => {
                let problem =
                    format!("`{kind}`: expected \"share\" (0 to 1), \"open\" (metres) or \"close\" (newtons)");
                return Err(self.sheet.refuse_at(row, name, problem));
            }
        };
        match is_fine {
            true => Ok(command),
            false => Err(self.sheet.refuse_at(row, name, format!("{value} is no command of the kind \"{kind}\""))),
        }
    }

    /// The object that is named in each row; an empty cell names none.
    fn references(&self) -> Result<Option<Vec<String>>, BenchError> {
        let name = self.mapping.keys.columns.reference.as_ref();
        let references = self.words(name, &key(&["columns", "reference"]))?;
        let known = |word: &String| word.is_empty() || self.mapping.keys.objects.contains_key(word);
        if let (Some(references), Some(name)) = (&references, name)
            && let Some(row) = references.iter().position(|word| !known(word))
        {
            let objects = self.mapping.objects().collect::<Vec<_>>().join(", ");
            let problem = format!("no object `{}`: expected one of {objects}, or nothing", references[row]);
            return Err(self.sheet.refuse_at(row, name, problem));
        }
        Ok(references)
    }

    fn frames(&self) -> Result<Vec<Frame>, BenchError> {
        let keys = &self.mapping.keys;
        let hands = self.poses(&keys.gripper, &key(&["gripper"]))?;
        let objects = keys.objects.iter().map(|(name, pose)| self.poses(pose, &key(&["objects", name])));
        let objects = objects.collect::<Result<Vec<_>, _>>()?;
        let seconds = self.seconds()?;
        let Openings { measured: openings, commands } = self.openings()?;
        let columns = &keys.columns;
        let intervention = columns.intervention.as_deref().or(self.sheet.usual().intervention);
        let marks = self.flags(columns.mark.as_deref(), "mark")?;
        let interventions = self.flags(intervention, "intervention")?;
        let announced = self.flags(columns.announced.as_deref(), "announced")?;
        let references = self.references()?;
        let narrations = self.words(columns.narration.as_ref(), &key(&["columns", "narration"]))?;
        let hold = columns.hold.as_ref();
        let holds = hold.map(|name| self.numbers(name, &key(&["columns", "hold"]))).transpose()?;
        if let (Some(holds), Some(name)) = (&holds, hold)
            && let Some(row) = holds.iter().position(|hold| !(0.0..=FARTHEST).contains(hold))
        {
            return Err(self.sheet.refuse_at(row, name, format!("{}: expected seconds, 0 or more", holds[row])));
        }
        let word = |words: &Option<Vec<String>>, row: usize| {
            words.as_ref().map(|words| words[row].clone()).filter(|word| !word.is_empty())
        };
        let number = |numbers: &Option<Vec<f64>>, row: usize| numbers.as_ref().map(|numbers| numbers[row]);
        let frame = |row: usize| Frame {
            seconds: seconds[row],
            hand: hands[row],
            opening: number(&openings, row),
            command: commands.as_ref().map(|commands| commands[row]),
            objects: objects.iter().map(|poses| poses[row]).collect(),
            mark: number(&marks, row),
            reference: word(&references, row),
            narration: word(&narrations, row),
            announced: number(&announced, row).is_some_and(|flag| flag != 0.0),
            intervention: number(&interventions, row).is_some_and(|flag| flag != 0.0),
            hold: number(&holds, row),
        };
        Ok((0..self.sheet.rows()).map(frame).collect())
    }
}

/// A quaternion of four numbers in this order.
fn ordered([a, b, c, d]: [f64; 4], order: QuaternionOrder) -> Quaternion<f64> {
    match order {
        QuaternionOrder::Wxyz => Quaternion::new(a, b, c, d),
        QuaternionOrder::Xyzw => Quaternion::new(d, a, b, c),
    }
}

fn unit(quaternion: Quaternion<f64>) -> UnitQuaternion<f64> {
    let length = libm::sqrt(quaternion.coords.dot(&quaternion.coords));
    let is_unit = (length - 1.0).abs() <= ROUNDING;
    UnitQuaternion::new_unchecked(if is_unit { quaternion } else { quaternion / length })
}

/// The episodes of a sheet in the order in which they begin. Without a column of episodes all of it is one, called
/// `label`.
///
/// # Errors
/// [`BenchError::Task`] where the mapping names what is not there; [`BenchError::Recording`] with row and column.
pub(super) fn takes(sheet: &Sheet, mapping: &Mapping, label: &str) -> Result<Vec<Take>, BenchError> {
    let reader = Reader { sheet, mapping };
    let frames = reader.frames()?;
    let named = mapping.keys.columns.episode.as_deref();
    let column = named.or(sheet.usual().episode);
    let labels = match column {
        None => vec![label.to_owned(); frames.len()],
        Some(name) => sheet.words(name).ok_or_else(|| reader.missing(name, &key(&["columns", "episode"])))?,
    };
    let (mut takes, mut met): (Vec<Take>, BTreeSet<String>) = (Vec::new(), BTreeSet::new());
    let (mut begun, mut last) = (0.0, 0.0);
    for (row, (mut frame, label)) in frames.into_iter().zip(labels).enumerate() {
        if takes.last().is_none_or(|take| take.label != label) {
            if !met.insert(label.clone()) {
                let problem = format!("episode `{label}` goes on after another: expected its rows to stand together");
                return Err(sheet.refuse_at(row, column.unwrap_or_default(), problem));
            }
            takes.push(Take { label, frames: Vec::new() });
            (begun, last) = (frame.seconds, frame.seconds);
        }
        if frame.seconds < last || frame.seconds - begun > FARTHEST {
            let name = mapping.keys.columns.time.as_deref().or(sheet.usual().time).unwrap_or_default();
            let problem = format!("{} after {last}: expected a time that does not go back, nor jump", frame.seconds);
            return Err(sheet.refuse_at(row, name, problem));
        }
        last = frame.seconds;
        frame.seconds -= begun;
        if let Some(take) = takes.last_mut() {
            take.frames.push(frame);
        }
    }
    Ok(takes)
}
