//! From a task file as written to checked settings; every mistake is reported at its key.

mod event;
mod joint;
mod object;
mod skill;

use std::collections::{BTreeMap, BTreeSet};

use situ_sim::MAX_OPENING;

use crate::error::TaskError;
use crate::feature::{Observable, Schema};
use crate::file::{JointFile, ObjectFile, TaskFile, VariationFile};
use crate::key::{Document, Key};
use crate::plant::Plant;
use crate::predicate::{GRIPPER, Predicate, Role};
use crate::sequence::Sequence;
use crate::setting::{Edit, Event, HandStart, Setting};
use crate::start::BORDER;

/// Names that mean something else where objects and skills are named.
const RESERVED: [&str; 7] = [GRIPPER, "table", "hand", "arm", BORDER, "start", "end"];

/// Builds the settings of one file.
pub(crate) struct Builder<'a> {
    pub(crate) document: &'a Document<'a>,
    pub(crate) file: &'a TaskFile,
}

/// The objects of a setting, as far as names are concerned: containers, what slides, and whether there are beads.
struct Names {
    objects: BTreeMap<String, bool>,
    sliding: BTreeSet<String>,
    beads: bool,
}

type Located<'a, T> = Vec<(Key, &'a T)>;

impl<'a> Builder<'a> {
    /// Checks what belongs to the file as a whole: its name, the names of its variations.
    pub(crate) fn check_names(&self) -> Result<(), TaskError> {
        let root = Key::default();
        self.check_word(&root.field("name"), &self.file.name)?;
        let mut seen = BTreeSet::new();
        for (i, variation) in self.file.variation.iter().enumerate() {
            let key = root.field("variation").index(i).field("name");
            self.check_word(&key, &variation.name)?;
            if !seen.insert(variation.name.as_str()) {
                return self
                    .wrong(&key, format!("the variation `{}` exists already; expected another name", variation.name));
            }
        }
        Ok(())
    }

    /// The sequences of variations.
    pub(crate) fn sequences(&self) -> Result<Vec<Sequence>, TaskError> {
        let mut seen = BTreeSet::new();
        let mut sequences = Vec::new();
        for (key, file) in located(&Key::default(), "sequence", &self.file.sequence) {
            self.check_word(&key.field("name"), &file.name)?;
            if !seen.insert(&file.name) {
                let expected = format!("the sequence `{}` exists already; expected another name", file.name);
                return self.wrong(&key.field("name"), expected);
            }
            if file.variations.len() < 2 {
                return self.wrong(&key.field("variations"), "expected at least two variations");
            }
            for (i, name) in file.variations.iter().enumerate() {
                let key = key.field("variations").index(i);
                if !self.file.variation.iter().any(|variation| &variation.name == name) {
                    let known = self.file.variation.iter().map(|variation| variation.name.as_str()).collect::<Vec<_>>();
                    let expected = format!("there is no variation `{name}`; expected one of {}", known.join(", "));
                    return self.wrong(&key, expected);
                }
                if file.variations[..i].contains(name) {
                    return self
                        .wrong(&key, format!("`{name}` is in the sequence already; expected each variation once"));
                }
            }
            let analysis = file.analysis.trim().to_owned();
            sequences.push(Sequence { name: file.name.clone(), analysis, variations: file.variations.clone() });
        }
        Ok(sequences)
    }

    /// The features of the family: names may belong to the original or to any variation.
    pub(crate) fn schema(&self) -> Result<Schema, TaskError> {
        let root = Key::default();
        let mut all =
            self.names(&located(&root, "object", &self.file.object), &self.file.joint, self.file.beads.is_some());
        for (i, variation) in self.file.variation.iter().enumerate() {
            let key = root.field("variation").index(i);
            let more =
                self.names(&located(&key, "object", &variation.object), &variation.joint, variation.beads.is_some());
            all.objects.extend(more.objects);
            all.sliding.extend(more.sliding);
            all.beads |= more.beads;
        }
        let mut observables = Vec::new();
        for (i, text) in self.file.observe.iter().enumerate() {
            let key = root.field("observe").index(i);
            let observable = Observable::parse(text).map_err(|expected| self.document.error(&key, expected))?;
            let mut unknown = None;
            observable.visit_names(&mut |name, role| {
                unknown = unknown.take().or_else(|| all.mistake(name, role));
            });
            if let Some(expected) = unknown {
                return self.wrong(&key, expected);
            }
            if observables.contains(&observable) {
                return self.wrong(&key, format!("`{text}` is observed already; expected each feature once"));
            }
            observables.push(observable);
        }
        if observables.is_empty() {
            return self.wrong(&root.field("observe"), "expected at least one feature");
        }
        Ok(Schema::new(observables))
    }

