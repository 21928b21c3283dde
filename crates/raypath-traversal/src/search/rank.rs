//! The rank of a vector, and the distance that is returned for it.

use super::distance::Sums;
use super::job::SearchMetric;

/// The rank of a vector, the lower the better; NaN for none. For the cosine, it is minus the squared cosine times the
/// query's squared norm, with the cosine's sign, in two roundings: vectors whose cosines differ by less than a few units
/// in the last place may be in either order.
pub fn rank_of(metric: SearchMetric, Sums { sum, norm }: Sums) -> f32 {
    let rank = match metric {
        SearchMetric::Euclidean => sum,
        SearchMetric::Dot => -sum,
        SearchMetric::Cosine => -(sum / norm * sum.abs()),
    };
    // Of both zeros, this is the positive one.
    rank + 0.0
}

/// The distance of a vector with this rank: the Euclidean distance, the dot product, or the cosine of the angle. Each
/// operation rounds. The cosine is within 3 units in the last place of that of the exact angle between the sums.
pub fn distance_of(metric: SearchMetric, rank: f32, query_norm: f32, scale: f32) -> f32 {
    match metric {
        SearchMetric::Euclidean => rank.sqrt() * scale,
        SearchMetric::Dot => (0.0 - rank) * scale * scale,
        SearchMetric::Cosine => {
            let cosine = (rank.abs() / query_norm).sqrt();
            if rank > 0.0 { -cosine } else { cosine }
        }
    }
}

/// A rank as a word that is the lower the lower the rank. Numbers are not -0; those of NaN are behind all others.
pub fn key_of(rank: f32) -> u32 {
    let bits = rank.to_bits();
    if rank.is_nan() {
        u32::MAX
    } else if bits >> 31 == 1 {
        !bits
    } else {
        bits | 1 << 31
    }
}

/// The rank of a key.
pub fn rank_of_key(key: u32) -> f32 {
    f32::from_bits(if key >> 31 == 1 { key & !(1 << 31) } else { !key })
}
