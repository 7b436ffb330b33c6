//! `check --teacher`: how a teacher does, and whether what was learned needs no edit where a task file says so.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64};

use comfy_table::Table;
use situ_tasks::{NeededEdit, Registry, Setting};
use situ_teachers::{Teacher, convert};

use super::layout::{table, with_interval};
use crate::cmd::terminal;
use crate::conditions::Conditions;
use crate::error::BenchError;
use crate::memo::{Memo, Room};
use crate::protocol::Protocol;
use crate::spending::{RunPhase, Spending};
use crate::stats::{self, paired};
use crate::tally::{Rate, TotalEffort};
use crate::tuition::Absorbed;

/// The protocol by which the original task is taught, and whose rollouts an evaluation has.
const PROTOCOL: &str = "families";
/// A teacher may give up in this share of the starts.
const GIVES_UP: f64 = 0.05;
/// Beyond this it is no accident that a learned model does worse.
const SIGNIFICANT: f64 = 0.05;

/// A learned model may lose this much success where nothing needs an edit, and still be said to need none.
const MARGIN: f64 = 0.1;
/// Seeds without which nothing is said to need none: differences that happen to be equal have an interval of no width.
const LEAST_SEEDS: usize = 10;

/// An original task, and its variations that need no edit.
type Controls = (Arc<Setting>, Vec<Arc<Setting>>);

/// What all measurements share.
struct Ground<'a> {
    teacher: &'a Teacher,
    protocol: Protocol,
    room: Room,
    spending: Spending,
}

impl Ground<'_> {
    /// Measures something under the conditions of a seed.
    fn measure<R>(
        &self,
        setting: &Setting,
        seed: u64,
        interrupted: &AtomicBool,
        what: impl FnOnce(&Conditions<'_>) -> Result<R, BenchError>,
    ) -> Result<R, BenchError> {
        let schema = convert::schema(setting)?;
        let memo = Memo::new(&self.room);
        what(&Conditions {
            protocol: &self.protocol,
            teacher: self.teacher,
            content: "",
            seed,
            task: &setting.task,
            schema: &schema,
            interrupted,
            archive: None,
            memo: &memo,
            spending: &self.spending,
            phase: RunPhase::Teach,
            steps: &AtomicU64::new(0),
        })
    }
}

/// Three tables, and what is wrong.
pub(super) fn said(
    teacher: &Teacher,
    registry: &Registry,
    (settings, seeds): (&[Arc<Setting>], &[u64]),
    jobs: Option<u16>,
) -> Result<(String, Vec<String>), BenchError> {
    let ground =
        Ground { teacher, protocol: Protocol::find(PROTOCOL)?, room: Room::default(), spending: Spending::new() };
    let mut findings = Vec::new();
    let efforts = efforts(&ground, settings, seeds, jobs)?;
    let mut whole = effort_table();
    let mut corrections = effort_table();
    for (setting, efforts) in settings.iter().zip(efforts.chunks(seeds.len())) {
        let shown: Vec<TotalEffort> = efforts.iter().map(|(whole, _)| *whole).collect();
        findings.extend(add_row(&mut whole, setting, "a whole demonstration", &shown));
        if setting.edit != NeededEdit::None {
            let shown: Vec<TotalEffort> = efforts.iter().filter_map(|(_, correction)| *correction).collect();
            findings.extend(add_row(&mut corrections, setting, "a correction", &shown));
        }
    }
    let mut said = format!("Teacher: {}.\n\n{whole}\n", teacher.profile().name);
    said += "\nWhole demonstrations. *clean*: at the first try. All else is for each that was given, the tries that failed \
             among it.\n";
    if !corrections.is_empty() {
        said += &format!(
            "\n{corrections}\n\nCorrections from where a watching teacher, or the arm, stops the original \
                          script.\n"
        );
    }
    let (learned, worse) = learned(&ground, &controls(registry, settings)?, seeds, jobs)?;
    said += &learned;
    findings.extend(worse);
    Ok((said, findings))
}

