//! What an external method was told: its model, as far as we hold one.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use serde_json::{Map, Value, json};
use situ::demonstration::Demonstration;
use situ::state::State;

/// A demonstration as a method was told it: its name, the number of keyframes of each segment, and the state in which
/// each segment begins.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shown {
    pub(super) name: String,
    pub(super) lengths: Vec<usize>,
    pub(super) starts: Vec<State>,
}

impl Shown {
    /// A demonstration, cut into segments of these lengths.
    ///
    /// # Errors
    /// What was expected, where they are not all of its keyframes.
    pub(super) fn cut(demonstration: &Demonstration, lengths: Vec<usize>) -> Result<Self, String> {
        let keyframes = demonstration.keyframes();
        if lengths.contains(&0) || lengths.iter().sum::<usize>() != keyframes.len() {
            let (name, count) = (demonstration.name(), keyframes.len());
            return Err(format!("segments {lengths:?} of `{name}`: expected lengths above 0 that add up to {count}"));
        }
        let first = |(start, _): &(usize, usize)| keyframes[*start].state.clone();
        let starts = starts(&lengths).map(|start| first(&start)).collect();
        Ok(Self { name: demonstration.name().to_string(), lengths, starts })
    }
}

/// Where segments of these lengths begin, and how long each is.
fn starts(lengths: &[usize]) -> impl Iterator<Item = (usize, usize)> {
    lengths.iter().scan(0, |next, length| {
        *next += length;
        Some((*next - length, *length))
    })
}

/// The questions that made a model, the last of them and those before it.
#[derive(Debug)]
pub(super) struct Told {
    /// No two have one.
    pub(super) id: u64,
    before: Option<Arc<Told>>,
    pub(super) question: Map<String, Value>,
    /// All demonstrations up to this one, in order.
    pub(super) shown: Vec<Shown>,
    /// The model as the method saves it; `None` where it does not.
    pub(super) saved: OnceLock<Option<Value>>,
}

impl Told {
    pub(super) fn new(before: Option<Arc<Self>>, question: Map<String, Value>, shown: Vec<Shown>) -> Arc<Self> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let id = NEXT.fetch_add(1, Ordering::Relaxed);
        Arc::new(Self { id, before, question, shown, saved: OnceLock::new() })
    }

    /// The questions from the first to the last.
    pub(super) fn questions(&self) -> Vec<&Map<String, Value>> {
        let mut questions: Vec<_> = std::iter::successors(Some(self), |told| told.before.as_deref()).collect();
        questions.reverse();
        questions.into_iter().map(|told| &told.question).collect()
    }

    /// All of it.
    pub(super) fn to_json(&self) -> Value {
        let shown = |shown: &Shown| json!({"name": shown.name, "lengths": shown.lengths, "starts": shown.starts});
        json!({"told": self.questions(), "shown": self.shown.iter().map(shown).collect::<Vec<_>>()})
    }

    /// The same again; `None` where it is something else.
    pub(super) fn from_json(value: &Value) -> Option<Arc<Self>> {
        let shown = |shown: &Value| {
            Some(Shown {
                name: shown.get("name")?.as_str()?.to_owned(),
                lengths: serde_json::from_value(shown.get("lengths")?.clone()).ok()?,
                starts: serde_json::from_value(shown.get("starts")?.clone()).ok()?,
            })
        };
        let shown: Vec<Shown> = value.get("shown")?.as_array()?.iter().map(shown).collect::<Option<_>>()?;
        let questions = value.get("told")?.as_array()?;
        let originals = shown.len().checked_sub(questions.len().checked_sub(1)?)?;
        let mut told = None;
        for (index, question) in questions.iter().enumerate() {
            told = Some(Self::new(told, question.as_object()?.clone(), shown[..originals + index].to_vec()));
        }
        told
    }
}
