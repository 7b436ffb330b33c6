//! The keyframe instantiation of SITU (paper, "Keyframe Based Algorithms"). Policies are hidden Markov models over
//! keyframes, initiation classifiers are logistic regressions, and Find-Policy clusters by divergence.

pub mod alignment;
pub mod classifier;
pub mod cluster;
pub mod divergence;
pub mod frechet;
mod grouping;
mod half_turn;
pub mod hmm;
pub mod interpolate;
pub mod learner;
pub mod logistic;
pub mod parameters;
pub mod policy;
pub mod pose;
mod restore;
mod roles;
pub mod scatter;
mod true_keyframes;
