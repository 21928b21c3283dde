//! Carry lookahead in two levels: groups of three columns, and blocks of four groups. A carry passes a block in two
//! gates, and inside a block a group in two gates: between a ripple-carry adder and a prefix tree in area and in time.
//! The adders that synthesis makes of `+` are smaller or faster, but not both.

use raypath_hdl::Wire;

/// Columns that a carry passes at once inside a block.
const GROUP: u32 = 3;
/// Columns that a carry passes at once.
const BLOCK: u32 = 4 * GROUP;

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
    let step = |carry: Wire<'m>, column: u32| generates.bit(column) | (propagates(column, column) & carry);

    // Of each group: whether it makes a carry itself, and whether it lets one pass.
    let groups = || (0..width).step_by(GROUP as usize).map(|low| (low, (low + GROUP).min(width)));
    let makes: Vec<Wire<'m>> = groups()
        .map(|(low, end)| (low + 1..end).fold(generates.bit(low), step).named(&format!("{name}_makes_{end}")))
        .collect();
    let passes: Vec<Wire<'m>> = groups()
        .skip(lowest as usize)
        .map(|(low, end)| propagates(end - 1, low).all().named(&format!("{name}_passes_{end}")))
        .collect();
    let passes = |group: u32| passes[(group - lowest) as usize];

    // Element i is the carry into column i.
    let mut carries = vec![entering];
    for column in 1..=width {
        let from = if column == width { (column - 1) / BLOCK * BLOCK } else { origin(column) };
        let carry = if column % GROUP > 0 && column < width {
            carries[from as usize].map_or_else(|| generates.bit(from), |carry| step(carry, from))
        } else {
            let (first, end) = (from / GROUP, column.div_ceil(GROUP));
            let made = (first + 1..end)
                .fold(makes[first as usize], |carry, group| makes[group as usize] | (passes(group) & carry));
            carries[from as usize].map_or(made, |carry| {
                let all_pass = (first + 1..end).fold(passes(first), |all, group| all & passes(group));
                made | (all_pass & carry)
            })
        };
        carries.push(Some(carry.named(&format!("{name}_carry_{column}"))));
    }
    let zero = m.constant(1, 0);
    let leaving = carries.pop().flatten().unwrap_or(zero);
    let entering: Vec<Wire<'m>> = carries.into_iter().rev().map(|carry| carry.unwrap_or(zero)).collect();
    Sum {
        word: (a ^ b).hint(&format!("{name}_differ")) ^ m.concat(&entering).named(&format!("{name}_carries")),
        carry: leaving,
    }
}

/// The sum of two words with its carry, a bit wider than the wider one: with a lookahead, or by the operator `+`, whose
/// carries ripple through gates, and have chains in an FPGA.
pub(crate) fn sum<'m>(a: Wire<'m>, b: Wire<'m>, has_lookahead: bool, name: &str) -> Wire<'m> {
    let width = a.width().max(b.width());
    if !has_lookahead {
        return a.extend(width + 1) + b.extend(width + 1);
    }
    let Sum { word, carry } = add(a.extend(width), b.extend(width), None, name);
    a.builder().concat(&[carry, word])
}

/// A word plus one, modulo two to its width. `name` is the prefix of the signals inside.
pub(crate) fn increment<'m>(word: Wire<'m>, name: &str) -> Wire<'m> {
    let m = word.builder();
    // Element i is the carry into column i: whether all columns below are set.
    let mut carries = vec![m.constant(1, 1)];
    for column in 1..word.width() {
        let ends_group = column.is_multiple_of(GROUP);
        let from = if ends_group { origin(column) } else { column / GROUP * GROUP };
        let passes = word.bits(column - 1, from).all();
        let carry = if from == 0 { passes } else { passes & carries[from as usize] };
        carries.push(if ends_group { carry.named(&format!("{name}_carry_{column}")) } else { carry });
    }
    carries.reverse();
    word ^ m.concat(&carries)
}

/// The column whose carry gives the carry into a column: the first of the block or of the group below, or the column
/// below.
fn origin(column: u32) -> u32 {
    [BLOCK, GROUP]
        .into_iter()
        .find(|columns| column.is_multiple_of(*columns))
        .map_or(column - 1, |columns| column - columns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};
    use raypath_hdl::{Builder, Simulator};

    /// Ends of groups and blocks, and the widths between them.
    const WIDEST: u32 = 40;
    const CASES: usize = 300;

    /// Two operands. Every other pair lets a carry pass nearly all columns.
    fn operands(random: &mut ChaCha8Rng, width: u32, case: usize) -> (u64, u64) {
        let (a, b): (u64, u64) = (random.random(), random.random());
        let few = b & random.random::<u64>() & random.random::<u64>() & random.random::<u64>();
        let mask = (1 << width) - 1;
        (a & mask, if case.is_multiple_of(2) { b & mask } else { (!a ^ few) & mask })
    }

    #[test]
    fn sums_are_those_of_integers() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for (width, carries) in (1..=WIDEST).flat_map(|width| [(width, false), (width, true)]) {
            let m = Builder::new("sum");
            let (a, b) = (m.input("a_i", width), m.input("b_i", width));
            let sum = add(a, b, carries.then(|| m.input("carry_i", 1)), "sum");
            m.output("sum_o", m.concat(&[sum.carry, sum.word]));
            let mut simulator = Simulator::new(&m.finish().expect("a module")).expect("no loop");
            for case in 0..CASES {
                let ((a, b), carry) = (operands(&mut random, width, case), u64::from(carries && case % 3 > 0));
                let sum = simulator.evaluate([a, b, carry]);
                assert_eq!(sum, [a + b + carry], "{a:#x} + {b:#x} + {carry}, {width} bits");
            }
        }
    }

    #[test]
    fn increments_are_those_of_integers() {
        let mut random = ChaCha8Rng::seed_from_u64(2);
        for width in 1..=WIDEST {
            let m = Builder::new("increment");
            m.output("next_o", increment(m.input("word_i", width), "word"));
            let mut simulator = Simulator::new(&m.finish().expect("a module")).expect("no loop");
            for case in 0..CASES {
                let (a, b) = operands(&mut random, width, case);
                // Ones in all low columns, up to a column of any number.
                let value = if case.is_multiple_of(2) { a } else { a | ((1 << (b % (u64::from(width) + 1))) - 1) };
                let next = (value + 1) & ((1 << width) - 1);
                assert_eq!(simulator.evaluate([value]), [next], "{value:#x}, {width} bits");
            }
        }
    }
}
