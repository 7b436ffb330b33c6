//! Block sorting without physics, as in the paper's simulated evaluation: two blocks, two bins, and corrections that
//! need a known edit.
//!
//! A state is the place of each block, whether it is held, and whether a lid is on the bins. The effect of a skill on
//! the world is written down, not simulated. The table is laid anew for every demonstration.

use std::sync::Arc;

use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use situ::demonstration::{Demonstration, Gripper, Keyframe, Kind, Pose};
use situ::edit::Edit;
use situ::keyframe::pose::{Tangent, exp};
use situ::random::{standard_normal, stream};
use situ::state::{Feature, Schema, State};

use Skill::{Drop, Nudge, Pick, Tap, Uncover};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Skill {
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

/// What the originals show.
pub(crate) const TASK: [Skill; 4] = [Pick(0), Drop(0), Pick(1), Drop(1)];

/// What a correction shows, and why it is needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Need {
    /// Nothing new: the robot stopped.
    Nothing,
    /// The first block is in its bin already.
    Sorted,
    /// A block slipped from the hand: the robot picks it once more.
    Slipped,
    /// A block jumped out of its bin: the robot goes back to it.
    Jumped,
    /// A lid is on the bins.
    Lid,
    /// The other block stands in the way of the first.
    InTheWay,
    /// At the end, the first bin needs a tap: a new skill about a known object, with the hand as open as after a drop.
    Unsettled,
    /// A bin stands higher and further away.
    HighBin,
    /// A block has to be taken 12 cm from where it was.
    OtherGrasp,
}

impl Need {
    pub(crate) const ALL: [Self; 9] = [
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

    pub(crate) fn edit(self) -> Edit {
        match self {
            Self::Nothing => Edit::None,
            Self::Sorted | Self::Slipped | Self::Jumped => Edit::EdgeAddition,
            Self::Lid | Self::InTheWay | Self::Unsettled => Edit::NodeAddition,
            Self::HighBin | Self::OtherGrasp => Edit::NodeModification,
        }
    }

    /// How many skills of the task have run, and what is shown then.
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

/// Ideal keyframes: a position relative to the reference object, metres, and the command from there on.
type Way = [([f64; 3], Gripper); 3];

/// The table with the blocks and bins.
pub(crate) struct World {
    blocks: [Vector3<f64>; 2],
    bins: [Vector3<f64>; 2],
    held: [bool; 2],
    pub(crate) lid: bool,
    rng: ChaCha8Rng,
    noise: f64,
}

impl World {
    pub(crate) fn new(seed: u64, noise: f64) -> Self {
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

    /// Applies the effect of a skill.
    pub(crate) fn after(&mut self, skill: Skill) {
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

    /// The reference object of a skill, its place, and the ideal keyframes relative to it.
    fn way(&self, skill: Skill) -> (String, Vector3<f64>, Way) {
        let (open, closed) = (Gripper::Open(0.08), Gripper::Close(20.0));
        match skill {
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
        }
    }

    /// What a novice shows of a way. With 15 % probability there is one keyframe too many before a keyframe, somewhere
    /// near. Of the keyframes that do nothing to the hand, 7 % are left out.
    fn as_novices_do(&mut self, way: Way) -> Vec<([f64; 3], Gripper)> {
        let mut shown = Vec::new();
        let mut before = None;
        for (place, gripper) in way {
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
    }

    /// The keyframes of a skill, moved by `moved`.
    fn show(&mut self, skill: Skill, moved: Vector3<f64>) -> Vec<Keyframe> {
        let (name, at, way) = self.way(skill);
        let reference: Arc<str> = name.into();
        let reference_pose = Pose::from_parts(Translation3::from(at), UnitQuaternion::identity());
        let state = self.state();
        let shown = self.as_novices_do(way);
        let keyframe = |(place, gripper): ([f64; 3], Gripper)| {
            let mean = Pose::from_parts(Translation3::from(Vector3::from(place) + moved), UnitQuaternion::identity());
            let noise = self.noise;
            let error = Tangent::from_fn(|axis, _| self.normal(if axis < 3 { noise } else { 4.0 * noise }));
            Keyframe {
                reference: reference.clone(),
                reference_pose,
                gripper_pose: reference_pose * exp(&mean, &error),
                gripper,
                hold: 0.0,
                state: state.clone(),
                announced: false,
                narration: None,
            }
        };
        shown.into_iter().map(keyframe).collect()
    }

    pub(crate) fn demonstrate(
        &mut self,
        name: &str,
        skills: &[(Skill, Vector3<f64>)],
        kind: Kind,
        end: bool,
    ) -> Demonstration {
        let mut keyframes = Vec::new();
        for (skill, moved) in skills {
            keyframes.extend(self.show(*skill, *moved));
            self.after(*skill);
        }
        let last = self.state();
        Demonstration::new(name, kind, &schema(), keyframes, last, end).unwrap()
    }
}

pub(crate) fn schema() -> Schema {
    let mut features = Vec::new();
    for block in 0..2 {
        features.extend(["x", "y", "z"].map(|axis| Feature { name: format!("{axis}({block})"), scale: 0.2 }));
        features.push(Feature { name: format!("held({block})"), scale: 0.5 });
    }
    features.push(Feature { name: "lid".to_owned(), scale: 0.5 });
    Schema::new(features).unwrap()
}

pub(crate) fn originals(count: usize, seed: u64, noise: f64) -> Vec<Demonstration> {
    let still = TASK.map(|skill| (skill, Vector3::zeros()));
    (0..count)
        .map(|index| {
            let name = format!("original-{index}");
            World::new(stream(seed, &name), noise).demonstrate(&name, &still, Kind::Original, true)
        })
        .collect()
}

/// A correction, and how many skills of the task had run before it.
pub(crate) fn correction(need: Need, seed: u64, noise: f64) -> (usize, Demonstration) {
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
    // 12 cm, as for the high bins of the design.
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
