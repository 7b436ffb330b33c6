//! What every method owes, and whether one does it: on a small synthetic automaton, without physics.

use std::collections::BTreeSet;
use std::fmt::Write;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use situ::correction::Correction;
use situ::edit::{Edit, difference};
use situ::graph::Graph;
use situ::keyframe::policy::Execution;
use situ::method::{Learned, Method, Role};
use situ::place::Place;
use situ::segment::RelativeKeyframe;
use situ::state::State;

use crate::cost::timed;
use crate::error::BenchError;
use crate::synthetic::{Automaton, Parameters};

/// The primitives of the automaton.
const NODES: usize = 10;
/// The seed of the automaton, of the method and of what is drawn.
const SEED: u64 = 1;
/// The most primitives on the way through the automaton.
const LONGEST: usize = 4 * NODES;

/// What is owed: what it is, and what is wrong with it where something is.
type Owed = (&'static str, Result<(), String>);

/// All that a model answers about some states.
#[derive(PartialEq)]
struct Answers {
    graph: Graph,
    ranked: Vec<Vec<(Place, f64)>>,
    executed: Vec<(String, Vec<RelativeKeyframe>)>,
}

impl Answers {
    /// Whether a model makes nothing else of things. The demonstrations themselves are counted here, whatever the
    /// method makes of them.
    fn says_the_same(&self, other: &Self) -> bool {
        let structure = |of: &Self| (of.graph.nodes.clone(), of.graph.edges.clone());
        self.ranked == other.ranked && self.executed == other.executed && structure(self) == structure(other)
    }
}

/// Checks a method. Returns what is said about it, and what is wrong.
pub(super) fn said(method: &dyn Method) -> Result<(String, Vec<String>), BenchError> {
    let automaton = Automaton::new(Parameters::of(NODES, SEED))?;
    let mut times = Times::default();
    let owed = owed(method, &automaton, &mut times);
    let mut text = format!("{}: {}\n\n", method.name(), method.summary());
    let mut findings = Vec::new();
    for (what, result) in &owed {
        let _ = writeln!(text, "{}  {what}", if result.is_ok() { "ok   " } else { "wrong" });
        findings.extend(result.as_ref().err().map(|problem| format!("{what}: {problem}")));
    }
    if findings.is_empty() {
        text.push_str(&times.words());
    }
    Ok((text, findings))
}

/// Seconds of calls of each kind.
#[derive(Default)]
struct Times {
    teach: Vec<f64>,
    next: Vec<f64>,
    keyframes: Vec<f64>,
    correct: Vec<f64>,
}

impl Times {
    fn words(&self) -> String {
        let mean = |of: &[f64]| 1e3 * of.iter().sum::<f64>() / of.len().max(1) as f64;
        let calls = [("teach", &self.teach), ("next", &self.next), ("keyframes", &self.keyframes)];
        let mut text = "\nA call takes on average, in milliseconds:".to_owned();
        for (name, of) in calls.into_iter().chain([("correct", &self.correct)]).filter(|(_, of)| !of.is_empty()) {
            let _ = write!(text, " {name} {:.3}", mean(of));
        }
        text + ".\n"
    }
}

fn owed(method: &dyn Method, automaton: &Automaton, times: &mut Times) -> Vec<Owed> {
    let (schema, originals) = (automaton.schema(), automaton.originals());
    let mut owed: Vec<Owed> = Vec::new();
    let mut teach = || {
        let (learned, seconds) = timed(|| method.teach(schema, originals, SEED));
        times.teach.push(seconds);
        learned.map_err(|error| error.to_string())
    };
    let learned = match teach() {
        Ok(learned) => learned,
        Err(problem) => {
            owed.push(("it learns an original task", Err(problem)));
            return owed;
        }
    };
    owed.push(("it learns an original task", Ok(())));
    let again = teach();
    let before = match answers(&*learned, automaton, times) {
        Ok(answers) => answers,
        Err(problem) => {
            owed.push(("it answers every question", Err(problem)));
            return owed;
        }
    };
    owed.push(("it answers every question", Ok(())));
    owed.push(("its structure is of what it was shown", holds(&before.graph, originals.len())));
    owed.push(("what may follow has probabilities, the likeliest first", rank(&before)));
    owed.push((
        "what is performed is a list of sound keyframes about an object of the task",
        perform(&before, automaton),
    ));
    owed.push(("it does what it was shown", follows(&*learned, automaton)));
    let is_same = again.and_then(|again| answers(&*again, automaton, times)).and_then(|again| same(&again, &before));
    owed.push(("taught the same again, with the same seed, it is the same", is_same));
    owed.push(("it draws from the seed it is given alone", draws(&*learned, automaton)));
    owed.extend(corrected(method, &*learned, automaton, &before, times));
    owed
}

/// What comes of corrections. A control is not corrected by anybody; what is taught anew is never corrected at all.
fn corrected(
    method: &dyn Method,
    learned: &dyn Learned,
    automaton: &Automaton,
    before: &Answers,
    times: &mut Times,
) -> Vec<Owed> {
    if method.role() != Role::Correct {
        return Vec::new();
    }
    let (mut learns, mut knows, mut can, mut keeps) = (Ok(()), Ok(()), Ok(()), Ok(()));
    let note = |owed: &mut Result<(), String>, edit: Edit, problem: String| {
        if owed.is_ok() {
            *owed = Err(format!("a correction that needs {edit}: {problem}"));
        }
    };
    for edit in Edit::ALL {
        let Ok(planted) = automaton.plant(edit, SEED) else { continue };
        let Some(last) = planted.last(&before.graph) else {
            note(&mut keeps, edit, "no primitive holds the segment after which it begins".to_owned());
            continue;
        };
        let mut model = learned.boxed();
        let (trace, seconds) = timed(|| model.correct(Correction::after(last, &planted.demonstration)));
        times.correct.push(seconds);
        let after = trace.map_err(|error| error.to_string()).and_then(|_| answers(&*model, automaton, times));
        let after = match after {
            Ok(after) => after,
            Err(problem) => {
                note(&mut learns, edit, problem);
                continue;
            }
        };
        if let Err(problem) = holds(&after.graph, automaton.originals().len() + 1).and_then(|()| rank(&after)) {
            note(&mut learns, edit, problem);
        }
        let made = difference(&before.graph, &after.graph).edit();
        if !method.edits().contains(&made) {
            note(&mut can, edit, format!("it made the edit {made}, which it does not say that it can"));
        }
        if after.says_the_same(before) {
            note(&mut knows, edit, "every answer is as it was".to_owned());
        }
        match answers(learned, automaton, times).and_then(|own| same(&own, before)) {
            Ok(()) => {}
            Err(problem) => note(&mut keeps, edit, format!("the model that was copied before it: {problem}")),
        }
    }
    // What was not seen is not said.
    if learns.is_err() {
        return vec![("it learns from corrections", learns)];
    }
    vec![
        ("it learns from corrections", learns),
        ("a correction changes what it answers", knows),
        ("it makes no edit but those it says it can", can),
        ("a copy of the model knows nothing of what the other one learns", keeps),
    ]
}

/// Asks all there is to ask.
fn answers(model: &dyn Learned, automaton: &Automaton, times: &mut Times) -> Result<Answers, String> {
    let said = |error: situ::error::SituError| error.to_string();
    let graph = model.graph().map_err(said)?;
    let states = states(automaton);
    let places = graph.nodes.iter().map(|node| Place::Node(node.id)).chain([Place::Start]);
    let mut ranked = Vec::new();
    for place in places {
        for state in &states {
            let (answer, seconds) = timed(|| model.ranked(place, state));
            times.next.push(seconds);
            ranked.push(answer.map_err(said)?);
        }
    }
    let mut executed = Vec::new();
    for node in &graph.nodes {
        for execution in [Execution::Mean, Execution::Sample] {
            for way in model.ways(node.id, states[0]).map_err(said)? {
                let mut rng = ChaCha8Rng::seed_from_u64(SEED);
                let (answer, seconds) = timed(|| model.keyframes(node.id, way, states[0], execution, &mut rng));
                times.keyframes.push(seconds);
                let (reference, keyframes) = answer.map_err(said)?;
                executed.push((reference.to_string(), keyframes));
            }
        }
    }
    Ok(Answers { graph, ranked, executed })
}

/// The states of the first original: those in which its keyframes begin, and the last.
fn states(automaton: &Automaton) -> Vec<&State> {
    let first = &automaton.originals()[0];
    first.keyframes().iter().map(|keyframe| &keyframe.state).chain([first.final_state()]).collect()
}

/// Each segment is of a demonstration that was shown, and in one primitive at the most.
fn holds(graph: &Graph, shown: usize) -> Result<(), String> {
    if graph.lengths.len() != shown {
        return Err(format!("it knows {} demonstrations, expected {shown}", graph.lengths.len()));
    }
    if graph.nodes.is_empty() {
        return Err("there is no primitive".to_owned());
    }
    let mut held = BTreeSet::new();
    for segment in graph.nodes.iter().flat_map(|node| &node.segments) {
        let lengths = graph.lengths.get(segment.demonstration as usize);
        if lengths.is_none_or(|lengths| segment.index as usize >= lengths.len()) {
            return Err(format!("segment {} of demonstration {} is none", segment.index, segment.demonstration));
        }
        if !held.insert(*segment) {
            return Err(format!("segment {} of demonstration {} is held twice", segment.index, segment.demonstration));
        }
    }
    let first = graph.edges.iter().any(|(from, _)| *from == Place::Start);
    if first { Ok(()) } else { Err("no edge leads from the start".to_owned()) }
}

fn rank(answers: &Answers) -> Result<(), String> {
    let nodes: BTreeSet<Place> = answers.graph.nodes.iter().map(|node| Place::Node(node.id)).collect();
    for ranked in &answers.ranked {
        if let Some((place, probability)) = ranked.iter().find(|(_, probability)| !(0.0..=1.0).contains(probability)) {
            return Err(format!("{place} has the probability {probability}, expected 0 to 1"));
        }
        if !ranked.is_sorted_by(|one, other| one.1 >= other.1) {
            return Err(format!("{ranked:?} is in another order"));
        }
        if let Some((place, _)) = ranked.iter().find(|(place, _)| *place != Place::End && !nodes.contains(place)) {
            return Err(format!("{place} follows, which is no primitive of its structure"));
        }
    }
    Ok(())
}

fn perform(answers: &Answers, automaton: &Automaton) -> Result<(), String> {
    let objects: BTreeSet<&str> = automaton
        .originals()
        .iter()
        .flat_map(|original| original.keyframes())
        .map(|keyframe| &*keyframe.reference)
        .collect();
    for (reference, keyframes) in &answers.executed {
        if !objects.contains(reference.as_str()) {
            return Err(format!("`{reference}` is no object of the demonstrations"));
        }
        if keyframes.is_empty() {
            return Err(format!("nothing is done at `{reference}`"));
        }
        let numbers = keyframes.iter().flat_map(|keyframe| {
            let pose = keyframe.pose.translation.vector.iter().chain(keyframe.pose.rotation.coords.iter());
            pose.copied().chain([keyframe.gripper.value(), keyframe.hold])
        });
        if let Some(number) = numbers.into_iter().find(|number| !number.is_finite()) {
            return Err(format!("a keyframe at `{reference}` has the number {number}"));
        }
    }
    Ok(())
}

/// Whether the likeliest places lead through the states of an original to its end.
fn follows(model: &dyn Learned, automaton: &Automaton) -> Result<(), String> {
    let original = &automaton.originals()[0];
    let segments = situ::segmentation::by_reference_object(original);
    let (mut last, mut done) = (Place::Start, 0);
    for _ in 0..LONGEST {
        let state = segments.get(done).map_or(original.final_state(), |segment| &segment.start);
        match model.next(last, state).map_err(|error| error.to_string())? {
            Some((Place::End, _)) if done >= segments.len() => return Ok(()),
            Some((Place::End, _)) => return Err(format!("it ends after {done} of {} segments", segments.len())),
            Some((next, _)) => (last, done) = (next, done + 1),
            None => return Err(format!("nothing follows after {done} of {} segments", segments.len())),
        }
    }
    Err(format!("no end within {LONGEST} primitives"))
}

fn draws(model: &dyn Learned, automaton: &Automaton) -> Result<(), String> {
    let state = states(automaton)[0];
    let said = |error: situ::error::SituError| error.to_string();
    for node in model.graph().map_err(said)?.nodes {
        let draw = || {
            let mut rng = ChaCha8Rng::seed_from_u64(SEED);
            model.keyframes(node.id, 0, state, Execution::Sample, &mut rng).map_err(said)
        };
        if draw()? != draw()? {
            return Err(format!("{} is performed differently with the same seed", node.id));
        }
    }
    Ok(())
}

fn same(one: &Answers, other: &Answers) -> Result<(), String> {
    match () {
        () if one.graph != other.graph => Err("its structure is another one".to_owned()),
        () if one.ranked != other.ranked => Err("other places follow, or with other probabilities".to_owned()),
        () if one.executed != other.executed => Err("its keyframes are others".to_owned()),
        () => Ok(()),
    }
}
