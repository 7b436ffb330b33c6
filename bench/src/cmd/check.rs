//! `check`: whether tasks are what their files claim.

use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use clap::Args;
use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};
use indicatif::ProgressBar;
use rayon::prelude::*;
use situ_tasks::{Attempt, Episode, NeededEdit, Setting, TaskError, Trial, script, trial};

use crate::cmd::library::{Carrier, Library};
use crate::cmd::terminal;
use crate::cost;
use crate::error::BenchError;
use crate::files;
use crate::record::Rate;
use crate::stats;

/// Checks that tasks are what their files claim.
#[derive(Args, Clone, Debug)]
#[command(
    after_long_help = "Checks from each start that the objects settle and the premise holds; that the goal does not \
        hold yet; that the observed state is finite; that the competent script succeeds; that the original script, \
        which knows nothing of the variation, fails where an edit is needed and succeeds where none is; and that a \
        watching teacher stops it and the competent script succeeds from there.

Prints one row for each task and variation, and then what is wrong. Exit status 1 where something is wrong.

Examples:
  situ-bench check
  situ-bench check drawer/stiff --seeds 5
  situ-bench check --tasks my_tasks tower
  situ-bench check --seeds 100 --out premises.md
  situ-bench check --speed"
)]
pub struct Check {
    /// The tasks, with a variation or without. All known tasks where none is named.
    #[arg(value_name = "TASK[/VARIATION]")]
    pub task: Vec<String>,
    /// Starts from which each setting is tried.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..))]
    pub seeds: u32,
    /// The seed of the first start.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Instead measures how many simulated seconds of the competent script one core does in a second.
    #[arg(long)]
    pub speed: bool,
    /// Also writes the table to this file, as Markdown.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Threads. One for each processor where it is not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Tasks and teachers of one's own.
    #[command(flatten)]
    pub library: Library,
}

/// The share of all trials that must turn out as claimed.
const MOST: f64 = 0.95;
/// The same for the competent script.
const COMPETENT: f64 = 0.99;
/// A script that takes a greater share of the time limit than this hardly succeeds in time.
const IN_TIME: f64 = 0.7;

/// The result of a check.
pub struct Checked {
    /// The text that is to be printed.
    pub text: String,
    /// Whether everything is as claimed.
    pub is_sound: bool,
}

/// The trials of a setting.
struct Report {
    setting: Arc<Setting>,
    trials: Vec<(u64, Result<Trial, TaskError>)>,
}

impl Check {
    /// Checks the tasks; returns the text that is to be printed.
    ///
    /// # Errors
    /// A name that nothing has, a file with a mistake, [`BenchError::Interrupted`].
    pub fn run(&self) -> Result<Checked, BenchError> {
        let settings = self.settings()?;
        if self.speed {
            return self.speed(&settings);
        }
        let interrupted = terminal::interrupt_flag();
        let bar =
            ProgressBar::new(settings.len() as u64 * u64::from(self.seeds)).with_style(terminal::progress_style());
        let seeds: Vec<u64> = (0..u64::from(self.seeds)).map(|index| self.seed.wrapping_add(index)).collect();
        let reports = terminal::threads(self.jobs)?.install(|| {
            let reports = settings.par_iter().map(|setting| {
                let trials = seeds.par_iter().map(|seed| {
                    if interrupted.load(Ordering::Relaxed) {
                        return None;
                    }
                    bar.set_message(setting.label());
                    let trial = trial(setting, *seed);
                    bar.inc(1);
                    Some((*seed, trial))
                });
                Some(Report { setting: Arc::clone(setting), trials: trials.collect::<Option<_>>()? })
            });
            reports.collect::<Option<Vec<Report>>>()
        });
        bar.finish_and_clear();
        let reports = reports.ok_or(BenchError::Stopped)?;
        let mut table = table(&[
            "setting",
            "edit",
            "starts",
            "competent",
            "original",
            "corrected",
            "seconds",
            "metres",
            "keyframes",
            "guarded",
        ]);
        for report in &reports {
            table.add_row(report.row());
        }
        let all: Rate = reports.iter().map(|report| report.rate(|trial| trial.competent.succeeded())).sum();
        let mut text =
            self.write(&table, &format!("The competent script, over all settings: {}.\n", with_interval(all)))?;
        let findings: Vec<String> = reports.iter().flat_map(Report::findings).collect();
        findings.iter().for_each(|finding| writeln!(text, "wrong: {finding}").expect("in memory"));
        Ok(Checked { text, is_sound: findings.is_empty() })
    }

