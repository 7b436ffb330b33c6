//! How long the sequences of a model are, and how much time they spend in each state.

use super::model::Hmm;

impl<E> Hmm<E> {
    /// The expected number of frames in each state, n = πᵀ (I − A)⁻¹, shape (K). All are infinite if some sequence
    /// never ends.
    pub fn expected_visits(&self) -> Vec<f64> {
        let k = self.states();
        // (I − A)ᵀ n = π by elimination. No rows are exchanged. The rows of A sum to at most 1, so in every column the
        // diagonal outweighs the rest, and elimination preserves that.
        let mut matrix: Vec<f64> = (0..k * k)
            .map(|at| f64::from(u8::from(at / k == at % k)) - self.transition[(at % k) * k + at / k])
            .collect();
        let mut visits = self.initial.clone();
        for column in 0..k {
            if matrix[column * k + column] < f64::EPSILON {
                return vec![f64::INFINITY; k];
            }
            for row in column + 1..k {
                let factor = matrix[row * k + column] / matrix[column * k + column];
                for at in column..k {
                    matrix[row * k + at] -= factor * matrix[column * k + at];
                }
                visits[row] -= factor * visits[column];
            }
        }
        for row in (0..k).rev() {
            for at in row + 1..k {
                visits[row] -= matrix[row * k + at] * visits[at];
            }
            visits[row] /= matrix[row * k + row];
        }
        visits
    }

    /// The expected number of frames of a sequence.
    pub fn expected_length(&self) -> f64 {
        self.expected_visits().iter().sum()
    }
}
