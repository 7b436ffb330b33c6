//! What a way of refining primitives must be able to do.

use std::fmt::Debug;

use nalgebra::Matrix6;
use serde::Serialize;

use crate::error::SituError;
use crate::keyframe::policy::KeyframePolicy;
use crate::segment::{RelativeKeyframe, Segment};
use crate::trace::Counters;

/// A keyframe of a refined primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefinedKeyframe {
    /// The mean, in the frame of the reference object.
    pub mean: RelativeKeyframe,
    /// The scatter about the mean in the tangent space there, metres and radians, position first, shape (6, 6). A
    /// sampled execution draws from it within the bounds of decision D15.
    pub scatter: Matrix6<f64>,
}

/// A way of refining single primitives.
pub trait Refine: Copy + Debug + Send + Sync + 'static {
    /// A primitive that can be refined.
    type Primitive: Clone + Debug + PartialEq + Serialize + Send + Sync;

    /// The primitive of an original policy, before any correction. `segments` are those that the policy was fitted to.
    ///
    /// # Errors
    /// [`SituError::Policy`] if it cannot be fitted.
    fn fit(
        &self,
        original: &KeyframePolicy,
        segments: &[&Segment],
        counters: &mut Counters,
    ) -> Result<Self::Primitive, SituError>;

    /// Refines the primitive by a segment that shows another way of doing it.
    ///
    /// # Errors
    /// [`SituError::Policy`] if it cannot be fitted. The primitive must then be discarded.
    fn correct(
        &self,
        primitive: &mut Self::Primitive,
        shown: &Segment,
        counters: &mut Counters,
    ) -> Result<(), SituError>;

    /// The keyframes of an execution, in order, at least one.
    fn keyframes(&self, primitive: &Self::Primitive) -> Vec<RefinedKeyframe>;
}
