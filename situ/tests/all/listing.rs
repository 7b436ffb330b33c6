//! The listing, transcribed as it is printed by somebody who has never seen the crate's own update, beside
//! `situ:literal`.
//!
//! The transcription keeps no index and no journal, fits every primitive again after every line, and writes each line
//! as the paper has it. It takes over only what the keyframe instantiation cannot do without: the segment's start state
//! is the world before its motion (D0), Cluster and Find-Policy are one (D4), merged nodes get new names (D9), and
//! there are START and END (D11). Over random automata and random corrections, with a learner on a line that reaches
//! every branch, both must make the same task model.

use std::collections::{BTreeMap, BTreeSet};

use crate::common::toy::{Line, Nearest, Toy};
use crate::common::{folded, histories, spelt};
use proptest::prelude::*;
use proptest::sample::Index;
use situ::correction::Correction;
use situ::decisions::Decisions;
use situ::demonstration::Demonstration;
use situ::method::rebuild::rebuild;
use situ::place::{NodeId, Place, SampleId, SegmentId};
use situ::primitive::{Initiation, Learner};
use situ::segment::Segment;
use situ::segmentation::by_reference_object;
use situ::state::State;
use situ::task_model::TaskModel;
use situ::trace::Counters;
use situ::trail::{StepEnd, TrailStep};

/// A primitive of the transcription.
#[derive(Clone, Debug, PartialEq)]
struct Primitive {
    data: BTreeSet<SegmentId>,
    policy: Line,
    positives: BTreeSet<SampleId>,
    negatives: BTreeSet<SampleId>,
    classifier: Nearest,
}

/// A demonstration of the transcription.
#[derive(Clone, Debug)]
struct Traversal {
    after: Option<SegmentId>,
    segments: Vec<Segment>,
    last: State,
    to_end: bool,
}

/// The task model `T` of the transcription.
#[derive(Clone)]
struct Listing {
    learner: Toy,
    nodes: BTreeMap<NodeId, Primitive>,
    end: (BTreeSet<SampleId>, BTreeSet<SampleId>),
    edges: BTreeSet<(Place, Place)>,
    traversals: Vec<Traversal>,
    next: u32,
}

impl Listing {
    /// The same model as this one.
    fn of(model: &TaskModel<Toy>, learner: &Toy) -> Self {
        let primitive = |(id, node): (NodeId, &situ::task_model::Node<Toy>)| {
            let primitive = Primitive {
                data: node.segments.clone(),
                policy: {
                    let [way] = &node.ways[..] else { panic!("the listing knows one way") };
                    way.policy.clone()
                },
                positives: node.samples.positives.clone(),
                negatives: node.samples.negatives.clone(),
                classifier: node.classifier.clone(),
            };
            (id, primitive)
        };
        let traversal = |history: &situ::task_model::History| Traversal {
            after: history.after,
            segments: history.segments.iter().map(|segment| Segment::clone(segment)).collect(),
            last: history.final_state.clone(),
            to_end: history.carried_to_end,
        };
        Self {
            learner: learner.clone(),
            nodes: model.nodes().map(primitive).collect(),
            end: (model.end().samples.positives.clone(), model.end().samples.negatives.clone()),
            edges: model.edges().collect(),
            traversals: model.histories().iter().map(traversal).collect(),
            next: model.next_id().0,
        }
    }

    fn segment(&self, id: SegmentId) -> &Segment {
        &self.traversals[id.demonstration as usize].segments[id.index as usize]
    }

    fn state(&self, sample: SampleId) -> &State {
        match sample {
            SampleId::Start(id) => &self.segment(id).start,
            SampleId::Final(index) => &self.traversals[index as usize].last,
            SampleId::Chosen { .. } => panic!("the listing knows no trail"),
        }
    }

    fn children(&self, place: Place) -> BTreeSet<Place> {
        self.edges.iter().filter(|(from, _)| *from == place).map(|(_, to)| *to).collect()
    }

    fn parent(&self, place: Place) -> BTreeSet<Place> {
        self.edges.iter().filter(|(_, to)| *to == place).map(|(from, _)| *from).collect()
    }

    /// `S(Z)`.
    fn s(&self, places: &BTreeSet<Place>) -> BTreeSet<SampleId> {
        let samples = |place: &Place| match place {
            Place::Start => BTreeSet::new(),
            Place::Node(id) => self.nodes[id].positives.clone(),
            Place::End => self.end.0.clone(),
        };
        places.iter().flat_map(samples).collect()
    }

