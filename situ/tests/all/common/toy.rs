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
    positives: Vec<f64>,
    negatives: Vec<f64>,
}

/// Greatest distance of an applicable state from a positive.
const REACH: f64 = 2.0;

fn nearest(samples: &[f64], state: &State) -> f64 {
    samples.iter().map(|sample| (sample - state.values()[0]).abs()).fold(f64::INFINITY, f64::min)
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

/// Chains of points on one object, each nearer than `width` to the next: labels, in order of first appearance.
fn chains(points: &[(Arc<str>, f64)], width: f64) -> Vec<usize> {
    let mut labels: Vec<usize> = (0..points.len()).collect();
    for _ in 0..points.len() {
        for left in 0..points.len() {
            for right in 0..points.len() {
                if points[left].0 == points[right].0 && (points[left].1 - points[right].1).abs() < width {
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

    fn fit_policy(&self, segments: &[&Segment], _: &mut Counters) -> Result<Line, SituError> {
        let mean = segments.iter().map(|segment| x(segment)).sum::<f64>() / segments.len() as f64;
        Ok(Line { reference: segments[0].reference.clone(), x: mean })
    }

    fn fit_classifier(
        &self,
        positives: &[&State],
        negatives: &[&State],
        _: &mut Counters,
    ) -> Result<Nearest, SituError> {
        let values = |states: &[&State]| states.iter().map(|state| state.values()[0]).collect();
        Ok(Nearest { positives: values(positives), negatives: values(negatives) })
    }

    fn cluster_and_find(&self, own: &Line, candidates: &[&Line], _: &[f64], (): &(), _: &mut Counters) -> Clustering {
        let points: Vec<_> = candidates.iter().chain([&own]).map(|line| (line.reference.clone(), line.x)).collect();
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
        let points: Vec<_> = segments.iter().map(|segment| (segment.reference.clone(), x(segment))).collect();
        Ok(chains(&points, self.taught))
    }

    fn path(&self, policy: &Line) -> Vec<Pose> {
        vec![Pose::translation(policy.x, 0.0, 0.0)]
    }
}
