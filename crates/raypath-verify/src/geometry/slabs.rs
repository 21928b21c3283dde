//! Where a ray is in a box, exactly, and what rounding may make of it.

use super::dyadic::Dyadic;
use raypath_ops::{Binary32, Ray};
use std::cmp::Ordering;

/// A number as a fraction whose denominator is positive.
#[derive(Debug, Clone)]
pub struct Fraction {
    numerator: Dyadic,
    denominator: Dyadic,
}

/// Which bound of a computed distance is meant.
#[derive(Debug, Clone, Copy)]
enum Side {
    Below,
    Above,
}

impl Fraction {
    fn integer(value: Dyadic) -> Self {
        Self { numerator: value, denominator: Dyadic::from(1) }
    }

    /// What a slab distance of this value is computed as at least or at most: three roundings, and half of the smallest
    /// number where the product underflows.
    fn rounded(&self, side: Side) -> Self {
        let step = Dyadic::from(1) + Dyadic::power_of_two(-24);
        let relative = &step * &step * &step - Dyadic::from(1);
        let error = self.numerator.abs() * &relative + &self.denominator * &Dyadic::power_of_two(-150);
        let numerator = match side {
            Side::Below => &self.numerator - &error,
            Side::Above => &self.numerator + &error,
        };
        Self { numerator, denominator: self.denominator.clone() }
    }

    /// About this, for reports.
    pub fn to_f64(&self) -> f64 {
        self.numerator.to_f64() / self.denominator.to_f64()
    }

    /// How far a number is from it.
    pub fn distance(&self, x: f32) -> f64 {
        (Dyadic::from(x) * &self.denominator - &self.numerator).abs().to_f64() / self.denominator.to_f64()
    }

    /// Whether `x` is what it may be computed as.
    pub fn may_round_to(&self, x: f32) -> bool {
        let x = Self::integer(x.into());
        self.rounded(Side::Below) <= x && x <= self.rounded(Side::Above)
    }
}

impl PartialEq for Fraction {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Fraction {}

impl PartialOrd for Fraction {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Fraction {
    fn cmp(&self, other: &Self) -> Ordering {
        (&self.numerator * &other.denominator).cmp(&(&other.numerator * &self.denominator))
    }
}

/// Where a ray is between the two planes of a slab that it crosses.
struct Crossing {
    near: Fraction,
    far: Fraction,
}

/// What is known of a ray and a box.
pub struct Geometry {
    /// Where the ray enters, if it does.
    pub entry: Fraction,
    /// Whether the ray, within its extent, has a point in the closed box.
    pub is_hit: bool,
    /// What must be computed; `None` where rounding may decide.
    pub must_be: Option<bool>,
    /// Whether some distance is beyond the range of binary32, so that nothing is claimed.
    pub is_out_of_range: bool,
    /// By how much the distance at which the ray leaves exceeds the one at which it enters, as a part of itself.
    pub gap: f64,
}

impl Geometry {
    /// Of this ray and the box between these corners.
    pub fn new(ray: &Ray<Binary32>, [low, high]: [[f32; 3]; 2]) -> Self {
        let (origin, direction) = (<[f32; 3]>::from(ray.origin), <[f32; 3]>::from(ray.dir));
        let extent = f32::from(ray.extent);
        let (mut crossings, mut is_beside) = (Vec::new(), false);
        for axis in 0..3 {
            let (o, d) = (origin[axis], direction[axis]);
            if d == 0.0 {
                is_beside |= o < low[axis] || high[axis] < o;
                continue;
            }
            let at = |bound: f32| {
                let difference = Dyadic::from(bound) - Dyadic::from(o);
                let numerator = if d < 0.0 { -difference } else { difference };
                Fraction { numerator, denominator: Dyadic::from(d.abs()) }
            };
            let [near, far] = if d < 0.0 { [high[axis], low[axis]] } else { [low[axis], high[axis]] }.map(at);
            crossings.push(Crossing { near, far });
        }
        Self::of(&crossings, is_beside, (extent != f32::INFINITY).then(|| Fraction::integer(extent.into())))
    }

