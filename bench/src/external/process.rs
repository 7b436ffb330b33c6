//! One process of an external method: asked line by line, given up where it is too late, and never left running.
//!
//! Here alone a clock decides a record: a limit of time that is passed breaks the run off, as the methods' file says.

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Map, Value};
use situ_tasks::name::{one_line, shown};

use super::answers::fields;
use super::file::Described;
use super::interrupt::Interrupt;
use super::log::{Log, Tail};

/// The longest answer, bytes.
const LONGEST: u64 = 256 << 20;
/// How often somebody who waits looks up.
const LOOK: Duration = Duration::from_millis(50);
/// How long a process may take to end by itself when its input ends.
const GRACE: Duration = Duration::from_millis(500);
/// Letters of an answer that stand in a message.
const QUOTED: usize = 200;

/// Why a question has no answer.
#[derive(Debug)]
pub(super) enum Fault {
    /// The method refuses, for this reason; its model is as it was.
    Refused(String),
    /// The process crashed, was too late, or answered what is no answer. It is of no use any more.
    Broken(String),
}

/// The processes that run, so that whoever ends the program in haste can end them, too.
static RUNNING: Mutex<BTreeSet<u32>> = Mutex::new(BTreeSet::new());

fn running() -> std::sync::MutexGuard<'static, BTreeSet<u32>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends every process of every external method.
pub fn end_all() {
    running().iter().for_each(|id| end(*id));
}

/// Ends a process and all that it has started.
#[cfg(unix)]
fn end(id: u32) {
    use rustix::process::{Pid, Signal, kill_process_group};
    if let Some(group) = i32::try_from(id).ok().and_then(Pid::from_raw) {
        let _ = kill_process_group(group, Signal::KILL);
    }
}

#[cfg(not(unix))]
fn end(_: u32) {}

/// A running process.
pub(super) struct Process {
    child: Child,
    /// Lines to its standard input. A thread writes them: a process that does not read must not keep us.
    to: Option<Sender<String>>,
    /// Lines of its standard output, or why there are no more.
    from: Receiver<Result<String, String>>,
    tail: Arc<Tail>,
    asked: u64,
}

impl Process {
    /// Starts the program of a method.
    ///
    /// # Errors
    /// Where it cannot be started: why.
    pub(super) fn start(described: &Described, log: &Arc<Log>) -> Result<Self, String> {
        let Described { command, env, folder, .. } = described;
        let [program, arguments @ ..] = &command[..] else { return Err("no command".to_owned()) };
        let mut command = Command::new(program);
        command.args(arguments).envs(env).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        if !folder.as_os_str().is_empty() {
            command.current_dir(folder);
        }
        // A group of its own: the user's interrupt is ours to hear, and what it starts ends with it.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn().map_err(|error| format!("`{}` cannot be started: {error}", shown(program)))?;
        running().insert(child.id());
        let (mut input, output, errors) =
            (child.stdin.take().expect("piped"), child.stdout.take().expect("piped"), child.stderr.take());
        let (to, lines) = channel::<String>();
        thread::spawn(move || {
            for line in lines {
                if input.write_all(line.as_bytes()).and_then(|()| input.flush()).is_err() {
                    break;
                }
            }
        });
        let (answers, from) = channel();
        thread::spawn(move || {
            let mut output = BufReader::new(output);
            loop {
                let line = read_line(&mut output);
                let is_last = line.is_err();
                if answers.send(line).is_err() || is_last {
                    break;
                }
            }
        });
        let tail = Arc::new(Tail::default());
        let (last, log) = (Arc::clone(&tail), Arc::clone(log));
        thread::spawn(move || {
            let Some(errors) = errors else { return };
            for line in BufReader::new(errors).split(b'\n').map_while(Result::ok) {
                let line = String::from_utf8_lossy(&line);
                last.push(&line);
                log.line(line.trim_end());
            }
            last.end();
        });
        Ok(Self { child, to: Some(to), from, tail, asked: 0 })
    }

    /// Asks one question, which has the key `do`, and returns the answer.
    ///
    /// # Errors
    /// [`Fault`].
    pub(super) fn ask(
        &mut self,
        question: &Map<String, Value>,
        limit: Duration,
        interrupt: &Interrupt,
    ) -> Result<Map<String, Value>, Fault> {
        self.asked += 1;
        let what = question.get("do").and_then(Value::as_str).unwrap_or_default().to_owned();
        let mut question = question.clone();
        question.insert("id".to_owned(), self.asked.into());
        let line = Value::Object(question).to_string() + "\n";
        // Where the process has ended, there is no answer either, and that is told below.
        self.to.as_ref().map(|to| to.send(line));
        let answer = self.wait(limit, interrupt).map_err(|problem| self.broken(&what, &problem))?;
        let fields = fields(&answer, self.asked).map_err(|problem| {
            let answer: String = one_line(&answer).chars().take(QUOTED).collect();
            self.broken(&what, &format!("{problem}, found `{answer}`"))
        })?;
        match fields.get("error") {
            Some(Value::String(why)) => Err(Fault::Refused(shown(why))),
            _ => Ok(fields),
        }
    }

    fn wait(&self, limit: Duration, interrupt: &Interrupt) -> Result<String, String> {
        let asked = Instant::now();
        loop {
            let left = limit.saturating_sub(asked.elapsed());
            match self.from.recv_timeout(left.min(LOOK)) {
                Ok(line) => {
                    if line.is_err() {
                        self.hear_out();
                    }
                    return line;
                }
                Err(RecvTimeoutError::Disconnected) => return Err("its output has ended".to_owned()),
                Err(RecvTimeoutError::Timeout) if interrupt.is_set() => return Err("interrupted".to_owned()),
                Err(RecvTimeoutError::Timeout) if left.is_zero() => {
                    return Err(format!("no answer within {} s", limit.as_secs_f64()));
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    }

    /// Waits for the last words of a process whose answers have ended.
    fn hear_out(&self) {
        let begun = Instant::now();
        while begun.elapsed() < GRACE && !self.tail.has_ended() {
            thread::sleep(Duration::from_millis(2));
        }
    }

    fn broken(&self, what: &str, problem: &str) -> Fault {
        Fault::Broken(format!("asked `{what}`: {problem}{}", self.tail.words()))
    }
}

/// One line of an answer.
fn read_line(output: &mut impl BufRead) -> Result<String, String> {
    let mut line = Vec::new();
    match output.by_ref().take(LONGEST).read_until(b'\n', &mut line) {
        Ok(0) => Err("it has ended".to_owned()),
        Ok(_) if line.last() != Some(&b'\n') && line.len() as u64 == LONGEST => {
            Err(format!("expected an answer of at most {LONGEST} bytes"))
        }
        Ok(_) => String::from_utf8(line).map_err(|_| "expected UTF-8".to_owned()),
        Err(error) => Err(error.to_string()),
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // Its input ends, and a sound program ends with it.
        self.to = None;
        let begun = Instant::now();
        while begun.elapsed() < GRACE && matches!(self.child.try_wait(), Ok(None)) {
            thread::sleep(Duration::from_millis(2));
        }
        end(self.child.id());
        let _ = self.child.kill();
        let _ = self.child.wait();
        running().remove(&self.child.id());
    }
}
