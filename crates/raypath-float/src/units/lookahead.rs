//! An adder whose carries go ahead in groups of three columns: between a ripple of full adders and a prefix tree in
//! area as in time. What synthesis makes of `+` is smaller or faster, but not both.

use raypath_hdl::Wire;

/// Columns that a carry passes at once.
const GROUP: u32 = 3;

/// A sum as wide as its operands, and the carry out of the top column.
pub(crate) struct Sum<'m> {
    pub word: Wire<'m>,
    pub carry: Wire<'m>,
}

/// Adds two words of one width and a carry. `name` begins the names of what is inside.
pub(crate) fn add<'m>(a: Wire<'m>, b: Wire<'m>, entering: Wire<'m>, name: &str) -> Sum<'m> {
    let m = a.builder();
    let generates = (a & b).named(&format!("{name}_generates"));
    let propagates = (a | b).named(&format!("{name}_propagates"));
    let step = |column: u32, carry: Wire<'m>| generates.bit(column) | (propagates.bit(column) & carry);
    let mut carries = Vec::new();
    let mut entering = entering;
    for low in (0..a.width()).step_by(GROUP as usize) {
        let end = (low + GROUP).min(a.width());
        let mut carry = entering;
        for column in low..end {
            carries.push(carry);
            carry = step(column, carry);
        }
        let ahead = (low + 1..end).fold(generates.bit(low), |carry, column| step(column, carry));
        entering = ahead | (propagates.bits(end - 1, low).all() & entering);
        entering = entering.named(&format!("{name}_carry_{end}"));
    }
    carries.reverse();
    Sum { word: (a ^ b) ^ m.concat(&carries), carry: entering }
}
