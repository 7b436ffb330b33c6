//! The shells of an arm: what it collides with.

use rapier3d::geometry::SharedShape;
use rapier3d::prelude::Pose as EnginePose;

use crate::arm::model::{ArmModel, JOINTS};
use crate::error::SimError;
use crate::frame::to_engine;

/// The shells of an arm in the engine's words, each in the frame of its link: of the mount, then of the link after each
/// joint.
#[derive(Clone)]
pub(crate) struct Shells(Vec<Vec<(SharedShape, EnginePose)>>);

impl Shells {
    /// # Errors
    /// A shell of the model is impossible.
    pub(crate) fn new(model: &ArmModel) -> Result<Shells, SimError> {
        let mut all = Vec::with_capacity(JOINTS + 1);
        for parts in &model.shells {
            let parts = parts.iter().map(|part| {
                let (shape, upright) = part.shape.engine(&model.name)?;
                Ok((shape, to_engine(&part.pose) * upright))
            });
            all.push(parts.collect::<Result<Vec<_>, SimError>>()?);
        }
        Ok(Shells(all))
    }

    /// The shells of one link, 0 being the mount; none for a link that does not exist.
    pub(crate) fn of_link(&self, link: usize) -> &[(SharedShape, EnginePose)] {
        self.0.get(link).map_or(&[], Vec::as_slice)
    }
}
