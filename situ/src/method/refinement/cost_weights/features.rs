//! The features of a plan, its cost, and the plan that has the least.
//!
//! A plan of K keyframes is written as displacements `u_k` from the demonstrated keyframes: three positions in the
//! frame of the reference object (along its x and y, and height; metres), then three turns about the gripper's own axes
//! (two tilts and the turn about its approach axis; radians). The keyframes are of two groups, `g`: the *contacts*, at
//! which the hand closes or opens, and the *free* ones. There is one feature a group and axis, the mean displacement of
//! the group along it,
//!
//! `φ_{g,c}(u) = (1/n_g) Σ_{k ∈ g} u_{k,c}`,
//!
//! twelve in all, and the cost of a plan with weights `w` is
//!
//! `J(u) = Σ_g (1/2n_g) Σ_{k ∈ g} |u_k|² + wᵀ φ(u)`:
//!
//! its distance to what was demonstrated, and what the weights ask for. A square metre and a square radian cost the
//! same, which no plan depends on. The gradient vanishes at `u_{k,c} = −w_{g,c}`, the only minimum, since J is strictly
//! convex; so the features of a plan are its weights with the other sign.
//!
//! **What these features can say**: carry the contacts somewhere else, or hold them at another height, tilt or turn;
//! the same of the free keyframes, as one body. **What they cannot**: move one free keyframe against another (a bend, a
//! way around something), one keyframe more or fewer, another grip command, another rest. Nor can they say what depends
//! on another object: the frame is the reference object's.

use std::array;

use crate::keyframe::pose::Tangent;

/// Axes of a displacement.
const AXES: usize = 6;
/// Groups of keyframes: free, contact.
const GROUPS: usize = 2;
/// Features of a plan.
pub const FEATURES: usize = GROUPS * AXES;
/// A number a feature: six of the free keyframes, then six of the contacts; metres, metres, metres, radians, radians,
/// radians.
pub type Features = [f64; FEATURES];

/// Range of a position, metres, and of a turn, radians: the scales at which a difference of either matters (decision
/// D16: offsets 0.2 m, tilt 0.5 rad). What is compared across features is measured in ranges.
const RANGE: [f64; 2] = [0.2, 0.5];
/// The range of each feature.
pub const RANGES: Features = {
    let mut ranges = [0.0; FEATURES];
    let mut feature = 0;
    while feature < FEATURES {
        ranges[feature] = RANGE[feature % AXES / 3];
        feature += 1;
    }
    ranges
};

fn sizes(contacts: &[bool]) -> [f64; GROUPS] {
    let contact = contacts.iter().filter(|contact| **contact).count();
    [contacts.len() - contact, contact].map(|count| count.max(1) as f64)
}

/// φ(u): `contacts` says which keyframes are, one a displacement. The features of a group without keyframes are 0.
pub fn features(contacts: &[bool], displacements: &[Tangent]) -> Features {
    let sizes = sizes(contacts);
    array::from_fn(|feature| {
        let (group, axis) = (feature / AXES, feature % AXES);
        let own = contacts.iter().zip(displacements).filter(|(contact, _)| usize::from(**contact) == group);
        own.map(|(_, moved)| moved[axis]).sum::<f64>() / sizes[group]
    })
}

/// J(u).
pub fn cost(contacts: &[bool], displacements: &[Tangent], weights: &Features) -> f64 {
    let sizes = sizes(contacts);
    let mut cost = 0.0;
    for (contact, moved) in contacts.iter().zip(displacements) {
        cost += 0.5 * moved.dot(moved) / sizes[usize::from(*contact)];
    }
    let features = features(contacts, displacements);
    cost + weights.iter().zip(features).map(|(weight, feature)| weight * feature).sum::<f64>()
}

/// The displacements of least cost, one a keyframe.
pub fn plan(contacts: &[bool], weights: &Features) -> Vec<Tangent> {
    let moved = |contact: &bool| Tangent::from_fn(|axis, _| -weights[usize::from(*contact) * AXES + axis]);
    contacts.iter().map(moved).collect()
}
