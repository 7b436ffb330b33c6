//! Algorithm 1 (SITU) and Algorithm 2 (Local-Update), line by line. `A1.6` is line 6 of the listing of Algorithm 1;
//! `D10` is a decision that the paper leaves open ([`crate::decisions`]).

use std::collections::BTreeSet;

use crate::candidates;
use crate::correction::Correction;
use crate::decisions::{Decisions, Modify};
use crate::demonstration::Segment;
use crate::error::SituError;
use crate::place::{NodeId, Place, SampleId, Samples, SegmentId};
use crate::primitive::Learner;
use crate::segmentation::by_reference_object;
use crate::task_model::{History, TaskModel};
use crate::trace::{Branch, Counters, Step, Trace};

/// A1.1: folds a corrective demonstration into the task model.
///
/// Returns the updated model and what was done. The cost depends on the applicable primitives and their neighbours, not
/// on the size of the model, but for the scan of A1.6.
///
/// # Errors
/// Where the last primitive is END or not in the model, or the interrupted one is not, or the learner refuses a segment; the model is lost
/// then: clone it before.
pub fn situ<L: Learner>(
    correction: Correction<'_>,
    mut model: TaskModel<L>,
    learner: &L,
    decisions: &Decisions,
) -> Result<(TaskModel<L>, Trace), SituError> {
    let Correction { last, mut interrupted, demonstration, told: _ } = correction;
    let mut trace = Trace::default();
    let origin = model.origin(last)?;
    interrupted.map(|id| model.node(id)).transpose()?;
    let segments = model.begin(History::new(demonstration, by_reference_object(demonstration), origin));
    let mut a = last; // A1.2
    for d in &segments {
        // A1.3: for i ← 1 to |D|
        let s = model.segment(*d).start.clone(); // A1.4 (D0: the world before the motion to the first keyframe)
        let mut counters = Default::default();
        let z = model.applicable(&s, &mut counters); // A1.6 (A1.5, d ← D[i], is the loop's own)
        let mut step = local_update(a, interrupted.take(), *d, &z, &mut model, learner, decisions)?; // A1.7
        a = Place::Node(step.node); // A1.7
        counters += step.counters;
        step.counters = counters;
        trace.counters += counters;
        trace.steps.push(step);
    }
    if demonstration.carried_to_end() {
        end(a, segments[0].demonstration, &mut model, learner, decisions, &mut trace.counters)?;
    }
    Ok((model, trace))
}

/// D11: the listing has no END. The final state of a demonstration that was carried on to the end is a positive of END, and where siblings
/// are told (D3), a negative of theirs; `a` is the primitive that ran last.
pub(crate) fn end<L: Learner>(
    a: Place,
    demonstration: u32,
    model: &mut TaskModel<L>,
    learner: &L,
    decisions: &Decisions,
    counters: &mut Counters,
) -> Result<(), SituError> {
    let mut stale = BTreeSet::from([Place::End]);
    let siblings: BTreeSet<Place> = model.children(a).filter(|child| *child != Place::End).collect();
    model.add_final(demonstration);
    let n = model.starts(siblings.iter().copied().chain(decisions.background.neighbours.then_some(a)));
    model.add_negatives(Place::End, &n, true);
    if decisions.push_to_siblings {
        let s = BTreeSet::from([SampleId::Final(demonstration)]);
        stale.extend(siblings.into_iter().filter(|sibling| model.add_negatives(*sibling, &s, true)));
    }
    model.add_edge(a, Place::End);
    model.fit_classifiers(learner, &stale, counters)
}

