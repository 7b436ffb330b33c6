//! The learning kernels against oracles that share no code with them.
//!
//! Where the answer can be had by brute force (every path of a model, every pair of a cluster), it is, over random
//! inputs. Where it cannot, another implementation's numbers are compared: `tests/data` holds them, minted once, each
//! beside the script that minted it. To mint anew is to claim that the *definition* changed; say so in that commit.

mod alignment;
mod cluster;
mod divergence;
mod em;
mod hmm;
mod hmmlearn;
mod interpolate;
mod logistic;
mod policies;
mod pose;
mod sample;
mod scalar;
