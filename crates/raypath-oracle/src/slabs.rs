//! Rays and boxes in exact rationals: where a ray enters a box and where it leaves it, and answers held against that.

use crate::exact;
use num_rational::BigRational;
use raypath_ops::{Binary32, Num, Ray};

/// What an answer has in one place.
pub struct Place {
    /// The box is hit.
    pub hit: bool,
    /// Where the ray enters it.
    pub tmin: Num<Binary32>,
    /// Which box it is.
    pub index: u32,
}

/// Places must be sorted (nearer first, hits before misses, then by index), have each box once, and +∞ for a miss.
/// Boxes that the ray hits by more than the bound must be hit, those that it misses by more must be missed, and the
/// distance of a hit must be within the bound. `of` answers what is exact about a box; nothing, where no bound holds.
///
/// # Errors
/// The first box about which the answer is wrong, or the places if they are out of order.
pub fn check<const N: usize>(places: [Place; N], of: impl Fn(usize) -> Option<Passage>) -> Result<(), String> {
    let keys = places.map(|Place { hit, tmin, index }| (tmin.to_bits(), !hit, index));
    if !keys.is_sorted() {
        return Err(format!("places (tmin, miss, index) {keys:x?} are out of order"));
    }
    let mut seen = [false; N];
    for (tmin, miss, index) in keys {
        let index = index as usize;
        if std::mem::replace(&mut seen[index], true) {
            return Err(format!("box {index} stands in two places"));
        }
        let infinite = f32::INFINITY.to_bits();
        if tmin > infinite || (miss && tmin != infinite) {
            return Err(format!("box {index}: tmin has the bits {tmin:08x}, expected a distance, +∞ of a miss"));
        }
        let Some(passage) = of(index) else { continue };
        let place = exact::value(Num::from_bits(tmin));
        let near = place.is_some_and(|tmin| passage.entry[0] <= tmin && tmin <= passage.entry[1]);
        match passage.hit() {
            Some(hit) if hit == miss => return Err(format!("box {index}: hit is {}, but exactly it is {hit}", !miss)),
            _ if !miss && !near => {
                let [least, greatest] = passage.entry;
                return Err(format!("box {index}: tmin is {:e}, expected {least} to {greatest}", f32::from_bits(tmin)));
            }
            _ => {}
        }
    }
    Ok(())
}

/// A plane across an axis.
pub struct Plane {
    /// How far it is from the ray's origin, along the axis.
    pub at: BigRational,
    /// By how much an answer may go by another place; its distances are then off by this over the direction.
    pub bound: BigRational,
}

/// Where the ray enters a box and where it leaves it: the least and the greatest distance that the answer may go by.
pub struct Passage {
    entry: [BigRational; 2],
    /// None is infinite.
    exit: Option<[BigRational; 2]>,
    /// Whether it is beside a slab along which it runs; none if too close to a plane to say.
    beside: Option<bool>,
}

impl Passage {
    /// Through the box of these planes: least and greatest, along x, y and z. None where a number is not finite, where
    /// `inv` is not the inverse, or where one is so large or small that bounds do not hold.
    pub fn new(ray: &Ray<Binary32>, planes: [[Plane; 2]; 3]) -> Option<Self> {
        let zero = BigRational::default();
        let extent = match f32::from(ray.extent) {
            f32::INFINITY => None,
            _ => Some(exact::value(ray.extent)?),
        };
        let exit = extent.map(|extent| [extent.clone(), extent]);
        let mut passage = Self { entry: [zero.clone(), zero.clone()], exit, beside: Some(false) };
        let inverses = [ray.inv.x, ray.inv.y, ray.inv.z];
        for (planes, (dir, inv)) in planes.into_iter().zip([ray.dir.x, ray.dir.y, ray.dir.z].into_iter().zip(inverses))
        {
            let direction = exact::value(dir)?;
            let is_inverse = f32::from(inv).to_bits() == (1.0 / f32::from(dir)).to_bits();
            let numbers = planes.iter().flat_map(|plane| [&plane.at, &plane.bound]);
            if !is_inverse || numbers.into_iter().any(|number| exact::absolute(number) > exact::power(60)) {
                return None;
            }
            if direction == zero {
                passage.along(planes);
            } else if (exact::power(-60)..exact::power(60)).contains(&exact::absolute(&direction)) {
                passage.across(planes, &direction);
            } else {
                return None;
            }
        }
        Some(passage)
    }

    /// A slab that the ray runs along.
    fn along(&mut self, [min, max]: [Plane; 2]) {
        if min.at > min.bound || max.at < -&max.bound {
            self.beside = Some(true);
        } else if (min.at > -min.bound || max.at < max.bound) && self.beside == Some(false) {
            self.beside = None;
        }
    }

    /// A slab that the ray crosses.
    fn across(&mut self, planes: [Plane; 2], direction: &BigRational) {
        let [near, far] = planes.map(|Plane { at, bound }| {
            let bound = bound / exact::absolute(direction) + exact::power(-130);
            let distance = at / direction;
            [&distance - &bound, distance + bound]
        });
        let (near, far) = if *direction < BigRational::default() { (far, near) } else { (near, far) };
        let [least, greatest] = near;
        let [entry_least, entry_greatest] = self.entry.clone();
        self.entry = [exact::greater(entry_least, least), exact::greater(entry_greatest, greatest)];
        let [least, greatest] = far;
        self.exit = Some(match self.exit.take() {
            Some([exit_least, exit_greatest]) => {
                [exact::lesser(exit_least, least), exact::lesser(exit_greatest, greatest)]
            }
            None => [least, greatest],
        });
    }

    /// Whether it is hit, if by more than the bound.
    pub fn hit(&self) -> Option<bool> {
        let [entry_least, entry_greatest] = &self.entry;
        let misses = self.exit.as_ref().is_some_and(|[_, greatest]| entry_least > greatest);
        let hits = self.exit.as_ref().is_none_or(|[least, _]| entry_greatest <= least);
        match self.beside {
            Some(true) => Some(false),
            _ if misses => Some(false),
            Some(false) if hits => Some(true),
            _ => None,
        }
    }
}