    /// The original (no index) or one variation.
    pub(crate) fn setting(&self, schema: &Schema, index: Option<usize>) -> Result<Setting, TaskError> {
        let (file, root) = (self.file, Key::default());
        let patch = index.map(|i| (root.field("variation").index(i), &file.variation[i]));
        let list = |base: Key, patched: Option<Key>| patched.unwrap_or(base);
        let patched_key =
            |present: bool, name: &str| patch.as_ref().filter(|_| present).map(|(key, _)| key.field(name));
        let variation = patch.as_ref().map(|(_, variation)| *variation);

        let objects =
            self.merged(located(&root, "object", &file.object), &patch, "object", |v| &v.object, |o| &o.name, false)?;
        let beads = variation.and_then(|v| v.beads.as_ref()).or(file.beads.as_ref());
        let joint_files = self.merged_joints(&patch)?;
        let names = self.names(&objects, joint_files.iter().map(|(_, joint)| *joint), beads.is_some());
        let placed = self.objects(&objects)?;
        let mut joints = Vec::new();
        for (key, joint) in joint_files {
            joints.push(self.joint(&key, joint, &placed, &names)?);
        }
        let beads_key = list(root.field("beads"), patched_key(variation.is_some_and(|v| v.beads.is_some()), "beads"));
        let beads = beads.map(|beads| self.beads(&beads_key, beads, &names)).transpose()?;

        let base_skills = self.skills(&self.merged_skills(&None)?, &names)?;
        let skill_files = self.merged_skills(&patch)?;
        let skills = self.skills(&skill_files, &names)?;
        let mut magnets = Vec::new();
        for (key, magnet) in appended(&root, "magnet", &file.magnet, &patch, |v| &v.magnet) {
            magnets.push(self.magnet(&key, magnet, &names)?);
        }
        let mut events: Vec<Event> = Vec::new();
        for (key, event) in appended(&root, "event", &file.event, &patch, |v| &v.event) {
            events.push(self.event(&key, event, &names, &skills)?);
        }
        let mut interventions = Vec::new();
        for (key, intervention) in appended(&root, "intervention", &file.intervention, &patch, |v| &v.intervention) {
            interventions.push(self.intervention(&key, intervention, &names)?);
        }

        let premise_key =
            list(root.field("premise"), patched_key(variation.is_some_and(|v| v.premise.is_some()), "premise"));
        let premise = variation.and_then(|v| v.premise.as_ref()).unwrap_or(&file.premise);
        let goal_key = list(root.field("goal"), patched_key(variation.is_some_and(|v| v.goal.is_some()), "goal"));
        let goal = variation.and_then(|v| v.goal.as_ref()).unwrap_or(&file.goal);
        let limit_key = list(
            root.field("time_limit"),
            patched_key(variation.is_some_and(|v| v.time_limit.is_some()), "time_limit"),
        );
        let time_limit = variation.and_then(|v| v.time_limit).unwrap_or(file.time_limit);
        self.check_positive(&limit_key, time_limit)?;
        let guard = self.guard(&root)?;
        let gripper_key = root.field("gripper").field("open");
        self.check_opening(&gripper_key, file.gripper.open)?;
        self.check_positive(&root.field("gripper").field("at").index(2), file.gripper.at[2])?;

        let setting = Setting {
            task: file.name.clone(),
            variation: variation.map(|v| v.name.clone()),
            edit: variation.map_or(Edit::None, |v| v.edit),
            analysis: variation.map_or(&file.analysis, |v| &v.analysis).trim().to_owned(),
            accepts_edges: variation.map(|v| v.accepts_edges.clone()).unwrap_or_default(),
            premise: self.predicate(&premise_key, premise, &names)?,
            goal: self.predicate(&goal_key, goal, &names)?,
            objects: placed,
            beads,
            joints,
            magnets,
            events,
            skills,
            original_skills: base_skills,
            schema: schema.clone(),
            interventions,
            time_limit,
            guard,
            plant: Plant::default(),
            solver_iterations: file.solver_iterations,
            hand: HandStart { at: file.gripper.at, open: file.gripper.open },
        };
        if let Some((key, variation)) = &patch {
            self.check_edit(key, variation, &setting)?;
        }
        self.check_starts(&objects, &setting)?;
        Ok(setting)
    }

