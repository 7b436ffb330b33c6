//! `check`: whether tasks are what their files claim.

use std::fmt::Write;
use std::iter;
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use situ_tasks::{Attempt, Episode, NeededEdit, Registry, Setting, TaskError, Trial, script, trial};
use situ_teachers::Teacher;

use self::layout::{table, with_interval};
use crate::cmd::library::{Carrier, Library, OwnMethods};
use crate::cmd::terminal;
use crate::cost;
use crate::error::BenchError;
use crate::files;
use crate::shown;
use crate::tally::Rate;

mod layout;
mod owed;
mod results;
mod tuition;
mod visible;

/// Checks that tasks are what their files claim.
#[derive(Args, Clone, Debug)]
#[command(
    after_long_help = "Checks from each start that the objects settle and the premise holds; that the goal does not \
        hold yet; that the observed state is finite; that the competent script succeeds; that the original script, \
        which knows nothing of the variation, fails where an edit is needed and succeeds where none is; and that a \
        watching teacher stops it and the competent script succeeds from there. The original script is the file's own \
        skills in their order, each once, whatever they find. Of a graded variation it may manage what it can.

Prints one row for each task and variation, and then what is wrong. Exit status 1 where something is wrong.

With --teacher, wrong is a teacher who gives up in more than one start of twenty, and a variation that needs no edit \
in which the learned model succeeds less often than in the original task: the sign-flip test of the differences, one \
for each seed, over all such variations by Holm, below 5 %. Seeds so few that they cannot tell leave it open, as the \
        table then says.

With --visible, a change is shown at a decision where one feature has an area under the curve of 0.95 or more, above \
those of all of 1000 relabellings of the starts.

