//! `situ-bench`: the benchmark of learning from corrective demonstrations. Each verb explains itself with `--help`.
//!
//! Exit status: 0; 1 where the machine failed (a disk, say) or a check did; 2 where the input was bad, and then nothing
//! is written by halves; 130 where the user interrupted it. A run that broke off is recorded as that, and is no failure
//! of the program.

use std::io::{self, ErrorKind, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use situ_bench::cmd::{
    ask::Ask, check::Check, cost::Cost, export::Export, import::Import, learn::Learn, list::List, merge::Merge,
    run::Run, say, serve::Serve, show::Show, supersede::Supersede, tables::Tables,
};
use situ_bench::error::BenchError;

/// The benchmark of learning from corrective demonstrations: task models as automata of primitives, what it takes to
/// correct them, and what an update costs.
#[derive(Parser)]
#[command(
    name = "situ-bench",
    version,
    after_help = "Without a verb: run.

Examples:
  situ-bench run --task pour
  situ-bench show pour/lid --failure
  situ-bench check pour
  situ-bench list methods
  situ-bench tables quick.jsonl --out tables
  situ-bench import recording.csv --mapping mapping.toml --out shown
  situ-bench learn original.json --correct correction.json --dot model.dot
  situ-bench ask model.json '{\"do\": \"graph\"}'

Exit status: 0; 1 where the machine or a check failed; 2 where the input was bad; 130 where it was interrupted. A run \
that broke off is in the ledger and in the table `endings`, and no failure of the program."
)]
struct Arguments {
    #[command(subcommand)]
    verb: Option<Verb>,
}

#[derive(Subcommand)]
enum Verb {
    Run(Run),
    Check(Check),
    Cost(Cost),
    List(List),
    Merge(Merge),
    Tables(Tables),
    Learn(Learn),
    Ask(Ask),
    Import(Import),
    Export(Export),
    Serve(Serve),
    Show(Show),
    Supersede(Supersede),
}

fn main() -> ExitCode {
    let verb = Arguments::parse().verb.or_else(|| Arguments::parse_from(["situ-bench", "run"]).verb);
    let result = match verb.expect("`run` is a verb") {
        Verb::Run(run) => run.run().and_then(|text| print(&text)),
        Verb::Check(check) => match check.run().and_then(|checked| print(&checked.text).map(|()| checked.is_sound)) {
            Ok(false) => return ExitCode::FAILURE,
            result => result.map(|_| ()),
        },
        Verb::Cost(cost) => match cost.run().and_then(|costed| print(&costed.text).map(|()| costed.is_sound)) {
            Ok(false) => return ExitCode::FAILURE,
            result => result.map(|_| ()),
        },
        Verb::List(list) => list.run().and_then(|text| print(&text)),
        Verb::Merge(merge) => merge.run().and_then(|text| print(&text)),
        Verb::Tables(tables) => tables.run().and_then(|printed| {
            printed.warnings.iter().for_each(|warning| say(&format!("warning: {warning}")));
            print(&printed.text)
        }),
        Verb::Learn(learn) => learn.run().and_then(|text| print(&text)),
        Verb::Ask(ask) => ask.run().and_then(|text| print(&text)),
        Verb::Export(export) => export.run().and_then(|text| print(&text)),
        Verb::Import(import) => import.run().and_then(|text| print(&text)),
        Verb::Serve(serve) => serve.run().and_then(|text| print(&text)),
        Verb::Show(show) => show.run().and_then(|text| print(&text)),
        Verb::Supersede(supersede) => supersede.run().and_then(|text| print(&text)),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(&format!("error: {error}"));
            ExitCode::from(error.exit_status())
        }
    }
}

/// Prints to standard output. It is no failure where the reader has closed the pipe.
fn print(text: &str) -> Result<(), BenchError> {
    match io::stdout().write_all(text.as_bytes()) {
        Err(source) if source.kind() != ErrorKind::BrokenPipe => {
            Err(BenchError::Write { path: PathBuf::from("standard output"), source })
        }
        _ => Ok(()),
    }
}