    fn settings(&self) -> Result<Vec<Arc<Setting>>, BenchError> {
        let registry = self.library.registry()?;
        if self.task.is_empty() {
            return Ok(registry.tasks().flat_map(|task| task.settings().cloned()).collect());
        }
        let mut settings = Vec::new();
        for name in &self.task {
            match name.split_once('/') {
                Some((task, variation)) => settings.push(registry.get(task)?.variation(Some(variation))?),
                None => settings.extend(registry.get(name)?.settings().cloned()),
            }
        }
        Ok(settings)
    }

    /// The table as it is printed. It is also written to a file, where the user wants that.
    fn write(&self, table: &Table, said: &str) -> Result<String, BenchError> {
        let text = format!("{table}\n\n{said}");
        if let Some(path) = &self.out {
            let made_by = format!("Made by `{}`; do not edit.", self.command());
            files::write_all(&[(path.clone(), &format!("{made_by}\n\n{text}"))])?;
        }
        Ok(text)
    }

    /// The command that makes the table again. It names all that the table depends on, and not the threads.
    fn command(&self) -> String {
        let mut words = vec!["situ-bench check".to_owned()];
        words.extend(self.task.iter().cloned());
        words.push(format!("--seeds {}", self.seeds));
        if self.seed != 0 {
            words.push(format!("--seed {}", self.seed));
        }
        if self.speed {
            words.push("--speed".to_owned());
        }
        words.extend(self.library.tasks.iter().map(|folder| format!("--tasks {}", folder.display())));
        if self.library.plant == Carrier::Hand {
            words.push("--plant hand".to_owned());
        }
        words.join(" ")
    }

    /// The competent script against the clock, one setting after another on this thread.
    fn speed(&self, settings: &[Arc<Setting>]) -> Result<Checked, BenchError> {
        let mut table = table(&["setting", "scripts", "simulated seconds", "microseconds a step", "times real time"]);
        for setting in settings {
            let (mut simulated, mut clock, mut speeds) = (0.0, 0.0, Vec::new());
            for index in 0..u64::from(self.seeds) {
                let mut episode = Episode::start(setting, self.seed.wrapping_add(index))?;
                let (_, seconds) = cost::timed(|| script::competent(&mut episode, &mut |_| {}));
                simulated += episode.seconds();
                clock += seconds;
                speeds.push(episode.seconds() / seconds);
            }
            speeds.sort_by(f64::total_cmp);
            let steps = simulated / situ_sim::DT;
            table.add_row([
                setting.label(),
                self.seeds.to_string(),
                format!("{simulated:.0}"),
                format!("{:.1}", 1e6 * clock / steps),
                format!("{:.0} [{:.0}, {:.0}]", simulated / clock, speeds[0], speeds[speeds.len() - 1]),
            ]);
        }
        let said = "The competent script on one thread, planning and observing included; in brackets the slowest and \
                    the fastest script.\n";
        Ok(Checked { text: self.write(&table, said)?, is_sound: true })
    }
}

impl Report {
    fn tried(&self) -> impl Iterator<Item = (u64, &Trial)> {
        self.trials.iter().filter_map(|(seed, trial)| Some((*seed, trial.as_ref().ok()?)))
    }

    /// In how many trials something is so.
    fn rate(&self, is_so: impl Fn(&Trial) -> bool) -> Rate {
        self.tried().map(|(_, trial)| Rate::from(is_so(trial))).sum()
    }

    fn mean(&self, value: impl Fn(&Trial) -> f64) -> f64 {
        let count = self.tried().count().max(1);
        self.tried().map(|(_, trial)| value(trial)).sum::<f64>() / count as f64
    }

