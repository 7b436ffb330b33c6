//! Random tasks whose structure is known, models that are taught by them, and corrections that need a known edit.

pub(crate) mod known;
pub(crate) mod soak;
pub(crate) mod structure;
pub(crate) mod toy;

use std::collections::BTreeSet;
use std::sync::Arc;

use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::correction::{Correction as Corrected, Oracle};
use situ::decisions::Decisions;
use situ::demonstration::{Demonstration, Gripper, Keyframe, Kind, Pose};
use situ::edit::Edit;
use situ::fold::situ;
use situ::keyframe::learner::KeyframeLearner;
use situ::keyframe::parameters::KeyframeParameters;
use situ::keyframe::pose::{Tangent, exp};
use situ::method::rebuild::rebuild;
use situ::place::{Place, SegmentId};
use situ::primitive::Learner;
use situ::random::{standard_normal, stream};
use situ::segmentation::by_reference_object;
use situ::state::{Feature, Schema, State};
use situ::task_model::{History, TaskModel};
use situ::trace::Trace;

/// A keyframe task model.
pub(crate) type Model = TaskModel<KeyframeLearner>;

/// Scale of every feature (D16: offsets and distances), metres.
const SCALE: f64 = 0.2;
/// What a skill changes in its progress feature, metres: an object carried to its goal.
const DONE: f64 = 0.4;
/// Distance between the paths of two skills on one object, metres.
const APART: f64 = 0.4;
/// How far a modified path is from the old one, metres: 12 cm, as the higher bins of the design. Not straight up: a
/// path that runs up and down, shifted along itself, is within the cut and averaged (decision D18).
const MOVED: [f64; 3] = [0.07, 0.0, 0.0975];
/// A careful teacher: metres, radians, and metres in the observed state.
pub(crate) const CAREFUL: Noise = Noise { position: 0.005, rotation: 0.03, state: 0.01 };
/// No noise at all.
pub(crate) const EXACT: Noise = Noise { position: 0.0, rotation: 0.0, state: 0.0 };

/// Standard deviations of what a teacher does and of what is seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    pub(crate) position: f64,
    pub(crate) rotation: f64,
    pub(crate) state: f64,
}

/// A skill: a path about an object.
#[derive(Clone, Debug)]
struct Skill {
    name: Arc<str>,
    object: usize,
    path: Vec<(Pose, Gripper)>,
}

/// A task: skills in a row, of which one may be optional. Consecutive skills have different objects.
#[derive(Clone, Debug)]
pub(crate) struct Task {
    pub(crate) schema: Schema,
    skills: Vec<Skill>,
    /// Known to no original: the last path of an object that the task uses, or the first of one that it does not.
    spare: Skill,
    /// Left out by the second original.
    optional: Option<usize>,
    objects: usize,
    seed: u64,
}

/// What a correction shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Planted {
    /// What the task does next, from one of its states.
    Covered,
    /// A skill that the model does not know, then the one that was expected.
    NewNode,
    /// The skill after the next, and the one behind it.
    NewEdge,
    /// The skill that has just run, once more.
    SelfLoop,
    /// The next skill, every keyframe moved by 12 cm.
    Modified,
}

impl Planted {
    pub(crate) const ALL: [Self; 5] = [Self::Covered, Self::NewNode, Self::NewEdge, Self::SelfLoop, Self::Modified];

    /// The edit that it needs.
    pub(crate) fn edit(self) -> Edit {
        match self {
            Self::Covered => Edit::None,
            Self::NewNode => Edit::NodeAddition,
            Self::NewEdge | Self::SelfLoop => Edit::EdgeAddition,
            Self::Modified => Edit::NodeModification,
        }
    }
}

/// A correction, and where it begins.
#[derive(Clone, Debug)]
pub(crate) struct Correction {
    planted: Planted,
    pub(crate) demonstration: Demonstration,
    /// A segment of the node that ran last.
    after: SegmentId,
}

