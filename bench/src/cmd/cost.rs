//! `cost`: the cost of updates now, against their cost when it was last meant to change.

use std::collections::BTreeMap;
use std::env;
use std::path::{Path, PathBuf};

use clap::Args;
use comfy_table::{Table, presets::ASCII_MARKDOWN};
use situ::demonstration::Kind;
use situ::edit::Edit;
use situ::method;

use crate::cmd::library::OwnMethods;
use crate::cmd::run::Run;
use crate::cost::Subject;
use crate::demonstration_file::DemonstrationFile;
use crate::digest;
use crate::error::BenchError;
use crate::files;
use crate::gate::{Judged, MeasuredUpdate, Origin, Verdict, WorkBaseline, valgrind};
use crate::kept_model::KeptModel;
use crate::own_cost::{self, OwnBaseline};
use crate::protocol::Protocol;
use crate::record::{CostRecord, Record};
use crate::tables;

/// Measures the cost of updates on synthetic automata, prints T4, and compares the exact work with the baseline.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = "The counters are exact: any difference is a verdict. Where valgrind is installed, the \
        instructions of updates are counted as well, on automata of the first seed with at most 300 nodes times \
        originals. They are compared, with a tolerance of 2 %, where compiler, target and vectors are those of the \
        baseline. Times are printed and never judged.

Exit status 1 where an update regressed.

Examples:
  situ-bench cost
  situ-bench cost --check
  situ-bench cost --mint
  situ-bench cost --model tea.json --correct lid.json --mint    (writes tea.cost.json)
  situ-bench cost --model tea.json --correct lid.json --check")]
pub struct Cost {
    /// The protocol whose cost series are measured: the name of a built-in one, or a file.
    #[arg(long, default_value = "cost", value_name = "NAME|FILE")]
    pub protocol: String,
    /// Measures the corrections of a model of one's own in the place of a protocol: what `learn --out` wrote.
    #[arg(long, value_name = "MODEL.json", requires = "correct", conflicts_with_all = ["protocol", "out"])]
    pub model: Option<PathBuf>,
    /// The corrections of that model, folded in one after another.
    #[arg(long, value_name = "CORRECTION.json", num_args = 1.., requires = "model")]
    pub correct: Vec<PathBuf>,
    /// Methods of one's own, for a model of one of them.
    #[command(flatten)]
    pub own: OwnMethods,
    /// The folder for the ledger and the tables. Where it is not given, `runs/PROTOCOL`, which is begun anew each time.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Compares with the baseline, update by update: improved, regressed, unchanged or incomparable.
    #[arg(long)]
    pub check: bool,
    /// Writes the baseline anew, from this measurement.
    #[arg(long, conflicts_with = "check")]
    pub mint: bool,
    /// The baseline. Where it is not given: results/baselines/update_cost.json; for a model of one's own `.cost.json`
    /// beside it.
    #[arg(long, value_name = "FILE")]
    pub baseline: Option<PathBuf>,
    /// Leaves the instructions out, even where valgrind is installed.
    #[arg(long)]
    pub without_instructions: bool,
    /// Measures one automaton, for valgrind: series, method, nodes, originals and seed.
    #[arg(long, hide = true, num_args = 5, value_names = ["SERIES", "METHOD", "NODES", "ORIGINALS", "SEED"])]
    pub one: Option<Vec<String>>,
}

/// The baseline of the protocol.
const BASELINE: &str = "results/baselines/update_cost.json";
/// Instructions are counted of automata whose nodes times originals are at most this. Under valgrind, teaching a
/// greater one takes minutes.
const MOST_SEGMENTS: u32 = 300;

/// The text that is to be printed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Costed {
    /// To standard output.
    pub text: String,
    /// Whether no update regressed.
    pub is_sound: bool,
}

