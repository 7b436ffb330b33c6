//! Segments of many demonstrations in one list, the role of each, and groups of them.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::segment::Segment;

/// A role in the task: the k-th visit to a reference object.
type Role<'a> = (&'a str, usize);

/// The segments of all demonstrations in order, and the role of each.
pub(super) fn pooled<'a>(demonstrations: &[&'a [Arc<Segment>]]) -> (Vec<&'a Segment>, Vec<Role<'a>>) {
    let (mut pooled, mut roles) = (Vec::new(), Vec::new());
    for segments in demonstrations {
        let mut visits: BTreeMap<&str, usize> = BTreeMap::new();
        for segment in *segments {
            let visit = visits.entry(&segment.reference).or_default();
            pooled.push(&**segment);
            roles.push((&*segment.reference, *visit));
            *visit += 1;
        }
    }
    (pooled, roles)
}

/// The indices of equal keys.
pub(super) fn grouped<K: Ord + Copy>(keys: &[K]) -> BTreeMap<K, Vec<usize>> {
    let mut groups: BTreeMap<K, Vec<usize>> = BTreeMap::new();
    for (index, key) in keys.iter().enumerate() {
        groups.entry(*key).or_default().push(index);
    }
    groups
}

/// Notes for each member of a group, of which every one has a label, the first member with its label.
pub(super) fn lead(members: &[usize], labels: &[usize], first: &mut [usize]) {
    let mut leaders: BTreeMap<usize, usize> = BTreeMap::new();
    for (member, label) in members.iter().zip(labels) {
        first[*member] = *leaders.entry(*label).or_insert(*member);
    }
}

/// Labels in the order in which they first appear, from the first member with each label.
pub(super) fn in_order(first: &[usize]) -> Vec<usize> {
    let mut names: BTreeMap<usize, usize> = BTreeMap::new();
    let name = |leader: &usize| {
        let next = names.len();
        *names.entry(*leader).or_insert(next)
    };
    first.iter().map(name).collect()
}