impl Correction {
    /// The place that ran last.
    pub(crate) fn last(&self, model: &Model) -> Place {
        Place::Node(model.node_of(self.after).expect("the first original visits every skill"))
    }

    /// What an oracle says: of a modification, which skills have changed.
    pub(crate) fn oracle(&self) -> Oracle {
        let first = self.demonstration.keyframes()[0].narration.clone();
        Oracle { changed: first.filter(|_| self.planted == Planted::Modified).into_iter().collect() }
    }

    /// The place that ran last, in a model of which only the graph is seen.
    pub(crate) fn last_in(&self, graph: &situ::graph::Graph) -> Place {
        Place::Node(graph.holders()[&self.after].id)
    }
}

/// One skill in a demonstration: from which progress, and moved by how much.
struct Act<'a> {
    skill: &'a Skill,
    moved: Vector3<f64>,
    done: Vec<bool>,
    blocked: bool,
}

impl Task {
    /// A random task of so many skills, at least 4, over so many objects, at least 3.
    pub(crate) fn new(seed: u64, skills: usize, objects: usize) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(stream(seed, "task"));
        let mut sites = vec![0; objects + 1];
        let mut skill = |object: usize, rng: &mut ChaCha8Rng| {
            let site = sites[object];
            sites[object] += 1;
            Skill { name: format!("{object}-{site}").into(), object, path: path(site, rng) }
        };
        let mut row: Vec<Skill> = Vec::new();
        while row.len() < skills {
            let object = rng.random_range(0..objects);
            // Three in a row differ, so that one can be left out.
            if row.iter().rev().take(2).all(|before| before.object != object) {
                row.push(skill(object, &mut rng));
            }
        }
        let object = if rng.random() { objects } else { rng.random_range(0..objects) };
        let spare = skill(object, &mut rng);
        let optional = rng.random::<bool>().then(|| rng.random_range(1..skills - 1));
        let progress = (0..skills).map(|index| format!("done({index})"));
        let places = (0..objects).map(|index| format!("place({index})"));
        let names = progress.chain(places).chain(["blocked".to_owned()]);
        let schema = Schema::new(names.map(|name| Feature { name, scale: SCALE }).collect()).unwrap();
        Self { schema, skills: row, spare, optional, objects, seed }
    }

    /// The original demonstrations: at least two, the first through every skill, the second without the optional one.
    pub(crate) fn originals(&self, count: usize, noise: Noise) -> Vec<Demonstration> {
        (0..count)
            .map(|index| {
                let visited = (0..self.skills.len()).filter(|skill| !(index == 1 && self.optional == Some(*skill)));
                let acts: Vec<Act<'_>> = visited.map(|skill| self.act(skill, skill)).collect();
                self.demonstrate(&format!("original-{index}"), Kind::Original, &acts, noise, true)
            })
            .collect()
    }

    /// A correction. `draw` chooses the place and the noise.
    pub(crate) fn correction(&self, planted: Planted, draw: u64, noise: Noise, carried_to_end: bool) -> Correction {
        let last = self.skills.len() - 1;
        let may_follow = |k: &usize| match planted {
            Planted::Covered | Planted::NewNode | Planted::Modified => *k < last,
            Planted::NewEdge => k + 2 <= last && self.optional != Some(k + 1),
            Planted::SelfLoop => true,
        };
        let places: Vec<usize> = (0..=last).filter(may_follow).collect();
        let mut rng = ChaCha8Rng::seed_from_u64(stream(draw, "place"));
        let k = places[rng.random_range(0..places.len())];
        let mut acts = Vec::new();
        match planted {
            Planted::Covered => acts.push(self.act(k + 1, k + 1)),
            Planted::NewNode => {
                // A segment of an object is cut where the object changes.
                let next = self.act(k + 1, k + 1);
                let new = Act { skill: &self.spare, blocked: true, moved: Vector3::zeros(), done: next.done.clone() };
                acts.push(new);
                if next.skill.object != self.spare.object {
                    acts.push(next);
                }
            }
            // Somebody has done the next skill already.
            Planted::NewEdge => acts.push(self.act(k + 2, k + 2)),
            // The skill that has just run has had no effect.
            Planted::SelfLoop => acts.push(self.act(k, k)),
            Planted::Modified => acts.push(Act { moved: Vector3::from(MOVED), ..self.act(k + 1, k + 1) }),
        }
        let next = match planted {
            Planted::NewEdge => k + 3,
            Planted::SelfLoop => k + 1,
            Planted::NewNode if acts.len() == 1 => last + 1,
            _ => k + 2,
        };
        if carried_to_end {
            acts.extend((next..=last).map(|skill| self.act(skill, skill)));
        }
        let name = format!("{planted:?}-{draw}");
        Correction {
            planted,
            demonstration: self.demonstrate(&name, Kind::Corrective, &acts, noise, carried_to_end),
            after: SegmentId { demonstration: 0, index: k as u32 },
        }
    }

    /// A skill, begun where the first `progress` skills are done.
    fn act(&self, skill: usize, progress: usize) -> Act<'_> {
        let done = (0..self.skills.len()).map(|index| index < progress).collect();
        Act { skill: &self.skills[skill], moved: Vector3::zeros(), done, blocked: false }
    }

    fn demonstrate(
        &self,
        name: &str,
        kind: Kind,
        acts: &[Act<'_>],
        noise: Noise,
        carried_to_end: bool,
    ) -> Demonstration {
        let mut rng = ChaCha8Rng::seed_from_u64(stream(self.seed, name));
        let mut normal = |deviation: f64| deviation * standard_normal(&mut rng);
        // The table is laid anew for every demonstration.
        let table: Vec<Pose> = (0..=self.objects)
            .map(|_| {
                let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, normal(0.5));
                Pose::from_parts(Translation3::new(normal(0.2), normal(0.2), 0.0), turn)
            })
            .collect();
        let places: Vec<f64> = (0..self.objects).map(|_| normal(0.05)).collect();
        let state = |done: &[bool], blocked: bool, normal: &mut dyn FnMut(f64) -> f64| {
            let progress = done.iter().map(|done| if *done { 0.0 } else { DONE }).chain(places.iter().copied());
            let values = progress.chain([if blocked { DONE } else { 0.0 }]);
            State::new(values.map(|value| value + normal(noise.state)).collect::<Vec<_>>())
        };
        let mut keyframes = Vec::new();
        for act in acts {
            let state = state(&act.done, act.blocked, &mut normal);
            let frame = table[act.skill.object];
            for (pose, gripper) in &act.skill.path {
                let mean = Pose::from_parts(Translation3::from(pose.translation.vector + act.moved), pose.rotation);
                let error = Tangent::from_fn(|axis, _| normal(if axis < 3 { noise.position } else { noise.rotation }));
                keyframes.push(Keyframe {
                    reference: format!("object-{}", act.skill.object).into(),
                    reference_pose: frame,
                    gripper_pose: frame * exp(&mean, &error),
                    gripper: *gripper,
                    hold: 0.0,
                    state: state.clone(),
                    announced: false,
                    narration: Some(act.skill.name.clone()),
                });
            }
        }
        let done = vec![true; self.skills.len()];
        let done = if carried_to_end { &done } else { &acts[acts.len() - 1].done };
        let last = state(done, false, &mut normal);
        Demonstration::new(name, kind, &self.schema, keyframes, last, carried_to_end).unwrap()
    }

    /// The model of the original demonstrations, by the kernels of `situ`, and a learner of these parameters.
    pub(crate) fn taught(&self, noise: Noise, parameters: KeyframeParameters) -> (Model, KeyframeLearner) {
        let teacher = KeyframeLearner::new(&self.schema, KeyframeParameters::default());
        let model = rebuild(histories(&self.originals(3, noise)), None, &teacher, &Decisions::mended()).unwrap().0;
        (model, KeyframeLearner::new(&self.schema, parameters))
    }

    /// Whether each skill is one node of the model, as the originals visit them.
    pub(crate) fn is_recovered(&self, model: &Model) -> bool {
        let mut holders = vec![BTreeSet::new(); self.skills.len()];
        for (index, history) in model.histories().iter().enumerate() {
            let visited = (0..self.skills.len()).filter(|skill| !(index == 1 && self.optional == Some(*skill)));
            for (skill, node) in visited.zip(&history.nodes) {
                holders[skill].insert(*node);
            }
        }
        holders.iter().all(|holders| holders.len() == 1) && model.len() == self.skills.len()
    }
}

