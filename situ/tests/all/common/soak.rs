//! How long property tests go on, and from which seed.
//!
//! `SITU_SOAK=N` makes N times as many cases. `SITU_SEED=S` is the seed of what is drawn; where it is not given, the
//! seed is 0, so that a test that has failed fails again, but a soaked one draws a seed of its own. A failure says it.

use std::env;
use std::hash::{BuildHasher, RandomState};
use std::sync::OnceLock;

use proptest::test_runner::{Config, RngSeed};

/// How many times the usual number of cases is wanted.
pub(crate) fn times() -> u32 {
    number("SITU_SOAK").map_or(1, |times| u32::try_from(times).expect("SITU_SOAK: expected at most 4294967295"))
}

/// The seed of everything that is drawn.
pub(crate) fn seed() -> u64 {
    static SEED: OnceLock<u64> = OnceLock::new();
    let drawn = || if times() > 1 { RandomState::new().hash_one("a seed") } else { 0 };
    *SEED.get_or_init(|| number("SITU_SEED").unwrap_or_else(drawn))
}

/// So many cases, or more where they are soaked.
pub(crate) fn config(cases: u32) -> Config {
    println!("SITU_SEED={}", seed());
    Config { cases: cases.saturating_mul(times()), rng_seed: RngSeed::Fixed(seed()), ..Config::default() }
}

/// Says how much was done, once in a while, where a test is soaked.
pub(crate) fn tell(done: u64, what: &str) {
    if times() > 1 && done.is_multiple_of(ONCE_IN) {
        println!("{done} {what}");
    }
}

/// How often something is done between two words about it.
const ONCE_IN: u64 = 100_000;

/// The number that a variable of the environment holds.
fn number(name: &str) -> Option<u64> {
    let text = env::var(name).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{name}={text}: expected a number from 0")))
}
