//! A method that breaks off takes nobody with it: each way to break off is recorded as what it is, and the sweep goes
//! on.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

use rand_chacha::ChaCha8Rng;
use situ::correction::Correction;
use situ::demonstration::Demonstration;
use situ::error::SituError;
use situ::graph::Graph;
use situ::keyframe::policy::Execution;
use situ::method::{self, Learned, Method, Original, Role};
use situ::place::{NodeId, Place};
use situ::segment::RelativeKeyframe;
use situ::state::{Schema, State};
use situ::trace::Trace;
use situ_bench::external::Methods;
use situ_bench::ledger::{self, Canonical, Ledger};
use situ_bench::plan::{Filter, Plan};
use situ_bench::protocol::Protocol;
use situ_bench::record::{Outcome, Record, RunRecord};
use situ_bench::runner::{Progress, Runner};
use situ_bench::spending::Spending;
use situ_tasks::Registry;
use situ_teachers::Roster;

use crate::small;

/// What goes wrong, and where.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fault {
    /// The correction panics.
    Panics,
    /// The correction is refused.
    Refuses,
    /// Its own model of the original task panics.
    PanicsAtOnce,
    /// After a correction a keyframe is not a number.
    NotANumber,
    /// After a correction a probability is not a number.
    Improbable,
    /// After a correction every keyframe is held for an hour.
    Endless,
}

/// `situ`, until it is corrected.
struct Faulty {
    name: &'static str,
    fault: Fault,
    within: Box<dyn Method>,
}

impl Faulty {
    fn boxed(name: &'static str, fault: Fault) -> Box<dyn Method> {
        Box::new(Self { name, fault, within: method::named("situ").unwrap() })
    }
}

impl Method for Faulty {
    fn name(&self) -> &str {
        self.name
    }

    fn summary(&self) -> &str {
        "breaks off"
    }

    fn source(&self) -> &str {
        "this test"
    }

    fn role(&self) -> Role {
        Role::Correct
    }

    fn original(&self) -> &str {
        if self.fault == Fault::PanicsAtOnce { self.name } else { self.within.original() }
    }

    fn learn_original(&self, schema: &Schema, all: &[Demonstration], seed: u64) -> Result<Original, SituError> {
        assert!(self.fault != Fault::PanicsAtOnce, "nothing can be learned");
        self.within.learn_original(schema, all, seed)
    }

    fn take_over(&self, original: &Original) -> Result<Box<dyn Learned>, SituError> {
        Ok(Box::new(Broken { fault: self.fault, corrected: false, within: self.within.take_over(original)? }))
    }
}

struct Broken {
    fault: Fault,
    corrected: bool,
    within: Box<dyn Learned>,
}

impl Learned for Broken {
    fn correct(&mut self, correction: Correction<'_>) -> Result<Trace, SituError> {
        assert!(self.fault != Fault::Panics, "a correction\nof two lines");
        if self.fault == Fault::Refuses {
            return Err(SituError::NoDemonstration);
        }
        self.corrected = true;
        self.within.correct(correction)
    }

    fn ranked(&self, last: Place, state: &State) -> Result<Vec<(Place, f64)>, SituError> {
        let broken = self.corrected && self.fault == Fault::Improbable;
        let ranked = self.within.ranked(last, state)?.into_iter();
        Ok(ranked.map(|(place, probability)| (place, if broken { f64::NAN } else { probability })).collect())
    }

    fn keyframes(
        &self,
        node: NodeId,
        way: usize,
        state: &State,
        execution: Execution,
        rng: &mut ChaCha8Rng,
    ) -> Result<(Arc<str>, Vec<RelativeKeyframe>), SituError> {
        let (reference, mut keyframes) = self.within.keyframes(node, way, state, execution, rng)?;
        match self.fault {
            Fault::NotANumber if self.corrected => keyframes[0].pose.translation.vector.x = f64::NAN,
            Fault::Endless if self.corrected => keyframes.iter_mut().for_each(|keyframe| keyframe.hold = 3600.0),
            _ => {}
        }
        Ok((reference, keyframes))
    }

    fn graph(&self) -> Result<Graph, SituError> {
        self.within.graph()
    }

    fn boxed(&self) -> Box<dyn Learned> {
        Box::new(Self { fault: self.fault, corrected: self.corrected, within: self.within.boxed() })
    }

    fn to_json(&self) -> serde_json::Value {
        self.within.to_json()
    }
}

