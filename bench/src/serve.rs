//! An episode for one's own loop: one JSON object a line is a request, one a line is the answer. `bench/docs/serve.md`
//! ([`crate::serve_page`]) is the page about it.
//!
//! Starts are those of `show`, keyframes are gone to as in rollouts, and teachers are those of the benchmark. Whatever
//! a line holds, it is answered; where it cannot be done, the answer says what could be, and the episode is as it was.

mod deed;
mod request;
mod seen;
mod served;
mod shelf;
mod token;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use situ_sim::MAX_OPENING;
use situ_tasks::name::shown;
use situ_tasks::{Registry, Setting, Task};
use situ_teachers::{Roster, Teacher};

use crate::digest::hash;
use crate::ended::Ended;
use crate::error::BenchError;
use crate::files;
use crate::program::SOURCES;
use deed::Deed;
use request::{Beginning, Picture, PictureFormat, Request};
use served::{MOST_KEYFRAMES, Served};
use shelf::Shelf;
use token::Token;

/// The version of the requests and answers.
pub const PROTOCOL: u64 = 1;
/// The teacher of an episode that names no other.
const TEACHER: &str = "expert";
/// The box in which the tasks happen and the hand can be, metres, world frame: least and greatest x, y and z of the
/// point between the finger tips.
const REACH: [[f64; 3]; 2] = [[-0.5, -0.5, 0.0], [0.5, 0.5, 0.5]];
/// The widths and heights that a picture may have, pixels.
const PIXELS: std::ops::RangeInclusive<u32> = 16..=1920;

/// Answers requests about one episode after the other.
pub struct Service {
    registry: Registry,
    roster: Roster,
    plant: &'static str,
    /// Whether a picture may be written to a file.
    writes: bool,
    served: Option<Served>,
    shelf: Shelf,
}

/// The answer to a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Reply {
    /// One JSON object, without a line feed.
    pub line: String,
    /// Whether it was the last request.
    pub is_last: bool,
}

impl Service {
    /// A service of these tasks and teachers, without an episode. `plant` is the name of what carries the hand in the
    /// tasks.
    pub fn new(registry: Registry, roster: Roster, plant: &'static str) -> Self {
        Self { registry, roster, plant, writes: true, served: None, shelf: Shelf::default() }
    }

    /// The same that writes no file, whatever it is asked.
    #[must_use]
    pub fn without_files(self) -> Self {
        Self { writes: false, ..self }
    }

    /// Answers a line. The answer has the `id` of the request, `null` where it has none, and the key `error` where the
    /// request could not be done.
    pub fn answer(&mut self, line: &str) -> Reply {
        let (id, request) = request::read(line);
        let is_last = matches!(request, Ok(Request::Bye));
        let answer = request.and_then(|request| {
            // A fault of ours must not end somebody's work. What it left behind is not to be trusted.
            catch_unwind(AssertUnwindSafe(|| self.done(request))).unwrap_or_else(|_| {
                self.served = None;
                Err("a fault of the program, which said why on its standard error: expected `reset`".to_owned())
            })
        });
        let mut keys = answer.unwrap_or_else(|problem| json!({"error": shown(&problem)}));
        keys["id"] = id;
        Reply { line: keys.to_string(), is_last }
    }

    /// The answer where a line is none that can be read.
    pub fn refuse(problem: &str) -> Reply {
        Reply { line: json!({"id": null, "error": shown(problem)}).to_string(), is_last: false }
    }

    fn done(&mut self, request: Request) -> Result<Value, String> {
        match request {
            Request::Hello(greeting) => self.hello(greeting.protocol),
            Request::Tasks => Ok(self.tasks()),
            Request::Reset(beginning) => self.reset(&beginning),
            Request::Observe => Ok(seen::observation(self.served()?)),
            Request::Move(target) => {
                let deed = self.served()?.deed(target)?;
                self.go(deed)
            }
            Request::Gripper(command) => {
                let deed = self.served()?.grip(command.gripper.0, command.hold)?;
                self.go(deed)
            }
            Request::Snapshot => {
                let text = token::write(self.served()?);
                self.shelf.keep(&text, self.served.as_ref().ok_or(NOTHING)?);
                Ok(json!({"snapshot": text}))
            }
            Request::Restore(kept) => self.restore(&kept.snapshot),
            Request::IsSolved => Ok(json!({"solved": self.served()?.episode.succeeded()})),
            Request::Demonstrate(own) => self.served()?.demonstrate(own.attempt).map_err(told),
            Request::Correct(own) => self.served()?.correct(own.attempt).map_err(told),
            Request::Watch(look) => {
                let served = self.served()?;
                served.check_reference(&look.reference)?;
                Ok(json!({"stop": served.stop(&look)}))
            }
            Request::Picture(picture) => self.picture(&picture),
            Request::Bye => Ok(json!({})),
        }
    }

    fn served(&self) -> Result<&Served, String> {
        self.served.as_ref().ok_or_else(|| NOTHING.to_owned())
    }

    fn hello(&self, protocol: Option<u64>) -> Result<Value, String> {
        if let Some(other) = protocol.filter(|protocol| *protocol != PROTOCOL) {
            return Err(format!("protocol {other}: this program speaks {PROTOCOL}"));
        }
        Ok(json!({
            "protocol": PROTOCOL,
            "program": "situ-bench",
            "version": env!("CARGO_PKG_VERSION"),
            "sources": SOURCES,
            "benchmark": self.benchmark(),
            "plant": self.plant,
        }))
    }

