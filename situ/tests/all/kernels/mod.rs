//! The learning kernels against oracles that share no code with them.
//!
//! If brute force can find the answer (every path of a model, every pair of a cluster), it does, over random inputs. If
//! not, the numbers of another implementation are compared. They are in `tests/data`, minted once, each beside the
//! script that minted it. To mint anew is to claim that the *definition* changed; say so in that commit.

mod alignment;
mod classifier;
mod cluster;
mod divergence;
mod em;
mod frechet;
mod half_turn;
mod hmm;
mod hmmlearn;
mod interpolate;
mod logistic;
mod policies;
mod pose;
mod sample;
mod scalar;
mod scatter;
