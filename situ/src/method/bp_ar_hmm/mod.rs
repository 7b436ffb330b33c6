//! The method.

pub mod sampler;
