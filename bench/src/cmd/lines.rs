//! Lines on the standard input, each answered by one on the standard output.

use std::io::{self, BufRead, ErrorKind, Read, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::Duration;

use crate::error::BenchError;

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

/// Answers lines until there are no more, or an answer is the last. `answer` gets a line, or why it is none, and says
/// whether its answer is the last. Empty lines have no answer.
///
/// # Errors
/// A standard output that takes nothing more; [`BenchError::Stopped`] where the flag is set.
pub(super) fn answered(
    interrupted: Option<&AtomicBool>,
    mut answer: impl FnMut(Result<&str, &str>) -> (String, bool),
) -> Result<String, BenchError> {
    let (to, lines) = sync_channel(WAITING);
    thread::spawn(move || read(&to));
    loop {
        if interrupted.is_some_and(|flag| flag.load(Ordering::Relaxed)) {
            return Err(BenchError::Stopped);
        }
        let (text, is_last) = match lines.recv_timeout(LOOK) {
            Ok(Line::Text(line)) if line.trim().is_empty() => continue,
            Ok(Line::Text(line)) => answer(Ok(&line)),
            Ok(Line::Odd(problem)) => answer(Err(&problem)),
            Err(RecvTimeoutError::Timeout) => continue,
            Err(RecvTimeoutError::Disconnected) => return Ok(String::new()),
        };
        if !say(&text)? || is_last {
            return Ok(String::new());
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
fn say(answer: &str) -> Result<bool, BenchError> {
    let mut output = io::stdout().lock();
    match writeln!(output, "{answer}").and_then(|()| output.flush()) {
        Ok(()) => Ok(true),
        Err(source) if source.kind() == ErrorKind::BrokenPipe => Ok(false),
        Err(source) => Err(BenchError::Write { path: PathBuf::from("standard output"), source }),
    }
}
