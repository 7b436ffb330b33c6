//! A learner on a line, none of whose decisions comes from the crate's kernels: a policy is a mean position, two
//! policies are one where they are near. It shows the structure of an update alone, and thousands of updates a second.

use std::collections::BTreeMap;
use std::sync::Arc;

use situ::demonstration::Pose;
use situ::error::SituError;
use situ::primitive::{Clustering, Initiation, Learner};
use situ::segment::Segment;
use situ::state::State;
use situ::trace::Counters;

/// Two distances: nearer than `taught`, segments share a node in a full retraining; nearer than `found`, in an update.
/// Where `taught` is the smaller, originals are fragmented and updates find redundant nodes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Toy {
    pub(crate) taught: f64,
    pub(crate) found: f64,
    /// The numbers of a state, each of scale 1; at most 3.
    pub(crate) features: usize,
}

impl Toy {
    /// A learner for states of one number, which finds what is nearer than 2.
    pub(crate) const fn on_a_line(taught: f64) -> Self {
        Self { taught, found: 2.0, features: 1 }
    }
}

/// Reference object and mean position of the first keyframe.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Line {
    pub(crate) reference: Arc<str>,
    pub(crate) x: f64,
}

/// Remembers its samples: the nearest decides, and only what is near a positive is applicable.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Nearest {
    positives: Vec<State>,
    negatives: Vec<State>,
}

/// Greatest distance of an applicable state from a positive.
const REACH: f64 = 2.0;

fn nearest(samples: &[State], state: &State) -> f64 {
    let apart = |sample: &State| {
        let squares = sample.values().iter().zip(state.values()).map(|(one, other)| (one - other) * (one - other));
        squares.sum::<f64>().sqrt()
    };
    samples.iter().map(apart).fold(f64::INFINITY, f64::min)
}

impl Initiation for Nearest {
    fn probability(&self, state: &State) -> f64 {
        // A distance of 1 from the nearest negative is always left over, so that no sample decides alone.
        let (own, other) = (nearest(&self.positives, state), nearest(&self.negatives, state).min(1e6));
        (1.0 + other) / (2.0 + own + other)
    }

    fn is_applicable(&self, state: &State) -> bool {
        self.probability(state) >= 0.5 && nearest(&self.positives, state) <= REACH
    }
}

fn x(segment: &Segment) -> f64 {
    segment.keyframes[0].pose.translation.x
}

/// Chains of things on one object, each with a point that is nearer than `width` to one of the next: labels, in order
/// of first appearance.
fn chains(things: &[(Arc<str>, Vec<f64>)], width: f64) -> Vec<usize> {
    let is_near = |(one, left): &(Arc<str>, Vec<f64>), (other, right): &(Arc<str>, Vec<f64>)| {
        one == other && left.iter().any(|left| right.iter().any(|right| (left - right).abs() < width))
    };
    let mut labels: Vec<usize> = (0..things.len()).collect();
    for _ in 0..things.len() {
        for left in 0..things.len() {
            for right in 0..things.len() {
                if is_near(&things[left], &things[right]) {
                    labels[left] = labels[left].min(labels[right]);
                }
            }
        }
    }
    let mut names = BTreeMap::new();
    labels
        .iter()
        .map(|label| {
            let next = names.len();
            *names.entry(*label).or_insert(next)
        })
        .collect()
}

impl Learner for Toy {
    type Policy = Line;
    type Classifier = Nearest;
    type Calibration = ();

    fn fit_policy(&self, segments: &[&Segment], (): &(), _: &mut Counters) -> Result<Line, SituError> {
        let mean = segments.iter().map(|segment| x(segment)).sum::<f64>() / segments.len() as f64;
        Ok(Line { reference: segments[0].reference.clone(), x: mean })
    }

    fn fit_classifier(
        &self,
        positives: &[&State],
        negatives: &[&State],
        _: &mut Counters,
    ) -> Result<Nearest, SituError> {
        let owned = |states: &[&State]| states.iter().copied().cloned().collect();
        Ok(Nearest { positives: owned(positives), negatives: owned(negatives) })
    }

    fn cluster_and_find(
        &self,
        own: &Line,
        candidates: &[Vec<&Line>],
        _: &[f64],
        (): &(),
        _: &mut Counters,
    ) -> Clustering {
        let own = vec![own];
        let points = |ways: &Vec<&Line>| (ways[0].reference.clone(), ways.iter().map(|line| line.x).collect());
        let points: Vec<_> = candidates.iter().chain([&own]).map(points).collect();
        let labels = chains(&points, self.found);
        let (own, others) = labels.split_last().expect("the segment's own");
        let mut clusters: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (index, label) in others.iter().enumerate() {
            clusters.entry(*label).or_default().push(index);
        }
        let matched = clusters.remove(own).unwrap_or_default();
        Clustering { matched, redundant: clusters.into_values().filter(|group| group.len() > 1).collect() }
    }

    fn distance(&self, left: &Line, right: &Line, _: Option<&()>, _: &mut Counters) -> f64 {
        if left.reference == right.reference { (left.x - right.x).abs() } else { f64::INFINITY }
    }

    fn calibrate(&self, _: &[&[Arc<Segment>]], _: &mut Counters) -> Result<(), SituError> {
        Ok(())
    }

    fn cluster(&self, segments: &[&Segment], (): &(), _: &mut Counters) -> Result<Vec<usize>, SituError> {
        let points: Vec<_> = segments.iter().map(|segment| (segment.reference.clone(), vec![x(segment)])).collect();
        Ok(chains(&points, self.taught))
    }

    fn scales(&self) -> &[f64] {
        &[1.0; 3][..self.features]
    }

    fn path(&self, policy: &Line) -> Vec<Pose> {
        vec![Pose::translation(policy.x, 0.0, 0.0)]
    }
}
