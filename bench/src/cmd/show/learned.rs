//! What a learned model does before it is corrected, the corrections, and what it does after them.

use std::fmt::Write;

use situ::method::{Method, Role};
use situ_sim::World;

use super::album::{Piece, yes_or_no};
use crate::error::BenchError;
use crate::external::Methods;
use crate::performance::{Performance, RolloutRecorder, StepsOnly};
use crate::pictures;
use crate::record::Outcome;
use crate::rerun::{GivenCorrection, NamedModel, Rerun, Story};
use crate::rollout::Rollout;
use crate::tally::Rate;
use crate::track::Track;

/// The method of this name.
///
/// # Errors
/// A name that nothing has, or a method that takes no corrections; with the names that can be shown.
pub(super) fn method(name: &str, methods: &Methods) -> Result<Box<dyn Method>, BenchError> {
    let all = methods.all();
    let known = all.iter().filter(|method| method.role() == Role::Correct).map(|method| method.name());
    let method = methods.named(name)?;
    if method.role() != Role::Correct {
        return Err(BenchError::Argument(format!(
            "--method {name}: it takes no corrections, expected one of {}",
            known.collect::<Vec<_>>().join(", ")
        )));
    }
    Ok(method)
}

/// The first part of the names of its files.
pub(super) fn stem(rerun: &Rerun<'_>, method: &dyn Method) -> String {
    let (setting, teacher) = (pictures::stem(rerun.setting), &rerun.teacher.profile().name);
    format!("{setting}-{}-{teacher}-{}", method.name().replace(':', "-"), rerun.seed)
}

/// What is shown of a run: the rollout before, each correction, and the rollout after; where nothing was corrected, the
/// rollout alone.
///
/// # Errors
/// Where a rollout or a correction cannot be done once more.
pub(super) fn pieces<'a>(rerun: &'a Rerun<'a>, story: &'a Story) -> Result<Vec<Piece<'a>>, BenchError> {
    let is_corrected = !story.corrections.is_empty();
    let (name, title) = match story.failures.is_empty() {
        true => ("success", "not corrected"),
        false => ("before", "before"),
    };
    let mut pieces = vec![rollout(rerun, story, &story.before, (name, title))?];
    for (index, given) in story.corrections.iter().enumerate() {
        pieces.push(correction(rerun, story, index, given)?);
    }
    if is_corrected {
        pieces.push(rollout(rerun, story, &story.after, ("after", "after"))?);
    }
    Ok(pieces)
}

/// A rollout from the start that is shown.
fn rollout<'a>(
    rerun: &'a Rerun<'a>,
    story: &'a Story,
    model: &'a NamedModel,
    (name, title): (&str, &str),
) -> Result<Piece<'a>, BenchError> {
    let start = rerun.episode(story.start)?;
    let mut recorder = RolloutRecorder::new(model, &start, title);
    let rollout = rerun.roll_out(&*model.learned, story.start, &mut recorder)?;
    let again = move |observer: &mut dyn FnMut(&World)| {
        rerun.roll_out(&*model.learned, story.start, &mut StepsOnly(observer)).map(drop)
    };
    let performance = Performance::rolled_out(start, recorder, &rollout, Box::new(again));
    let (number, rollouts) = (story.start.1 + 1, rerun.protocol.rollouts);
    let said = format!(
        "{title}: {}\n  rollout {number} of {rollouts}: {}, simulated seconds {:.1}, the goal holds: {}\n",
        skills(model, &rollout),
        rollout.ended,
        performance.seconds(),
        yes_or_no(rollout.success)
    );
    Ok(Piece {
        film: name.to_owned(),
        strip: format!("{name}-strip"),
        about: format!("the rollout, {title}"),
        moments: moments(&performance),
        said,
        performance,
    })
}

