//! Properties of an update, for random automata and random corrections.
//!
//! Once with a learner on a line, which reaches every branch in thousands of automata, and once with the keyframe
//! learner of `situ` and of the literal listing.
//!
//! ```text
//! SITU_SOAK=200 cargo test -p situ --release --test all -- update --nocapture     # a million corrections
//! ```

use std::collections::BTreeSet;
use std::fmt::Debug;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::common::known::{a_new_way_changes_no_other, every_probability_is_one, obeys, ways_keep_what_they_know};
use crate::common::soak;
use crate::common::structure::{check, retired};
use crate::common::toy::Toy;
use crate::common::{CAREFUL, EXACT, Noise, Planted, Task, folded, histories, written};
use proptest::prelude::*;
use proptest::sample::Index;
use situ::correction::Correction;
use situ::decisions::{Candidates, Decisions, Limit, Modify, Ways};
use situ::demonstration::{Demonstration, Kind};
use situ::edit::{Edit, difference};
use situ::graph::Graph;
use situ::keyframe::parameters::{Divergence, KeyframeParameters};
use situ::method::rebuild::rebuild;
use situ::place::{NodeId, Place};
use situ::placement::{ByPolicy, Placement};
use situ::primitive::{Initiation, Learner};
use situ::segment::Segment;
use situ::segmentation::by_reference_object;
use situ::state::State;
use situ::task_model::TaskModel;
use situ::trace::{Branch, Counters, MatchedIn, Trace};
use situ::trail::{StepEnd, TrailStep};
use situ::update::Update;

/// A segment to be: object, site on it, where about the site, and the state in which it begins.
type Word = (u8, u8, f64, [f64; 2]);

/// Some states look alike, number for number.
fn state() -> impl Strategy<Value = [f64; 2]> {
    let number = || prop_oneof![3 => (0_u8..3).prop_map(f64::from), 1 => 0.0..8.0];
    (number(), (0_u8..2).prop_map(f64::from)).prop_map(<[f64; 2]>::from)
}

fn words(longest: usize) -> impl Strategy<Value = Vec<Word>> {
    prop::collection::vec((0_u8..3, 0_u8..4, -0.6..0.6, state()), 1..=longest)
}

fn demonstration(kind: Kind, words: &[Word], carried_to_end: bool) -> Demonstration {
    let spell = |(object, site, x, state): &Word| (*object, f64::from(*site) * 10.0 + x, *state);
    let announced = kind == Kind::Corrective;
    written(kind, announced, &words.iter().map(spell).collect::<Vec<_>>(), [9.0, 0.0], carried_to_end)
}

/// A correction to be: what it shows, whether to the end, what ran last, what was interrupted, and the choices before.
#[derive(Clone, Debug)]
struct Given {
    words: Vec<Word>,
    carried_to_end: bool,
    last: Option<Index>,
    interrupted: Option<Index>,
    trail: Vec<(Index, [f64; 2], StepEnd)>,
}

impl Given {
    fn any() -> impl Strategy<Value = Self> {
        let end = prop::sample::select(vec![StepEnd::Finished, StepEnd::Interrupted, StepEnd::Prevented]);
        let trail = prop::collection::vec((any::<Index>(), state(), end), 0..4);
        (words(3), any::<bool>(), any::<Option<Index>>(), any::<Option<Index>>(), trail).prop_map(
            |(words, carried_to_end, last, interrupted, trail)| Self {
                words,
                carried_to_end,
                last,
                interrupted,
                trail,
            },
        )
    }

    fn node(index: Index, model: &TaskModel<Toy>) -> NodeId {
        model.nodes().nth(index.index(model.len())).unwrap().0
    }

    /// A model after this correction, and what was done.
    fn to(&self, model: &TaskModel<Toy>, learner: &Toy, decisions: &Decisions) -> (TaskModel<Toy>, Trace) {
        let step = |(node, state, end): &(Index, [f64; 2], StepEnd)| TrailStep {
            state: State::new(*state),
            node: Self::node(*node, model),
            end: *end,
        };
        let trail: Vec<TrailStep> = self.trail.iter().map(step).collect();
        let correction = Correction {
            last: self.last.map_or(Place::Start, |last| Place::Node(Self::node(last, model))),
            interrupted: self.interrupted.map(|node| Self::node(node, model)),
            trail: &trail,
            demonstration: &demonstration(Kind::Corrective, &self.words, self.carried_to_end),
            oracle: None,
        };
        let (after, trace, _) = update(model, correction, learner, decisions);
        (after, trace)
    }
}