/// D18: the primitives on the segment's object that it can be showing another way of, the likeliest first: the one that was interrupted,
/// the child of `a` that would have run, and then `a` itself.
pub(crate) fn suspects<L: Learner>(
    model: &TaskModel<L>,
    a: Place,
    interrupted: Option<NodeId>,
    segment: &Segment,
    rule: &Modify,
) -> Result<Vec<NodeId>, SituError> {
    let nodes = model.children(a).filter(|child| matches!(child, Place::Node(_)));
    let likely = nodes
        .map(|child| (model.probability(child, &segment.start), child))
        .reduce(|best, other| if other.0 > best.0 { other } else { best });
    let likely = likely.filter(|(probability, _)| *probability >= rule.min_probability).map(|(_, child)| child);
    let mut suspects = Vec::new();
    for place in interrupted.map(Place::Node).into_iter().chain(likely).chain([a]) {
        if let Place::Node(y) = place
            && model.node(y)?.reference == segment.reference
        {
            suspects.push(y);
        }
    }
    Ok(suspects)
}

/// D18: the first of the suspects that is not too far from the segment, whose own policy this is.
pub(crate) fn near_enough<L: Learner>(
    model: &TaskModel<L>,
    suspects: &[NodeId],
    own: &L::Policy,
    learner: &L,
    rule: &Modify,
    counters: &mut Counters,
) -> Result<Option<NodeId>, SituError> {
    for y in suspects {
        if learner.distance(&model.node(*y)?.policy, own, None, counters) <= rule.max_distance {
            return Ok(Some(*y));
        }
    }
    Ok(None)
}

/// D18: the primitive that the segment is an instance of or shows another way of doing, if any, and whether that way is to replace its own.
///
/// It is the match `i`, and of an unmatched segment the first suspect that is near enough. The policy is replaced where the segment is
/// displaced from it; where it is not, what sets the two apart is noise, and the segment is one more instance.
#[expect(clippy::too_many_arguments, reason = "what a line of the listing knows")]
fn another_way<L: Learner>(
    model: &TaskModel<L>,
    a: Place,
    interrupted: Option<NodeId>,
    i: Option<NodeId>,
    segment: &Segment,
    own: &L::Policy,
    learner: &L,
    rule: &Modify,
    counters: &mut Counters,
) -> Result<Option<(NodeId, bool)>, SituError> {
    let y = match i {
        Some(i) => Some(i),
        None => near_enough(model, &suspects(model, a, interrupted, segment, rule)?, own, learner, rule, counters)?,
    };
    let Some(y) = y else { return Ok(None) };
    Ok(Some((y, learner.displacement(&model.node(y)?.policy, own) >= rule.min_displacement)))
}

/// A2.1: one segment `d`, whose start state is `s`, folded in after `a`, the applicable primitives being `z_set`.
fn local_update<L: Learner>(
    a: Place,
    interrupted: Option<NodeId>,
    d: SegmentId,
    z_set: &[NodeId],
    model: &mut TaskModel<L>,
    learner: &L,
    decisions: &Decisions,
) -> Result<Step, SituError> {
    let mut counters = Default::default();
    let model_size = model.len();
    let segment = model.segment(d).clone();

    // Paper, "Find Policy": a model of d alone comes first; it is the π of A2.8 where d turns out to be new.
    let own = learner.fit_policy(&[&segment], &mut counters)?;
    // A2.2 and A2.4: Cluster and Find-Policy in one (D4, D10).
    let found = candidates::find(model, &segment, &own, z_set, learner, decisions, &mut counters)?;
    // A2.3: Local-Reconnect; `a` and the match may have been merged into another node (D9).
    let renamed = model.local_reconnect(learner, &found.groups, decisions.subtract_own_positives, &mut counters)?;
    let now = |id: NodeId| renamed.get(&id).copied().unwrap_or(id);
    let a = if let Place::Node(id) = a { Place::Node(now(id)) } else { a };
    let (i, interrupted) = (found.node.map(now), interrupted.map(now));
    let way = match &decisions.modify {
        Some(rule) => another_way(model, a, interrupted, i, &segment, &own, learner, rule, &mut counters)?, // D18
        None => i.map(|i| (i, false)),
    };
    let target = match way {
        None => Target::New(own),
        Some((z, true)) => Target::Modify(z, own),
        Some((z, false)) => Target::Existing(z),
    };
    let branch = target.branch();
    let (z, edge_added) = commit(a, d, target, model, learner, decisions, &mut counters)?;
    Ok(Step {
        reference: segment.reference.to_string(),
        applicable: z_set.len(),
        model_size,
        candidates: found.compared,
        matched_in: found.matched_in,
        branch,
        node: z,
        after: a,
        edge_added,
        merged: found.groups.iter().map(|group| (group.clone(), now(group[0]))).collect(),
        counters,
    })
}

