//! Random numbers.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

/// A ChaCha generator that can be cloned, to repeat a stream of jobs or traffic from any position.
#[derive(Debug)]
pub struct CloneableRng(pub ChaCha8Rng);

impl Clone for CloneableRng {
    fn clone(&self) -> Self {
        let mut copy = ChaCha8Rng::from_seed(self.0.get_seed());
        copy.set_stream(self.0.get_stream());
        copy.set_word_pos(self.0.get_word_pos());
        Self(copy)
    }
}
