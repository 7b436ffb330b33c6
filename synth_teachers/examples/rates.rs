//! How often each teacher errs, in corrections performed in physics, against what the profile says; as a Markdown
//! table.
//!
//! `cargo run --release -p situ-teachers --example rates -- [CORRECTIONS]`
//!
//! Every teacher gives so many corrections of the bumped cube of *sort_blocks*, each from another start. All attempts
//! count, also those that fail. The exit status is 1 where a rate is outside its interval (exact binomial, 95 % for all
//! rates together), and a line on the standard error names each such rate.

use std::error::Error;
use std::process::ExitCode;

use situ::demonstration::Kind;
use situ_tasks::script::{self, Ending};
use situ_tasks::{Episode, EpisodeSnapshot, Registry};
use situ_teachers::{Onset, Roster, Tally, Teacher, Way, convert};

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let corrections: u64 = std::env::args().nth(1).map_or(Ok(80), |text| text.parse())?;
    let setting = Registry::builtin()?.get("sort_blocks")?.variation(Some("bump"))?;
    let schema = convert::schema(&setting)?;
    let failures: Vec<(u64, EpisodeSnapshot)> = (0..corrections)
        .map(|seed| {
            let mut episode = Episode::start(&setting, seed)?;
            let record = script::watched(&mut episode, &mut |_| {});
            assert_eq!(record.ending, Ending::Stopped, "the bump is always seen");
            Ok((seed, episode.snapshot()))
        })
        .collect::<Result<_, Box<dyn Error>>>()?;

    let roster = Roster::builtin()?;
    let mut rows = Vec::new();
    for profile in roster.profiles() {
        let teacher = Teacher::new(profile.clone());
        let mut tally = Tally::default();
        for (seed, failure) in &failures {
            let onset = teacher.onset(*seed);
            tally.count(Way::BeginsEarly, onset == Onset::Early);
            tally.count(Way::BeginsLate, onset == Onset::Late);
            let mut episode = Episode::restore(failure);
            let shown = teacher.demonstrate("rates", Kind::Corrective, &schema, &mut episode, *seed, &mut |_| {})?;
            tally += shown.tally;
        }
        rows.extend(Way::ALL.into_iter().map(|way| (profile, way, tally.of(way))));
    }

    println!("Made by `cargo run --release -p situ-teachers --example rates -- {corrections}`; do not edit.\n");
    let alpha = 0.05 / rows.len() as f64;
    println!("| teacher | errs | configured | observed | of | p |\n|---|---|---|---|---|---|");
    let mut outside = Vec::new();
    for (profile, way, count) in &rows {
        let (rate, name, unit) = (profile.rate(*way), way.name(), way.unit());
        let p = count.tails(rate);
        let observed = f64::from(count.happened) / f64::from(count.chances.max(1));
        if rate > 0.0 {
            println!("| {} | {name} | {rate} | {observed:.3} | {} {unit} | {p:.3} |", profile.name, count.chances);
        }
        if p < alpha {
            let of = format!("{observed:.3} of {} {unit}, p = {p:.1e}", count.chances);
            outside.push(format!("outside: teacher `{}`, `{name}`: configured {rate}, observed {of}", profile.name));
        }
    }
    let least = rows.iter().filter(|(_, way, _)| *way == Way::Spurious).map(|(_, _, count)| count.chances).min();
    println!(
        "\n{} rates, those of 0 among them; {} keyframes a teacher at the least. p is twice the smaller exact binomial tail; below \
         {alpha:.5} a rate would be outside the 95 % interval for all of them together: {} are.",
        rows.len(),
        least.unwrap_or(0),
        outside.len()
    );
    outside.iter().for_each(|line| eprintln!("{line}"));
    Ok(if outside.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
