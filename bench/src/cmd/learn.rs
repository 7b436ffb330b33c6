//! `learn`: a task model from demonstration files alone, without physics.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use situ::demonstration::Kind;
use situ::edit::Difference;
use situ::method::{Learned, Method};
use situ::trace::Counters;
use situ_tasks::name::one_line;

use crate::behaviour_tree;
use crate::cmd::library::OwnMethods;
use crate::demonstration_file::DemonstrationFile;
use crate::diagnosis::Diagnosis;
use crate::earlier::Earlier;
use crate::error::BenchError;
use crate::files;
use crate::kept_model::{Corrected, KeptModel};
use crate::stop::StopPoint;

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

With "version": 2 a file may leave out schema, state, final_state and
reference_pose. Each keyframe then gives the poses of all objects, and the
states follow from them:

  "world": {"objects": {"cup": {"position": …, "quaternion": …}, …},
            "hand": {"position": …, "quaternion": …},
            "opening": metres}     before the motion to the keyframe
  "final_world": the same          after the last keyframe
  "objects": [names]              all objects of the task, where one may be absent

"half_turn": "z" in either version says that half a turn of the hand about this
axis of its own is the same grasp.

All keys: `cargo doc --open`, situ_bench::demonstration_file.

Examples:
  situ-bench learn tea-1.json tea-2.json --dot tea.dot
  situ-bench learn tea-1.json tea-2.json --correct lid.json --trace lid.csv
  situ-bench learn tea-1.json tea-2.json --out tea.model.json
  situ-bench learn --model tea.model.json --correct lid.json --out tea.model.json
  situ-bench learn tea-1.json --method rebuild --tree tea.xml"#;

/// Builds a task model from demonstration files alone, without physics.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = FORMAT)]
pub struct Learn {
    /// Original demonstrations: the task from its start.
    #[arg(required_unless_present = "model", value_name = "ORIGINAL.json")]
    pub originals: Vec<PathBuf>,
    /// A model that `--out` wrote, in the place of originals: the corrections go on from there. `--out` may name the
    /// same file.
    #[arg(long, value_name = "MODEL.json", conflicts_with_all = ["originals", "method", "seed"])]
    pub model: Option<PathBuf>,
    /// Corrective demonstrations, folded in one after another.
    #[arg(long, value_name = "CORRECTION.json", num_args = 1..)]
    pub correct: Vec<PathBuf>,
    /// The method that keeps the task model up to date: see `situ-bench list methods`. `situ` where it is not given.
    #[arg(long)]
    pub method: Option<String>,
    /// Methods of one's own.
    #[command(flatten)]
    pub own: OwnMethods,
    /// Root seed of the method's random draws. Some methods draw Monte Carlo divergences; `situ` and `rebuild` draw
    /// nothing. 0 where it is not given.
    #[arg(long)]
    pub seed: Option<u64>,
    /// Writes the whole model here, as JSON: for --model, and for `situ-bench ask`.
    #[arg(long, value_name = "MODEL.json")]
    pub out: Option<PathBuf>,
    /// Writes the automaton here, for Graphviz: one node for each primitive, besides START and END.
    #[arg(long, value_name = "FILE")]
    pub dot: Option<PathBuf>,
    /// Writes the automaton here as a behaviour tree, in the XML of BehaviorTree.CPP 4.
    #[arg(long, value_name = "FILE.xml")]
    pub tree: Option<PathBuf>,
    /// Leaves out what the originals say about the teacher: for that, a model is learned without each of them.
    #[arg(long)]
    pub without_diagnosis: bool,
    /// Writes the steps of each update here, one line for each.
    #[arg(long, value_name = "FILE.csv")]
    pub trace: Option<PathBuf>,
}

/// A model that was learned from files, and its corrections.
pub struct Learning {
    /// The model.
    pub kept: KeptModel,
    /// The corrections in order.
    pub corrections: Vec<Corrected>,
    /// The model before them, where it was taught here.
    pub taught: Option<Box<dyn Learned>>,
}

/// Teaches a method the originals, then folds the corrections in. All files are checked before anything is learned.
///
/// # Errors
/// [`BenchError::Demonstration`] where the files do not go together; [`BenchError::Teach`]; [`BenchError::Learn`].
pub fn learn(
    method: Box<dyn Method>,
    originals: &[DemonstrationFile],
    corrections: &[DemonstrationFile],
    seed: u64,
) -> Result<Learning, BenchError> {
    originals.iter().try_for_each(|file| file.check_kind(Kind::Original))?;
    corrections.iter().try_for_each(|file| file.check_kind(Kind::Corrective))?;
    let mut earlier = Earlier::default();
    for file in originals {
        earlier.stop(file)?;
    }
    let stops = corrections.iter().map(|file| earlier.stop(file)).collect::<Result<Vec<_>, _>>()?;
    let kept = KeptModel::teach(method, originals, seed)?;
    let taught = Some(kept.learned.boxed());
    Ok(Learning { taught, ..correct(kept, corrections, &stops)? })
}

fn correct(mut kept: KeptModel, files: &[DemonstrationFile], stops: &[StopPoint]) -> Result<Learning, BenchError> {
    let corrections = files.iter().zip(stops).map(|(file, stop)| kept.correct(file, stop)).collect::<Result<_, _>>()?;
    Ok(Learning { kept, corrections, taught: None })
}

