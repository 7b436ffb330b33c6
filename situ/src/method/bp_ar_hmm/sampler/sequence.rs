//! The frames that the sampler sees.

use nalgebra::SVector;

use super::dynamics::Statistics;

/// The frames of one sequence, at least one, each with the frame before it.
#[derive(Clone, Debug, PartialEq)]
pub struct LaggedSequence<const D: usize> {
    /// x_t.
    pub current: Vec<SVector<f64, D>>,
    /// y_t, one per x_t.
    pub lagged: Vec<SVector<f64, D>>,
}

impl<const D: usize> LaggedSequence<D> {
    /// The number of frames.
    pub fn len(&self) -> usize {
        self.current.len()
    }

    /// Whether there is no frame.
    pub fn is_empty(&self) -> bool {
        self.current.is_empty()
    }

    /// The statistics of the frames for which `belongs` holds.
    pub(super) fn statistics(&self, belongs: impl Fn(usize) -> bool) -> Statistics<D> {
        let mut statistics = Statistics::default();
        for frame in (0..self.len()).filter(|frame| belongs(*frame)) {
            statistics.add(&self.current[frame], &self.lagged[frame], 1.0);
        }
        statistics
    }
}