/// A path at a site of its object: towards it, on it, and away, with a turn of its own.
fn path(site: usize, rng: &mut ChaCha8Rng) -> Vec<(Pose, Gripper)> {
    let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, rng.random_range(-1.0..1.0));
    let (far, high) = (rng.random_range(-0.05..0.05), rng.random_range(0.15..0.25));
    let stops =
        [(far, high, Gripper::Open(0.08)), (0.0, 0.02, Gripper::Close(20.0)), (-far, 0.2, Gripper::Close(20.0))];
    let pose = |along: f64, height: f64| Pose::from_parts(Translation3::new(APART * site as f64, along, height), turn);
    stops.into_iter().map(|(along, height, gripper)| (pose(along, height), gripper)).collect()
}

/// The demonstrations cut into segments, all from START.
pub(crate) fn histories(demonstrations: &[Demonstration]) -> Vec<History> {
    demonstrations.iter().map(|shown| History::new(shown, by_reference_object(shown), None)).collect()
}

/// A demonstration of one keyframe a word: its object and where along x the hand goes; its states are one number.
pub(crate) fn spelt(words: &[(u8, f64, f64)], last: f64, carried_to_end: bool) -> Demonstration {
    let words: Vec<_> = words.iter().map(|(object, x, state)| (*object, *x, [*state])).collect();
    written(Kind::Original, false, &words, [last], carried_to_end)
}

