//! The features of a plan, its cost, and the plan of least cost.
//!
//! A plan of K keyframes is written as displacements `u_k` from the demonstrated keyframes. A displacement has three
//! positions in the frame of the reference object (along x, along y, and height; metres). Then it has three turns about
//! the gripper's own axes (two tilts, and the turn about the approach axis; radians). The keyframes form two groups
//! `g`: the *contacts*, where the hand closes or opens, and the *free* ones. There is one feature per group and axis,
//! the mean displacement of the group along the axis:
//!
//! `φ_{g,c}(u) = (1/n_g) Σ_{k ∈ g} u_{k,c}`.
//!
//! These are twelve features. The cost of a plan with weights `w` is
//!
//! `J(u) = Σ_g (1/2n_g) Σ_{k ∈ g} |u_k|² + wᵀ φ(u)`:
//!
//! its distance from what was demonstrated, plus the weighted features. A square metre and a square radian cost the
//! same; no plan depends on that. The gradient vanishes at `u_{k,c} = −w_{g,c}`. As J is strictly convex, that is the
//! only minimum. So the features of the best plan are its weights with the other sign.
//!
//! **These features can express**: move the contacts elsewhere, or hold them at another height, tilt or turn; and the
//! same for the free keyframes, as one body. **They cannot express**: move one free keyframe relative to another (a
//! bend, a way around something), have one keyframe more or fewer, another grip command, another rest. Nor can they
//! express what depends on another object, because the frame is that of the reference object.

use std::array;

use crate::keyframe::pose::Tangent;

/// The axes of a displacement.
const AXES: usize = 6;
/// The groups of keyframes: free, contact.
const GROUPS: usize = 2;
/// The features of a plan.
pub const FEATURES: usize = GROUPS * AXES;
/// One number per feature: six of the free keyframes, then six of the contacts; three in metres, then three in radians.
pub type Features = [f64; FEATURES];

/// The range of a position, metres, and of a turn, radians: the scales at which a difference matters (decision D16:
/// offsets 0.2 m, tilt 0.5 rad). Features are compared with each other in ranges.
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

/// φ(u). `contacts` has one entry per displacement. The features of a group without keyframes are 0.
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

/// The displacements of least cost, one per keyframe.
pub fn plan(contacts: &[bool], weights: &Features) -> Vec<Tangent> {
    let moved = |contact: &bool| Tangent::from_fn(|axis, _| -weights[usize::from(*contact) * AXES + axis]);
    contacts.iter().map(moved).collect()
}