Examples:
  situ-bench check
  situ-bench check drawer/stiff --seeds 5
  situ-bench check --tasks my_tasks tower
  situ-bench check --seeds 100 --out premises.md
  situ-bench check --teacher novice pour
  situ-bench check --visible --seeds 50 --out shown.md
  situ-bench check --speed
  situ-bench check --method mine --methods mine.toml
  situ-bench check --results results/quick --sample 3"
)]
pub struct Check {
    /// The tasks, with a variation or without. All known tasks where none is named.
    #[arg(value_name = "TASK[/VARIATION]")]
    pub task: Vec<String>,
    /// Starts from which each setting is tried.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..))]
    pub seeds: u32,
    /// The seed of the first start, 0 where it is not given. With --results the seed of the drawing, which is another
    /// one each time.
    #[arg(long)]
    pub seed: Option<u64>,
    /// Instead measures how many simulated seconds of the competent script one core does in a second.
    #[arg(long, conflicts_with_all = ["teacher", "visible"])]
    pub speed: bool,
    /// Instead checks that a method does what every method owes, on a small automaton without physics. Where --methods
    /// is given without it, every method of those files.
    #[arg(long, value_name = "NAME", conflicts_with_all = ["teacher", "visible", "speed", "task"])]
    pub method: Option<String>,
    /// Instead measures how this teacher does: demonstrations, corrections from where the original script fails, and
    /// whether a model that was learned needs no edit where the task file says so.
    #[arg(long, value_name = "NAME", conflicts_with = "visible")]
    pub teacher: Option<String>,
    /// Instead measures which variations show their change: how well one observed feature tells them from the original
    /// task where another decision has to be made.
    #[arg(long)]
    pub visible: bool,
    /// Instead makes a drawn sample of the runs in this folder anew, and says whether they are the same, times left
    /// out: somebody's results, which must be of this benchmark version.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["teacher", "visible", "speed", "task", "method"])]
    pub results: Option<PathBuf>,
    /// How many runs are drawn, with --results.
    #[arg(long, value_name = "N", default_value_t = 5, requires = "results",
        value_parser = clap::value_parser!(u32).range(1..))]
    pub sample: u32,
    /// Also writes the table to this file, as Markdown; with --visible, a list for programs beside it (.csv).
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Threads. One for each processor where it is not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Tasks and teachers of one's own.
    #[command(flatten)]
    pub library: Library,
    /// Methods of one's own.
    #[command(flatten)]
    pub own: OwnMethods,
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
        let is_about_tasks = !self.task.is_empty() || self.teacher.is_some() || self.visible || self.speed;
        if is_about_tasks && !self.own.methods.is_empty() {
            let problem =
                "--methods: no method takes part in a check of tasks; expected it alone, with --method or --results";
            return Err(BenchError::Argument(problem.to_owned()));
        }
        if self.method.is_some() || (self.results.is_none() && !self.own.methods.is_empty()) {
            return self.owed();
        }
        if let Some(folder) = &self.results {
            let sample = results::Sample { folder, runs: self.sample, seed: self.seed, jobs: self.jobs };
            let (said, findings) = sample.said(&self.library, &self.own.known()?)?;
            return self.checked(&said, &findings);
        }
        let registry = self.library.registry()?;
        let settings = self.settings(&registry)?;
        let seeds: Vec<u64> = (0..u64::from(self.seeds)).map(|index| self.first_seed().wrapping_add(index)).collect();
        if self.speed {
            return self.speed(&settings);
        }
        if self.visible {
            let (said, rows) = visible::said(&registry, &settings, &seeds, self.jobs)?;
            let list = self.out.iter().map(|path| (path.with_extension("csv"), shown::to_csv(&rows)));
            return Ok(Checked { text: self.write(&said, list)?, is_sound: true });
        }
        if let Some(name) = &self.teacher {
            let teacher = Teacher::new(self.library.roster()?.get(name)?.clone());
            let (said, findings) = tuition::said(&teacher, &registry, (&settings, &seeds), self.jobs)?;
            return self.checked(&said, &findings);
        }
        self.premises(&settings, &seeds)
    }

    /// Whether a method, or every method of the files of one's own, does what every method owes.
    fn owed(&self) -> Result<Checked, BenchError> {
        let methods = self.own.known_alone()?;
        let names: Vec<&str> = match &self.method {
            Some(name) => vec![name],
            None => methods.external().collect(),
        };
        let (mut text, mut findings) = (Vec::new(), Vec::new());
        for name in names {
            let (said, wrong) = owed::said(&*methods.named(name)?)?;
            text.push(said);
            findings.extend(wrong);
        }
        self.checked(&text.join("\n"), &findings)
    }

    fn first_seed(&self) -> u64 {
        self.seed.unwrap_or_default()
    }

    /// Whether the tasks are what their files claim.
    fn premises(&self, settings: &[Arc<Setting>], seeds: &[u64]) -> Result<Checked, BenchError> {
        let starts: Vec<(&Arc<Setting>, u64)> =
            settings.iter().flat_map(|setting| seeds.iter().map(move |seed| (setting, *seed))).collect();
        let label = |(setting, _): &(&Arc<Setting>, u64)| setting.label();
        let mut trials =
            terminal::each(self.jobs, &starts, label, |(setting, seed), _| Ok((*seed, trial(setting, *seed))))?
                .into_iter();
        let report = |setting: &Arc<Setting>| Report {
            setting: Arc::clone(setting),
            trials: trials.by_ref().take(seeds.len()).collect(),
        };
        let reports: Vec<Report> = settings.iter().map(report).collect();
        let mut table = table(
            &[
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
            ],
            2,
        );
        for report in &reports {
            table.add_row(report.row());
        }
        let all: Rate = reports.iter().map(|report| report.rate(|trial| trial.competent.succeeded())).sum();
        let said = format!("{table}\n\nThe competent script, over all settings: {}.\n", with_interval(all));
        let findings: Vec<String> = reports.iter().flat_map(Report::findings).collect();
        self.checked(&said, &findings)
    }

    /// What was said, which is written to a file where the user wants that, and then what is wrong.
    fn checked(&self, said: &str, findings: &[String]) -> Result<Checked, BenchError> {
        let mut text = self.write(said, [])?;
        findings.iter().for_each(|finding| writeln!(text, "wrong: {finding}").expect("in memory"));
        Ok(Checked { text, is_sound: findings.is_empty() })
    }

    fn settings(&self, registry: &Registry) -> Result<Vec<Arc<Setting>>, BenchError> {
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

    /// The text as it is printed. It is also written to a file, where the user wants that, and others beside it.
    fn write(&self, text: &str, beside: impl IntoIterator<Item = (PathBuf, String)>) -> Result<String, BenchError> {
        if let Some(path) = &self.out {
            let made_by = format!("Made by `{}`; do not edit.", self.command());
            let own = (path.clone(), format!("{made_by}\n\n{text}"));
            files::write_all(&iter::once(own).chain(beside).collect::<Vec<_>>())?;
        }
        Ok(text.to_owned())
    }

    /// The command that makes the table again. It names all that the table depends on, and not the threads.
    fn command(&self) -> String {
        let mut words = vec!["situ-bench check".to_owned()];
        words.extend(self.task.iter().cloned());
        words.push(format!("--seeds {}", self.seeds));
        if self.first_seed() != 0 {
            words.push(format!("--seed {}", self.first_seed()));
        }
        words.extend(self.method.iter().map(|name| format!("--method {name}")));
        words.extend(self.own.methods.iter().map(|file| format!("--methods {}", file.display())));
        words.extend(
            self.results.iter().map(|folder| format!("--results {} --sample {}", folder.display(), self.sample)),
        );
        if self.speed {
            words.push("--speed".to_owned());
        }
        if self.visible {
            words.push("--visible".to_owned());
        }
        words.extend(self.teacher.iter().map(|name| format!("--teacher {name}")));
        words.extend(self.library.teachers.iter().map(|file| format!("--teachers {}", file.display())));
        words.extend(self.library.tasks.iter().map(|folder| format!("--tasks {}", folder.display())));
        if self.library.plant == Carrier::Hand {
            words.push("--plant hand".to_owned());
        }
        words.join(" ")
    }

    /// The competent script against the clock, one setting after another on this thread.
    fn speed(&self, settings: &[Arc<Setting>]) -> Result<Checked, BenchError> {
        let mut table =
            table(&["setting", "scripts", "simulated seconds", "microseconds a step", "times real time"], 2);
        for setting in settings {
            let (mut simulated, mut clock, mut speeds) = (0.0, 0.0, Vec::new());
            for index in 0..u64::from(self.seeds) {
                let mut episode = Episode::start(setting, self.first_seed().wrapping_add(index))?;
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
        Ok(Checked { text: self.write(&format!("{table}\n\n{said}"), [])?, is_sound: true })
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
            _ if setting.graded => with_interval(self.rate(goes_on)),
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
        if setting.graded {
            require("a watching teacher stops the original script and can go on from there", COMPETENT, &goes_on);
        } else if needs_edit {
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
    goes_on(trial) && !trial.original.succeeded()
}

fn goes_on(trial: &Trial) -> bool {
    trial.corrected.as_ref().is_some_and(Attempt::succeeded)
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
