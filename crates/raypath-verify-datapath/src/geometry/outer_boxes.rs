//! Ray against box under the rules `bounds`: a box that the exact ray enters is hit, and tmin is a lower bound.

use super::box_intersection::ExactIntersection;
use super::boxes::{Answer, Case, datapath};
use super::campaign::Tally;
use raypath_ops::{BoxBits, Rules};

/// A fault in the computation of [`interval`].
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fault {
    None,
    NoMargin,
    NearAway,
    FarTowardZero,
}

/// The faulty computations that the campaign must find.
const FAULTS: [(&str, Fault); 3] = [
    ("bounds without the margin", Fault::NoMargin),
    ("near bounds rounded away from zero", Fault::NearAway),
    ("far bounds rounded toward zero", Fault::FarTowardZero),
];

/// The names of the negative controls.
pub(super) const CONTROLS: [&str; 4] = [FAULTS[0].0, FAULTS[1].0, FAULTS[2].0, "bounds rounded to nearest"];

/// Checks the datapath's results for a case, in a number of bits that depends on it: against exact arithmetic, and bit
/// for bit against a computation in binary64.
pub(super) fn run(tally: &mut Tally, case: &Case, geometry: &[ExactIntersection; 4]) {
    let bits = bits_of(case);
    let answers = datapath(Rules::Bounds(BoxBits(bits)), case);
    let nearest = datapath(Rules::Paper, case);
    for i in 0..4 {
        let by_hand = answer(case, case.boxes[i], bits, Fault::None);
        if by_hand != answers[i] {
            tally.fail(|| format!("{case:?}, box {i} in {bits} bits: {:?}, expected {by_hand:?}", answers[i]));
        }
        if geometry[i].is_out_of_range || !is_in_range(case, case.boxes[i]) {
            tally.add("outer: out of range", true);
            continue;
        }
        tally.add("outer: checked", true);
        tally.add("outer: entered", geometry[i].is_hit);
        tally.add("outer: hit", answers[i].0);
        if !is_outer(&geometry[i], answers[i]) {
            let entry = geometry[i].entry.to_f64();
            tally.fail(|| format!("{case:?}, box {i} in {bits} bits: {:?}, exact entry {entry:e}", answers[i]));
        }
        // The interval grows by at most six roundings. Relative errors have no meaning where distances underflow.
        let is_large = geometry[i].entry.to_f64() > 2_f64.powi(-120);
        if answers[i].0 && !geometry[i].is_hit && geometry[i].gap.is_finite() && is_large {
            tally.add_value("outer: gap", geometry[i].gap.abs() * 2_f64.powi(bits as i32 - 1));
        }
        for (name, fault) in FAULTS {
            tally.add(name, !is_outer(&geometry[i], answer(case, case.boxes[i], bits, fault)));
        }
        tally.add(CONTROLS[3], !is_outer(&geometry[i], nearest[i]));
    }
}

/// The number of bits for a case: it follows from its numbers, so that the cases are those without this check.
fn bits_of(case: &Case) -> u32 {
    let numbers = <[f32; 3]>::from(case.ray.dir).into_iter().chain(case.boxes.into_iter().flatten().flatten());
    let digest = numbers.fold(1_u32, |digest, x| (digest ^ x.to_bits()).wrapping_mul(0x9e37_79b1).rotate_left(9));
    BoxBits::MIN.0 + digest % (BoxBits::MAX.0 - BoxBits::MIN.0 + 1)
}

/// The remark on the campaign's results.
pub(super) fn remark(tally: &Tally) -> String {
    format!(
        "rules bounds, 8 to 24 bits: {} boxes, {} entered by the exact ray, all of them hit; {} hit; a box hit but not \
         entered is missed by at most {:.2} units of the last bit; beyond the range that the claim excludes: {}",
        tally.count("outer: checked"),
        tally.count("outer: entered"),
        tally.count("outer: hit"),
        tally.largest("outer: gap"),
        tally.count("outer: out of range"),
    )
}

