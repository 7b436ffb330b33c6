//! Random numbers whose bits do not depend on the platform.

use rand::{Rng, RngExt};

/// A draw from the standard normal distribution (Box and Muller 1958). The logarithm and the cosine are those of
/// `libm`.
pub fn standard_normal(rng: &mut impl Rng) -> f64 {
    // 1 − u is in (0, 1], where the logarithm is finite.
    let radius = libm::sqrt(-2.0 * libm::log(1.0 - rng.random::<f64>()));
    radius * libm::cos(2.0 * core::f64::consts::PI * rng.random::<f64>())
}

/// A seed for a named stream of a root seed: FNV-1a over the bytes of the root and the name (Fowler, Noll and Vo), then
/// the finaliser of SplitMix64. So the streams of neighbouring roots have nothing in common.
pub fn stream(root: u64, name: &str) -> u64 {
    const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    let bytes = root.to_le_bytes().into_iter().chain(name.bytes());
    let mut mixed = bytes.fold(OFFSET, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(PRIME));
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}
