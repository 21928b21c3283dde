//! Saved states as bytes.

use crate::Error;
use raypath_model::{State, restore_state, saved_state};
use sha2::{Digest, Sha256};

/// The version of the bytes.
const VERSION: u8 = 2;
const MAGIC: &[u8] = b"raypath state ";
const DIGEST: usize = 64;

/// The bytes of a state: a magic number, the version, the digest of what the state belongs to, the words in
/// little-endian order, and the digest of all that.
pub fn save(state: &(impl State + Clone), of: &str) -> Vec<u8> {
    let mut bytes = [MAGIC, &[VERSION], owner(of).as_bytes()].concat();
    bytes.extend(saved_state(state).iter().flat_map(|word| word.to_le_bytes()));
    let all = digest(&bytes);
    bytes.extend(all.as_bytes());
    bytes
}

/// Replaces a state by a saved one.
///
/// # Errors
/// Bytes that are not a saved state of this version and owner. Then nothing changes.
pub fn restore(state: &mut (impl State + Clone), of: &str, bytes: &[u8]) -> Result<(), Error> {
    let expected = |what: &str| Error::Argument(format!("{} bytes of a state, expected {what}", bytes.len()));
    let rest = bytes.strip_prefix(MAGIC).ok_or_else(|| expected("those that a model saved"))?;
    let (version, rest) = rest.split_first().ok_or_else(|| expected("a version"))?;
    if *version != VERSION {
        return Err(Error::Argument(format!("a state of version {version}, expected version {VERSION}")));
    }
    let whole = rest
        .split_last_chunk::<DIGEST>()
        .filter(|(_, all)| **all == *digest(&bytes[..bytes.len() - DIGEST]).as_bytes());
    let Some((found, words)) = whole.and_then(|(rest, _)| rest.split_first_chunk::<DIGEST>()) else {
        return Err(expected("all that a model saved, unchanged"));
    };
    if *found != *owner(of).as_bytes() {
        return Err(Error::Argument(format!("a state of another configuration or release, expected that of {of}")));
    }
    let (words, left) = words.as_chunks();
    let words: Vec<u64> = words.iter().map(|word| u64::from_le_bytes(*word)).collect();
    if left.is_empty() && restore_state(state, &words) { Ok(()) } else { Err(expected("the words of such a state")) }
}

fn digest(bytes: &[u8]) -> String {
    format!("{:x}", Sha256::digest(bytes))
}

/// The digest of what a state belongs to: a configuration, in a release.
pub fn owner(of: &str) -> String {
    digest(format!("{} {of}", env!("CARGO_PKG_VERSION")).as_bytes())
}
