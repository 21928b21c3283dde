//! Names of results: digests of what they depend on.

use sha2::{Digest, Sha256};

/// The name of a result: a digest of everything that it depends on.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Key(String);

impl Key {
    /// The key of a result of this kind that depends on these parts, and on this crate's version.
    pub fn new(kind: &str, parts: &[&str]) -> Self {
        let mut digest = Sha256::new();
        for part in [env!("CARGO_PKG_VERSION"), kind].iter().chain(parts) {
            digest.update((part.len() as u64).to_le_bytes());
            digest.update(part);
        }
        Self(format!("{kind}-{}", &hex(&digest.finalize())[..32]))
    }

    /// The key as text, which another key may depend on.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// The SHA-256 digest of bytes, in hexadecimal digits.
pub fn digest(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_separate_their_parts() {
        let keys = [Key::new("a", &["bc", "d"]), Key::new("a", &["b", "cd"]), Key::new("ab", &["c", "d"])];
        assert!(keys[0] != keys[1] && keys[1] != keys[2] && keys[0] != keys[2]);
    }
}
