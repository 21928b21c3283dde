//! Wrong implementations of sums over vectors: the negative control of `sums`.

use super::sums::{angular, euclidean, lanes};
use super::wrong_distances::truncate;
use raypath_ops::{Beat, Binary32, Flags};

/// A wrong implementation.
#[derive(Debug, Clone, Copy)]
pub enum Wrong {
    /// The mask is ignored.
    MasksIgnored,
    /// The operands have significands of 16 bits.
    ShortOperands,
    /// Only the last beat is added.
    LastBeatAlone,
    /// Euclidean sums by (a - b)² = a² - 2ab + b², which cancels if a is near b.
    Expanded,
}

impl Wrong {
    /// All wrong implementations.
    pub const ALL: [Self; 4] = [Self::MasksIgnored, Self::ShortOperands, Self::LastBeatAlone, Self::Expanded];

    /// The name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::MasksIgnored => "masks ignored",
            Self::ShortOperands => "operands of 16 bits",
            Self::LastBeatAlone => "the last beat alone",
            Self::Expanded => "squares of differences expanded",
        }
    }

    /// The wrong Euclidean sum.
    pub fn euclidean<const E: usize, const A: usize>(self, beats: &[Beat<Binary32, E>]) -> f32 {
        match self {
            Self::Expanded => beats.iter().flat_map(lanes).map(|[a, b]| a * a - 2.0 * a * b + b * b).sum(),
            _ => euclidean::<E, A>(&self.changed(beats)),
        }
    }

    /// The wrong dot product and norm.
    pub fn angular<const E: usize, const A: usize>(self, beats: &[Beat<Binary32, A>]) -> [f32; 2] {
        angular::<E, A>(&self.changed(beats))
    }

    /// The beats to run on the datapath instead of these.
    fn changed<const N: usize>(self, beats: &[Beat<Binary32, N>]) -> Vec<Beat<Binary32, N>> {
        let short = |number: [_; N]| number.map(|number| truncate(f32::from(number), 16).into());
        let change = |beat: &Beat<Binary32, N>| match self {
            Self::MasksIgnored => Beat { mask: Flags::from_mask(u64::MAX), ..*beat },
            Self::ShortOperands => Beat { a: short(beat.a), b: short(beat.b), ..*beat },
            Self::LastBeatAlone | Self::Expanded => *beat,
        };
        let first = if matches!(self, Self::LastBeatAlone) { beats.len() - 1 } else { 0 };
        beats[first..].iter().map(change).collect()
    }
}
