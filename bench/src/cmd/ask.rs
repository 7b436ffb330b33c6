//! `ask`: what a robot has to know of a task model that it executes.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;

use crate::asked::{answer, refused};
use crate::cmd::library::OwnMethods;
use crate::cmd::lines;
use crate::error::BenchError;
use crate::kept_model::KeptModel;

/// The end of the long help.
const QUESTIONS: &str = r#"A question is one JSON object; so is its answer.

  {"do": "next", "last": null, "state": [numbers]}
      what may follow the place that ran last (null: nothing ran yet), the
      likeliest first; "end" is the end of the task. Each probability is that
      of the place's own classifier, whether it can begin in this state: they
      do not add up to 1
  {"do": "keyframes", "place": "z1", "state": [numbers]}
      the reference object, and keyframes relative to it: position in metres,
      quaternion as w, x, y, z, gripper, seconds of hold. May be left out:
      "attempt" (how often the place has failed here: each asks for the next
      way), "execution" ("mean" or "sample") and "seed"
  {"do": "graph"}
      places with the segments that they hold, and edges

Where the demonstrations gave poses, "world" may stand in the place of "state",
as in a demonstration file; keyframes then come with "in_world", too. An "id" is
given back. A question that cannot be answered gets {"error": why}.

Examples:
  situ-bench ask tea.model.json '{"do": "graph"}'
  situ-bench ask tea.model.json '{"do": "next", "last": null, "state": [0.5, 0]}'
  robot | situ-bench ask tea.model.json      one question a line, as it runs"#;

/// Answers what a robot asks of a task model that `learn --out` wrote.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = QUESTIONS)]
pub struct Ask {
    /// The model.
    #[arg(value_name = "MODEL.json")]
    pub model: PathBuf,
    /// Questions. Without any, each line of standard input is one, answered at once.
    #[arg(value_name = "QUESTION")]
    pub questions: Vec<String>,
    /// Methods of one's own.
    #[command(flatten)]
    pub own: OwnMethods,
}

impl Ask {
    /// Answers the questions of the command line. All answers are printed, whether one of them is an error or not.
    fn asked(&self, kept: &KeptModel) -> Result<String, BenchError> {
        let answers: Vec<String> = self.questions.iter().map(|question| answer(kept, question)).collect();
        let text = answers.join("\n") + "\n";
        let is_error = |answer: &&String| {
            serde_json::from_str::<serde_json::Value>(answer).is_ok_and(|answer| answer.get("error").is_some())
        };
        let Some(error) = answers.iter().find(is_error) else { return Ok(text) };
        let written = io::stdout().lock().write_all(text.as_bytes());
        written.map_err(|source| BenchError::Write { path: PathBuf::from("standard output"), source })?;
        Err(BenchError::Argument(format!("a question has no answer: {error}")))
    }

    /// Answers, and prints each answer as it comes.
    ///
    /// # Errors
    /// As [`KeptModel::read`]; [`BenchError::Argument`] where a question of the command line has no answer;
    /// [`BenchError::Write`] for the standard output.
    pub fn run(&self) -> Result<String, BenchError> {
        let methods = self.own.known_alone()?;
        let kept = KeptModel::read(&self.model, &methods)?;
        if !self.questions.is_empty() {
            return self.asked(&kept);
        }
        lines::answered(None, |line| {
            let text = match line {
                Ok(line) => answer(&kept, line),
                Err(problem) => refused(problem),
            };
            (text, false)
        })
    }
}
