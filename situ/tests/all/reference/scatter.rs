//! The teacher's own scatter (decision D21), by brute force: every way to lay one list of keyframes into another.

use std::collections::BTreeMap;
use std::sync::Arc;

use situ::demonstration::{Gripper, Pose};
use situ::keyframe::hmm::HmmParameters;
use situ::keyframe::scatter::ScatterParameters;
use situ::segment::Segment;

use crate::reference::pose::log;

/// An opening that changes by more than this share of the stroke is another command.
const STROKE: f64 = 0.2;
/// The steps of an integral.
const STEPS: usize = 400;

/// A keyframe: its pose, and whether the hand closes or opens there.
pub(crate) type Laid = (Pose, bool);

/// The deviation of positions along an axis, metres, and of rotations about each axis of the gripper's frame, radians.
pub(crate) type Deviations = (f64, [f64; 3]);

/// The scatter at contacts and at all other keyframes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scattered {
    pub(crate) contact: Deviations,
    pub(crate) free: Deviations,
    pub(crate) is_clamped: bool,
}

/// Keyframes with their contacts. What the hand did before the first is unknown.
pub(crate) fn with_contacts(keyframes: &[(Pose, Gripper)]) -> Vec<Laid> {
    let is_contact = |index: usize| {
        index > 0
            && match (keyframes[index - 1].1, keyframes[index].1) {
                (Gripper::Opening(before), Gripper::Opening(after)) => (before - after).abs() > STROKE,
                (Gripper::Open(_), Gripper::Open(_)) | (Gripper::Close(_), Gripper::Close(_)) => false,
                _ => true,
            }
    };
    (0..keyframes.len()).map(|index| (keyframes[index].0, is_contact(index))).collect()
}

/// How far apart two keyframes are, metres.
pub(crate) fn metres(one: &Laid, other: &Laid) -> f64 {
    (one.0.translation.vector - other.0.translation.vector).norm()
}

/// Every way to lay the shorter list into the longer one in order: the partner of each of the shorter.
pub(crate) fn ways(short: usize, long: usize) -> Vec<Vec<usize>> {
    if short == 0 {
        return vec![Vec::new()];
    }
    let last = |partner: usize| {
        ways(short - 1, partner).into_iter().map(move |before| before.into_iter().chain([partner]).collect())
    };
    (short - 1..long).flat_map(last).collect()
}

/// The partners with the least sum of squared distances.
fn partners<'a>(left: &'a [Laid], right: &'a [Laid]) -> Vec<(&'a Laid, &'a Laid)> {
    let (short, long) = if left.len() <= right.len() { (left, right) } else { (right, left) };
    let all = ways(short.len(), long.len()).into_iter();
    let pairs = all.map(|way| short.iter().zip(way.into_iter().map(|partner| &long[partner])).collect::<Vec<_>>());
    let sum = |pairs: &Vec<(&Laid, &Laid)>| pairs.iter().map(|(one, other)| metres(one, other).powi(2)).sum::<f64>();
    pairs.min_by(|one, other| sum(one).total_cmp(&sum(other))).expect("there is one way at least")
}

/// What a χ² variable of `freedom` degrees, the squared length of as many normal numbers, is below with probability
/// `share`.
pub(crate) fn chi_squared(freedom: i32, share: f64) -> f64 {
    // The length has a density in proportion to this; beyond 12 there is nothing.
    let density = |length: f64| length.powi(freedom - 1) * (-0.5 * length * length).exp();
    let below = |length: f64| {
        let step = length / STEPS as f64;
        let simpson = |at: usize| if at == 0 || at == STEPS { 1.0 } else { [2.0, 4.0][at % 2] };
        (0..=STEPS).map(|at| simpson(at) * density(at as f64 * step)).sum::<f64>() * step / 3.0
    };
    let (whole, mut low, mut high) = (below(12.0), 0.0, 12.0);
    while high - low > 1e-12 {
        let middle = 0.5 * (low + high);
        if below(middle) < share * whole { low = middle } else { high = middle }
    }
    low * low
}

/// The middle of some numbers.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let count = values.len();
    0.5 * (values[(count - 1) / 2] + values[count / 2])
}

impl Scattered {
    /// The scatter of the teacher of these originals.
    pub(crate) fn of(originals: &[&[Arc<Segment>]], rule: &ScatterParameters) -> Self {
        // A role is the k-th visit to an object.
        let mut roles: BTreeMap<(&str, usize), Vec<Vec<Laid>>> = BTreeMap::new();
        for segments in originals {
            for (index, segment) in segments.iter().enumerate() {
                let visit = segments[..index].iter().filter(|before| before.reference == segment.reference).count();
                let keyframes: Vec<_> = segment.keyframes.iter().map(|at| (at.pose, at.gripper)).collect();
                roles.entry((&segment.reference, visit)).or_default().push(with_contacts(&keyframes));
            }
        }
        let mut all = Vec::new();
        for shown in roles.values() {
            for (index, left) in shown.iter().enumerate() {
                all.extend(shown[..index].iter().flat_map(|right| partners(left, right)));
            }
        }
        let pairs = |contact: bool| all.iter().filter(move |(one, other)| (one.1 && other.1) == contact);
        let mut is_clamped = false;
        let mut deviation = |squares: Vec<f64>, freedom: i32, prior: f64, least: f64, greatest: f64| {
            // Both of a pair scatter.
            let count = squares.len() as f64;
            let sum = if squares.is_empty() { 0.0 } else { median(squares) / chi_squared(freedom, 0.5) / 2.0 * count };
            let believed = ((sum + rule.prior_pairs * prior * prior) / (count + rule.prior_pairs)).sqrt();
            is_clamped |= !(least..=greatest).contains(&believed);
            believed.max(least).min(greatest)
        };
        let ((metres_prior, radians_prior), least, greatest) = (rule.prior, rule.least, rule.greatest);
        let [contact, free] = [true, false].map(|contact| {
            let lengths = pairs(contact).map(|(one, other)| metres(one, other).powi(2)).collect();
            let position = deviation(lengths, 3, metres_prior, least.0, greatest.0);
            let rotation = [3, 4, 5].map(|axis| {
                let squares = pairs(contact).map(|(one, other)| log(&one.0, &other.0)[axis].powi(2)).collect();
                deviation(squares, 1, radians_prior, least.1, greatest.1)
            });
            (position, rotation)
        });
        Self { contact, free, is_clamped }
    }

    /// The parameters of a signature: no axis is thought to be steadier than the teacher.
    pub(crate) fn floor(&self, rule: &HmmParameters) -> HmmParameters {
        let greatest = |own: f64, contact: f64, free: f64| [own, contact, free].into_iter().fold(0.0, f64::max);
        let rotation = |axis: usize| greatest(rule.rotation_floor[axis], self.contact.1[axis], self.free.1[axis]);
        HmmParameters {
            position_floor: greatest(rule.position_floor, self.contact.0, self.free.0),
            rotation_floor: [rotation(0), rotation(1), rotation(2)],
            ..*rule
        }
    }
}