/// What a rollout's primitives are called, those that were begun.
fn skills(model: &NamedModel, rollout: &Rollout) -> String {
    let begun = rollout.choices.iter().take(rollout.primitives).map(|choice| model.name(choice.child));
    let skills: Vec<String> = begun.collect();
    if skills.is_empty() { "nothing".to_owned() } else { skills.join(", ") }
}

/// A correction that the robot was given.
fn correction<'a>(
    rerun: &'a Rerun<'a>,
    story: &'a Story,
    index: usize,
    given: &'a GivenCorrection,
) -> Result<Piece<'a>, BenchError> {
    let number = index + 1;
    let title = format!("correction {number}");
    let mut track = Track::new(&given.episode);
    let (shown, is_goal) = rerun.correct(given, &mut |world| track.see(world))?;
    let again = move |observer: &mut dyn FnMut(&World)| rerun.correct(given, observer).map(drop);
    let start = (given.episode.clone(), track);
    let performance = Performance::shown(start, &title, (&shown, is_goal), Box::new(again));
    let (round, rollout) = given.failure;
    let mut said = format!("{title}: {}\n", shown.skills.join(", "));
    let _ = write!(
        said,
        "  the teacher steps in at rollout {} of round {}: {}; keyframes {}, simulated seconds {:.1}, the goal holds: {}",
        rollout + 1,
        round + 1,
        given.trigger,
        shown.effort.keyframes,
        shown.effort.seconds,
        yes_or_no(is_goal)
    );
    let edit = story.record.corrections.get(index).map(|record| format!(", edit: {}", record.edit_made));
    let _ = writeln!(said, "{}", edit.unwrap_or_default());
    Ok(Piece {
        film: format!("correction-{number}"),
        strip: format!("correction-{number}-strip"),
        about: title,
        moments: moments(&performance),
        said,
        performance,
    })
}

fn moments(performance: &Performance<'_>) -> String {
    let all = performance.moments.len();
    format!("{} of {all} keyframes", pictures::even_selection(&performance.moments).len())
}

/// What is said of the run as a whole: whether anything was corrected, and what its record says.
pub(super) fn verdict(rerun: &Rerun<'_>, story: &Story) -> String {
    let Story { record, corrections, failures, rollouts, .. } = story;
    let mut said = String::new();
    let failed = failures.len();
    match (corrections.is_empty(), failed) {
        (false, _) => {}
        (true, 0) => {
            let _ = writeln!(said, "Nothing fails in {rollouts} rollouts, so nothing is corrected.");
        }
        (true, _) => {
            let why = record.outcome.why().map_or_else(
                || format!("the target of {} is reached", rerun.protocol.target),
                |why| format!("not one correction was given: {why}"),
            );
            let _ = writeln!(said, "Nothing is corrected: {failed} of {rollouts} rollouts fail, and {why}.");
        }
    }
    let rate =
        |rate: Option<Rate>| rate.map_or("–".to_owned(), |rate| format!("{}/{}", rate.successes, rate.rollouts));
    let _ = writeln!(
        said,
        "the run's record: {}; from fresh starts, the changed task before {}, after {}; the original one before {}, \
         after {}; corrections {}",
        outcome(&record.outcome),
        rate(record.before),
        rate(record.after),
        rate(record.original_rate),
        rate(record.retained),
        record.corrections.len()
    );
    said
}

/// How a run ended.
fn outcome(outcome: &Outcome) -> String {
    let name = match outcome {
        Outcome::Reached => "the target is reached",
        Outcome::Censored => "the budget is used up",
        Outcome::GaveUp { .. } => "the teacher gave up",
        Outcome::Spoilt { .. } => "the physics was spoilt",
        Outcome::Untaught { .. } => "the original task was not taught",
        Outcome::NotApplicable => "the method cannot make the edit",
        Outcome::MethodError { .. } | Outcome::TimedOut { .. } | Outcome::Panicked { .. } => "it broke off",
    };
    outcome.why().map_or_else(|| name.to_owned(), |why| format!("{name} ({why})"))
}
