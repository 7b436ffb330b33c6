//! The edges of a task model, known from both ends.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::place::Place;

/// Pairs of places. Parents and children are inverse to each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Edges {
    children: BTreeMap<Place, BTreeSet<Place>>,
    parents: BTreeMap<Place, BTreeSet<Place>>,
}

impl Edges {
    pub(super) fn children(&self, place: Place) -> impl Iterator<Item = Place> + Clone {
        self.children.get(&place).into_iter().flatten().copied()
    }

    pub(super) fn parents(&self, place: Place) -> impl Iterator<Item = Place> + Clone {
        self.parents.get(&place).into_iter().flatten().copied()
    }

    /// All edges, in order.
    pub(super) fn all(&self) -> impl Iterator<Item = (Place, Place)> {
        self.children.iter().flat_map(|(from, to)| to.iter().map(move |to| (*from, *to)))
    }

    /// Returns whether the edge is new.
    pub(super) fn add(&mut self, from: Place, to: Place) -> bool {
        self.parents.entry(to).or_default().insert(from);
        self.children.entry(from).or_default().insert(to)
    }

    pub(super) fn remove(&mut self, from: Place, to: Place) {
        detach(&mut self.children, from, to);
        detach(&mut self.parents, to, from);
    }
}

/// As a list of pairs.
impl Serialize for Edges {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.all())
    }
}

impl<'de> Deserialize<'de> for Edges {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut edges = Self::default();
        for (from, to) in Vec::<(Place, Place)>::deserialize(deserializer)? {
            edges.add(from, to);
        }
        Ok(edges)
    }
}

fn detach(map: &mut BTreeMap<Place, BTreeSet<Place>>, key: Place, value: Place) {
    if let Some(set) = map.get_mut(&key) {
        set.remove(&value);
        if set.is_empty() {
            map.remove(&key);
        }
    }
}
