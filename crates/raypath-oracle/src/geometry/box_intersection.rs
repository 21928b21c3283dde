//! The exact intersection of a ray and a box, and the results that rounding allows.

use crate::geometry::dyadic::Dyadic;
use raypath_ops::{Binary32, Ray};
use std::cmp::Ordering;

/// A fraction with a positive denominator.
#[derive(Debug, Clone)]
pub struct Fraction {
    numerator: Dyadic,
    denominator: Dyadic,
}

impl Fraction {
    fn integer(value: Dyadic) -> Self {
        Self { numerator: value, denominator: Dyadic::from(1) }
    }

    /// The lower and upper bounds of a slab distance of this value as computed: three roundings, and half of the
    /// smallest number for underflow of the product.
    fn rounded(&self) -> [Self; 2] {
        let step = Dyadic::from(1) + Dyadic::power_of_two(-24);
        let relative = &step * &step * &step - Dyadic::from(1);
        let error = self.numerator.abs() * &relative + &self.denominator * &Dyadic::power_of_two(-150);
        [&self.numerator - &error, &self.numerator + &error]
            .map(|numerator| Self { numerator, denominator: self.denominator.clone() })
    }

    /// An approximation, for reports.
    pub fn to_f64(&self) -> f64 {
        self.numerator.to_f64() / self.denominator.to_f64()
    }

    /// The distance of a number from the fraction.
    pub fn distance(&self, x: f32) -> f64 {
        (Dyadic::from(x) * &self.denominator - &self.numerator).abs().to_f64() / self.denominator.to_f64()
    }

    /// Whether it is not less than a number.
    pub fn is_at_least(&self, x: f32) -> bool {
        x.is_finite() && Self::integer(x.into()) <= *self
    }