    fn row(&self) -> Vec<String> {
        let setting = &self.setting;
        let edit = if setting.variation.is_some() { setting.edit.word() } else { "original" };
        let corrected = match setting.edit {
            NeededEdit::None => "–".to_owned(),
            _ => with_interval(self.rate(is_corrected)),
        };
        let started = self.tried().count();
        vec![
            setting.label(),
            edit.to_owned(),
            format!("{started}/{}", self.trials.len()),
            with_interval(self.rate(|trial| trial.competent.succeeded())),
            with_interval(self.rate(|trial| trial.original.succeeded())),
            corrected,
            format!("{:.1}", self.mean(|trial| trial.competent.seconds)),
            format!("{:.2}", self.mean(|trial| trial.competent.metres)),
            format!("{:.1}", self.mean(|trial| trial.competent.record.keyframes as f64)),
            format!("{:.2}", self.mean(|trial| trial.competent.record.guarded as f64)),
        ]
    }

    /// The mistakes that were found, one sentence for each.
    fn findings(&self) -> Vec<String> {
        let (setting, label) = (&self.setting, self.setting.label());
        let mut found = Vec::new();
        for (seed, trial) in &self.trials {
            match trial {
                Err(error) => found.push(format!("{label}, seed {seed}: {error}")),
                Ok(trial) => {
                    if trial.solved_at_start {
                        found.push(format!("{label}, seed {seed}: the goal holds at the start, nothing is left to do"));
                    }
                    if let Some(feature) = &trial.odd_feature {
                        found.push(format!("{label}, seed {seed}: `{feature}` is observed to be no finite number"));
                    }
                }
            }
        }
        let needs_edit = setting.edit != NeededEdit::None;
        let mut require = |what: &str, share: f64, is_so: &dyn Fn(&Trial) -> bool| {
            let rate = self.rate(is_so);
            if f64::from(rate.successes) < share * f64::from(rate.rollouts) {
                let first = self.tried().find(|(_, trial)| !is_so(trial));
                let how =
                    first.map_or(String::new(), |(seed, trial)| format!(", first at seed {seed}: {}", endings(trial)));
                let Rate { successes, rollouts, .. } = rate;
                found.push(format!("{label}: {what} in {successes} of {rollouts} starts only{how}"));
            }
        };
        require("the competent script succeeds", COMPETENT, &|trial| trial.competent.succeeded());
        let hardly = format!("the competent script is done within {IN_TIME} of the time limit");
        require(&hardly, COMPETENT, &|trial| trial.competent.seconds <= IN_TIME * setting.time_limit);
        if needs_edit {
            require("the original script fails, as it must where an edit is needed", MOST, &|trial| {
                !trial.original.succeeded()
            });
            require("a watching teacher stops the original script and can go on from there", COMPETENT, &is_corrected);
        } else {
            require("the original script succeeds, as it must where no edit is needed", MOST, &|trial| {
                trial.original.succeeded()
            });
        }
        found
    }
}

fn is_corrected(trial: &Trial) -> bool {
    trial.corrected.as_ref().is_some_and(Attempt::succeeded) && !trial.original.succeeded()
}

/// How the scripts of a trial ended, in words.
fn endings(trial: &Trial) -> String {
    let words = |name: &str, attempt: &Attempt| {
        let last = attempt.record.skills.last().map_or("nothing", String::as_str);
        format!("{name} {} after {last}, {:.1} s", attempt.record.ending, attempt.seconds)
    };
    let mut all = vec![words("competent", &trial.competent), words("original", &trial.original)];
    all.extend(trial.corrected.as_ref().map(|attempt| words("corrected", attempt)));
    all.join("; ")
}

fn with_interval(rate: Rate) -> String {
    let (low, high) = stats::wilson(rate.successes, rate.rollouts.max(1));
    format!("{}/{} [{low:.3}, {high:.3}]", rate.successes, rate.rollouts)
}

/// A table whose first column is text and whose other columns are numbers.
fn table(heads: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN).set_header(heads.to_vec());
    table.column_iter_mut().skip(2).for_each(|column| column.set_cell_alignment(CellAlignment::Right));
    table
}