    fn fit_policy(&self, data: &BTreeSet<SegmentId>) -> Line {
        let data: Vec<&Segment> = data.iter().map(|id| self.segment(*id)).collect();
        self.learner.fit_policy(&data, &(), &mut Counters::default()).unwrap()
    }

    fn fit_classifier(&self, p: &BTreeSet<SampleId>, n: &BTreeSet<SampleId>) -> Nearest {
        let states = |samples: &BTreeSet<SampleId>| samples.iter().map(|id| self.state(*id)).collect::<Vec<_>>();
        self.learner.fit_classifier(&states(p), &states(n), &mut Counters::default()).unwrap()
    }

    fn add(&mut self, primitive: Primitive) -> NodeId {
        let z = NodeId(self.next);
        self.next += 1;
        self.nodes.insert(z, primitive);
        z
    }

    fn holder(&self, id: SegmentId) -> Option<Place> {
        self.nodes.iter().find(|(_, node)| node.data.contains(&id)).map(|(id, _)| Place::Node(*id))
    }

    /// The places that a demonstration went through, as far as they are placed.
    fn walk(&self, index: usize) -> Vec<Place> {
        let traversal = &self.traversals[index];
        let first =
            traversal.after.map_or(Place::Start, |segment| self.holder(segment).expect("what ran last is held"));
        let ids = (0..traversal.segments.len() as u32)
            .map(|segment| SegmentId { demonstration: index as u32, index: segment });
        let held: Vec<Place> = ids.map_while(|id| self.holder(id)).collect();
        let is_over = traversal.to_end && held.len() == traversal.segments.len();
        [first].into_iter().chain(held).chain(is_over.then_some(Place::End)).collect()
    }

    /// Procedure SITU(z, S, D, T), then END (D11).
    fn situ(&mut self, z: Place, after: Option<SegmentId>, shown: &Demonstration) {
        let demonstration = self.traversals.len() as u32;
        let segments = by_reference_object(shown);
        let (last, to_end) = (shown.final_state().clone(), shown.carried_to_end());
        self.traversals.push(Traversal { after, segments: segments.clone(), last, to_end });
        let mut a = z;
        for index in 0..segments.len() as u32 {
            let d = SegmentId { demonstration, index };
            let s = &segments[index as usize].start;
            let z: Vec<NodeId> =
                self.nodes.iter().filter(|(_, node)| node.classifier.is_applicable(s)).map(|(id, _)| *id).collect();
            a = Place::Node(self.local_update(a, d, z));
        }
        if to_end {
            let siblings = self.children(a).into_iter().filter(|child| *child != Place::End).collect();
            let n = self.s(&siblings);
            self.end.0.insert(SampleId::Final(demonstration));
            self.end.1.extend(n);
            self.edges.insert((a, Place::End));
        }
    }

    /// Local-Reconnect for groups of nodes; returns the new name of each.
    fn local_reconnect(&mut self, groups: Vec<Vec<NodeId>>) -> BTreeMap<NodeId, NodeId> {
        let mut names = BTreeMap::new();
        for old in groups {
            let gone: Vec<Primitive> = old.iter().map(|id| self.nodes.remove(id).unwrap()).collect();
            let gather = |of: fn(&Primitive) -> &BTreeSet<SampleId>| gone.iter().flat_map(of).copied().collect();
            let data = gone.iter().flat_map(|node| &node.data).copied().collect();
            let (positives, negatives) = (gather(|node| &node.positives), gather(|node| &node.negatives));
            let policy = self.fit_policy(&data);
            let classifier = self.fit_classifier(&positives, &negatives);
            let new = self.add(Primitive { data, policy, positives, negatives, classifier });
            names.extend(old.iter().map(|id| (*id, new)));
            self.edges.retain(|(from, to)| !old.iter().any(|id| *from == Place::Node(*id) || *to == Place::Node(*id)));
            for index in 0..self.traversals.len() {
                let walk = self.walk(index);
                let touched = walk.windows(2).filter(|pair| pair.contains(&Place::Node(new)));
                self.edges.extend(touched.map(|pair| (pair[0], pair[1])));
            }
        }
        names
    }

