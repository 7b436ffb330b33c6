//! Roles that several objects can fill, and what conditions say of each of them: `[[role]]` and `each`.

use super::check::Builder;
use super::layers::Located;
use super::names::Names;
use crate::error::TaskError;
use crate::expression::{Argument, Call};
use crate::file::{ObjectFile, RoleFile};
use crate::key::KeyPath;
use crate::predicate::Predicate;
use crate::role::{IT, ObjectRole};

/// The word of a condition about each object of a role.
const EACH: &str = "each";

impl Builder<'_> {
    /// The roles of a setting, with the objects that can fill them.
    pub(super) fn roles(
        &self,
        files: &Located<'_, RoleFile>,
        objects: &Located<'_, ObjectFile>,
        names: &Names,
    ) -> Result<Vec<ObjectRole>, TaskError> {
        for (key, object) in objects {
            if let Some(role) = object.role.as_ref().filter(|role| !files.iter().any(|(_, file)| file.name == **role)) {
                let known: Vec<&str> = files.iter().map(|(_, file)| file.name.as_str()).collect();
                let known = if known.is_empty() { "a `[[role]]` of this name".to_owned() } else { known.join(", ") };
                return self.wrong(&key.field("role"), format!("there is no role `{role}`; expected {known}"));
            }
        }
        files.iter().map(|(key, file)| self.role(key, file, objects, names)).collect()
    }

    fn role(
        &self,
        key: &KeyPath,
        file: &RoleFile,
        objects: &Located<'_, ObjectFile>,
        names: &Names,
    ) -> Result<ObjectRole, TaskError> {
        if objects.iter().any(|(_, object)| object.name == file.name) {
            let expected = format!("`{}` is an object already; expected another name", file.name);
            return self.wrong(&key.field("name"), expected);
        }
        if objects.iter().any(|(_, object)| object.name == IT) {
            let expected = format!("an object is called `{IT}`, by which `done` speaks of any; expected another name");
            return self.wrong(&key.field("done"), expected);
        }
        let members = objects.iter().filter(|(_, object)| object.role.as_ref() == Some(&file.name));
        let members: Vec<&str> = members.map(|(_, object)| object.name.as_str()).collect();
        if members.is_empty() {
            let expected = format!("no object has `role = \"{}\"`; expected at least one", file.name);
            return self.wrong(&key.field("name"), expected);
        }
        let key = key.field("done");
        let call = Call::parse(&file.done).map_err(|expected| self.document.error(&key, expected))?;
        if !call.speaks_of(IT) {
            return self.wrong(&key, format!("expected a condition about `{IT}`, the object that may be done"));
        }
        let mut done = Vec::new();
        for object in members {
            let condition = self.condition(&key, &call.with(IT, object), names)?;
            let mut role = None;
            condition.visit_names(&mut |name, _| {
                role = role.take().or_else(|| names.is_role(name).then(|| name.to_owned()))
            });
            if let Some(name) = role {
                return self.wrong(&key, format!("`{name}` is a role; expected `{IT}` or the names of objects"));
            }
            done.push((object.to_owned(), condition));
        }
        Ok(ObjectRole { name: file.name.clone(), objects: done })
    }

    /// A condition that is read from a call, in which `each(role, p)` stands for `p` about each object of the role.
    pub(super) fn condition(&self, key: &KeyPath, call: &Call, names: &Names) -> Result<Predicate, TaskError> {
        let read = spread(call, names).and_then(|call| Predicate::from_call(&call));
        let predicate = read.map_err(|expected| self.document.error(key, expected))?;
        let mut mistake = None;
        predicate.visit_names(&mut |name, role| mistake = mistake.take().or_else(|| names.mistake(name, role)));
        mistake.map_or(Ok(predicate), |expected| self.wrong(key, expected))
    }
}

/// A call in which each argument `each(role, p)` has been replaced by `p` about each object of the role.
fn spread(call: &Call, names: &Names) -> Result<Call, String> {
    let mut arguments = Vec::new();
    for argument in &call.arguments {
        match argument {
            Argument::Call(Call { word, arguments: of }) if word == EACH => {
                let [Argument::Name(role), Argument::Call(about)] = of.as_slice() else {
                    return Err(format!("expected `{EACH}(role, condition about {IT})`"));
                };
                let about = spread(about, names)?;
                let Some(objects) = names.objects_of(role) else {
                    return Err(format!("there is no role `{role}`; expected the role of an object"));
                };
                if !about.speaks_of(IT) {
                    return Err(format!("expected a condition about `{IT}`, the object, in `{EACH}`"));
                }
                arguments.extend(objects.iter().map(|object| Argument::Call(about.with(IT, object))));
            }
            Argument::Call(inner) => arguments.push(Argument::Call(spread(inner, names)?)),
            other => arguments.push(other.clone()),
        }
    }
    Ok(Call { word: call.word.clone(), arguments })
}
