//! Block sorting without physics, as in the paper's simulated evaluation: two blocks, two bins, and corrections that
//! need a known edit.
//!
//! A state is each block's place and whether it is held, and whether a lid is on the bins. What a skill does to the
//! world is written down, not simulated; the table is laid anew for every demonstration.

use std::collections::BTreeSet;
use std::sync::Arc;

use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use situ::correction::Correction;
use situ::demonstration::{Demonstration, Feature, Gripper, Keyframe, Kind, Pose, Schema, State};
use situ::edit::{Edit, difference};
use situ::keyframe::policy::Execution;
use situ::keyframe::pose::{Tangent, exp};
use situ::method::Learned;
use situ::method::itmcd::ItmcdTask;
use situ::method::itmcd::parameters::{ItmcdParameters, Lag};
use situ::place::{Place, SegmentId};
use situ::random::{standard_normal, stream};
use situ::trace::Counters;

/// Draws of each kind of correction.
const DRAWS: u64 = 25;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Skill {
    /// Takes a block.
    Pick(usize),
    /// Puts it into its bin.
    Drop(usize),
    /// Slides the lid off the bins.
    Uncover,
    /// Pushes a block out of the way.
    Nudge(usize),
    /// Taps a bin at its rim.
    Tap(usize),
}

use Skill::{Drop, Nudge, Pick, Tap, Uncover};

/// What the originals show.
const TASK: [Skill; 4] = [Pick(0), Drop(0), Pick(1), Drop(1)];

/// What a correction shows, and why it is needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Need {
    /// Nothing new: the robot stopped.
    Nothing,
    /// The first block is in its bin already.
    Sorted,
    /// A block slipped from the hand: once more.
    Slipped,
    /// A block jumped out of its bin: back to it.
    Jumped,
    /// A lid is on the bins.
    Lid,
    /// The other block stands in the way of the first.
    InTheWay,
    /// At the end, the first bin wants a tap: a new skill about a known object, the hand as open as after a drop.
    Unsettled,
    /// A bin stands higher and further away.
    HighBin,
    /// A block wants to be taken 12 cm from where it was.
    OtherGrasp,
}

impl Need {
    const ALL: [Self; 9] = [
        Self::Nothing,
        Self::Sorted,
        Self::Slipped,
        Self::Jumped,
        Self::Lid,
        Self::InTheWay,
        Self::Unsettled,
        Self::HighBin,
        Self::OtherGrasp,
    ];

    fn edit(self) -> Edit {
        match self {
            Self::Nothing => Edit::None,
            Self::Sorted | Self::Slipped | Self::Jumped => Edit::EdgeAddition,
            Self::Lid | Self::InTheWay | Self::Unsettled => Edit::NodeAddition,
            Self::HighBin | Self::OtherGrasp => Edit::NodeModification,
        }
    }

    /// How many skills of the task have run, and what is shown.
    fn shown(self, block: usize) -> (usize, Vec<Skill>) {
        match self {
            Self::Nothing => (2 * block, vec![Pick(block), Drop(block)]),
            Self::Sorted => (0, vec![Pick(1), Drop(1)]),
            Self::Slipped => (2 * block + 1, vec![Pick(block), Drop(block)]),
            Self::Jumped => (2 * block + 2, vec![Pick(block), Drop(block)]),
            Self::Lid => (2 * block + 1, vec![Uncover, Drop(block)]),
            Self::InTheWay => (0, vec![Nudge(1), Pick(0)]),
            Self::Unsettled => (4, vec![Tap(0)]),
            Self::HighBin => (2 * block + 1, vec![Drop(block)]),
            Self::OtherGrasp => (2 * block, vec![Pick(block)]),
        }
    }
}

/// The table.
struct World {
    blocks: [Vector3<f64>; 2],
    bins: [Vector3<f64>; 2],
    held: [bool; 2],
    lid: bool,
    rng: ChaCha8Rng,
    noise: f64,
}