    /// Whether what a variation changes agrees with the edit that it declares.
    fn check_edit(&self, key: &Key, variation: &VariationFile, setting: &Setting) -> Result<(), TaskError> {
        let known: BTreeSet<&str> = self.file.skill.iter().map(|skill| skill.name.as_str()).collect();
        let added = variation.skill.iter().filter(|skill| !known.contains(skill.name.as_str())).count();
        let replaced = variation.skill.len() - added;
        let rule = match variation.edit {
            Edit::NodeAddition if added == 0 => "at least one skill of a new name",
            Edit::EdgeAddition if !variation.skill.is_empty() => {
                "no change of the skills, for only their order differs"
            }
            Edit::EdgeAddition if variation.accepts_edges.is_empty() => "`accepts_edges` to name the transition",
            Edit::NodeModification if replaced == 0 || added > 0 => {
                "skills that replace some of the original, and no others"
            }
            Edit::None if !variation.skill.is_empty() => "no change of the skills",
            _ => "",
        };
        if !rule.is_empty() {
            let expected = format!("the edit `{}` was declared; expected {rule}", variation.edit.word());
            return self.wrong(&key.field("edit"), expected);
        }
        for (i, edge) in variation.accepts_edges.iter().enumerate() {
            for name in edge {
                if !["start", "end"].contains(&name.as_str()) && !setting.skills.iter().any(|skill| &skill.name == name)
                {
                    let expected = format!("there is no skill `{name}`; expected a skill, `start` or `end`");
                    return self.wrong(&key.field("accepts_edges").index(i), expected);
                }
            }
        }
        Ok(())
    }

    /// The base's entries with those of the variation: the same name replaces, a new one comes after (or before) the rest.
    fn merged<T>(
        &self,
        base: Located<'a, T>,
        patch: &Option<(Key, &'a VariationFile)>,
        field: &str,
        of: fn(&'a VariationFile) -> &'a Vec<T>,
        name: fn(&T) -> &String,
        first: bool,
    ) -> Result<Located<'a, T>, TaskError> {
        let mut merged = base;
        let unique = |entries: &Located<'a, T>| {
            let mut seen = BTreeSet::new();
            for (key, entry) in entries {
                let key = key.field("name");
                self.check_word(&key, name(entry))?;
                if RESERVED.contains(&name(entry).as_str()) {
                    return self.wrong(&key, format!("the name `{}` is reserved; expected another", name(entry)));
                }
                if !seen.insert(name(entry).clone()) {
                    return self
                        .wrong(&key, format!("the {field} `{}` exists already; expected another name", name(entry)));
                }
            }
            Ok(())
        };
        unique(&merged)?;
        let Some((key, variation)) = patch else { return Ok(merged) };
        let patches = located(key, field, of(variation));
        unique(&patches)?;
        let mut place = 0;
        for (key, entry) in patches {
            if let Some(old) = merged.iter_mut().find(|(_, old)| name(old) == name(entry)) {
                *old = (key, entry);
            } else if first {
                merged.insert(place, (key, entry));
                place += 1;
            } else {
                merged.push((key, entry));
            }
        }
        Ok(merged)
    }

