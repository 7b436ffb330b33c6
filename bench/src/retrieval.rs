//! Whether the index of the task model alone (A1.6) finds the primitive that a segment is, by the teacher's words.

use std::collections::BTreeMap;
use std::sync::Arc;

use situ::demonstration::Demonstration;
use situ::place::NodeId;
use situ::structure::main_skill;
use situ::trace::Trace;

/// For each step of an update, whether a primitive that holds the segment's skill was among the applicable ones; `None`
/// where no primitive held it, and where the teacher named nothing.
///
/// `skills` are those of the nodes before the update, `lengths` the keyframes of each segment. Steps before it rename
/// nodes and add some, so the skills follow them.
pub fn retrieved(
    mut skills: BTreeMap<NodeId, Arc<str>>,
    trace: &Trace,
    demonstration: &Demonstration,
    lengths: &[usize],
) -> Vec<Option<bool>> {
    let mut rest = demonstration.keyframes();
    let mut found = Vec::with_capacity(trace.steps.len());
    for (step, length) in trace.steps.iter().zip(lengths.iter().chain(std::iter::repeat(&0))) {
        let (segment, after) = rest.split_at((*length).min(rest.len()));
        rest = after;
        let Some(skill) = main_skill(segment) else {
            found.push(None);
            continue;
        };
        let is_held = skills.values().any(|held| *held == skill);
        let is_found = step.applicable.iter().any(|node| skills.get(node) == Some(&skill));
        found.push(is_held.then_some(is_found));
        for (merged, name) in &step.merged {
            let held: Vec<Arc<str>> = merged.iter().filter_map(|node| skills.remove(node)).collect();
            if let Some(first) = held.into_iter().next() {
                skills.insert(*name, first);
            }
        }
        skills.entry(step.node).or_insert(skill);
    }
    found
}

#[cfg(test)]
mod tests {
    use situ::place::Place;
    use situ::trace::{Branch, Counters, MatchedIn, Step};
    use situ_tasks::{Episode, Registry};
    use situ_teachers::convert::schema;
    use situ_teachers::{Roster, Teacher};

    use super::*;

    /// A step in which these nodes were applicable, and that ended in a node.
    fn step(applicable: &[u32], node: u32, merged: &[(&[u32], u32)]) -> Step {
        let ids = |nodes: &[u32]| nodes.iter().copied().map(NodeId).collect::<Vec<_>>();
        Step {
            reference: "button".to_owned(),
            applicable: ids(applicable),
            model_size: 2,
            candidates: 0,
            matched_in: MatchedIn::None,
            branch: Branch::New,
            node: NodeId(node),
            after: Place::Start,
            edge_added: false,
            merged: merged.iter().map(|(from, to)| (ids(from), NodeId(*to))).collect(),
            counters: Counters::default(),
        }
    }

    #[test]
    fn the_skills_follow_the_names_of_the_nodes() {
        let setting = Registry::builtin().unwrap().get("stack").unwrap().variation(None).unwrap();
        let teacher = Teacher::new(Roster::builtin().unwrap().get("expert").unwrap().clone());
        let mut episode = Episode::start(&setting, 1).unwrap();
        let schema = schema(&setting).unwrap();
        let kind = situ::demonstration::Kind::Original;
        let shown = teacher.demonstrate("one", kind, &schema, &mut episode, 1, &mut |_| {}).unwrap();
        let (demonstration, names) = (shown.demonstration.unwrap(), shown.skills);
        let count = |name: &str| {
            let keyframes = demonstration.keyframes().iter();
            keyframes.filter(|keyframe| keyframe.narration.as_deref() == Some(name)).count()
        };
        let lengths = [count(&names[0]), count(&names[1])];
        let skills = BTreeMap::from([(NodeId(0), names[0].clone().into()), (NodeId(1), names[0].clone().into())]);
        // The first skill is held by 0 and 1, and 1 is applicable; then both are one, called 7. The second is held by
        // nothing before its own step.
        let trace = Trace { steps: vec![step(&[1], 7, &[(&[0, 1], 7)]), step(&[7], 8, &[])], ..Trace::default() };
        assert_eq!(retrieved(skills.clone(), &trace, &demonstration, &lengths), [Some(true), None]);
        let trace = Trace { steps: vec![step(&[5], 0, &[]), step(&[7], 8, &[])], ..Trace::default() };
        assert_eq!(retrieved(skills, &trace, &demonstration, &lengths), [Some(false), None]);
        let trace = Trace { steps: vec![step(&[], 3, &[]), step(&[3], 4, &[])], ..Trace::default() };
        let twice = [1, 1];
        assert_eq!(retrieved(BTreeMap::new(), &trace, &demonstration, &twice), [None, Some(true)], "what it added");
    }
}