struct Silent;

impl Progress for Silent {
    fn at(&self, _: &str) {}
    fn finished(&self) {}
}

const FAULTS: [(&str, Fault); 6] = [
    ("panics", Fault::Panics),
    ("refuses", Fault::Refuses),
    ("panics_at_once", Fault::PanicsAtOnce),
    ("not_a_number", Fault::NotANumber),
    ("improbable", Fault::Improbable),
    ("endless", Fault::Endless),
];

/// The canonical records of the sound method and the faulty ones, by this many threads.
fn records(text: &str, filter: &Filter, faults: &[(&'static str, Fault)], threads: usize) -> Vec<RunRecord> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ledger.jsonl");
    let protocol = Protocol::parse(text, Path::new("small.toml")).unwrap();
    let plan =
        Plan::new(protocol, filter, &Registry::builtin().unwrap(), &Roster::builtin().unwrap(), &Methods::builtin())
            .unwrap();
    let plan = faults.iter().fold(plan, |plan, (name, fault)| plan.with_method(Faulty::boxed(name, *fault)));
    let (ledger, _) = Ledger::open(&path).unwrap();
    let (ledger, stop, spending) = (Mutex::new(ledger), AtomicBool::new(false), Spending::new());
    let (done, progress) = (BTreeSet::new(), &Silent);
    let runner = Runner {
        plan: &plan,
        ledger: &ledger,
        done: &done,
        interrupted: &stop,
        archive: None,
        progress,
        spending: &spending,
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| runner.run()).unwrap();
    let records = Canonical::from(ledger::read(&path).unwrap().records);
    assert_eq!(records.len(), plan.len(), "every run has its record");
    let without_times = records.iter().map(Record::without_times);
    without_times.filter_map(|record| if let Record::Run(run) = record { Some(run) } else { None }).collect()
}

#[test]
fn each_way_to_break_off_is_recorded_as_what_it_is() {
    let text = small::physics(r#"["situ"]"#).replace("[budget]", "[budget]\nsteps = 60000");
    let filter = Filter { variations: vec!["bump".to_owned()], ..Filter::default() };
    let runs = records(&text, &filter, &FAULTS, 2);
    assert_eq!(runs, records(&text, &filter, &FAULTS, 1), "whatever the number of threads");
    let of = |name: &str| runs.iter().find(|run| run.key.method == name).unwrap();
    assert_eq!(of("situ").outcome, Outcome::Reached, "the sound one is as ever");
    let method_error = |why: &str| Outcome::MethodError { why: why.to_owned() };
    let expected = [
        ("panics", Outcome::Panicked { why: "a correction\nof two lines".to_owned() }),
        ("refuses", method_error(&SituError::NoDemonstration.to_string())),
        ("panics_at_once", Outcome::Panicked { why: "nothing can be learned".to_owned() }),
        ("endless", Outcome::TimedOut { why: "more than 60000 steps of the physics (`budget.steps`)".to_owned() }),
    ];
    for (name, outcome) in expected {
        assert_eq!(of(name).outcome, outcome, "{name}");
    }
    for (name, problem) in [("not_a_number", "keyframe 0: expected finite"), ("improbable", "probability NaN")] {
        let outcome = &of(name).outcome;
        assert!(matches!(outcome, Outcome::MethodError { why } if why.contains(problem)), "{name}: {outcome:?}");
    }
    for (name, _) in FAULTS {
        let run = of(name);
        assert_eq!((run.after.unwrap().successes, run.after.unwrap().rollouts), (0, 2), "{name}");
        assert!(!run.is_reached() && run.charged() == run.budget && run.outcome.counts(), "{name}");
    }
}

/// A stage that breaks off is the end of those after it; the stages before it stay as they were.
#[test]
fn a_sequence_ends_where_it_breaks_off() {
    let filter = Filter { sequences: vec!["workshop".to_owned()], ..Filter::default() };
    let runs = records(&small::physics(r#"["no_update"]"#), &filter, &FAULTS[..1], 2);
    let stages = runs.iter().filter(|run| run.key.method == "no_update").count();
    assert!(stages > 1);
    let own: Vec<_> = runs.iter().filter(|run| run.key.method == "panics").collect();
    assert_eq!(own.len(), stages);
    let first = own.iter().position(|run| run.outcome.is_failure()).unwrap();
    assert!(own[first..].iter().all(|run| matches!(run.outcome, Outcome::Panicked { .. })));
}