    fn of(crossings: &[Crossing], is_beside: bool, extent: Option<Fraction>) -> Self {
        let zero = Fraction::integer(Dyadic::zero());
        let nears = || crossings.iter().map(|crossing| crossing.near.clone());
        let fars = || crossings.iter().map(|crossing| crossing.far.clone());
        let entry = nears().fold(zero.clone(), Fraction::max);
        let exit = fars().chain(extent.clone()).min();
        let is_hit = !is_beside && exit.as_ref().is_none_or(|exit| entry <= *exit);
        let gap = exit.map_or(f64::INFINITY, |exit| {
            let (enters, leaves) = (&entry.numerator * &exit.denominator, &exit.numerator * &entry.denominator);
            (&leaves - &enters).to_f64() / leaves.to_f64().abs()
        });
        let is_out_of_range = nears().chain(fars()).any(|t| t.to_f64().abs() >= 2_f64.powi(127));
        let must_be = if is_beside {
            Some(false)
        } else if is_surely_hit(crossings, &zero, extent.as_ref()) {
            Some(true)
        } else {
            is_surely_missed(crossings, &zero, extent.as_ref()).then_some(false)
        };
        Self { entry, is_hit, must_be, is_out_of_range, gap }
    }
}

/// Whatever rounding does, no near distance exceeds a far one. The two of one slab are rounded alike, so that their
/// order stays.
fn is_surely_hit(crossings: &[Crossing], zero: &Fraction, extent: Option<&Fraction>) -> bool {
    let pairs =
        crossings.iter().enumerate().flat_map(|(i, a)| crossings.iter().enumerate().map(move |(j, b)| (i, a, j, b)));
    let mut pairs =
        pairs.map(
            |(i, a, j, b)| {
                if i == j { a.near <= a.far } else { a.near.rounded(Side::Above) <= b.far.rounded(Side::Below) }
            },
        );
    pairs.all(|fits| fits)
        && crossings.iter().all(|crossing| crossing.far >= *zero)
        && extent.is_none_or(|extent| crossings.iter().all(|crossing| crossing.near.rounded(Side::Above) <= *extent))
}

/// Whatever rounding does, some near distance exceeds a far one.
fn is_surely_missed(crossings: &[Crossing], zero: &Fraction, extent: Option<&Fraction>) -> bool {
    let near = crossings.iter().map(|crossing| crossing.near.rounded(Side::Below)).max();
    let near = near.map_or(zero.clone(), |near| near.max(zero.clone()));
    let far = crossings.iter().map(|crossing| crossing.far.rounded(Side::Above)).min();
    far.into_iter().chain(extent.cloned()).any(|far| near > far)
}

#[cfg(test)]
mod tests {
    use super::Geometry;
    use raypath_ops::Ray;

    fn geometry(origin: [f32; 3], direction: [f32; 3], extent: f32, aabb: [[f32; 3]; 2]) -> Geometry {
        Geometry::new(&Ray::new(origin, direction, extent).expect("a ray"), aabb)
    }

    #[test]
    fn what_is_seen_by_eye() {
        let cube = [[-1.0; 3], [1.0; 3]];
        let from = |origin, direction| geometry(origin, direction, f32::INFINITY, cube);
        let verdict = |g: Geometry| (g.is_hit, g.must_be, g.entry.to_f64());
        assert_eq!(verdict(from([0.0, 0.0, -5.0], [0.0, 0.0, 2.0])), (true, Some(true), 2.0));
        assert_eq!(verdict(from([0.0, 0.0, -5.0], [0.0, -0.0, -2.0])), (false, Some(false), 0.0));
        assert_eq!(verdict(from([1.0, 0.0, -5.0], [0.0, 0.0, 1.0])), (true, Some(true), 4.0));
        assert_eq!(verdict(from([1.5, 0.0, -5.0], [-0.0, 0.0, 1.0])), (false, Some(false), 4.0));
        assert_eq!(verdict(from([0.5, 0.5, 0.5], [1.0, 2.0, 3.0])), (true, Some(true), 0.0));
        // Through an edge: exactly a hit, but rounding may decide.
        assert_eq!(verdict(from([-2.0, 0.0, 0.0], [1.0, 1.0, 0.0])), (true, None, 1.0));
        assert_eq!(verdict(from([-2.0, 1e-6, 0.0], [1.0, 1.0, 0.0])), (false, Some(false), 1.0));
        assert_eq!(verdict(from([-2.0, -1e-6, 0.0], [1.0, 1.0, 0.0])), (true, Some(true), 1.0));
    }

    #[test]
    fn flat_empty_and_beyond_the_extent() {
        let along = |extent, aabb| geometry([-3.0, 0.0, 0.0], [3.0, 0.0, 1.0], extent, aabb).must_be;
        let flat = [[0.0, -1.0, -4.0], [0.0, 1.0, 4.0]];
        assert_eq!(along(f32::INFINITY, flat), Some(true));
        assert_eq!(along(0.5, flat), Some(false));
        assert_eq!(along(1.0, flat), None);
        assert_eq!(along(f32::INFINITY, [[0.5, -1.0, -4.0], [0.0, 1.0, 4.0]]), Some(false));
        assert_eq!(along(f32::INFINITY, [[0.0, 1.0, -4.0], [0.5, -1.0, 4.0]]), Some(false));
    }
}
