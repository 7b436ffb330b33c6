//! From a task file as written to checked settings; every mistake is reported at its key.

mod check;
mod coupling;
mod event;
mod family;
mod hinge;
mod layers;
pub(crate) mod mesh;
mod names;
mod object;
mod perception;
mod role;
mod skill;
mod slide;

use std::collections::BTreeSet;

use situ_sim::{Beads, Hinge, Slide};

pub(crate) use check::Builder;
use layers::{Layers, Located, New, laid_over, located};
use names::Names;

use crate::edit::NeededEdit;
use crate::error::TaskError;
use crate::feature::WorldSchema;
use crate::file::{ObjectFile, VariationFile};
use crate::key::KeyPath;
use crate::placement::{HandStart, Placed};
use crate::plant::Plant;
use crate::role::ObjectRole;
use crate::setting::Setting;
use crate::start::BORDER;
use crate::view::GRIPPER;

/// Names that mean something else where objects and skills are named.
const RESERVED: [&str; 7] = [GRIPPER, "table", "hand", "arm", BORDER, "start", "end"];

/// What is there in a setting.
struct Things<'a> {
    files: Located<'a, ObjectFile>,
    names: Names,
    roles: Vec<ObjectRole>,
    objects: Vec<Placed>,
    slides: Vec<Slide>,
    hinges: Vec<Hinge>,
    /// The container that is filled, and its beads.
    beads: Option<(String, Beads)>,
}

impl<'a> Builder<'a> {
    /// The original (no index) or one variation.
    pub(crate) fn setting(&self, schema: &WorldSchema, index: Option<usize>) -> Result<Setting, TaskError> {
        let (file, root) = (self.file, KeyPath::default());
        let layers = Layers::new(file, index);
        let variation = layers.over().map(|(_, variation)| variation);

        let things = self.things(&layers)?;
        let names = &things.names;
        let skill_lists = layers.lists("skill", &file.skill, |v| &v.skill);
        let skill_files = self.merged(skill_lists, "skill", |skill| &skill.name, New::First)?;
        let original_skills = self.skills(&located(&root, "skill", &file.skill), names)?;
        let skills = self.skills(&skill_files, names)?;
        let magnets = layers.lists("magnet", &file.magnet, |v| &v.magnet).concat();
        let events = layers.lists("event", &file.event, |v| &v.event).concat();
        let interventions = layers.lists("intervention", &file.intervention, |v| &v.intervention).concat();
        let (premise_key, premise) = layers.value("premise", &file.premise, |v| &v.premise);
        let (goal_key, goal) = layers.value("goal", &file.goal, |v| &v.goal);
        let (limit_key, time_limit) = layers.value("time_limit", &file.time_limit, |v| &v.time_limit);
        self.check_positive(&limit_key, *time_limit)?;

        let setting = Setting {
            task: file.name.clone(),
            variation: variation.map(|v| v.name.clone()),
            edit: variation.map_or(NeededEdit::None, |v| v.edit),
            graded: variation.is_some_and(|v| v.graded),
            analysis: variation.map_or(&file.analysis, |v| &v.analysis).trim().to_owned(),
            accepts_edges: variation.map(|v| v.accepts_edges.clone()).unwrap_or_default(),
            roles: things.roles,
            beads: things.beads,
            slides: things.slides,
            hinges: things.hinges,
            magnets: each(magnets, |key, magnet| self.magnet(key, magnet, names))?,
            events: each(events, |key, event| self.event(key, event, names, &skills))?,
            premise: self.predicate(&premise_key, premise, names)?,
            goal: self.predicate(&goal_key, goal, names)?,
            skills,
            original_skills,
            schema: schema.clone(),
            interventions: each(interventions, |key, file| self.intervention(key, file, names))?,
            time_limit: *time_limit,
            guard: self.guard(&root)?,
            perception: self.perception(&root)?,
            plant: Plant::default(),
            solver_iterations: file.solver_iterations,
            hand: self.hand(&root)?,
            objects: things.objects,
        };
        if let Some((key, variation)) = layers.over() {
            self.check_edit(key, variation, &setting)?;
        }
        self.check_starts(&things.files, &setting)?;
        Ok(setting)
    }