impl Cost {
    /// Measures, compares or mints.
    ///
    /// # Errors
    /// As [`Run::run`]; a file that is not there or is no baseline; an error of valgrind.
    pub fn run(&self) -> Result<Costed, BenchError> {
        if let Some(model) = &self.model {
            return self.of_own(model);
        }
        let baseline_file = self.baseline.clone().unwrap_or_else(|| PathBuf::from(BASELINE));
        let protocol = Protocol::find(&self.protocol)?;
        if protocol.cost.is_empty() {
            let problem = format!("the protocol `{}` has no cost series: expected one that has", protocol.name);
            return Err(BenchError::Argument(problem));
        }
        if let Some(one) = &self.one {
            one_automaton(&protocol, one)?;
            return Ok(Costed { text: String::new(), is_sound: true });
        }
        let baseline = self.check.then(|| WorkBaseline::read(&baseline_file)).transpose()?;
        let protocol = Protocol { tasks: Vec::new(), ..protocol };
        let run = Run { protocol: self.protocol.clone(), out: self.out.clone(), ..Run::default() };
        let published = run.publish(&protocol, &[tables::COST])?;
        let mut printed = published.printed;
        let costs = published.records.iter().filter_map(|record| match record {
            Record::Cost(cost) => Some(MeasuredUpdate { cost: cost.clone(), instructions: None }),
            Record::Run(_) => None,
        });
        let mut rows: Vec<MeasuredUpdate> = costs.collect();
        let counts = !self.without_instructions && valgrind::is_possible();
        if counts {
            self.count_instructions(&mut rows)?;
            printed.push_str(&instruction_table(&rows));
        } else {
            printed.push_str(
                "Instructions were not counted: valgrind is not here, or is not wanted. The counters alone are \
                 compared.\n",
            );
        }
        let mut is_sound = true;
        if let Some(baseline) = baseline {
            let judged = baseline.judge(&Origin::here(), &protocol, &rows);
            printed.push_str(&verdicts(&judged));
            is_sound = judged.iter().all(|judged| judged.verdict != Verdict::Regressed);
        }
        if self.mint {
            let baseline = WorkBaseline::new(Origin::here(), &protocol, rows);
            files::write_all(&[(baseline_file.clone(), baseline.to_json())])?;
            printed.push_str(&format!("The baseline is {}.\n", baseline_file.display()));
        }
        Ok(Costed { text: printed, is_sound })
    }

    /// The corrections of a model of one's own.
    fn of_own(&self, path: &Path) -> Result<Costed, BenchError> {
        let methods = self.own.known_alone()?;
        let read = self.correct.iter().map(|path| DemonstrationFile::read(path));
        let corrections = read.collect::<Result<Vec<_>, _>>()?;
        corrections.iter().try_for_each(|file| file.check_kind(Kind::Corrective))?;
        let mut kept = KeptModel::read(path, &methods)?;
        let model = digest::hash(kept.render());
        let mut earlier = kept.earlier(path);
        let stops = corrections.iter().map(|file| earlier.stop(file)).collect::<Result<Vec<_>, _>>()?;
        let beside = self.baseline.clone().unwrap_or_else(|| path.with_extension("cost.json"));
        let baseline = self.check.then(|| OwnBaseline::read(&beside)).transpose()?;
        let rows = own_cost::measured(&mut kept, &corrections, &stops)?;
        let mut costed = Costed { text: own_cost::table(&rows), is_sound: true };
        let now = OwnBaseline::new(kept.method.name(), model, rows);
        if let Some(baseline) = baseline {
            let (text, is_sound) = baseline.judge(&now);
            costed.text.push_str(&text);
            costed.is_sound = is_sound;
        }
        if self.mint {
            let inputs: Vec<&Path> = self.correct.iter().map(PathBuf::as_path).chain([path]).collect();
            files::write_beside(&inputs, &[(beside.clone(), now.to_json())])?;
            costed.text.push_str(&format!("The baseline is {}.\n", beside.display()));
        }
        Ok(costed)
    }