/// `situ`, the listing, and each switch that changes structure turned alone.
fn decisions() -> Vec<Decisions> {
    let mended = Decisions::mended();
    vec![
        mended,
        Decisions::literal(),
        Decisions { push_to_siblings: false, ..mended },
        Decisions { merge_redundant: false, modify: None, ..mended },
        Decisions { candidates: Candidates::All, ..mended },
        Decisions { subtract_own_positives: false, ..mended },
        Decisions::replacing(),
        Decisions { follow: false, ..mended },
        Decisions { ways: Ways::Keep(2), ..mended },
        Decisions { obey: false, ..mended },
        Decisions { trail: false, ..mended },
        nearly(),
    ]
}

/// `situ` for a teacher to whom half a unit is far: matches are displaced, too.
fn nearly() -> Decisions {
    let mended = Decisions::mended();
    let limit = Limit { metres: 0.5, scatters: 0.5 };
    let modify = mended.modify.map(|rule| Modify { near: limit, far: limit, ..rule });
    Decisions { modify, ..mended }
}

/// What Cluster may compare with the segment, or more.
fn candidates_of<L: Learner>(model: &TaskModel<L>, segment: &Segment, decisions: &Decisions) -> BTreeSet<NodeId> {
    let applicable = model.applicable(&segment.start, &mut Counters::default()).into_iter();
    match decisions.candidates {
        Candidates::Applicable => applicable.collect(),
        Candidates::ReferenceFallback(_) => model.nodes_of(&segment.reference).collect(),
        Candidates::All => model.nodes().map(|(id, _)| id).collect(),
    }
}

/// The nodes that an update by a demonstration of one segment may not touch: neither candidates, nor children of
/// `last`, nor children of what they may be merged into.
fn out_of_reach<L: Learner>(
    before: &TaskModel<L>,
    last: Place,
    shown: &Demonstration,
    decisions: &Decisions,
) -> BTreeSet<NodeId> {
    let segments = by_reference_object(shown);
    let candidates = candidates_of(before, &segments[0], decisions);
    let mut parents = vec![last];
    if shown.carried_to_end() || candidates.iter().any(|id| last == Place::Node(*id)) {
        parents.extend(candidates.iter().copied().map(Place::Node));
    }
    let reached: BTreeSet<Place> = parents
        .into_iter()
        .flat_map(|parent| before.children(parent))
        .chain(candidates.into_iter().map(Place::Node))
        .collect();
    before.nodes().map(|(id, _)| id).filter(|id| !reached.contains(&Place::Node(*id))).collect()
}

/// A1.6, one node after the other.
fn asked<L: Learner>(model: &TaskModel<L>, state: &State) -> Vec<NodeId> {
    model.nodes().filter(|(_, node)| node.classifier.is_applicable(state)).map(|(id, _)| id).collect()
}

/// The distances that a model kept are those of its policies.
fn nothing_kept_is_stale<L: Learner + Clone>(model: &TaskModel<L>, learner: &L) {
    let (ids, mut counters) = (model.nodes().map(|(id, _)| id).collect::<Vec<_>>(), Counters::default());
    let policies = |id: &NodeId| model.node(*id).unwrap().policies();
    let mut fresh = Vec::new();
    for (index, lower) in ids.iter().enumerate() {
        for higher in &ids[index + 1..] {
            let pairs =
                policies(lower).into_iter().flat_map(|one| policies(higher).into_iter().map(move |two| (one, two)));
            let distance = |(one, two)| learner.distance(one, two, Some(model.calibration()), &mut counters);
            fresh.push(pairs.map(distance).fold(f64::INFINITY, f64::min));
        }
    }
    let (mut first, mut again) = (Counters::default(), Counters::default());
    let mut kept = model.clone();
    assert_eq!(kept.distances_among(learner, &ids, &mut first).unwrap(), fresh);
    assert!(first.divergences <= counters.divergences);
    assert_eq!(kept.distances_among(learner, &ids, &mut again).unwrap(), fresh);
    assert_eq!(again.divergences, 0);
}

/// What is out of reach of an update by one segment stays as it was. Returns how many nodes that are.
fn stays_local<L: Learner + Debug + PartialEq>(
    before: &TaskModel<L>,
    after: &TaskModel<L>,
    last: Place,
    shown: &Demonstration,
    decisions: &Decisions,
) -> usize {
    let untouched = out_of_reach(before, last, shown, decisions);
    for id in &untouched {
        assert_eq!(before.node(*id).unwrap(), after.node(*id).unwrap(), "{id} is out of reach");
    }
    // Between two places out of reach no edge comes or goes.
    let is_far = |place: &Place| matches!(place, Place::Node(id) if untouched.contains(id)) && *place != last;
    let edges =
        |model: &TaskModel<L>| model.edges().filter(|(from, to)| is_far(from) && is_far(to)).collect::<Vec<_>>();
    assert_eq!(edges(before), edges(after));
    untouched.len()
}

