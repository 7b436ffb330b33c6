//! `learn`: a task model from demonstration files alone, without physics.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use situ::demonstration::Kind;
use situ::edit::{self, Difference};
use situ::graph::Graph;
use situ::method::{Learned, Method};
use situ::trace::{Counters, Trace};
use situ_tasks::name::one_line;

use crate::cmd::library::OwnMethods;
use crate::demonstration_file::{DemonstrationFile, check_together};
use crate::error::BenchError;
use crate::files;
use crate::stop::Unheld;

/// The end of the long help: the file format in short.
const FORMAT: &str = r#"A demonstration is one JSON file:

  {"name": "tea-1",
   "kind": "original",              or "corrective"
   "schema": [                      the features of a state
     {"name": "cup_x", "scale": 0.2}, …],   scale: a difference that matters
   "after": null,                   what ran last: null is START; or the node
                                    that holds a segment of an earlier one:
                                    {"demonstration": "tea-1", "segment": 0}
   "carried_to_end": true,          whether the task was over at the end
   "keyframes": [{
     "reference": "cup",            the object that the keyframe is about
     "reference_pose": {"position": [x, y, z], "quaternion": [w, x, y, z]},
     "gripper_pose": {"position": [x, y, z], "quaternion": [w, x, y, z]},
     "gripper": 0.7,                opening from 0 to 1; or {"open": metres}
                                    or {"close": newtons}
     "hold": 0.5,                   seconds of rest; may be left out
     "state": [numbers]}, …],       the world before the motion to it
   "final_state": [numbers]}        the world after the last keyframe

Poses are in the world frame, in metres. Consecutive keyframes about one object
are a segment; of its reference poses the first counts. All files of one call
share one schema. Nothing is written where a file has a mistake.

Examples:
  situ-bench learn tea-1.json tea-2.json --dot tea.dot
  situ-bench learn tea-1.json tea-2.json --correct lid.json --trace lid.csv
  situ-bench learn tea-1.json --method rebuild --out tea.model.json"#;

/// Builds a task model from demonstration files alone, without physics.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = FORMAT)]
pub struct Learn {
    /// Original demonstrations: the task from its start.
    #[arg(required = true, value_name = "ORIGINAL.json")]
    pub originals: Vec<PathBuf>,
    /// Corrective demonstrations, folded in one after another.
    #[arg(long, value_name = "CORRECTION.json", num_args = 1..)]
    pub correct: Vec<PathBuf>,
    /// The method that keeps the task model up to date: see `situ-bench list methods`.
    #[arg(long, default_value = "situ")]
    pub method: String,
    /// Methods of one's own.
    #[command(flatten)]
    pub own: OwnMethods,
    /// Root seed of the method's random draws. Some methods draw Monte Carlo divergences; `situ` and `rebuild` draw
    /// nothing.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Writes the whole model here, as JSON.
    #[arg(long, value_name = "MODEL.json")]
    pub out: Option<PathBuf>,
    /// Writes the automaton here, for Graphviz: one node for each primitive, besides START and END.
    #[arg(long, value_name = "FILE")]
    pub dot: Option<PathBuf>,
    /// Writes the steps of each update here, one line for each.
    #[arg(long, value_name = "FILE.csv")]
    pub trace: Option<PathBuf>,
}

/// The effect of one correction.
#[derive(Clone, Debug, PartialEq)]
pub struct Corrected {
    /// The corrective demonstration's name.
    pub name: String,
    /// How the model changed.
    pub difference: Difference,
    /// The trace of the update.
    pub trace: Trace,
}

/// A model that was learned from files, and its corrections.
pub struct Learning {
    /// The model.
    pub learned: Box<dyn Learned>,
    /// Its structure.
    pub graph: Graph,
    /// The corrections in order.
    pub corrections: Vec<Corrected>,
}