/// Whether a result is right under the claim's conditions.
pub(super) fn is_right(geometry: &ExactIntersection, case: &Case, aabb: [[f32; 3]; 2], answer: Answer) -> bool {
    !is_in_range(case, aabb) || is_outer(geometry, answer)
}

/// Whether a result is not a false miss, and tmin a lower bound.
fn is_outer(geometry: &ExactIntersection, (hit, tmin): Answer) -> bool {
    !geometry.is_hit || hit && geometry.entry.is_at_least(tmin)
}

/// Whether the claim's conditions hold: no difference underflows or overflows, and no inverse is flushed to zero.
fn is_in_range(case: &Case, [low, high]: [[f32; 3]; 2]) -> bool {
    let (origin, dir, inv) = (<[f32; 3]>::from(case.ray.origin), case.ray.dir, <[f32; 3]>::from(case.ray.inv));
    let dir = <[f32; 3]>::from(dir);
    (0..3).all(|axis| {
        let differences = [low, high].map(|bound| f64::from(bound[axis]) - f64::from(origin[axis]));
        let is_difference = |x: f64| x == 0.0 || (2_f64.powi(-125)..2_f64.powi(127)).contains(&x.abs());
        let is_inverse = dir[axis] == 0.0 || (2_f32.powi(-124)..2_f32.powi(126)).contains(&inv[axis].abs());
        differences.into_iter().all(is_difference) && is_inverse
    })
}

/// The result in `bits` bits by the text of the rules, for one box.
fn answer(case: &Case, [low, high]: [[f32; 3]; 2], bits: u32, fault: Fault) -> Answer {
    let (origin, inv) = (<[f32; 3]>::from(case.ray.origin), <[f32; 3]>::from(case.ray.inv));
    let (near_away, far_away) = (fault == Fault::NearAway, fault != Fault::FarTowardZero);
    let margin = if fault == Fault::NoMargin { 0 } else { 4 };
    let (mut tmin, mut tmax) = (0.0_f32, rounded(f32::from(case.ray.extent), bits, true));
    for axis in 0..3 {
        let is_backwards = inv[axis].is_sign_negative();
        let [near, far] = if is_backwards { [high[axis], low[axis]] } else { [low[axis], high[axis]] };
        let distance = |bound: f32, is_away: bool, inverse_away: bool| {
            let inverse = rounded(moved(inv[axis], margin, inverse_away), bits, inverse_away);
            rounded(rounded(bound - origin[axis], bits, is_away) * inverse, bits, is_away)
        };
        // A NaN fails both comparisons, and so is ignored.
        let (near, far) = (distance(near, near_away, near_away), distance(far, far_away, far_away));
        tmin = if near > tmin { near } else { tmin };
        tmax = if far < tmax { far } else { tmax };
    }
    if tmin <= tmax { (true, tmin) } else { (false, f32::INFINITY) }
}

/// A finite number other than zero, `steps` numbers nearer to zero or farther from it.
fn moved(number: f32, steps: u32, is_away: bool) -> f32 {
    if !number.is_finite() {
        return number;
    }
    let step = |magnitude: f32| if is_away { magnitude.next_up() } else { magnitude.next_down().max(0.0) };
    (0..steps).fold(number.abs(), |magnitude, _| step(magnitude)).copysign(number)
}

/// A number rounded to a significand of `bits` bits, and to zero below 2⁻¹²⁵.
fn rounded(number: f32, bits: u32, is_away: bool) -> f32 {
    let magnitude = f64::from(number.abs());
    if !magnitude.is_normal() {
        return number;
    }
    let exponent = (magnitude.to_bits() >> 52) as i32 - 1023;
    let unit = 2_f64.powi(exponent - bits as i32 + 1);
    let units = magnitude / unit;
    let magnitude = unit * if is_away { units.ceil() } else { units.floor() };
    (if magnitude < 2_f64.powi(-125) { 0.0 } else { magnitude as f32 }).copysign(number)
}