/// The order of Z does not matter.
fn order_does_not_matter<L: Learner + Clone>(
    before: &TaskModel<L>,
    last: Place,
    shown: &Demonstration,
    learner: &L,
    decisions: &Decisions,
) {
    let segments = by_reference_object(shown);
    let mut z = before.applicable(&segments[0].start, &mut Counters::default());
    let find = |z: &[NodeId]| {
        let mut model = before.clone();
        let history = model.history(&Correction::after(last, shown), segments.clone()).unwrap();
        let d = model.begin(history)[0];
        let mut update = Update::new(&mut model, learner, decisions);
        (ByPolicy.cluster(&mut update, d, z).unwrap(), update.counters)
    };
    let expected = find(&z);
    for _ in 0..z.len().min(3) {
        z.rotate_left(1);
        assert_eq!(find(&z), expected);
    }
    z.reverse();
    assert_eq!(find(&z), expected);
}

/// Corrections whose updates were checked, in all tests.
static CORRECTIONS: AtomicU64 = AtomicU64::new(0);

/// Folds a correction in, and checks all that holds whatever the learner thinks.
fn update<L>(
    before: &TaskModel<L>,
    correction: Correction<'_>,
    learner: &L,
    decisions: &Decisions,
) -> (TaskModel<L>, Trace, usize)
where
    L: Learner + Clone + Debug + PartialEq,
{
    let (after, trace) = folded(correction, before, learner, decisions);
    let (last, shown) = (correction.last, correction.demonstration);
    check(&after, decisions);
    obeys(&after, &trace, decisions);
    ways_keep_what_they_know(&after, learner);
    every_probability_is_one(&after, shown);
    soak::tell(1 + CORRECTIONS.fetch_add(1, Ordering::Relaxed), "corrections were checked");
    // A retired positive may be one of the trail.
    let gone = retired(&after) - retired(before);
    assert!(gone <= trace.obedience.retired as usize, "{gone} are gone, {:?}", trace.obedience);
    let segments = by_reference_object(shown);
    assert_eq!(trace.steps.len(), segments.len());
    let mut size = before.len();
    for step in &trace.steps {
        assert_eq!(step.model_size, size);
        let merged: usize = step.merged.iter().map(|(group, _)| group.len() - 1).sum();
        size = size - merged + usize::from(matches!(step.branch, Branch::New));
        // A match is an instance or another way of doing the same. An unmatched segment is new, or one of these (D18).
        match step.branch {
            Branch::Existing => assert!(step.matched_in != MatchedIn::None || decisions.modify.is_some()),
            Branch::New => assert_eq!(step.matched_in, MatchedIn::None),
            Branch::Modify => assert!(decisions.modify.is_some()),
        }
    }
    assert_eq!(after.len(), size, "a node more for every new branch, fewer for every merge, and no other");

    // Locality: one segment's update.
    let mut far = 0;
    if let [step] = &trace.steps[..] {
        far = stays_local(before, &after, last, shown, decisions);
        if step.branch == Branch::Modify {
            a_new_way_changes_no_other(before, &after, step, decisions);
        }
        let made = difference(&Graph::of(before, learner), &Graph::of(&after, learner));
        let merged: usize = step.merged.iter().map(|(group, _)| group.len() - 1).sum();
        assert_eq!(made.nodes_merged, merged);
        order_does_not_matter(before, last, shown, learner, decisions);
        for model in [before, &after] {
            let found = model.applicable(&segments[0].start, &mut Counters::default());
            assert_eq!(found, asked(model, &segments[0].start));
            nothing_kept_is_stale(model, learner);
        }
    }
    (after, trace, far)
}

proptest! {
    #![proptest_config(soak::config(256))]

    /// Random words in random states: every branch, merges of `a` and of bystanders, ways, corrections after any node
    /// and after START, with any trail or none, carried on to the end or not.
    #[test]
    fn any_automaton_keeps_its_structure(
        originals in prop::collection::vec((words(5), any::<bool>()), 1..4),
        corrections in prop::collection::vec(Given::any(), 1..4),
        taught in prop_oneof![Just(0.05), Just(2.0)],
    ) {
        let learner = Toy { features: 2, ..Toy::on_a_line(taught) };
        let originals: Vec<_> =
            originals.iter().map(|(words, end)| demonstration(Kind::Original, words, *end)).collect();
        for decisions in decisions() {
            let (mut model, _) = rebuild(histories(&originals), None, &learner, &decisions).unwrap();
            check(&model, &decisions);
            for given in &corrections {
                model = given.to(&model, &learner, &decisions).0;
            }
        }
    }
}