/// The effort of a whole demonstration and of a correction: setting by setting, seed by seed.
fn efforts(
    ground: &Ground<'_>,
    settings: &[Arc<Setting>],
    seeds: &[u64],
    jobs: Option<u16>,
) -> Result<Vec<(TotalEffort, Option<TotalEffort>)>, BenchError> {
    let starts: Vec<(&Arc<Setting>, u64)> =
        settings.iter().flat_map(|setting| seeds.iter().map(move |seed| (setting, *seed))).collect();
    terminal::each(
        jobs,
        &starts,
        |(setting, _)| setting.label(),
        |(setting, seed), interrupted| {
            ground.measure(setting, *seed, interrupted, |conditions| {
                let needs_edit = setting.edit != NeededEdit::None;
                let correction = if needs_edit { conditions.effort_of_correction(setting)? } else { None };
                Ok((conditions.effort_of_first(setting)?, correction))
            })
        },
    )
}

fn effort_table() -> Table {
    table(&["setting", "edit", "clean", "given", "tries", "keyframes", "seconds", "metres"], 2)
}

/// Adds what came of a setting; returns what is wrong with it.
fn add_row(table: &mut Table, setting: &Setting, what: &str, efforts: &[TotalEffort]) -> Option<String> {
    let rate = |is_so: fn(&TotalEffort) -> bool| efforts.iter().map(|effort| Rate::from(is_so(effort))).sum::<Rate>();
    let clean = rate(|effort| effort.demonstrations == 1 && effort.tries == 1);
    let given = rate(|effort| effort.demonstrations == 1);
    let each =
        |value: fn(&TotalEffort) -> f64| efforts.iter().map(value).sum::<f64>() / f64::from(given.successes.max(1));
    let edit = if setting.variation.is_some() { setting.edit.word() } else { "original" };
    table.add_row([
        setting.label(),
        edit.to_owned(),
        with_interval(clean),
        format!("{}/{}", given.successes, given.rollouts),
        format!("{:.2}", each(|effort| f64::from(effort.tries))),
        format!("{:.1}", each(|effort| f64::from(effort.keyframes))),
        format!("{:.1}", each(|effort| effort.seconds)),
        format!("{:.2}", each(|effort| effort.metres)),
    ]);
    let gave_up = given.rollouts - given.successes;
    (f64::from(gave_up) > GIVES_UP * f64::from(given.rollouts))
        .then(|| format!("{}: the teacher gives up {what} in {gave_up} of {} starts", setting.label(), given.rollouts))
}

/// The variations of these settings that need no edit, with the original tasks that they are held against.
fn controls(registry: &Registry, settings: &[Arc<Setting>]) -> Result<Vec<Controls>, BenchError> {
    let mut controls: BTreeMap<&str, Vec<Arc<Setting>>> = BTreeMap::new();
    for setting in settings.iter().filter(|setting| setting.variation.is_some()) {
        if setting.edit == NeededEdit::None {
            controls.entry(&setting.task).or_default().push(Arc::clone(setting));
        }
    }
    let originals = controls.into_iter().map(|(task, changed)| Ok((registry.get(task)?.variation(None)?, changed)));
    originals.collect()
}

/// What a variation that needs no edit is to a learned model: its success in the original task and there, seed by seed.
struct Held {
    label: String,
    taught: usize,
    rates: Vec<(f64, f64)>,
}

impl Held {
    fn differences(&self) -> Vec<f64> {
        self.rates.iter().map(|(original, changed)| changed - original).collect()
    }
}

/// The table of the learned models, and where they do worse though they need no edit. Nothing where there is no such
/// variation.
fn learned(
    ground: &Ground<'_>,
    controls: &[Controls],
    seeds: &[u64],
    jobs: Option<u16>,
) -> Result<(String, Vec<String>), BenchError> {
    let starts: Vec<(&Controls, u64)> =
        controls.iter().flat_map(|controls| seeds.iter().map(move |seed| (controls, *seed))).collect();
    let absorbed = terminal::each(
        jobs,
        &starts,
        |((original, _), _)| format!("{}: learned", original.label()),
        |((original, changed), seed), interrupted| {
            ground.measure(original, *seed, interrupted, |conditions| conditions.absorbed(original, changed))
        },
    )?;
    let held = controls.iter().zip(absorbed.chunks(seeds.len())).flat_map(|((_, changed), absorbed)| {
        changed.iter().enumerate().map(move |(index, setting)| held(setting, index, absorbed))
    });
    Ok(table_of_learned(&held.collect::<Vec<_>>()))
}

