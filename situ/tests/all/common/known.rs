//! What a model must do with what it knows after a correction: obey (decision D22), and keep its ways (decision D20).

use situ::decisions::Decisions;
use situ::demonstration::Demonstration;
use situ::place::Place;
use situ::primitive::{Initiation, Learner};
use situ::state::State;
use situ::task_model::TaskModel;
use situ::trace::{Obedience, Step, Trace};
use situ::worlds::MARGIN;

/// D22: of every segment of the last correction, and of its end, the place that is chosen after what ran before it, in
/// the state in which it began, is what was shown. The trace counts the others.
pub(crate) fn obeys<L: Learner>(model: &TaskModel<L>, trace: &Trace, decisions: &Decisions) {
    let (demonstration, history) = (0..).zip(model.histories()).last().unwrap();
    let origin = history.after.map_or(Place::Start, |after| Place::Node(model.node_of(after).unwrap()));
    let shown = history.nodes.iter().map(|node| Place::Node(*node)).chain(history.carried_to_end.then_some(Place::End));
    let starts = history.segments.iter().map(|segment| &segment.start).chain([&history.final_state]);
    let before = [origin].into_iter().chain(shown.clone());
    let lessons: Vec<(Place, &State, Place)> =
        before.zip(starts).zip(shown).map(|((before, state), shown)| (before, state, shown)).collect();
    let (mut aliased, mut disobeyed) = (0, 0);
    for (index, (before, state, shown)) in lessons.iter().enumerate() {
        let chosen = model.most_probable_child(*before, state).unwrap().0;
        if chosen == *shown {
            continue;
        }
        if lessons[index + 1..].iter().any(|(place, _, later)| place == before && *later == chosen) {
            aliased += 1;
        } else {
            disobeyed += 1;
        }
    }
    if decisions.obey {
        assert_eq!((aliased, disobeyed), (trace.obedience.aliased, trace.obedience.disobeyed), "{demonstration}");
    } else {
        assert_eq!(trace.obedience, Obedience::default());
    }
}

/// In every state of a demonstration every place has a probability from 0 to 1, and the child that is chosen is one.
pub(crate) fn every_probability_is_one<L: Learner>(model: &TaskModel<L>, shown: &Demonstration) {
    let states = shown.keyframes().iter().map(|keyframe| &keyframe.state).chain([shown.final_state()]);
    let places = model.nodes().map(|(id, _)| Place::Node(id)).chain([Place::Start]);
    let places: Vec<Place> = places.collect();
    for state in states {
        for (id, node) in model.nodes() {
            let probability = node.classifier.probability(state);
            assert!((0.0..=1.0).contains(&probability), "{id}: {probability}");
        }
        for place in &places {
            let Some((child, probability)) = model.most_probable_child(*place, state) else {
                assert_eq!(model.children(*place).count(), 0, "{place}");
                continue;
            };
            assert!((0.0..=1.0).contains(&probability) && model.children(*place).any(|other| other == child));
        }
    }
}

/// Whether some feature lies beyond all states of the older on one side, by more than their own range and the margin.
fn are_told_apart(older: &[&State], newer: &[&State], scales: &[f64]) -> bool {
    let is_told = |(feature, scale): (usize, &f64)| {
        let values = |states: &[&State]| {
            let mut values: Vec<f64> = states.iter().map(|state| state.values()[feature] / scale).collect();
            values.sort_by(f64::total_cmp);
            (values[0], values[values.len() - 1])
        };
        let ((low, high), (least, most)) = (values(older), values(newer));
        let apart = if least > high { least - high } else { low - most };
        apart > high - low && apart > MARGIN
    };
    !older.is_empty() && !newer.is_empty() && scales.iter().enumerate().any(is_told)
}

/// D20: wherever a way is known to be right, it runs, unless a newer one cannot be told apart from it. The newest runs
/// in any case.
pub(crate) fn ways_keep_what_they_know<L: Learner>(model: &TaskModel<L>, learner: &L) {
    for (id, node) in model.nodes() {
        let wanted: Vec<Vec<&State>> =
            node.ways.iter().map(|way| way.wanted.iter().map(|sample| model.state(*sample)).collect()).collect();
        for (way, states) in wanted.iter().enumerate() {
            let is_told = wanted[way + 1..].iter().all(|newer| are_told_apart(states, newer, learner.scales()));
            for state in states {
                let runs = model.way_in(id, state, learner.scales()).unwrap();
                assert!(!is_told || runs == way, "{id}: way {runs} of {} runs for {way}", node.ways.len());
                if node.ways.len() == 2 && way == 0 {
                    assert_eq!(runs == 0, is_told, "{id}: of two, the older runs only where it is told apart");
                }
            }
        }
    }
}

/// D20: a new way leaves the others as they are. Where there are too many, the oldest goes that a correction added.
pub(crate) fn a_new_way_changes_no_other<L: Learner>(
    before: &TaskModel<L>,
    after: &TaskModel<L>,
    step: &Step,
    decisions: &Decisions,
) {
    let Ok(old) = before.node(step.node) else { return };
    let ways = &after.node(step.node).unwrap().ways;
    let (_, older) = ways.split_last().unwrap();
    let mut kept = old.ways.clone();
    if kept.len() == decisions.ways.most() {
        let corrective = kept.iter().position(|way| way.is_corrective);
        kept.remove(corrective.unwrap_or(0));
    }
    assert_eq!(older, kept, "{}", step.node);
}
