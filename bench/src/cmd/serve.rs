//! `serve`: an episode for one's own loop, line by line.

use std::io::{self, BufRead, ErrorKind, Read, Write};
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::Duration;

use clap::Args;

use crate::cmd::library::Library;
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

/// The longest line, bytes: a snapshot of the longest episode is far below.
const LONGEST: u64 = 16 << 20;
/// How often whoever waits for a line looks whether the user wants to stop.
const LOOK: Duration = Duration::from_millis(100);

/// The lines that may wait to be answered; whoever writes more waits.
const WAITING: usize = 16;

/// A line of the input.
enum Line {
    Text(String),
    /// It is none that can be read; why.
    Odd(String),
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
        let (to, lines) = sync_channel(WAITING);
        thread::spawn(move || read(&to));
        loop {
            if interrupted.load(Ordering::Relaxed) {
                return Err(BenchError::Stopped);
            }
            let reply = match lines.recv_timeout(LOOK) {
                Ok(Line::Text(line)) if line.trim().is_empty() => continue,
                Ok(Line::Text(line)) => service.answer(&line),
                Ok(Line::Odd(problem)) => Service::refuse(&problem),
                Err(RecvTimeoutError::Timeout) => continue,
                Err(RecvTimeoutError::Disconnected) => return Ok(String::new()),
            };
            if !say(&reply)? || reply.is_last {
                return Ok(String::new());
            }
        }
    }
}

/// Reads the standard input to its end.
fn read(to: &SyncSender<Line>) {
    let mut input = io::stdin().lock();
    loop {
        let mut line = Vec::new();
        let read = input.by_ref().take(LONGEST).read_until(b'\n', &mut line);
        let line = match read {
            Ok(0) | Err(_) => break,
            Ok(_) if line.last() != Some(&b'\n') && line.len() as u64 == LONGEST => {
                if skip(&mut input).is_err() {
                    break;
                }
                Line::Odd(format!("expected a line of at most {LONGEST} bytes"))
            }
            Ok(_) => String::from_utf8(line).map_or_else(|_| Line::Odd("expected UTF-8".to_owned()), Line::Text),
        };
        if to.send(line).is_err() {
            break;
        }
    }
}

/// Passes over the rest of a line.
fn skip(input: &mut impl BufRead) -> io::Result<()> {
    loop {
        let buffer = input.fill_buf()?;
        let end = buffer.iter().position(|byte| *byte == b'\n');
        let length = end.map_or(buffer.len(), |end| end + 1);
        input.consume(length);
        if end.is_some() || length == 0 {
            return Ok(());
        }
    }
}

/// Writes an answer. Returns whether anybody reads it.
fn say(reply: &Reply) -> Result<bool, BenchError> {
    let mut output = io::stdout().lock();
    match writeln!(output, "{}", reply.line).and_then(|()| output.flush()) {
        Ok(()) => Ok(true),
        Err(source) if source.kind() == ErrorKind::BrokenPipe => Ok(false),
        Err(source) => Err(BenchError::Write { path: PathBuf::from("standard output"), source }),
    }
}
