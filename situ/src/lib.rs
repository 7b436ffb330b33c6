//! State-Indexed Task Updates (SITU): task models as automata of primitives, and how corrective demonstrations change
//! them.
//!
//! The paper is Gutierrez, Short, Niekum and Thomaz, "Towards Online Learning from Corrective Demonstrations" (2018).
//!
//! | paper | here |
//! |---|---|
//! | task model `T` | [`task_model::TaskModel`] |
//! | node `z`, policy `π`, initiation classifier `c` | [`task_model::Node`], [`primitive`] |
//! | `parent(z)`, `children(z)` | [`task_model::TaskModel::parents`], [`task_model::TaskModel::children`] |
//! | Algorithms 1 and 2, line by line | `situ/src/situ.rs`, two methods of an [`update::Update`] |
//! | `SITU(z, S, D, T)` as others call it | [`fold::situ`]; `z`, `S` and `D` are a [`correction::Correction`] |
//! | what the listing leaves open, one hook for each line | [`mending`]; the switches: [`decisions`] |
//! | A1.6, applicable primitives | [`task_model::TaskModel::applicable`] |
//! | A2.2, A2.4: Cluster, Find-Policy | [`placement::ByPolicy`], [`primitive::Learner::cluster_and_find`] |
//! | A2.3, Local-Reconnect | [`task_model::TaskModel::local_reconnect`] |
//! | `S(Z)` | [`task_model::TaskModel::starts`] |
//! | Fit-Policy, Fit-Classifier | [`primitive::Learner`] |
//! | segmentation | [`segmentation`] |
//! | keyframe instantiation | [`keyframe`] |
//! | the three edit types | [`edit`]; a structure against what the teacher meant: [`structure`] |
//!
//! The crate knows no physics, no files and no clock, and takes every random number from a seed that its caller names.

pub mod another_way;
pub mod correction;
pub mod decisions;
pub mod demonstration;
pub mod edit;
pub mod error;
pub mod fold;
pub mod graph;
pub mod keyframe;
pub mod matching;
pub mod mending;
pub mod method;
mod obedience;
pub mod place;
pub mod placement;
pub mod primitive;
pub mod random;
#[cfg(test)]
mod same_bits;
pub mod segment;
pub mod segmentation;
mod situ;
pub mod state;
pub mod structure;
pub mod task_model;
pub mod trace;
pub mod trail;
pub mod update;
pub mod vector;
pub mod worlds;