/// The same, given to mend a failure.
pub(crate) fn corrective(words: &[(u8, f64, f64)], last: f64, carried_to_end: bool) -> Demonstration {
    let words: Vec<_> = words.iter().map(|(object, x, state)| (*object, *x, [*state])).collect();
    written(Kind::Corrective, false, &words, [last], carried_to_end)
}

/// A demonstration of one keyframe a word, in states of `N` numbers. Each names its object anew where they are
/// `announced`.
pub(crate) fn written<const N: usize>(
    kind: Kind,
    announced: bool,
    words: &[(u8, f64, [f64; N])],
    last: [f64; N],
    carried_to_end: bool,
) -> Demonstration {
    let feature = |index: usize| Feature { name: format!("s{index}"), scale: 1.0 };
    let schema = Schema::new((0..N).map(feature).collect()).unwrap();
    let keyframe = |(object, x, state): &(u8, f64, [f64; N])| Keyframe {
        reference: Arc::from(char::from(b'a' + object).to_string()),
        reference_pose: Pose::identity(),
        gripper_pose: Pose::translation(*x, 0.0, 0.0),
        gripper: Gripper::Open(0.05),
        hold: 0.0,
        state: State::new(*state),
        announced,
        narration: None,
    };
    let keyframes = words.iter().map(keyframe).collect();
    Demonstration::new("spelt", kind, &schema, keyframes, State::new(last), carried_to_end).unwrap()
}

/// A copy of a model with a correction folded in by SITU, and what was done.
pub(crate) fn folded<L: Learner + Clone>(
    correction: Corrected<'_>,
    model: &TaskModel<L>,
    learner: &L,
    decisions: &Decisions,
) -> (TaskModel<L>, Trace) {
    let mut model = model.clone();
    let trace = situ(correction, &mut model, learner, decisions).expect("it can be learned");
    (model, trace)
}
