//! Rays and boxes in exact rationals, for oracles of box operations.

use crate::exact;
use num_rational::BigRational;
use raypath_ops::{Binary32, Num, Ray};

/// A box in the sorted result of an operation.
pub struct SortedBox {
    /// The ray hits the box.
    pub hit: bool,
    /// The distance at which the ray enters the box.
    pub tmin: Num<Binary32>,
    /// The index of the box in the job.
    pub index: u32,
}

/// Checks a sorted result. The boxes must be sorted (nearer first, hits before misses, then by index), each must occur
/// once, and a miss must have a distance of +∞. With the exact passage of a box from `passage`, a box that the ray hits
/// or misses by more than the error bound must be a hit or a miss, and the distance of a hit must be within the bound.
/// `passage` returns `None` if no error bound is known.
///
/// # Errors
/// The first wrong box, or the order of the boxes.
pub fn check<const N: usize>(boxes: [SortedBox; N], passage: impl Fn(usize) -> Option<Passage>) -> Result<(), String> {
    let keys = boxes.map(|SortedBox { hit, tmin, index }| (tmin.to_bits(), !hit, index));
    if !keys.is_sorted() {
        return Err(format!("boxes (tmin, miss, index) {keys:x?} are out of order"));
    }
    let mut seen = [false; N];
    for (tmin, miss, index) in keys {
        let index = index as usize;
        if std::mem::replace(&mut seen[index], true) {
            return Err(format!("box {index} occurs twice"));
        }
        let infinite = f32::INFINITY.to_bits();
        if tmin > infinite || (miss && tmin != infinite) {
            return Err(format!("box {index}: tmin has the bits {tmin:08x}, expected a distance, +∞ of a miss"));
        }
        let Some(passage) = passage(index) else { continue };
        let [least, greatest] = &passage.entry;
        let near = exact::value(Num::from_bits(tmin)).is_some_and(|tmin| (least..=greatest).contains(&&tmin));
        match passage.hit() {
            Some(hit) if hit == miss => return Err(format!("box {index}: hit is {}, but exactly it is {hit}", !miss)),
            _ if !miss && !near => {
                return Err(format!("box {index}: tmin is {:e}, expected {least} to {greatest}", f32::from_bits(tmin)));
            }
            _ => {}
        }
    }
    Ok(())
}

/// A plane perpendicular to an axis.
pub struct Plane {
    /// The exact coordinate, relative to the origin of the ray.
    pub at: BigRational,
    /// The bound of the error of the coordinate. Divided by the direction, it bounds the error of the distance.
    pub bound: BigRational,
}

/// The distances at which a ray enters and leaves a box, each as the least and greatest value within the error bound.
pub struct Passage {
    entry: [BigRational; 2],
    /// `None` if the ray has no end.
    exit: Option<[BigRational; 2]>,
    /// Whether the ray runs parallel to a slab and outside it; `None` if the error bound does not decide.
    beside: Option<bool>,
}

impl Passage {
    /// The passage through the box between these planes, `[min, max]` for each axis. `None` if no error bound is known:
    /// a number is not finite, `inv` is not the inverse of the direction, or magnitudes are not between 2^-60 and 2^60.
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

    /// Adds a slab that is parallel to the ray.
    fn along(&mut self, [min, max]: [Plane; 2]) {
        if min.at > min.bound || max.at < -&max.bound {
            self.beside = Some(true);
        } else if (min.at > -min.bound || max.at < max.bound) && self.beside == Some(false) {
            self.beside = None;
        }
    }

    /// Adds a slab that the ray crosses.
    fn across(&mut self, planes: [Plane; 2], direction: &BigRational) {
        let [near, far] = planes.map(|Plane { at, bound }| {
            let bound = bound / exact::absolute(direction) + exact::power(-130);
            let distance = at / direction;
            [&distance - &bound, distance + bound]
        });
        let (near, far) = if *direction < BigRational::default() { (far, near) } else { (near, far) };
        for (entry, near) in self.entry.iter_mut().zip(near) {
            *entry = near.max(entry.clone());
        }
        self.exit = Some(match self.exit.take() {
            Some([exit_least, exit_greatest]) => {
                let [least, greatest] = far;
                [exit_least.min(least), exit_greatest.min(greatest)]
            }
            None => far,
        });
    }

    /// Whether the ray hits the box; `None` if the error bound does not decide.
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