impl Learn {
    /// Learns, writes the files that were asked for, all or none, and returns the text that is to be printed.
    ///
    /// # Errors
    /// Where a name or a file is wrong: nothing is written then. [`BenchError::Write`].
    pub fn run(&self) -> Result<String, BenchError> {
        let methods = self.own.known_alone()?;
        let read =
            |paths: &[PathBuf]| paths.iter().map(|path| DemonstrationFile::read(path)).collect::<Result<Vec<_>, _>>();
        let (originals, corrections) = (read(&self.originals)?, read(&self.correct)?);
        let lesson = match &self.model {
            Some(path) => {
                corrections.iter().try_for_each(|file| file.check_kind(Kind::Corrective))?;
                let kept = KeptModel::read(path, &methods)?;
                let mut earlier = kept.earlier(path);
                let stops = corrections.iter().map(|file| earlier.stop(file)).collect::<Result<Vec<_>, _>>()?;
                correct(kept, &corrections, &stops)?
            }
            None => learn(methods.named(self.method())?, &originals, &corrections, self.seed.unwrap_or_default())?,
        };
        let outputs = self.outputs(&lesson);
        let inputs: Vec<&Path> = self.originals.iter().chain(&self.correct).map(PathBuf::as_path).collect();
        // A model may take the place of the one that was read.
        let model = self.model.iter().filter(|model| self.out.as_ref() != Some(model)).map(PathBuf::as_path);
        let inputs: Vec<&Path> = inputs.into_iter().chain(model).collect();
        files::write_beside(&inputs, &outputs)?;
        let mut text = read_line(&originals, &corrections);
        text.push_str(&report(&lesson));
        if let Some(taught) = lesson.taught.as_deref().filter(|_| !self.without_diagnosis) {
            let diagnosis = Diagnosis::of(&*lesson.kept.method, &originals, taught, lesson.kept.seed);
            let path = self.originals.first().cloned().unwrap_or_default();
            text.push_str(&diagnosis.map_err(|source| BenchError::Teach { path, source })?.text());
        }
        Ok(text)
    }

    /// The method of a model that is taught.
    fn method(&self) -> &str {
        self.method.as_deref().unwrap_or("situ")
    }

    /// The files that were asked for, with their content.
    fn outputs(&self, lesson: &Learning) -> Vec<(PathBuf, String)> {
        let mut outputs = Vec::new();
        let (kept, command) = (&lesson.kept, self.command());
        if let Some(path) = &self.out {
            outputs.push((path.clone(), kept.render()));
        }
        if let Some(path) = &self.dot {
            let name = kept.seen.first().map_or("", |seen| seen.name.as_str());
            outputs.push((path.clone(), format!("// Made by `{command}`.\n{}", kept.graph.to_dot(name))));
        }
        if let Some(path) = &self.tree {
            outputs.push((path.clone(), behaviour_tree::to_xml(&kept.graph, &format!("Made by `{command}`."))));
        }
        if let Some(path) = &self.trace {
            outputs.push((path.clone(), trace_csv(&lesson.corrections)));
        }
        outputs
    }

    /// The user's command, with every option.
    fn command(&self) -> String {
        let mut words = vec!["situ-bench learn".to_owned()];
        words.extend(self.originals.iter().map(|path| path.display().to_string()));
        words.extend(self.model.iter().map(|path| format!("--model {}", path.display())));
        words.extend(self.correct.iter().map(|path| format!("--correct {}", path.display())));
        words.extend(self.own.methods.iter().map(|path| format!("--methods {}", path.display())));
        if self.model.is_none() {
            words.push(format!("--method {} --seed {}", self.method(), self.seed.unwrap_or_default()));
        }
        // A path may hold anything but a zero; the command stands on one line, in comments.
        one_line(&words.join(" "))
    }
}

/// What was read, and in which version of the format.
fn read_line(originals: &[DemonstrationFile], corrections: &[DemonstrationFile]) -> String {
    let versions: BTreeSet<u32> = originals.iter().chain(corrections).map(|file| file.version).collect();
    let versions: Vec<String> = versions.iter().map(u32::to_string).collect();
    let format = match versions.is_empty() {
        true => String::new(),
        false => format!(", format version {}", versions.join(" and ")),
    };
    format!("read {} originals, {} corrections{format}\n", originals.len(), corrections.len())
}

fn report(lesson: &Learning) -> String {
    let (graph, method) = (&lesson.kept.graph, &lesson.kept.method);
    let mut text = format!("method {}: {}\n", method.name(), method.summary());
    let _ = writeln!(text, "nodes {}", graph.nodes.len());
    for node in &graph.nodes {
        let _ = writeln!(text, "  {} on {}, segments {}", node.id, node.reference, node.segments.len());
    }
    let _ = writeln!(text, "edges {}", graph.edges.len());
    for (from, to) in &graph.edges {
        let _ = writeln!(text, "  {from} -> {to}");
    }
    for Corrected { name, difference, trace, begins_again } in &lesson.corrections {
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
                "  segment on {}: {} of {} primitives applicable, {} candidates,\n    matched in {}, branch {}, {} after {}",
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
        let _ = writeln!(text, "  {}", wrapped(&counters));
        if let Some(node) = begins_again {
            let _ = writeln!(
                text,
                "  careful: in the state in which it ends, the model would do {node} again, with which it began;\n    \
                 carry it on to where it goes back to what was known, or to the end of the task"
            );
        }
    }
    text
}

/// Words with commas, in lines that fit a terminal.
fn wrapped(words: &[String]) -> String {
    const WIDEST: usize = 96;
    let (mut text, mut width) = (String::new(), 2);
    for (index, word) in words.iter().enumerate() {
        let word = if index + 1 < words.len() { format!("{word},") } else { word.clone() };
        if index > 0 && width + 1 + word.len() > WIDEST {
            text.push_str("\n    ");
            width = 4;
        } else if index > 0 {
            text.push(' ');
            width += 1;
        }
        width += word.len();
        text.push_str(&word);
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