/// Where a segment belongs.
pub(crate) enum Target<P> {
    /// To no primitive that there is: a new one, with this policy.
    New(P),
    /// To this one, as one more instance.
    Existing(NodeId),
    /// To this one, whose policy is from now on this, of the segment alone (D18).
    Modify(NodeId, P),
}

impl<P> Target<P> {
    /// The branch of Algorithm 2 that leads there.
    pub(crate) fn branch(&self) -> Branch {
        match self {
            Self::New(_) => Branch::New,
            Self::Existing(_) => Branch::Existing,
            Self::Modify(..) => Branch::Modify,
        }
    }
}

/// A2.5 to A2.21: one segment `d`, placed after `a` in the primitive that it belongs to. Returns that primitive, and whether the edge to it is new.
pub(crate) fn commit<L: Learner>(
    a: Place,
    d: SegmentId,
    target: Target<L::Policy>,
    model: &mut TaskModel<L>,
    learner: &L,
    decisions: &Decisions,
    counters: &mut Counters,
) -> Result<(NodeId, bool), SituError> {
    let s = SampleId::Start(d);
    let subtract = decisions.subtract_own_positives;
    let i = match &target {
        Target::New(_) => None,
        Target::Existing(z) | Target::Modify(z, _) => Some(*z),
    };
    // What else begins after `a`: the negatives of line 7, and whom D3 tells.
    let siblings: BTreeSet<Place> = model.children(a).filter(|child| i.map(Place::Node) != Some(*child)).collect();
    let mut stale = BTreeSet::new();
    let z = match target {
        // A2.5: i = ∅
        Target::New(own) => {
            let p = BTreeSet::from([s]); // A2.6
            let mut n = model.starts(siblings.iter().copied()); // A2.7
            n.extend(model.background(decisions.background, [a].into_iter(), &p)); // D2
            let samples = Samples { positives: p.clone(), negatives: n };
            let classifier = model.fit_samples(learner, &samples, counters)?; // A2.9
            model.add_node(BTreeSet::from([d]), own, samples, classifier) // A2.8, A2.10, A2.11
        }
        // A2.14
        Target::Existing(z) | Target::Modify(z, _) => {
            // A2.15 is the pattern; A2.16: p ← s, which `adopt` adds with d.
            let mut n = BTreeSet::new();
            for r in model.parents(Place::Node(z)).chain([a]) {
                let others = model.children(r).filter(|child| !subtract || *child != Place::Node(z)); // D1
                n.extend(model.starts(others)); // A2.17: S(children(a) ∪ ⋃ children(r))
            }
            if decisions.background.neighbours {
                n.extend(model.starts([a].into_iter())); // D2
            }
            if let Target::Modify(_, own) = target {
                model.replace_policy(z, d, own)?;
            } else {
                model.adopt(z, d)?;
                model.fit_policy(learner, z, counters)?; // A2.18
            }
            model.add_negatives(Place::Node(z), &n, subtract);
            stale.insert(Place::Node(z)); // A2.19, below
            z
        }
    };
    model.place(d, z);
    let edge_added = model.add_edge(a, Place::Node(z)); // A2.12, A2.20
    if decisions.push_to_siblings {
        let s = BTreeSet::from([s]);
        stale.extend(siblings.into_iter().filter(|sibling| model.add_negatives(*sibling, &s, true))); // D3
    }
    counters.nodes_touched += 1 + stale.iter().filter(|place| **place != Place::Node(z)).count() as u64;
    model.fit_classifiers(learner, &stale, counters)?; // A2.19 and D3
    Ok((z, edge_added)) // A2.13, A2.21
}