    /// What is there, in the file with a variation laid over it.
    fn things(&self, layers: &Layers<'a>) -> Result<Things<'a>, TaskError> {
        let (file, root) = (self.file, KeyPath::default());
        let object_lists = layers.lists("object", &file.object, |v| &v.object);
        let files = self.merged(object_lists, "object", |object| &object.name, New::Last)?;
        let slide_files = self.merged_slides(layers.lists("joint", &file.joint, |v| &v.joint))?;
        let hinge_files = self.merged_hinges(layers.lists("hinge", &file.hinge, |v| &v.hinge))?;
        let beads = layers.changed("beads", |v| &v.beads);
        let beads = beads.or_else(|| Some((root.field("beads"), file.beads.as_ref()?)));
        let names = Names::new(&files, &slide_files, &hinge_files, beads.is_some());
        let role_lists = layers.lists("role", &file.role, |v| &v.role);
        let role_files = self.merged(role_lists, "role", |role| &role.name, New::Last)?;
        let roles = self.roles(&role_files, &files, &names)?;
        let objects = self.objects(&files)?;
        let slides = each(slide_files, |key, slide| self.slide(key, slide, &objects, &names))?;
        let hinges = each(hinge_files, |key, hinge| self.hinge(key, hinge, &objects, &names))?;
        let beads = beads.map(|(key, beads)| self.beads(&key, beads, &names)).transpose()?;
        Ok(Things { files, names, roles, objects, slides, hinges, beads })
    }

    /// Where the hand starts: `[gripper]`.
    fn hand(&self, root: &KeyPath) -> Result<HandStart, TaskError> {
        let (key, file) = (root.field("gripper"), &self.file.gripper);
        self.check_opening(&key.field("open"), file.open)?;
        self.check_positive(&key.field("at").index(2), file.at[2])?;
        Ok(*file)
    }

    /// The entries of the file with those of a variation, by their names. Either list names each entry once.
    fn merged<T>(
        &self,
        lists: [Located<'a, T>; 2],
        field: &str,
        name: fn(&T) -> &String,
        new: New,
    ) -> Result<Located<'a, T>, TaskError> {
        for list in &lists {
            let mut seen = BTreeSet::new();
            for (key, entry) in list {
                let (key, name) = (key.field("name"), name(entry));
                self.check_word(&key, name)?;
                if RESERVED.contains(&name.as_str()) {
                    return self.wrong(&key, format!("the name `{name}` is reserved; expected another"));
                }
                if !seen.insert(name) {
                    return self.wrong(&key, format!("the {field} `{name}` exists already; expected another name"));
                }
            }
        }
        Ok(laid_over(lists, name, new))
    }

    /// Whether what a variation changes agrees with the edit that it declares.
    fn check_edit(&self, key: &KeyPath, variation: &VariationFile, setting: &Setting) -> Result<(), TaskError> {
        let known: BTreeSet<&str> = self.file.skill.iter().map(|skill| skill.name.as_str()).collect();
        let added = variation.skill.iter().filter(|skill| !known.contains(skill.name.as_str())).count();
        let replaced = variation.skill.len() - added;
        let rule = match variation.edit {
            NeededEdit::NodeAddition if added == 0 => "at least one skill of a new name",
            NeededEdit::EdgeAddition if !variation.skill.is_empty() => {
                "no change of the skills: only their order differs"
            }
            NeededEdit::EdgeAddition if variation.accepts_edges.is_empty() => "`accepts_edges` to name the transition",
            NeededEdit::NodeModification if replaced == 0 || added > 0 => {
                "skills that replace some of the original, and no others"
            }
            NeededEdit::None if !variation.skill.is_empty() => "no change of the skills",
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
}

/// What is built of each entry of a list.
fn each<T, B>(list: Located<'_, T>, build: impl Fn(&KeyPath, &T) -> Result<B, TaskError>) -> Result<Vec<B>, TaskError> {
    list.iter().map(|(key, entry)| build(key, entry)).collect()
}