/// One of the changed tasks, over the models of all seeds.
fn held(setting: &Setting, index: usize, absorbed: &[Option<Absorbed>]) -> Held {
    let share = |rate: Rate| f64::from(rate.successes) / f64::from(rate.rollouts.max(1));
    let taught = absorbed.iter().flatten();
    let rates = taught.clone().filter_map(|of| Some((share(of.original), share(of.changed[index]?))));
    Held { label: setting.label(), taught: taught.count(), rates: rates.collect() }
}

fn table_of_learned(held: &[Held]) -> (String, Vec<String>) {
    if held.is_empty() {
        return Default::default();
    }
    let mut table =
        table(&["variation", "taught", "original", "learned", "difference", "p", "least p", "needs none"], 1);
    let tests: Vec<_> = held.iter().map(|held| paired::sign_flip(&held.differences(), 0)).collect();
    let p_values: Vec<f64> = tests.iter().map(|test| test.as_ref().map_or(1.0, |test| test.p)).collect();
    let mut findings = Vec::new();
    for ((held, test), p) in held.iter().zip(&tests).zip(paired::holm(&p_values)) {
        let differences = held.differences();
        let mean = |of: fn(&(f64, f64)) -> f64| stats::mean(&held.rates.iter().map(of).collect::<Vec<_>>());
        let cell = |value: Option<f64>| value.map_or("–".to_owned(), |value| format!("{value:.3}"));
        let drawn =
            |indices: &[usize]| stats::mean(&indices.iter().map(|index| differences[*index]).collect::<Vec<_>>());
        let difference = stats::bootstrap(differences.len(), 0, drawn);
        let interval = difference.map(|of| format!("{:.3} [{:.3}, {:.3}]", of.value, of.low, of.high));
        table.add_row([
            held.label.clone(),
            held.taught.to_string(),
            cell(mean(|(original, _)| *original)),
            cell(mean(|(_, changed)| *changed)),
            interval.unwrap_or_else(|| "–".to_owned()),
            format!("{p:.3}"),
            cell(test.as_ref().map(|test| test.least)),
            verdict(difference.as_ref(), p, differences.len()).to_owned(),
        ]);
        if let Some(of) = difference.filter(|of| is_worse(of, p)) {
            findings.push(format!(
                "{}: needs no edit, and a learned model succeeds less often than in the original task: by {:.3}, p = \
                 {p:.3}",
                held.label, -of.value
            ));
        }
    }
    let said = format!(
        "\n{table}\n\nModels of the original task, taught as a run of the protocol `{PROTOCOL}` teaches it, in the original \
         task and where no edit is needed: mean success over the seeds at which it was taught. The difference has a \
         bootstrap interval over seeds; p is the paired sign-flip test's, corrected by Holm over this table, beside the \
         least p, not corrected, that the seeds which differ can give. Needs none: *no* where the model does worse and p \
         is below {SIGNIFICANT}; *yes* where there are {LEAST_SEEDS} seeds or more and their interval has no loss of more \
         than {MARGIN}; *open* where that cannot be told.\n"
    );
    (said, findings)
}

/// Whether it is no accident that a learned model does worse.
fn is_worse(difference: &stats::Estimate, p: f64) -> bool {
    difference.value < 0.0 && p < SIGNIFICANT
}

/// Whether a learned model needs no edit, as far as can be told.
fn verdict(difference: Option<&stats::Estimate>, p: f64, seeds: usize) -> &'static str {
    match difference {
        Some(difference) if is_worse(difference, p) => "no",
        Some(difference) if seeds >= LEAST_SEEDS && difference.low >= -MARGIN => "yes",
        _ => "open",
    }
}
