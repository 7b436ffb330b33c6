//! Where the time of a run goes: by task family and by phase.

use std::collections::BTreeMap;
use std::sync::Mutex;

use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};
use situ_sim::DT;

use crate::cost;

/// A part of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RunPhase {
    /// Whole demonstrations, what is learned of them, and the rollouts that say whether it is enough.
    Teach,
    /// Rollouts on the changed task: before the first correction and after each.
    Evaluate,
    /// A failure under a teacher's eyes, the correction from there, and the update.
    Correct,
    /// Rollouts of a corrected model on the original task, or on the earlier tasks of a sequence.
    Retain,
    /// The model that learned all demonstrations at once, and its rollouts.
    Pool,
}

impl RunPhase {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Teach => "teach",
            Self::Evaluate => "evaluate",
            Self::Correct => "correct",
            Self::Retain => "retain",
            Self::Pool => "pool",
        }
    }
}

/// What was spent on something.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// Rollouts, demonstrations and updates.
    pub pieces: u64,
    /// Steps of the physics that were simulated.
    pub simulated: u64,
    /// Steps that were not simulated because the memo had them.
    pub replayed: u64,
    /// Processor seconds.
    pub seconds: f64,
}

impl std::ops::AddAssign for Spent {
    fn add_assign(&mut self, other: Spent) {
        self.pieces += other.pieces;
        self.simulated += other.simulated;
        self.replayed += other.replayed;
        self.seconds += other.seconds;
    }
}

/// The steps of a piece of work: those that were simulated, and those that the memo had.
#[derive(Clone, Copy, Debug, Default)]
pub struct Steps {
    /// Simulated.
    pub simulated: u64,
    /// Not simulated.
    pub replayed: u64,
}

/// Where the time of a run goes.
#[derive(Debug, Default)]
pub struct Spending(Mutex<BTreeMap<(String, RunPhase), Spent>>);

impl Spending {
    /// Nothing was spent yet.
    pub const fn new() -> Self {
        Self(Mutex::new(BTreeMap::new()))
    }

    /// Does a piece of work on this thread, and adds what was spent on it. `steps` reads the steps off its result.
    pub fn spend<T>(
        &self,
        task: &str,
        phase: RunPhase,
        work: impl FnOnce() -> T,
        steps: impl FnOnce(&T) -> Steps,
    ) -> T {
        let (result, seconds) = cost::processor_timed(work);
        let Steps { simulated, replayed } = steps(&result);
        let spent = Spent { pieces: 1, simulated, replayed, seconds };
        *self.0.lock().expect("no holder of the spending panics").entry((task.to_owned(), phase)).or_default() += spent;
        result
    }

    /// The rows, with the sums over the phases of each family and over everything.
    pub fn rows(&self) -> Vec<(String, &'static str, Spent)> {
        let spent = self.0.lock().expect("no holder of the spending panics");
        let (mut rows, mut all) = (Vec::new(), Spent::default());
        let mut tasks: Vec<&String> = spent.keys().map(|(task, _)| task).collect();
        tasks.dedup();
        for task in tasks {
            let mut sum = Spent::default();
            for ((_, phase), spent) in spent.iter().filter(|((of, _), _)| of == task) {
                rows.push((task.clone(), phase.name(), *spent));
                sum += *spent;
            }
            rows.push((task.clone(), "all", sum));
            all += sum;
        }
        rows.push(("all".to_owned(), "all", all));
        rows
    }

    /// The rows as a table, for people.
    pub fn table(&self) -> String {
        let rows = self.rows();
        let total = rows.last().map_or(0.0, |(.., all)| all.seconds);
        let mut table = Table::new();
        table.load_style(ASCII_MARKDOWN).set_header([
            "task",
            "phase",
            "pieces",
            "processor s",
            "share %",
            "simulated s",
            "replayed s",
            "× real time",
        ]);
        for (task, phase, Spent { pieces, simulated, replayed, seconds }) in rows {
            let simulated = simulated as f64 * DT;
            table.add_row([
                task,
                phase.to_owned(),
                pieces.to_string(),
                format!("{seconds:.2}"),
                format!("{:.1}", 100.0 * seconds / total.max(f64::MIN_POSITIVE)),
                format!("{simulated:.0}"),
                format!("{:.0}", replayed as f64 * DT),
                if seconds > 0.0 { format!("{:.0}", simulated / seconds) } else { "–".to_owned() },
            ]);
        }
        table.column_iter_mut().skip(2).for_each(|column| column.set_cell_alignment(CellAlignment::Right));
        format!("{table}\n")
    }
}
