//! Hashes of content: SHA-256 in hexadecimal digits, as `sha256sum` prints it.

use sha2::{Digest, Sha256};

use crate::program::checkout;

/// The hash of a file's content.
pub fn hash(content: impl AsRef<[u8]>) -> String {
    checkout::hex(&Sha256::digest(content))
}

#[cfg(test)]
mod tests {
    use super::hash;

    #[test]
    fn a_hash_is_that_of_sha256sum() {
        assert_eq!(hash("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }
}