impl World {
    fn new(seed: u64, noise: f64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut place =
            |x: f64, y: f64| Vector3::new(x + rng.random_range(-0.08..0.08), y + rng.random_range(-0.08..0.08), 0.02);
        let blocks = [place(0.0, -0.2), place(0.0, 0.2)];
        let bins = [place(0.5, -0.2), place(0.5, 0.2)];
        Self { blocks, bins, held: [false; 2], lid: false, rng, noise }
    }

    fn normal(&mut self, deviation: f64) -> f64 {
        deviation * standard_normal(&mut self.rng)
    }

    fn state(&mut self) -> State {
        let mut values = Vec::new();
        for block in 0..2 {
            let (place, held) = (self.blocks[block], self.held[block]);
            values.extend([place.x, place.y, place.z].map(|value| value + self.normal(0.005)));
            values.push(if held { 1.0 } else { 0.0 });
        }
        values.push(if self.lid { 1.0 } else { 0.0 });
        State::new(values)
    }

    /// The effect of a skill.
    fn after(&mut self, skill: Skill) {
        match skill {
            Pick(block) => {
                self.held[block] = true;
                self.blocks[block].z = 0.2;
            }
            Drop(block) => {
                self.held[block] = false;
                self.blocks[block] = self.bins[block];
            }
            Uncover => self.lid = false,
            Nudge(block) => self.blocks[block].x -= 0.1,
            Tap(_) => {}
        }
    }

    /// The keyframes of a skill, moved by `moved`.
    fn show(&mut self, skill: Skill, moved: Vector3<f64>) -> Vec<Keyframe> {
        let (open, closed) = (Gripper::Open(0.08), Gripper::Close(20.0));
        let (name, at, path): (String, _, [([f64; 3], Gripper); 3]) = match skill {
            Pick(block) => (
                format!("block-{block}"),
                self.blocks[block],
                [([0.0, 0.0, 0.15], open), ([0.0, 0.0, 0.0], closed), ([0.0, 0.0, 0.2], closed)],
            ),
            Drop(block) => (
                format!("bin-{block}"),
                self.bins[block],
                [([0.0, 0.0, 0.25], closed), ([0.0, 0.0, 0.1], open), ([0.0, 0.0, 0.25], open)],
            ),
            Uncover => (
                "lid".to_owned(),
                Vector3::new(0.5, 0.0, 0.1),
                [([-0.1, 0.0, 0.1], closed), ([-0.1, 0.0, 0.03], closed), ([0.15, 0.0, 0.03], closed)],
            ),
            Nudge(block) => (
                format!("block-{block}"),
                self.blocks[block],
                [([0.1, 0.0, 0.1], open), ([0.08, 0.0, 0.0], open), ([-0.05, 0.0, 0.0], open)],
            ),
            Tap(bin) => (
                format!("bin-{bin}"),
                self.bins[bin],
                [([0.0, 0.1, 0.2], open), ([0.0, 0.1, 0.08], open), ([0.0, 0.1, 0.2], open)],
            ),
        };
        let reference: Arc<str> = name.into();
        let reference_pose = Pose::from_parts(Translation3::from(at), UnitQuaternion::identity());
        let state = self.state();
        // Novices give a keyframe too many in 15 % of the cases, somewhere near, and leave 7 % of those out that do
        // nothing to the hand.
        let mut shown = Vec::new();
        let mut before = None;
        for (place, gripper) in path {
            if self.rng.random::<f64>() < 0.07 && before == Some(gripper) {
                continue;
            }
            if self.rng.random::<f64>() < 0.15 {
                let near = Vector3::from_fn(|_, _| self.normal(0.03));
                shown.push(((Vector3::from(place) + near).into(), before.unwrap_or(gripper)));
            }
            shown.push((place, gripper));
            before = Some(gripper);
        }
        shown
            .into_iter()
            .map(|(place, gripper)| {
                let mean =
                    Pose::from_parts(Translation3::from(Vector3::from(place) + moved), UnitQuaternion::identity());
                let noise = self.noise;
                let error = Tangent::from_fn(|axis, _| self.normal(if axis < 3 { noise } else { 4.0 * noise }));
                Keyframe {
                    reference: reference.clone(),
                    reference_pose,
                    gripper_pose: reference_pose * exp(&mean, &error),
                    gripper,
                    hold: 0.0,
                    state: state.clone(),
                    narration: None,
                }
            })
            .collect()
    }

