//! An adder with carry lookahead in groups of three columns: between a ripple-carry adder and a prefix tree in area and
//! in time. The adders that synthesis makes of `+` are smaller or faster, but not both.

use raypath_hdl::Wire;

/// Columns that a carry passes at once.
const GROUP: u32 = 3;

/// A sum as wide as its operands, and the carry out of the top column.
pub(crate) struct Sum<'m> {
    pub word: Wire<'m>,
    pub carry: Wire<'m>,
}

/// Adds two words of one width and an optional carry. `name` is the prefix of the signals inside.
pub(crate) fn add<'m>(a: Wire<'m>, b: Wire<'m>, entering: Option<Wire<'m>>, name: &str) -> Sum<'m> {
    let m = a.builder();
    let width = a.width();
    let generates = (a & b).named(&format!("{name}_generates"));
    if width == 1 && entering.is_none() {
        return Sum { word: a ^ b, carry: generates };
    }
    // Without a carry in, the lowest column propagates nothing.
    let lowest = u32::from(entering.is_none());
    let propagates = (a.upper(width - lowest) | b.upper(width - lowest)).named(&format!("{name}_propagates"));
    let propagates = |high: u32, low: u32| propagates.bits(high - lowest, low - lowest);
    let step = |column: u32, carry: Option<Wire<'m>>| match carry {
        Some(carry) => generates.bit(column) | (propagates(column, column) & carry),
        None => generates.bit(column),
    };
    let mut entering = entering;
    let mut carries = Vec::new();
    for low in (0..width).step_by(GROUP as usize) {
        let end = (low + GROUP).min(width);
        let mut carry = entering;
        for column in low..end {
            carries.push(carry.unwrap_or_else(|| m.constant(1, 0)));
            if column + 1 < end {
                carry = Some(step(column, carry).named(&format!("{name}_carry_{}", column + 1)));
            }
        }
        let ahead = (low + 1..end).fold(generates.bit(low), |carry, column| step(column, Some(carry)));
        let passed = entering.map(|carry| propagates(end - 1, low).all() & carry);
        let leaving = passed.map_or(ahead, |passed| ahead | passed);
        entering = Some(leaving.named(&format!("{name}_carry_{end}")));
    }
    carries.reverse();
    let carries = m.concat(&carries).named(&format!("{name}_carries"));
    Sum { word: (a ^ b) ^ carries, carry: entering.unwrap_or_else(|| m.constant(1, 0)) }
}
