//! Named streams of random numbers.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The key of the stream of a seed and a name (hashed as FNV-1a, 64 bit). The bytes from 16 on are 0.
pub(crate) fn key(seed: u64, name: &str) -> [u8; 32] {
    const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0100_0000_01b3;
    let hash = name.bytes().fold(OFFSET, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(PRIME));
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8..16].copy_from_slice(&hash.to_le_bytes());
    key
}

/// The stream of random numbers of a seed and a name.
pub(crate) fn stream(seed: u64, name: &str) -> ChaCha8Rng {
    ChaCha8Rng::from_seed(key(seed, name))
}
