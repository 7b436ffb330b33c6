//! What a way to refine primitives must be able to do.

use std::fmt::Debug;

use nalgebra::Matrix6;
use serde::Serialize;

use crate::demonstration::{RelativeKeyframe, Segment};
use crate::error::SituError;
use crate::keyframe::policy::KeyframePolicy;
use crate::trace::Counters;

/// A keyframe of a refined primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refined {
    /// The mean, in the frame of the reference object.
    pub mean: RelativeKeyframe,
    /// Scatter about it in the tangent space at the mean, metres and radians, position first, shape (6, 6): what a
    /// sampled execution draws from, within the bounds of decision D15.
    pub scatter: Matrix6<f64>,
}

/// A way to refine single primitives.
pub trait Refine: Copy + Debug + Send + Sync + 'static {
    /// A refinable primitive.
    type Primitive: Clone + Debug + PartialEq + Serialize + Send + Sync;

    /// The primitive of an original policy and the segments that the policy was fitted to, before any correction.
    ///
    /// # Errors
    /// [`SituError::Policy`] where it cannot be fitted.
    fn fit(
        &self,
        original: &KeyframePolicy,
        segments: &[&Segment],
        counters: &mut Counters,
    ) -> Result<Self::Primitive, SituError>;

    /// Folds in a segment that shows another way of doing the primitive.
    ///
    /// # Errors
    /// [`SituError::Policy`] where it cannot be fitted; the primitive is then worth nothing.
    fn correct(
        &self,
        primitive: &mut Self::Primitive,
        shown: &Segment,
        counters: &mut Counters,
    ) -> Result<(), SituError>;

    /// The keyframes of an execution, in order: at least one.
    fn keyframes(&self, primitive: &Self::Primitive) -> Vec<Refined>;
}