    fn names<'j>(
        &self,
        objects: &Located<'_, ObjectFile>,
        joints: impl IntoIterator<Item = &'j JointFile>,
        beads: bool,
    ) -> Names {
        let objects = objects.iter().map(|(_, file)| (file.name.clone(), object::body(file).container.is_some()));
        let sliding = joints.into_iter().map(|joint| joint.object.clone());
        Names { objects: objects.collect(), sliding: sliding.collect(), beads }
    }

    fn predicate(&self, key: &Key, text: &str, names: &Names) -> Result<Predicate, TaskError> {
        let predicate = Predicate::parse(text).map_err(|expected| self.document.error(key, expected))?;
        let mut mistake = None;
        predicate.visit_names(&mut |name, role| mistake = mistake.take().or_else(|| names.mistake(name, role)));
        mistake.map_or(Ok(predicate), |expected| self.wrong(key, expected))
    }

    fn check_name(&self, key: &Key, name: &str, role: Role, names: &Names) -> Result<(), TaskError> {
        names.mistake(name, role).map_or(Ok(()), |expected| self.wrong(key, expected))
    }

    fn check_word(&self, key: &Key, word: &str) -> Result<(), TaskError> {
        let fine = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        if word.starts_with(|c: char| c.is_ascii_lowercase()) && word.chars().all(fine) {
            return Ok(());
        }
        self.wrong(key, format!("`{word}`: expected a name of small letters, digits and `_` that begins with a letter"))
    }

    fn check_positive(&self, key: &Key, value: f64) -> Result<(), TaskError> {
        if value > 0.0 { Ok(()) } else { self.wrong(key, format!("{value}: expected more than 0")) }
    }

    fn check_not_negative(&self, key: &Key, value: f64) -> Result<(), TaskError> {
        if value >= 0.0 { Ok(()) } else { self.wrong(key, format!("{value}: expected 0 or more")) }
    }

    fn check_opening(&self, key: &Key, width: f64) -> Result<(), TaskError> {
        if (0.0..=MAX_OPENING).contains(&width) {
            return Ok(());
        }
        self.wrong(key, format!("{width}: expected an opening of 0 to {MAX_OPENING} metres"))
    }

    fn wrong<T>(&self, key: &Key, expected: impl Into<String>) -> Result<T, TaskError> {
        Err(self.document.error(key, expected))
    }
}

impl Names {
    /// What is wrong with a name in this role, if anything.
    fn mistake(&self, name: &str, role: Role) -> Option<String> {
        let known = || self.objects.keys().cloned().collect::<Vec<_>>().join(", ");
        match (self.objects.get(name), role) {
            (None, Role::Point) if name == GRIPPER => None,
            (None, _) => Some(format!("there is no object `{name}`; expected one of {}", known())),
            (Some(_), Role::Sliding) if !self.sliding.contains(name) => {
                Some(format!("`{name}` does not slide; expected the object of a `[[joint]]`"))
            }
            (Some(false), Role::Container | Role::Filled) => {
                Some(format!("`{name}` is no container; expected a cup, a bin or a drawer"))
            }
            (Some(_), Role::Filled) if !self.beads => {
                Some(format!("nothing can be in `{name}`, for there are no beads; expected `[beads]`"))
            }
            _ => None,
        }
    }
}

/// Each entry of a list with its key.
fn located<'a, T>(root: &Key, field: &str, entries: &'a [T]) -> Located<'a, T> {
    entries.iter().enumerate().map(|(i, entry)| (root.field(field).index(i), entry)).collect()
}

/// The base's entries, then the variation's.
fn appended<'a, T>(
    root: &Key,
    field: &str,
    base: &'a [T],
    patch: &Option<(Key, &'a VariationFile)>,
    of: fn(&'a VariationFile) -> &'a Vec<T>,
) -> Located<'a, T> {
    let mut all = located(root, field, base);
    if let Some((key, variation)) = patch {
        all.extend(located(key, field, of(variation)));
    }
    all
}