/// Teaches a method the originals, then folds the corrections in.
///
/// # Errors
/// [`BenchError::Demonstration`] where the files do not go together; [`BenchError::Teach`]; [`BenchError::Learn`].
pub fn learn(
    method: &dyn Method,
    originals: &[DemonstrationFile],
    corrections: &[DemonstrationFile],
    seed: u64,
) -> Result<Learning, BenchError> {
    for (files, kind, word) in [(originals, Kind::Original, "original"), (corrections, Kind::Corrective, "corrective")]
    {
        if let Some(file) = files.iter().find(|file| file.demonstration.kind() != kind) {
            return Err(file
                .refuse("kind", format!("expected \"{word}\" here: corrections follow --correct, originals do not")));
        }
    }
    let files: Vec<DemonstrationFile> = originals.iter().chain(corrections).cloned().collect();
    let stops = check_together(&files)?;
    let Some(first) = originals.first() else {
        return Err(BenchError::Argument("no original demonstration: expected at least one".to_owned()));
    };
    let refuse = |file: &DemonstrationFile, source| BenchError::Learn { path: file.path().to_owned(), source };
    let demonstrations: Vec<_> = originals.iter().map(|file| file.demonstration.clone()).collect();
    let teach = |source| BenchError::Teach { path: first.path().to_owned(), source };
    let mut learned = method.teach(&first.schema, &demonstrations, seed).map_err(teach)?;
    let mut corrected = Vec::with_capacity(corrections.len());
    let mut before = learned.graph().map_err(teach)?;
    for (file, stop) in corrections.iter().zip(&stops[originals.len()..]) {
        let stop = stop.in_model(&before).map_err(|Unheld { key, .. }| {
            let problem = format!("`{}` keeps no node that holds this segment", method.name());
            file.refuse(&format!("{key}.segment"), problem)
        })?;
        let trace = learned.correct(stop.correction(&file.demonstration)).map_err(|source| refuse(file, source))?;
        let after = learned.graph().map_err(|source| refuse(file, source))?;
        let difference = edit::difference(&before, &after);
        corrected.push(Corrected { name: file.demonstration.name().to_string(), difference, trace });
        before = after;
    }
    Ok(Learning { learned, graph: before, corrections: corrected })
}

impl Learn {
    /// Learns, writes the files that were asked for, all or none, and returns the text that is to be printed.
    ///
    /// # Errors
    /// Where a name or a file is wrong: nothing is written then. [`BenchError::Write`].
    pub fn run(&self) -> Result<String, BenchError> {
        let methods = self.own.known_alone()?;
        let method = methods.named(&self.method)?;
        let read =
            |paths: &[PathBuf]| paths.iter().map(|path| DemonstrationFile::read(path)).collect::<Result<Vec<_>, _>>();
        let (originals, corrections) = (read(&self.originals)?, read(&self.correct)?);
        let lesson = learn(&*method, &originals, &corrections, self.seed)?;
        let name = originals[0].demonstration.name();
        let mut outputs = Vec::new();
        if let Some(path) = &self.out {
            outputs.push((path.clone(), self.model(&lesson)));
        }
        if let Some(path) = &self.dot {
            let dot = lesson.graph.to_dot(name);
            outputs.push((path.clone(), format!("// Made by `{}`.\n{dot}", self.command())));
        }
        if let Some(path) = &self.trace {
            outputs.push((path.clone(), trace_csv(&lesson.corrections)));
        }
        let inputs: Vec<&Path> = self.originals.iter().chain(&self.correct).map(PathBuf::as_path).collect();
        files::write_beside(&inputs, &outputs)?;
        Ok(report(&*method, &lesson))
    }

    /// The user's command, with every option.
    fn command(&self) -> String {
        let mut words = vec!["situ-bench learn".to_owned()];
        words.extend(self.originals.iter().map(|path| path.display().to_string()));
        words.extend(self.correct.iter().map(|path| format!("--correct {}", path.display())));
        words.extend(self.own.methods.iter().map(|path| format!("--methods {}", path.display())));
        words.push(format!("--method {} --seed {}", self.method, self.seed));
        // A path may hold anything but a zero; the command stands on one line, in comments.
        one_line(&words.join(" "))
    }