    /// Whether rounding allows `x` as the computed value.
    pub fn may_round_to(&self, x: f32) -> bool {
        let (x, [below, above]) = (Self::integer(x.into()), self.rounded());
        below <= x && x <= above
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

/// The distances at which a ray enters and leaves a slab.
struct Crossing {
    near: Fraction,
    far: Fraction,
}

/// The exact intersection of a ray and a box.
pub struct ExactIntersection {
    /// The distance at which the ray enters, if it does.
    pub entry: Fraction,
    /// Whether a point of the ray within its extent lies in the closed box.
    pub is_hit: bool,
    /// The hit that must be computed; none if it may depend on rounding.
    pub required_hit: Option<bool>,
    /// Whether a distance is beyond the range of binary32, so that the claim excludes the box.
    pub is_out_of_range: bool,
    /// The exit distance minus the entry distance, relative to the exit distance.
    pub gap: f64,
}

impl ExactIntersection {
    /// The intersection of this ray and the box between these corners.
    pub fn new(ray: &Ray<Binary32>, [low, high]: [[f32; 3]; 2]) -> Self {
        let (origin, direction) = (<[f32; 3]>::from(ray.origin), <[f32; 3]>::from(ray.dir));
        let extent = f32::from(ray.extent);
        let (mut crossings, mut is_outside_slab) = (Vec::new(), false);
        for axis in 0..3 {
            let (o, d) = (origin[axis], direction[axis]);
            if d == 0.0 {
                is_outside_slab |= o < low[axis] || high[axis] < o;
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
        Self::of(&crossings, is_outside_slab, (extent != f32::INFINITY).then(|| Fraction::integer(extent.into())))
    }

    fn of(crossings: &[Crossing], is_outside_slab: bool, extent: Option<Fraction>) -> Self {
        let zero = Fraction::integer(Dyadic::default());
        let nears = || crossings.iter().map(|crossing| crossing.near.clone());
        let fars = || crossings.iter().map(|crossing| crossing.far.clone());
        let entry = nears().fold(zero.clone(), Fraction::max);
        let exit = fars().chain(extent.clone()).min();
        let is_hit = !is_outside_slab && exit.as_ref().is_none_or(|exit| entry <= *exit);
        let gap = exit.map_or(f64::INFINITY, |exit| {
            let (enters, leaves) = (&entry.numerator * &exit.denominator, &exit.numerator * &entry.denominator);
            (&leaves - &enters).to_f64() / leaves.to_f64().abs()
        });
        let is_out_of_range = nears().chain(fars()).any(|t| t.to_f64().abs() >= 2_f64.powi(127));
        let required_hit = if is_outside_slab {
            Some(false)
        } else if must_hit(crossings, &zero, extent.as_ref()) {
            Some(true)
        } else {
            must_miss(crossings, &zero, extent.as_ref()).then_some(false)
        };
        Self { entry, is_hit, required_hit, is_out_of_range, gap }
    }
}

/// Whether no near distance exceeds a far one under any rounding. The two distances of one slab are rounded in the same
/// way, which keeps their order.
fn must_hit(crossings: &[Crossing], zero: &Fraction, extent: Option<&Fraction>) -> bool {
    let rounded: Vec<[[Fraction; 2]; 2]> =
        crossings.iter().map(|crossing| [crossing.near.rounded(), crossing.far.rounded()]).collect();
    let all = || crossings.iter().zip(&rounded).enumerate();
    let fits = |i: usize, [[_, near], _]: &[[Fraction; 2]; 2]| {
        all().all(|(j, (b, [_, [far, _]]))| if i == j { b.near <= b.far } else { near <= far })
    };
    all().all(|(i, (crossing, bounds))| fits(i, bounds) && crossing.far >= *zero)
        && extent.is_none_or(|extent| rounded.iter().all(|[[_, near], _]| near <= extent))
}

/// Whether some near distance exceeds a far one under any rounding.
fn must_miss(crossings: &[Crossing], zero: &Fraction, extent: Option<&Fraction>) -> bool {
    let nears = crossings.iter().map(|crossing| crossing.near.rounded()).map(|[below, _]| below);
    let fars = crossings.iter().map(|crossing| crossing.far.rounded()).map(|[_, above]| above);
    let near = nears.fold(zero.clone(), Fraction::max);
    fars.chain(extent.cloned()).any(|far| near > far)
}

#[cfg(test)]
mod tests {
    use super::ExactIntersection;
    use raypath_ops::Ray;

    fn geometry(origin: [f32; 3], direction: [f32; 3], extent: f32, aabb: [[f32; 3]; 2]) -> ExactIntersection {
        ExactIntersection::new(&Ray::new(origin, direction, extent).expect("a ray"), aabb)
    }

    #[test]
    fn simple_cases_are_right() {
        let cube = [[-1.0; 3], [1.0; 3]];
        let from = |origin, direction| geometry(origin, direction, f32::INFINITY, cube);
        let verdict = |g: ExactIntersection| (g.is_hit, g.required_hit, g.entry.to_f64());
        assert_eq!(verdict(from([0.0, 0.0, -5.0], [0.0, 0.0, 2.0])), (true, Some(true), 2.0));
        assert_eq!(verdict(from([0.0, 0.0, -5.0], [0.0, -0.0, -2.0])), (false, Some(false), 0.0));
        assert_eq!(verdict(from([1.0, 0.0, -5.0], [0.0, 0.0, 1.0])), (true, Some(true), 4.0));
        assert_eq!(verdict(from([1.5, 0.0, -5.0], [-0.0, 0.0, 1.0])), (false, Some(false), 4.0));
        assert_eq!(verdict(from([0.5, 0.5, 0.5], [1.0, 2.0, 3.0])), (true, Some(true), 0.0));
        // Through an edge: an exact hit, but the result may depend on rounding.
        assert_eq!(verdict(from([-2.0, 0.0, 0.0], [1.0, 1.0, 0.0])), (true, None, 1.0));
        assert_eq!(verdict(from([-2.0, 1e-6, 0.0], [1.0, 1.0, 0.0])), (false, Some(false), 1.0));
        assert_eq!(verdict(from([-2.0, -1e-6, 0.0], [1.0, 1.0, 0.0])), (true, Some(true), 1.0));
    }

    #[test]
    fn flat_empty_and_beyond_the_extent() {
        let along = |extent, aabb| geometry([-3.0, 0.0, 0.0], [3.0, 0.0, 1.0], extent, aabb).required_hit;
        let flat = [[0.0, -1.0, -4.0], [0.0, 1.0, 4.0]];
        assert_eq!(along(f32::INFINITY, flat), Some(true));
        assert_eq!(along(0.5, flat), Some(false));
        assert_eq!(along(1.0, flat), None);
        assert_eq!(along(f32::INFINITY, [[0.5, -1.0, -4.0], [0.0, 1.0, 4.0]]), Some(false));
        assert_eq!(along(f32::INFINITY, [[0.0, 1.0, -4.0], [0.5, -1.0, 4.0]]), Some(false));
    }
}
