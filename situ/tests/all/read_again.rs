//! A model that was written is read again, and is the model that it was.

use std::collections::BTreeSet;

use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use situ::correction::Correction;
use situ::demonstration::Demonstration;
use situ::error::SituError;
use situ::keyframe::policy::Execution;
use situ::method::{Learned, Method, all, keyframe_method, named};
use situ::place::Place;

use crate::common::soak;
use crate::common::{CAREFUL, Correction as Shown, Planted, Task};

const SEED: u64 = 5;
const PLANTED: [Planted; 4] = [Planted::NewNode, Planted::SelfLoop, Planted::Modified, Planted::NewNode];

fn task() -> Task {
    Task::new(5, 5, 3)
}

/// All that is asked of a model at the states of a demonstration, bit for bit.
fn answers(model: &dyn Learned, shown: &Demonstration) -> Value {
    let graph = model.graph().unwrap();
    let places: Vec<Place> = graph.nodes.iter().map(|node| Place::Node(node.id)).chain([Place::Start]).collect();
    let mut found = Vec::new();
    for keyframe in shown.keyframes() {
        for place in &places {
            found.push(json!(model.ranked(*place, &keyframe.state).unwrap()));
            let Some(id) = place.node() else { continue };
            for way in model.ways(id, &keyframe.state).unwrap() {
                let mut rng = ChaCha8Rng::seed_from_u64(1);
                found.push(json!(model.keyframes(id, way, &keyframe.state, Execution::Sample, &mut rng).unwrap()));
            }
        }
    }
    found.push(json!(format!("{:?}", model.held_out(shown))));
    json!(found)
}

/// The model of a file with this text.
fn read(method: &dyn Method, task: &Task, text: &str) -> Result<Box<dyn Learned>, SituError> {
    method.read(&task.schema, serde_json::from_str(text).unwrap(), SEED)
}

fn correct(model: &mut dyn Learned, shown: &Shown) -> Result<(), SituError> {
    let last = shown.last_in(&model.graph()?);
    let oracle = shown.oracle();
    model.correct(Correction { oracle: Some(&oracle), ..Correction::after(last, &shown.demonstration) }).map(drop)
}

/// Written and read after each correction, it is what it becomes in one go, number for number.
#[test]
fn a_model_that_is_read_is_the_model_that_was_written() {
    let task = task();
    let readable: BTreeSet<String> = keyframe_method::all().iter().map(|method| method.name().to_owned()).collect();
    for method in all() {
        let name = method.name();
        let mut at_once = method.teach(&task.schema, &task.originals(3, CAREFUL), SEED).unwrap();
        let text = at_once.to_json().to_string();
        if !readable.contains(name) {
            let refused = read(&*method, &task, &text).err();
            assert_eq!(refused, Some(SituError::Unreadable { method: name.to_owned() }));
            continue;
        }
        let mut in_parts = read(&*method, &task, &text).unwrap();
        for (draw, planted) in (0..).zip(PLANTED) {
            let shown = task.correction(planted, draw, CAREFUL, draw % 2 == 0);
            let [one, other] = [&in_parts, &at_once].map(|model| answers(&**model, &shown.demonstration));
            assert!(one == other, "{name}, before correction {draw}");
            correct(&mut *at_once, &shown).unwrap();
            correct(&mut *in_parts, &shown).unwrap();
            let text = in_parts.to_json().to_string();
            let of_one_go = at_once.to_json().to_string();
            assert!(text == of_one_go, "{name}, correction {draw}");
            in_parts = read(&*method, &task, &text).unwrap();
            let again = in_parts.to_json().to_string();
            assert!(again == text, "{name}, correction {draw}");
        }
    }
}

/// The number of values in it, each object, list, text and number.
fn size(value: &Value) -> usize {
    1 + match value {
        Value::Array(items) => items.iter().map(size).sum(),
        Value::Object(entries) => entries.values().map(size).sum(),
        _ => 0,
    }
}

/// The value of this number, counted as by [`size`].
fn nth<'a>(value: &'a mut Value, left: &mut usize) -> Option<&'a mut Value> {
    if *left == 0 {
        return Some(value);
    }
    *left -= 1;
    match value {
        Value::Array(items) => items.iter_mut().find_map(|item| nth(item, left)),
        Value::Object(entries) => entries.values_mut().find_map(|entry| nth(entry, left)),
        _ => None,
    }
}

/// What a hostile hand writes in the place of a value.
fn spoilt(value: &Value, how: usize) -> Value {
    let number = value.as_f64();
    match (how, value) {
        (0, _) => Value::Null,
        (1, Value::Number(_)) => json!(-number.unwrap_or(1.0)),
        (2, Value::Number(_)) => json!(1e300),
        (3, Value::Number(_)) => json!(4_000_000_000_u32),
        (4, Value::Number(_)) => json!(0),
        (5, Value::Number(_)) => json!(1e-300),
        (6, Value::Number(_)) => json!(number.unwrap_or(1.0) + 1.0),
        (1 | 2, Value::Array(items)) => json!(items[..items.len() / 2].to_vec()),
        (3 | 4, Value::Array(items)) => json!(items.iter().chain(items).cloned().collect::<Vec<_>>()),
        (1..=3, Value::Object(entries)) => Value::Object(entries.clone().into_iter().skip(1).collect()),
        (1..=3, Value::String(_)) => json!("nothing"),
        (1..=3, Value::Bool(value)) => json!(!value),
        _ => json!([]),
    }
}

proptest! {
    #![proptest_config(soak::config(400))]

    /// What cannot be a model is refused in words; what can be one is executed and corrected without a panic.
    #[test]
    fn no_model_that_is_read_ends_the_program(at in any::<usize>(), how in 0_usize..7, corrected in any::<bool>()) {
        let task = task();
        let method = named("situ").unwrap();
        let mut model = method.teach(&task.schema, &task.originals(3, CAREFUL), SEED).unwrap();
        if corrected {
            correct(&mut *model, &task.correction(Planted::Modified, 0, CAREFUL, true)).unwrap();
        }
        let mut value = model.to_json();
        let mut left = at % size(&value);
        let place = nth(&mut value, &mut left).unwrap();
        *place = spoilt(place, how);
        match read(&*method, &task, &value.to_string()) {
            Err(SituError::Model { place, problem }) => prop_assert!(!place.is_empty() && !problem.is_empty()),
            Err(other) => prop_assert!(false, "{other}"),
            Ok(mut model) => {
                let shown = task.correction(Planted::NewNode, 1, CAREFUL, true);
                answers(&*model, &shown.demonstration);
                drop(correct(&mut *model, &shown));
                answers(&*model, &shown.demonstration);
            }
        }
    }
}