/// How the two learners of the paper's keyframe instantiation are set; sampling is thinned, for time.
fn kernels() -> [(Decisions, KeyframeParameters); 2] {
    let literal = KeyframeParameters { divergence: Divergence::MonteCarlo(20), ..KeyframeParameters::literal() };
    [(Decisions::mended(), KeyframeParameters::default()), (Decisions::literal(), literal)]
}

proptest! {
    #![proptest_config(soak::config(12))]

    /// Keyframe models, three corrections in a row: structure, locality, and the same bits on a second run.
    #[test]
    fn keyframe_models_keep_their_structure_and_their_bits(
        seed in any::<u64>(),
        skills in 5_usize..10,
        planted in prop::collection::vec((prop::sample::select(Planted::ALL.to_vec()), any::<bool>()), 3),
    ) {
        let task = Task::new(seed, skills, 4);
        for (decisions, parameters) in kernels() {
            let run = || {
                let (mut model, learner) = task.taught(CAREFUL, parameters.clone());
                check(&model, &decisions);
                let mut bits = vec![serde_json::to_string(&model).unwrap()];
                for (draw, (planted, end)) in (0..).zip(&planted) {
                    let correction = task.correction(*planted, draw, CAREFUL, *end);
                    let last = correction.last(&model);
                    let trace;
                    (model, trace, _) = update(&model, Correction::after(last, &correction.demonstration), &learner, &decisions);
                    bits.push(serde_json::to_string(&(&model, trace)).unwrap());
                }
                bits
            };
            let bits = run();
            prop_assert_eq!(&bits, &run());
            // What is written is JSON, and no number of it is lost.
            for text in &bits {
                let value: serde_json::Value = serde_json::from_str(text).unwrap();
                prop_assert_eq!(&serde_json::from_str::<serde_json::Value>(&value.to_string()).unwrap(), &value);
            }
        }
    }
}

/// What an update by the kernels of `situ` made of a correction.
fn made(task: &Task, originals: Noise, planted: Planted, draw: u64, noise: Noise, end: bool) -> (Edit, Trace, usize) {
    let (model, learner) = task.taught(originals, KeyframeParameters::default());
    assert!(task.is_recovered(&model), "each skill is a node, or nothing can be said of edits");
    let correction = task.correction(planted, draw, noise, end);
    let last = correction.last(&model);
    let (after, trace, far) =
        update(&model, Correction::after(last, &correction.demonstration), &learner, &Decisions::mended());
    (difference(&Graph::of(&model, &learner), &Graph::of(&after, &learner)).edit(), trace, far)
}

proptest! {
    #![proptest_config(soak::config(12))]

    #[test]
    fn a_covered_correction_without_noise_adds_nothing(seed in any::<u64>(), skills in 5_usize..10, end in any::<bool>()) {
        let task = Task::new(seed, skills, 4);
        let (edit, trace, _) = made(&task, CAREFUL, Planted::Covered, seed, EXACT, end);
        prop_assert_eq!(edit, Edit::None);
        for step in &trace.steps {
            prop_assert!(step.branch == Branch::Existing && !step.edge_added && step.merged.is_empty(), "{:?}", step);
        }
    }
}

/// Four draws of each edit, each carried on to the end and not. The graphs say which edit it was.
#[test]
fn every_planted_edit_is_made() {
    let mut out_of_reach = 0;
    for seed in 0..4 {
        let task = Task::new(seed, 6 + seed as usize, 4);
        for planted in Planted::ALL {
            for end in [false, true] {
                let (edit, trace, far) = made(&task, CAREFUL, planted, seed, CAREFUL, end);
                assert_eq!(edit, planted.edit(), "{planted:?}, seed {seed}, to the end: {end}: {:#?}", trace.steps);
                let branch = match planted {
                    Planted::NewNode => Branch::New,
                    Planted::Modified => Branch::Modify,
                    _ => Branch::Existing,
                };
                assert_eq!(trace.steps[0].branch, branch, "{planted:?}");
                assert!(trace.steps[1..].iter().all(|step| step.branch == Branch::Existing), "back on the model");
                if planted == Planted::SelfLoop {
                    assert_eq!(trace.steps[0].after, Place::Node(trace.steps[0].node));
                }
                out_of_reach += far;
            }
        }
    }
    assert!(out_of_reach > 50, "locality was tested on {out_of_reach} nodes only");
}