    fn model(&self, lesson: &Learning) -> String {
        let model = serde_json::json!({
            "made_by": self.command(),
            "method": self.method,
            "seed": self.seed,
            "model": lesson.learned.to_json(),
        });
        format!("{model:#}\n")
    }
}

fn report(method: &dyn Method, lesson: &Learning) -> String {
    let graph = &lesson.graph;
    let mut text = format!("method {}: {}\n", method.name(), method.summary());
    let _ = writeln!(text, "nodes {}", graph.nodes.len());
    for node in &graph.nodes {
        let _ = writeln!(text, "  {} on {}, segments {}", node.id, node.reference, node.segments.len());
    }
    let _ = writeln!(text, "edges {}", graph.edges.len());
    for (from, to) in &graph.edges {
        let _ = writeln!(text, "  {from} -> {to}");
    }
    for Corrected { name, difference, trace } in &lesson.corrections {
        let Difference { nodes_added, edges_added, nodes_modified, nodes_merged } = difference;
        let _ = writeln!(
            text,
            "correction {name}: {} (nodes added {}, edges added {}, nodes modified {}, nodes merged {nodes_merged})",
            difference.edit(),
            nodes_added.len(),
            edges_added.len(),
            nodes_modified.len(),
        );
        for step in &trace.steps {
            let _ = writeln!(
                text,
                "  segment on {}: |Z| {} of |T| {}, candidates {}, matched in {}, branch {}, {} after {}",
                step.reference,
                step.applicable.len(),
                step.model_size,
                step.candidates,
                word(&step.matched_in),
                word(&step.branch),
                step.node,
                step.after,
            );
        }
        let counters: Vec<String> =
            trace.counters.named().iter().map(|(name, value)| format!("{name} {value}")).collect();
        let _ = writeln!(text, "  {}", counters.join(", "));
    }
    text
}

/// The word by which files name a choice.
fn word(choice: &impl Serialize) -> String {
    serde_json::to_value(choice).ok().and_then(|value| Some(value.as_str()?.to_owned())).unwrap_or_default()
}

/// One line for each step, and one for the whole of each update: the work on END is in no step, and a full retraining
/// has no step.
fn trace_csv(corrections: &[Corrected]) -> String {
    const STEP: [&str; 12] = [
        "demonstration",
        "step",
        "reference",
        "applicable",
        "model_size",
        "candidates",
        "matched_in",
        "branch",
        "node",
        "after",
        "edge_added",
        "merged",
    ];
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut write = |row: Vec<String>, counters: &Counters| {
        let counters = counters.named().map(|(_, value)| value.to_string());
        writer.write_record(row.into_iter().chain(counters)).expect("rows of one length, in memory");
    };
    let names = Counters::default().named().map(|(name, _)| name);
    let mut head = csv::Writer::from_writer(Vec::new());
    head.write_record(STEP.iter().chain(&names)).expect("in memory");
    for Corrected { name, trace, .. } in corrections {
        for (index, step) in trace.steps.iter().enumerate() {
            let merged = step.merged.iter().map(|(old, new)| {
                let old: Vec<String> = old.iter().map(ToString::to_string).collect();
                format!("{} -> {new}", old.join(" "))
            });
            let row = vec![
                name.clone(),
                index.to_string(),
                step.reference.clone(),
                step.applicable.len().to_string(),
                step.model_size.to_string(),
                step.candidates.to_string(),
                word(&step.matched_in),
                word(&step.branch),
                step.node.to_string(),
                step.after.to_string(),
                step.edge_added.to_string(),
                merged.collect::<Vec<_>>().join("; "),
            ];
            write(row, &step.counters);
        }
        let mut row = vec![name.clone(), "all".to_owned()];
        row.resize(STEP.len(), String::new());
        write(row, &trace.counters);
    }
    let bytes = [head, writer].map(|part| part.into_inner().expect("in memory")).concat();
    String::from_utf8(bytes).expect("made of strings")
}