    /// Procedure Local-Update(a, s, d, Z, T). Returns z.
    fn local_update(&mut self, a: Place, d: SegmentId, z_set: Vec<NodeId>) -> NodeId {
        let s = SampleId::Start(d);
        // Z_new ← Cluster(Z) and i ← Find-Policy(d, Π(Z_new)), in one.
        let own = self.fit_policy(&BTreeSet::from([d]));
        let policies: Vec<Vec<&Line>> = z_set.iter().map(|id| vec![&self.nodes[id].policy]).collect();
        let found = if policies.is_empty() {
            Default::default()
        } else {
            self.learner.cluster_and_find(&own, &policies, &[], &(), &mut Counters::default())
        };
        let mut groups = found.redundant.clone();
        groups.extend((found.matched.len() > 1).then(|| found.matched.clone()));
        // T ← Local-Reconnect(T, Z, Z_new)
        let groups = groups.iter().map(|group| group.iter().map(|index| z_set[*index]).collect()).collect();
        let names = self.local_reconnect(groups);
        let now = |id: NodeId| names.get(&id).copied().unwrap_or(id);
        let a = if let Place::Node(id) = a { Place::Node(now(id)) } else { a };
        match found.matched.first().map(|index| now(z_set[*index])) {
            None => {
                let p = BTreeSet::from([s]);
                let n = self.s(&self.children(a));
                let pi = self.fit_policy(&BTreeSet::from([d]));
                let c = self.fit_classifier(&p, &n);
                let data = BTreeSet::from([d]);
                let z = self.add(Primitive { data, policy: pi, positives: p, negatives: n, classifier: c });
                self.edges.insert((a, Place::Node(z)));
                z
            }
            Some(z) => {
                let parents = self.parent(Place::Node(z));
                let union = parents.into_iter().flat_map(|r| self.children(r)).chain(self.children(a)).collect();
                let n = self.s(&union);
                let node = self.nodes.get_mut(&z).unwrap();
                node.data.insert(d);
                node.positives.insert(s);
                node.negatives.extend(n);
                let node = &self.nodes[&z];
                let (policy, classifier) =
                    (self.fit_policy(&node.data), self.fit_classifier(&node.positives, &node.negatives));
                let node = self.nodes.get_mut(&z).unwrap();
                (node.policy, node.classifier) = (policy, classifier);
                self.edges.insert((a, Place::Node(z)));
                z
            }
        }
    }
}

/// Object, site on it, where about the site, and the state in which the segment begins.
type Word = (u8, u8, f64, f64);

fn words(longest: usize) -> impl Strategy<Value = Vec<Word>> {
    prop::collection::vec((0_u8..3, 0_u8..3, -0.6..0.6, 0.0..8.0), 1..=longest)
}

fn demonstration(words: &[Word], to_end: bool) -> Demonstration {
    let spell = |(object, site, x, state): &Word| (*object, f64::from(*site) * 10.0 + x, *state);
    spelt(&words.iter().map(spell).collect::<Vec<_>>(), 9.0, to_end)
}

fn assert_same(model: &TaskModel<Toy>, listing: &Listing) {
    let of = Listing::of(model, &listing.learner);
    assert_eq!(of.nodes, listing.nodes);
    assert_eq!(of.edges, listing.edges);
    assert_eq!(of.end, listing.end);
    let end = listing.fit_classifier(&listing.end.0, &listing.end.1);
    assert_eq!(model.end().classifier.as_ref(), (!listing.end.0.is_empty()).then_some(&end));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn situ_literal_is_the_listing(
        originals in prop::collection::vec((words(5), any::<bool>()), 1..4),
        corrections in prop::collection::vec((words(3), any::<bool>(), any::<Option<Index>>()), 1..4),
        taught in prop_oneof![Just(0.05), Just(2.0)],
    ) {
        let learner = Toy::on_a_line(taught);
        let originals: Vec<_> = originals.iter().map(|(words, end)| demonstration(words, *end)).collect();
        let (mut model, _) = rebuild(histories(&originals), None, &learner, &Decisions::mended()).unwrap();
        for (words, end, after) in &corrections {
            let last = after.map_or(Place::Start, |after| Place::Node(model.nodes().nth(after.index(model.len())).unwrap().0));
            let shown = demonstration(words, *end);
            let mut listing = Listing::of(&model, &learner);
            listing.situ(last, model.origin(last).unwrap(), &shown);
            // The listing does not ask what the robot was doing, or in which state it began that.
            let (node, state) = (model.nodes().next().unwrap().0, State::new([words[0].3]));
            let trail = [TrailStep { state, node, end: StepEnd::Interrupted }];
            let correction = Correction { interrupted: Some(node), trail: &trail, ..Correction::after(last, &shown) };
            model = folded(correction, &model, &learner, &Decisions::literal()).0;
            assert_same(&model, &listing);
        }
    }
}
