//! One sweep of a chain.

use rand::Rng;

use super::chain::Chain;

impl<const D: usize> Chain<D> {
    /// One sweep: features and states of each sequence, split–merge moves, transitions, dynamics, α and κ, γ and c.
    /// `None` if rounding leaves a matrix that is not positive definite.
    pub fn sweep(&mut self, rng: &mut impl Rng) -> Option<()> {
        for index in 0..self.sequences.len() {
            self.update_sequence(index, rng)?;
        }
        for _ in 0..self.moves.split_merges {
            self.split_or_merge(rng)?;
        }
        // Split and merge integrate η and θ out, so all of them are drawn anew before they are used.
        self.draw_weights(rng);
        self.draw_dynamics(rng)?;
        self.update_stickiness(rng);
        self.update_beta_process(rng);
        Some(())
    }
}