    /// A hash of what episodes are made of: what carries the hand, and the files of tasks and teachers.
    fn benchmark(&self) -> String {
        let tasks = self.registry.names().map(|name| (name, self.registry.text(name)));
        let profiles = self.roster.profiles().iter().map(|profile| profile.name.as_str());
        let teachers = profiles.map(|name| (name, self.roster.text(name)));
        let line = |(name, text): (&str, Option<&str>)| format!("{name} {}\n", hash(text.unwrap_or_default()));
        hash(format!("plant {}\n", self.plant) + &tasks.chain(teachers).map(line).collect::<String>())
    }

    fn tasks(&self) -> Value {
        let variation = |setting: &Setting| {
            let edit = setting.edit.word();
            json!({"variation": setting.variation, "edit": edit, "analysis": setting.analysis.trim()})
        };
        let task = |task: &Task| {
            let changed = task.settings().filter(|setting| setting.variation.is_some());
            let seconds = task.settings().next().map(|setting| setting.time_limit);
            let features = task.schema().features.iter().map(|feature| (feature.name.as_str(), feature.scale));
            json!({
                "task": task.name(),
                "analysis": task.analysis(),
                "variations": changed.map(|setting| variation(setting)).collect::<Value>(),
                "features": seen::features(features),
                "limit": {"seconds": seconds, "keyframes": MOST_KEYFRAMES},
            })
        };
        let teachers: Vec<&str> = self.roster.profiles().iter().map(|profile| profile.name.as_str()).collect();
        json!({
            "tasks": self.registry.tasks().map(task).collect::<Value>(),
            "teachers": teachers,
            "reach": {"low": REACH[0], "high": REACH[1]},
            "stroke": MAX_OPENING,
        })
    }

    fn begun(&mut self, beginning: &Beginning) -> Result<Served, BenchError> {
        let Beginning { task, variation, seed, teacher } = beginning;
        let setting = self.registry.get(task)?.variation(variation.as_deref())?;
        let profile = self.roster.get(teacher.as_deref().unwrap_or(TEACHER))?;
        let teacher = Teacher::new(profile.clone());
        Served::begin(self.shelf.start(&setting, *seed)?, teacher, *seed)
    }

    fn reset(&mut self, beginning: &Beginning) -> Result<Value, String> {
        let served = self.begun(beginning).map_err(told)?;
        Ok(seen::observation(self.served.insert(served)))
    }

    fn go(&mut self, deed: Deed) -> Result<Value, String> {
        let served = self.served.as_mut().ok_or(NOTHING)?;
        let about = json!(deed.about);
        let (end, force) = match served.go(deed)? {
            Ok(None) => ("reached".to_owned(), None),
            Ok(Some(force)) => ("guarded".to_owned(), Some(force)),
            Err(reason) => (reason.to_string(), None),
        };
        let abort = [Ended::Aborted, Ended::OutOfReach, Ended::NoPlan].into_iter().map(|reason| reason.to_string());
        Ok(json!({
            "reached": end == "reached",
            "aborted": abort.into_iter().any(|reason| reason == end),
            "end": end,
            "force": force,
            "about": about,
            "observation": seen::observation(served),
        }))
    }

    fn restore(&mut self, text: &str) -> Result<Value, String> {
        let found = self.shelf.find(text).cloned();
        let served = match found {
            Some(served) => served,
            None => self.simulated(text)?,
        };
        Ok(seen::observation(self.served.insert(served)))
    }

    /// The episode of a snapshot of another process: all of it once more.
    fn simulated(&mut self, text: &str) -> Result<Served, String> {
        let token = Token::read(text)?;
        let (task, variation) = (token.task.clone(), token.variation.clone());
        let beginning = Beginning { task, variation, seed: token.seed, teacher: Some(token.teacher.clone()) };
        let mut served = self.begun(&beginning).map_err(told)?;
        for (index, deed) in token.deeds.iter().enumerate() {
            // One that ended in an abort did so then, too.
            let _ = served.go(deed.clone()).map_err(|problem| format!("keyframes[{index}]: {problem}"))?;
        }
        token.check(&served)?;
        self.shelf.keep(text, &served);
        Ok(served)
    }

    fn picture(&self, picture: &Picture) -> Result<Value, String> {
        let served = self.served()?;
        let Picture { width, height, format, path } = picture;
        for (key, value) in [("width", width), ("height", height)] {
            if !PIXELS.contains(value) {
                let (least, most) = PIXELS.into_inner();
                return Err(format!("key `{key}`: {value} pixels, expected {least} to {most}"));
            }
        }
        if path.is_some() && !self.writes {
            return Err("key `path`: this service writes no file, expected no such key".to_owned());
        }
        let image = served.picture([*width, *height]);
        let (word, bytes) = match format {
            PictureFormat::Png => ("png", image.png().map_err(|error| error.to_string())?),
            PictureFormat::Rgb => ("rgb", image.rgb),
        };
        let Some(path) = path else {
            return Ok(json!({"width": width, "height": height, word: STANDARD.encode(&bytes)}));
        };
        files::write_all(&[(PathBuf::from(path), bytes)]).map_err(told)?;
        Ok(json!({"width": width, "height": height, "path": path}))
    }
}

/// What is said where there is no episode.
const NOTHING: &str = "there is no episode yet: expected `reset` or `restore` first";

fn told(error: BenchError) -> String {
    error.to_string()
}
