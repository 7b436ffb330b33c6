//! The simulator's tests from outside, in one program: what is generic is compiled once, and all cores are busy to the
//! end.

mod arm;
mod camera;
mod common;
mod grasp;
mod hinge;
mod lid;
mod mesh;
mod motion;
mod pour;
mod push;
mod rolling;
mod scene;
mod slide;
mod snapshot;
