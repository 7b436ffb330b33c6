//! Algorithm 1 (SITU) and Algorithm 2 (Local-Update), line by line. `A1.6` is line 6 of the listing of Algorithm 1.
//!
//! `D10` is a decision that the paper leaves open ([`crate::decisions`]). D1, D2, D3, D10 and D23 are hooks in
//! [`crate::mending`], D18 to D20 in [`crate::another_way`]. A hook does nothing where its decision is switched off;
//! then these two procedures are the listing as the keyframe instantiation needs it. That instantiation has three rules
//! of its own. Cluster and Find-Policy are one step (D4): Cluster puts the segment's own policy among the policies of
//! `Z`, so it finds the segment's cluster, too, and Find-Policy only has to look up what that cluster is called now.
//! Merged nodes have new names (D9). START and END are places, so END can be a child; `S` of a place are the states in
//! which it begins, its positive samples (D11).
//!
//! What the lines call is in [`crate::update`], under the listing's names.

use std::collections::BTreeSet;

use crate::error::SituError;
use crate::place::{NodeId, Place, SampleId, Samples, SegmentId};
use crate::placement::Placement;
use crate::primitive::Learner;
use crate::update::Update;

impl<L: Learner> Update<'_, L> {
    /// Algorithm 1: folds the segments `D`, shown after the primitive `z`, into the task model `T` (`self.model`).
    ///
    /// Returns the primitive that the last segment belongs to. `placement` says where a segment belongs: for SITU
    /// itself that is [`crate::placement::ByPolicy`].
    ///
    /// # Errors
    /// Where the learner refuses a segment. The model is then half-way: [`crate::fold::fold`] undoes it.
    #[expect(clippy::needless_range_loop, reason = "as the listing has it")]
    pub(crate) fn situ<P: Placement<L>>(
        &mut self,
        z: Place,
        segments: &[SegmentId],
        placement: &mut P,
    ) -> Result<Place, SituError> {
        let mut a = z; // A1.2: a ← z
        // A1.3: for i ← 1 to |D|
        for i in 0..segments.len() {
            let s = SampleId::Start(segments[i]); // A1.4: s ← S[i]
            let d = segments[i]; // A1.5: d ← D[i]
            self.begin_step(d); // D17
            let applicable = placement.applicable(self, s); // A1.6: Z ← { z_j ∈ T | c_j(s) = 1 }
            let z = self.local_update(a, s, d, &applicable, placement)?;
            a = Place::Node(z); // A1.7: T, a ← Local-Update(a, s, d, Z, T)
            self.end_step(applicable); // D17
        }
        Ok(a)
    }

    /// Algorithm 2: one segment `d`, which begins in the state `s` after the primitive `a`; `applicable` is `Z`.
    ///
    /// Later lines of the same correction can fit the classifier of `z` again: by D3, by a merge, and at END.
    fn local_update<P: Placement<L>>(
        &mut self,
        a: Place,
        s: SampleId,
        d: SegmentId,
        applicable: &[NodeId],
        placement: &mut P,
    ) -> Result<NodeId, SituError> {
        let clusters = placement.cluster(self, d, applicable)?; // A2.2: Z_new ← Cluster(Z), with d (D4, D10)
        let renamed = self.local_reconnect(&clusters)?; // A2.3: T ← Local-Reconnect(T, Z, Z_new)
        let a = renamed.place(a); // D9
        let instance_of = clusters.instance_of.map(|node| renamed.node(node)); // D9
        let i = placement.find_policy(self, a, d, instance_of)?; // A2.4: i ← Find-Policy(d, Π(Z_new)) (D18)
        // A2.5: if i = ∅
        let Some(i) = i else {
            let mut positives = BTreeSet::from([s]); // A2.6: p ← s
            self.mend_positives(a, None, d, &mut positives); // D23
            let mut negatives = self.starts_of_children([a]); // A2.7: n ← S(children(a))
            self.add_background(a, &positives, &mut negatives); // D2
            let policy = self.fit_policy(d)?; // A2.8: π ← Fit-Policy(d)
            let samples = Samples { positives: positives.clone(), negatives };
            let classifier = self.fit_classifier(&samples)?; // A2.9: c ← Fit-Classifier(p, n)
            let z = (policy, samples, classifier); // A2.10: z ← {π, c}
            let z = self.add_node(d, z); // A2.11: Add-Node(T, z)
            self.add_edge(a, z); // A2.12: Add-Edge(T, (a, z))
            self.tell_siblings(a, Place::Node(z), &positives)?; // D3
            return Ok(z); // A2.13: return T, z
        };
        // A2.14: else
        let z = i.node; // A2.15: z ← Z_new[i] (D10, D18: or a node outside of Z)
        let mut p = BTreeSet::from([s]); // A2.16: p ← s
        self.mend_positives(a, Some(z), d, &mut p); // D23
        // A2.17: n ← S(children(a) ∪ ⋃ children(r))
        let parents: BTreeSet<Place> = self.model.parents(Place::Node(z)).collect();
        let mut n = self.starts_of_children(parents.into_iter().chain([a]));
        self.mend_negatives(a, z, &mut n); // D1, D2
        self.update_policy(d, &i)?; // A2.18: Update-Policy(z, d) (D18 to D20: or another way of it)
        self.update_classifier(z, &p, &n)?; // A2.19: Update-Classifier(z, p, n): p and n join the samples of z
        self.add_edge(a, z); // A2.20: Add-Edge(T, (a, z))
        self.tell_siblings(a, Place::Node(z), &p)?; // D3
        Ok(z) // A2.21: return T, z
    }
}