    fn demonstrate(&mut self, name: &str, skills: &[(Skill, Vector3<f64>)], kind: Kind, end: bool) -> Demonstration {
        let mut keyframes = Vec::new();
        for (skill, moved) in skills {
            keyframes.extend(self.show(*skill, *moved));
            self.after(*skill);
        }
        let last = self.state();
        Demonstration::new(name, kind, &schema(), keyframes, last, end).unwrap()
    }
}

fn schema() -> Schema {
    let mut features = Vec::new();
    for block in 0..2 {
        features.extend(["x", "y", "z"].map(|axis| Feature { name: format!("{axis}({block})"), scale: 0.2 }));
        features.push(Feature { name: format!("held({block})"), scale: 0.5 });
    }
    features.push(Feature { name: "lid".to_owned(), scale: 0.5 });
    Schema::new(features).unwrap()
}

fn originals(count: usize, seed: u64, noise: f64) -> Vec<Demonstration> {
    let still = TASK.map(|skill| (skill, Vector3::zeros()));
    (0..count)
        .map(|index| {
            let name = format!("original-{index}");
            World::new(stream(seed, &name), noise).demonstrate(&name, &still, Kind::Original, true)
        })
        .collect()
}

/// A correction, and how many skills of the task had run before it.
fn correction(need: Need, seed: u64, noise: f64) -> (usize, Demonstration) {
    let mut world = World::new(stream(seed, "correction"), noise);
    let block = world.rng.random_range(0..2);
    let (done, skills) = need.shown(block);
    for skill in &TASK[..done] {
        world.after(*skill);
    }
    match need {
        Need::Sorted => world.blocks[0] = world.bins[0],
        Need::Slipped | Need::Jumped => {
            world.held[block] = false;
            world.blocks[block] = Vector3::new(0.2, world.normal(0.1), 0.02);
        }
        Need::Lid => world.lid = true,
        Need::InTheWay => world.blocks[1] = world.blocks[0] + Vector3::new(0.05, 0.0, 0.0),
        _ => {}
    }
    // 12 cm, as the high bins of the design.
    let moved = match need {
        Need::HighBin => Vector3::new(0.07, 0.0, 0.0975),
        Need::OtherGrasp => Vector3::new(-0.085, 0.085, 0.0),
        _ => Vector3::zeros(),
    };
    let end = need == Need::Unsettled || world.rng.random();
    let last = skills[skills.len() - 1];
    let mut shown: Vec<(Skill, Vector3<f64>)> = skills.into_iter().map(|skill| (skill, Vector3::zeros())).collect();
    shown[0].1 = moved;
    if end && let Some(at) = TASK.iter().position(|skill| *skill == last) {
        shown.extend(TASK[at + 1..].iter().map(|skill| (*skill, Vector3::zeros())));
    }
    (done, world.demonstrate("correction", &shown, Kind::Corrective, end))
}

/// What was chosen: an addition of a node before a modification before an edge, as [`difference`] orders them.
fn chosen(task: &ItmcdTask) -> Option<Edit> {
    let edits: Option<Vec<Edit>> =
        task.rounds().iter().map(|round| round.chosen.map(|candidate| candidate.edit())).collect();
    let edits = edits?;
    [Edit::NodeAddition, Edit::NodeModification, Edit::EdgeAddition]
        .into_iter()
        .find(|edit| edits.contains(edit))
        .or(Some(Edit::None))
}

/// The original model, and the place that ran last where so many skills of the task had run.
fn taught(originals: &[Demonstration], done: usize, parameters: ItmcdParameters) -> Option<(ItmcdTask, Place)> {
    let task = ItmcdTask::teach(&schema(), originals, parameters).unwrap();
    let graph = task.graph();
    let holders = graph.holders();
    let place = |index: usize| holders[&SegmentId { demonstration: 0, index: index as u32 }].id;
    let last = done.checked_sub(1).map_or(Place::Start, |index| Place::Node(place(index)));
    // Where the common start is not the task, what is chosen says nothing of the choice.
    (graph.nodes.len() == TASK.len()).then_some((task, last))
}