    fn count_instructions(&self, rows: &mut [MeasuredUpdate]) -> Result<(), BenchError> {
        let program = env::current_exe().map_err(|source| BenchError::Valgrind { problem: source.to_string() })?;
        let automaton = |cost: &CostRecord| (cost.series.clone(), cost.method.clone(), cost.nodes, cost.originals);
        let mut first: BTreeMap<_, u64> = BTreeMap::new();
        for MeasuredUpdate { cost, .. } in
            rows.iter().filter(|row| row.cost.nodes * row.cost.originals <= MOST_SEGMENTS)
        {
            let seed = first.entry(automaton(cost)).or_insert(cost.seed);
            *seed = cost.seed.min(*seed);
        }
        for ((series, method, nodes, originals), seed) in first {
            let words = [series.clone(), method.clone(), nodes.to_string(), originals.to_string(), seed.to_string()];
            let arguments = ["cost", "--protocol", &self.protocol, "--one"].map(str::to_owned);
            let counts = valgrind::count(&program, &[&arguments[..], &words].concat())?;
            for (edit, count) in Edit::ALL.into_iter().zip(counts) {
                let name = (series.clone(), method.clone(), nodes, originals);
                let is_it = |row: &&mut MeasuredUpdate| {
                    automaton(&row.cost) == name && row.cost.seed == seed && row.cost.edit == edit
                };
                rows.iter_mut().filter(is_it).for_each(|row| row.instructions = Some(count));
            }
        }
        Ok(())
    }
}

/// The updates that callgrind counts: one of each edit, of one automaton.
fn one_automaton(protocol: &Protocol, words: &[String]) -> Result<(), BenchError> {
    let [series, method, nodes, originals, seed] = words else {
        return Err(BenchError::Argument("`--one`: expected five words".to_owned()));
    };
    let number = |word: &String| {
        word.parse::<u32>().map_err(|_| BenchError::Argument(format!("`--one`: `{word}`: expected a number")))
    };
    let known = protocol.cost.iter().map(|series| series.series.as_str());
    let found = protocol.cost.iter().find(|other| other.series == *series);
    let found = found.ok_or_else(|| BenchError::unknown("cost series", series, known))?;
    let known = method::all();
    let named = method::named(method)
        .ok_or_else(|| BenchError::unknown("method", method, known.iter().map(|method| method.name())))?;
    let subject = Subject::teach(&*named, found.parameters(number(nodes)?, number(originals)?, number(seed)?.into()))?;
    Edit::ALL.into_iter().try_for_each(|edit| subject.measure(&protocol.name, series, edit, 0).map(|_| ()))
}

fn instruction_table(rows: &[MeasuredUpdate]) -> String {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    table.set_header(["series", "method", "edit planted", "nodes", "originals", "instructions"]);
    for MeasuredUpdate { cost, instructions } in rows {
        if let Some(instructions) = instructions {
            let CostRecord { series, method, edit, nodes, originals, .. } = cost;
            let words = [series.clone(), method.clone(), edit.to_string()];
            table.add_row(
                words.into_iter().chain([nodes, originals].map(u32::to_string)).chain([instructions.to_string()]),
            );
        }
    }
    format!("\n## T4 instructions of an update\n\n{table}\n\n")
}

fn verdicts(judged: &[Judged]) -> String {
    let mut text = String::from("## Against the baseline\n\n");
    for Judged { update, verdict, why } in judged {
        let why = if why.is_empty() { String::new() } else { format!(": {why}") };
        text.push_str(&format!("{verdict:<12} {update}{why}\n"));
    }
    let count = |verdict| judged.iter().filter(|judged| judged.verdict == verdict).count();
    let all = [Verdict::Improved, Verdict::Regressed, Verdict::Unchanged, Verdict::Incomparable];
    let counts = all.map(|verdict| format!("{verdict} {}", count(verdict)));
    text + "\n" + &counts.join(", ") + "\n"
}
