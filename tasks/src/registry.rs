//! The tasks that are known by name.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::error::TaskError;
use crate::name::shown;
use crate::plant::Plant;
use crate::task::Task;

/// The task files that are part of this crate.
const LIBRARY: [(&str, &str); 10] = [
    ("tasks/library/bread_box.toml", include_str!("../library/bread_box.toml")),
    ("tasks/library/clear_table.toml", include_str!("../library/clear_table.toml")),
    ("tasks/library/drawer.toml", include_str!("../library/drawer.toml")),
    ("tasks/library/lunch.toml", include_str!("../library/lunch.toml")),
    ("tasks/library/pour.toml", include_str!("../library/pour.toml")),
    ("tasks/library/press.toml", include_str!("../library/press.toml")),
    ("tasks/library/scoop.toml", include_str!("../library/scoop.toml")),
    ("tasks/library/sort_blocks.toml", include_str!("../library/sort_blocks.toml")),
    ("tasks/library/stack.toml", include_str!("../library/stack.toml")),
    ("tasks/library/tray.toml", include_str!("../library/tray.toml")),
];

/// The tasks that are known by name, in the order of their names.
#[derive(Debug, Clone, Default)]
pub struct Registry {
    tasks: BTreeMap<String, Task>,
    /// The text of each task's file, and the hashes of its meshes.
    texts: BTreeMap<String, String>,
}

impl Registry {
    /// The tasks of this crate.
    ///
    /// # Errors
    /// Only if a file of the library is wrong. A test excludes this.
    pub fn builtin() -> Result<Registry, TaskError> {
        let mut registry = Registry::default();
        for (file, text) in LIBRARY {
            let task = Task::parse(text, Path::new(file))?;
            registry.add(task, text, Path::new(file))?;
        }
        Ok(registry)
    }

    /// The same with all files `*.toml` of a folder, in the order of their names.
    ///
    /// # Errors
    /// The folder or a file cannot be read, a file is wrong, or a task of that name exists already.
    pub fn with_dir(mut self, folder: &Path) -> Result<Registry, TaskError> {
        let fail = |source| TaskError::Read { path: folder.to_owned(), source };
        let entries: Result<Vec<PathBuf>, std::io::Error> =
            std::fs::read_dir(folder).map_err(fail)?.map(|entry| entry.map(|e| e.path())).collect();
        let mut files = entries.map_err(fail)?;
        files.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
        files.sort();
        for file in files {
            let text = std::fs::read_to_string(&file);
            let text = text.map_err(|source| TaskError::Read { path: file.clone(), source })?;
            self.add(Task::parse(&text, &file)?, &text, &file)?;
        }
        Ok(self)
    }

    /// The same tasks with something else to carry the hand.
    #[must_use]
    pub fn with_plant(self, plant: Plant) -> Registry {
        let tasks = self.tasks.into_iter().map(|(name, task)| (name, task.with_plant(plant))).collect();
        Registry { tasks, ..self }
    }

    fn add(&mut self, task: Task, text: &str, file: &Path) -> Result<(), TaskError> {
        let name = task.name().to_owned();
        if self.tasks.contains_key(&name) {
            return Err(TaskError::DuplicateTask { file: file.to_owned(), name });
        }
        let meshes = task.meshes().iter().map(|(file, hash)| format!("# mesh {file} {hash}\n"));
        self.texts.insert(name.clone(), text.to_owned() + &meshes.collect::<String>());
        self.tasks.insert(name, task);
        Ok(())
    }

    /// The names of the tasks, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.tasks.keys().map(String::as_str)
    }

    /// The tasks, in the order of their names.
    pub fn tasks(&self) -> impl Iterator<Item = &Task> {
        self.tasks.values()
    }

    /// The text of the file that the task of this name was read from; `None` where there is no such task. Where the
    /// task uses meshes, a line of comment follows for each of their files, with its SHA-256: so two tasks of the same
    /// text are the same task.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.texts.get(name).map(String::as_str)
    }

    /// The task of this name.
    ///
    /// # Errors
    /// [`TaskError::UnknownTask`], which lists the known names.
    pub fn get(&self, name: &str) -> Result<&Task, TaskError> {
        self.tasks.get(name).ok_or_else(|| TaskError::UnknownTask {
            name: shown(name),
            known: self.names().collect::<Vec<_>>().join(", "),
        })
    }
}