/// Two to four originals, by a careful teacher and a novice in turns (0.5 cm and 1 cm, 2° and more), both of them
/// clumsy with keyframes.
///
/// Measured: 212 of 224 right; of 25 that need nothing 15, of the others 197 of 199. What errs are needless
/// modifications and nodes where the correction, or one of few originals, has a keyframe too many: it moves all ten
/// points behind it along the path, and they are taken for ten witnesses (see `frames`). Nothing was chosen on these
/// draws. At 0.946 the standard error over 224 draws is 0.015: 0.9 is three of them below; and half of a need's draws
/// is three of *its* standard errors below the worst but for needs nothing, which is one.
#[test]
fn the_planted_edit_is_chosen() {
    let (mut right, mut all, mut work) = (0, 0, Counters::default());
    let (mut table, mut made, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    let column = |edit: Option<Edit>| Edit::ALL.iter().position(|other| Some(*other) == edit).unwrap_or(4);
    for need in Need::ALL {
        let (mut row, mut row_made) = ([0; 5], [0; 5]);
        for draw in 0..DRAWS {
            let seed = stream(draw, &format!("held out: {need:?}"));
            let (count, noise) = (2 + (draw % 3) as usize, if draw % 2 == 0 { 0.005 } else { 0.01 });
            let (done, shown) = correction(need, seed, noise);
            let Some((mut task, last)) = taught(&originals(count, seed, noise), done, ItmcdParameters::default())
            else {
                continue;
            };
            let before = task.graph();
            work += task.correct(Correction::after(last, &shown)).unwrap().counters;
            let edit = chosen(&task);
            row[column(edit)] += 1;
            row_made[column(Some(difference(&before, &task.graph()).edit()))] += 1;
            all += 1;
            if edit == Some(need.edit()) {
                right += 1;
            } else {
                let edits = task.rounds().iter().filter_map(|round| round.chosen).map(|edit| edit.to_string());
                wrong.push(format!("{need:?}, {count} originals: {:?}", edits.collect::<Vec<_>>()));
            }
        }
        table.push((need, row));
        made.push((need, row_made));
    }
    for (what, rows) in [("chosen by AICc", &table), ("made, by the difference of the automata", &made)] {
        let on_diagonal: usize = rows.iter().map(|(need, row)| row[column(Some(need.edit()))]).sum();
        println!("{what}: {on_diagonal} of {all} as planted");
        println!("{:<30}{}refused", "planted", Edit::ALL.map(|edit| format!("{edit:<18}")).concat());
        for edit in Edit::ALL {
            let of_edit = rows.iter().filter(|(need, _)| need.edit() == edit);
            let sums = of_edit.fold([0; 5], |sums, (_, row)| std::array::from_fn(|index| sums[index] + row[index]));
            println!("{:<30}{}", edit, sums.map(|count| format!("{count:<18}")).concat());
        }
        for (need, row) in rows {
            let cells: String = row.iter().map(|count| format!("{count:<18}")).collect();
            println!("{:<12}{:<18}{cells}", format!("{need:?}"), need.edit());
        }
    }
    let each = |count: u64| count as f64 / all as f64;
    println!(
        "a correction: {:.1} fits, {:.1} EM iterations, {:.1} Newton steps",
        each(work.hmm_fits),
        each(work.em_iterations),
        each(work.logistic_steps)
    );
    println!("{}", wrong.join("\n"));
    assert!(all >= 200, "{all}");
    assert!(right as f64 >= 0.9 * all as f64, "{right} of {all}");
    for (need, row) in &table {
        let own = row[column(Some(need.edit()))];
        assert!(2 * own >= row.iter().sum::<usize>(), "{need:?}: {row:?}");
    }
}

/// A neighbour and its neighbour in a dense interpolation are so alike that an autoregression learns to copy, wherever
/// the path is; so a policy that is shifted as a whole looks like noise at one point. That is why the default has no
/// lag: this keeps the reason true.
#[test]
fn an_autoregression_does_not_see_a_path_that_moved() {
    let mut seen = [0, 0];
    for draw in 0..6 {
        let seed = stream(draw, "moved");
        let (done, shown) = correction(Need::HighBin, seed, 0.005);
        for (seen, lag) in seen.iter_mut().zip([Lag::None, Lag::One]) {
            let parameters = ItmcdParameters { lag, ..ItmcdParameters::default() };
            let Some((mut task, last)) = taught(&originals(3, seed, 0.005), done, parameters) else { continue };
            task.correct(Correction::after(last, &shown)).unwrap();
            *seen += usize::from(chosen(&task) == Some(Edit::NodeModification));
        }
    }
    assert!(seen[0] >= 5 && seen[1] <= 1, "{seen:?}");
}

/// Two points a segment are fewer numbers than one original's model has parameters.
#[test]
fn what_is_too_large_for_the_data_is_refused_and_said() {
    let (done, shown) = correction(Need::HighBin, 3, 0.005);
    let parameters = ItmcdParameters { points: 2, ..ItmcdParameters::default() };
    let (mut task, last) = taught(&originals(1, 3, 0.005), done, parameters).unwrap();
    let before = task.to_json();
    let trace = task.correct(Correction::after(last, &shown)).unwrap();
    assert!(trace.steps.is_empty() && trace.counters.hmm_fits == 1, "the automaton's own fit alone: {trace:?}");
    assert_eq!(task.to_json()["model"], before["model"], "nothing is chosen, nothing is changed");
    let [round] = task.rounds() else { panic!("{:?}", task.rounds()) };
    assert!(round.chosen.is_none() && !round.evaluations.is_empty());
    for evaluation in &round.evaluations {
        assert!(evaluation.observations <= evaluation.parameters + 1 && evaluation.weight == 0.0, "{evaluation:?}");
        assert_eq!((evaluation.criterion, evaluation.log_likelihood), (None, None));
    }
    assert_eq!(task.to_json()["rounds"][0]["evaluations"].as_array().unwrap().len(), round.evaluations.len());
    // What was refused was shown all the same: the next is the third demonstration, not the second.
    let more = originals(8, 9, 0.005);
    let keyframes: Vec<Keyframe> = more.iter().flat_map(|shown| shown.keyframes().iter().cloned()).collect();
    let segments = 1 + keyframes.windows(2).filter(|pair| pair[0].reference != pair[1].reference).count();
    let long = Demonstration::new("long", Kind::Corrective, &schema(), keyframes, more[7].final_state().clone(), true);
    assert_eq!(task.correct(Correction::after(Place::Start, &long.unwrap())).unwrap().steps.len(), segments);
    let graph = task.graph();
    let shown: BTreeSet<u32> = graph.holders().keys().map(|segment| segment.demonstration).collect();
    assert_eq!(shown, BTreeSet::from([0, 2]));
}

/// What was modified is what the node does now: the same correction once more needs nothing, and the weights say so.
#[test]
fn a_modification_is_needed_once() {
    let (done, shown) = correction(Need::HighBin, 5, 0.005);
    let (mut task, last) = taught(&originals(3, 5, 0.005), done, ItmcdParameters::default()).unwrap();
    let mut edits = Vec::new();
    for _ in 0..3 {
        task.correct(Correction::after(last, &shown)).unwrap();
        edits.push(chosen(&task).unwrap());
        let weights: f64 = task.rounds()[0].evaluations.iter().map(|evaluation| evaluation.weight).sum();
        assert!((weights - 1.0).abs() < 1e-12);
    }
    assert_eq!(edits, [Edit::NodeModification, Edit::None, Edit::None]);
}

/// A correction that no single edit makes possible is taken as far as one leads, and then further.
#[test]
fn two_new_skills_are_two_nodes() {
    let originals = originals(3, 9, 0.005);
    let (mut task, last) = taught(&originals, 4, ItmcdParameters::default()).unwrap();
    let mut world = World::new(9, 0.005);
    TASK.iter().for_each(|skill| world.after(*skill));
    world.lid = true;
    let skills = [Uncover, Nudge(0)].map(|skill| (skill, Vector3::zeros()));
    let shown = world.demonstrate("correction", &skills, Kind::Corrective, true);
    let trace = task.correct(Correction::after(last, &shown)).unwrap();
    assert_eq!(
        task.rounds().iter().map(|round| round.chosen.unwrap().edit()).collect::<Vec<_>>(),
        [Edit::NodeAddition; 2]
    );
    let graph = task.graph();
    let [first, second] = [&trace.steps[0], &trace.steps[1]].map(|step| Place::Node(step.node));
    assert_eq!(graph.nodes.len(), 6);
    for edge in [(last, first), (first, second), (second, Place::End)] {
        assert!(graph.edges.contains(&edge), "{edge:?} of {:?}", graph.edges);
    }
}

/// Nothing varies: a hand that does not move, in a world that does not change.
#[test]
fn a_task_that_stands_still_can_be_corrected() {
    let keyframe = Keyframe {
        reference: "table".into(),
        reference_pose: Pose::identity(),
        gripper_pose: Pose::identity(),
        gripper: Gripper::Open(0.08),
        hold: 0.0,
        state: State::new([0.0; 9]),
        narration: None,
    };
    let still = |kind| Demonstration::new("still", kind, &schema(), vec![keyframe.clone()], State::new([0.0; 9]), true);
    let originals = [still(Kind::Original).unwrap(), still(Kind::Original).unwrap()];
    let mut task = ItmcdTask::teach(&schema(), &originals, ItmcdParameters::default()).unwrap();
    task.correct(Correction::after(Place::Start, &still(Kind::Corrective).unwrap())).unwrap();
    assert_eq!(chosen(&task), Some(Edit::None));
}

/// Corrections as nobody gives them: one keyframe, about a known object or an unknown one, from anywhere, again and
/// again, after a single original. Each is folded in or refused, and what is left is a model that runs and that repeats
/// itself.
#[test]
fn odd_corrections_are_folded_in_or_refused() {
    let keyframe = |object: &str, at: f64| Keyframe {
        reference: object.into(),
        reference_pose: Pose::identity(),
        gripper_pose: Pose::translation(at, 0.0, 0.0),
        gripper: Gripper::Open(0.08),
        hold: 0.0,
        state: State::new([at.min(3.0); 9]),
        narration: None,
    };
    for count in [1, 2] {
        let originals = originals(count, 4, 0.005);
        let run = || {
            let task = ItmcdTask::teach(&schema(), &originals, ItmcdParameters::default()).unwrap();
            let mut task = Box::new(task) as Box<dyn Learned>;
            let mut edits = Vec::new();
            for (draw, object) in ["bin-0", "nowhere", "nowhere", "block-1"].into_iter().enumerate() {
                for (at, ends) in [(0.0, false), (1e3, true), (0.0, true)] {
                    let before = task.graph();
                    let ids: Vec<Place> = before.nodes.iter().map(|node| Place::Node(node.id)).collect();
                    let last = if draw % 2 == 0 { Place::Start } else { ids[draw % ids.len()] };
                    let (shown, state) = (vec![keyframe(object, at)], State::new([at.min(3.0); 9]));
                    let shown = Demonstration::new("odd", Kind::Corrective, &schema(), shown, state, ends).unwrap();
                    let trace = task.correct(Correction::after(last, &shown)).unwrap();
                    assert!(trace.steps.len() <= 1 && trace.counters.em_iterations > 0, "{trace:?}");
                    edits.push(difference(&before, &task.graph()).edit());
                }
            }
            assert!(edits.contains(&Edit::NodeAddition), "nothing else makes an unknown object possible: {edits:?}");
            let mut rng = ChaCha8Rng::seed_from_u64(0);
            for node in &task.graph().nodes {
                assert!(!task.keyframes(node.id, Execution::Sample, &mut rng).unwrap().1.is_empty());
            }
            task.to_json()
        };
        assert_eq!(run(), run());
    }
}
