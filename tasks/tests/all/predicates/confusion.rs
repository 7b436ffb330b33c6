//! Counting: how often a condition and the labels of states agreed.
//!
//! A label is the kind of a state, and the kind is how the state was made. Beside the label stands the word of an
//! oracle, a measurement that shares no code with the conditions. Where label and oracle differ, the state is not what
//! it was meant to be, and the test fails, as it does when the condition is wrong. No state is left out of the count
//! because it does not suit.

use std::fmt::Write as _;

use situ_tasks::Predicate;

use crate::predicates::scene::Scene;

/// The fewest states of a condition.
const LEAST_STATES: usize = 40;
/// The fewest states of either kind.
const LEAST_OF_A_KIND: usize = 10;

/// How a state came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// The condition was brought about.
    True,
    /// All but brought about.
    NearMiss,
    /// Brought about, and then undone.
    DroppedLater,
}

/// One labelled state, and what was said of it.
#[derive(Debug)]
struct State {
    kind: Kind,
    condition: String,
    made: String,
    holds: bool,
    oracle: bool,
}

impl State {
    fn label(&self) -> bool {
        self.kind == Kind::True
    }
}

/// All labelled states of one condition.
#[derive(Debug)]
pub(crate) struct Labels {
    word: &'static str,
    states: Vec<State>,
}

impl Labels {
    pub(crate) fn new(word: &'static str) -> Labels {
        Labels { word, states: Vec::new() }
    }

    /// A state in which the condition is fulfilled. `how` says how it was made. `oracle` is what was found out without
    /// the condition.
    pub(crate) fn truly(&mut self, scene: &Scene, condition: &str, how: &str, oracle: bool) {
        self.add(Kind::True, scene, condition, how, oracle);
    }

    /// A state in which the condition is all but fulfilled.
    pub(crate) fn near_miss(&mut self, scene: &Scene, condition: &str, how: &str, oracle: bool) {
        self.add(Kind::NearMiss, scene, condition, how, oracle);
    }

    /// A state in which the condition is fulfilled no longer.
    pub(crate) fn dropped_later(&mut self, scene: &Scene, condition: &str, how: &str, oracle: bool) {
        self.add(Kind::DroppedLater, scene, condition, how, oracle);
    }

    fn add(&mut self, kind: Kind, scene: &Scene, condition: &str, how: &str, oracle: bool) {
        assert!(condition.starts_with(self.word), "{condition} among the states of {}", self.word);
        let predicate = Predicate::parse(condition).unwrap_or_else(|error| panic!("{condition}: {error}"));
        let holds = scene.holds(&predicate);
        let (condition, made) = (condition.to_owned(), format!("{}: {how}", scene.label()));
        self.states.push(State { kind, condition, made, holds, oracle });
    }

    fn count(&self, is_counted: impl Fn(&State) -> bool) -> usize {
        self.states.iter().filter(|state| is_counted(state)).count()
    }

    fn of_kind(&self, kind: Kind) -> usize {
        self.count(|state| state.kind == kind)
    }

    /// True positives, false positives, false negatives, true negatives.
    fn confusion(&self) -> [usize; 4] {
        [(true, true), (true, false), (false, true), (false, false)]
            .map(|cell| self.count(|state| (state.holds, state.label()) == cell))
    }

    /// A row of [`table`].
    fn row(&self) -> String {
        let [tp, fp, fn_, tn] = self.confusion();
        let [truly, near, dropped] = [Kind::True, Kind::NearMiss, Kind::DroppedLater].map(|kind| self.of_kind(kind));
        let part = |of: usize, all: usize| if all == 0 { f64::NAN } else { of as f64 / all as f64 };
        let (precision, recall) = (part(tp, tp + fp), part(tp, tp + fn_));
        let word = self.word;
        format!("| {word} | {truly} | {near} | {dropped} | {tp} | {fp} | {fn_} | {tn} | {precision:.3} | {recall:.3} |")
    }

    /// All that is wrong: mistakes of the condition, states that are not what they were meant to be, states that are
    /// missing.
    pub(crate) fn complaints(&self) -> Vec<String> {
        let mut complaints = Vec::new();
        for State { kind, condition, made, holds, oracle } in &self.states {
            let label = *kind == Kind::True;
            if *holds != label {
                complaints.push(format!("{condition} is {holds} in a state of kind {kind:?}; {made}"));
            }
            if *oracle != label {
                complaints.push(format!("the oracle of {condition} says {oracle} of kind {kind:?}; {made}"));
            }
        }
        if self.states.len() < LEAST_STATES {
            complaints.push(format!("{} has only {} states", self.word, self.states.len()));
        }
        for kind in [Kind::True, Kind::NearMiss, Kind::DroppedLater] {
            if self.of_kind(kind) < LEAST_OF_A_KIND {
                complaints.push(format!("{} has only {} states of kind {kind:?}", self.word, self.of_kind(kind)));
            }
        }
        complaints
    }
}

/// The counts as Markdown.
pub(crate) fn table(all: &[Labels]) -> String {
    let mut table = String::from(
        "| predicate | true | near miss | dropped later | TP | FP | FN | TN | precision | recall |\n\
         |---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
    );
    for labels in all {
        let _ = writeln!(table, "{}", labels.row());
    }
    table
}
