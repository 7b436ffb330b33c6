//! `serve`: an episode for one's own loop, line by line.

use clap::Args;

use crate::cmd::library::Library;
use crate::cmd::lines;
use crate::cmd::terminal;
use crate::error::BenchError;
use crate::serve::{Reply, Service};

/// Offers an episode over JSON Lines: one request a line on the standard input, one answer a line on the standard
/// output.
#[derive(Args, Clone, Debug)]
#[command(
    after_long_help = "A request has the key `do` and may have an `id`, which the answer has too. An answer with \
        the key `error` says what would be right, and the episode is as it was. The requests:

  hello        protocol and versions
  tasks        families, variations, the edits they need, features, limits, teachers, and the box that is reached
  reset        task, variation (or none), seed, teacher (expert where it is left out): begins as `show` does
  observe      state, raw and scaled; poses of the objects and the hand; opening; what is solved and what is over
  move         position, quaternion_wxyz, and perhaps gripper, hold and about: a keyframe, world frame
  gripper      gripper, and perhaps hold: a command where the hand is
  snapshot     the episode as a text, which any process of the same program restores, bit for bit
  restore      snapshot
  is_solved    whether the goal holds
  demonstrate  the teacher's demonstration from the start of the episode; attempt
  correct      the teacher's correction from here; attempt
  watch        reference and moment (before, guard or after): whether a watching teacher would stop the robot
  picture      width, height, format (png or rgb), path: where no path is given, the answer holds it in base 64
  bye          ends the program, as the end of its input does

Metres, radians, newtons and seconds; world frame with z up; quaternions in the order w, x, y, z. A gripper's command \
        is an opening from 0 (closed) to 1 (open), {\"open\": metres} or {\"close\": newtons}. All keys: \
        bench/docs/serve.md. In Python: situ_bench.Env.

Example:
  printf '%s\\n' '{\"do\": \"reset\", \"task\": \"pour\", \"seed\": 1}' '{\"do\": \"is_solved\"}' | situ-bench serve"
)]
pub struct Serve {
    /// Tasks and teachers of one's own.
    #[command(flatten)]
    pub library: Library,
}

impl Serve {
    /// Answers requests until there are no more.
    ///
    /// # Errors
    /// A folder or file of tasks or teachers that cannot be read, or a mistake in one; a standard output that takes
    /// nothing more; [`BenchError::Stopped`].
    pub fn run(&self) -> Result<String, BenchError> {
        let (registry, roster) = (self.library.registry()?, self.library.roster()?);
        let interrupted = terminal::interrupt_flag(BenchError::Stopped, || ());
        let mut service = Service::new(registry, roster, self.library.plant.name());
        lines::answered(Some(&*interrupted), |line| match line {
            Ok(line) => {
                let Reply { line, is_last } = service.answer(line);
                (line, is_last)
            }
            Err(problem) => (Service::refuse(problem).line, false),
        })
    }
}
