//! Gates for the operators of a netlist. Operators that only move bits need none.

use super::network::{Bit, Network};
use crate::netlist::{Driver, SignalId};

/// Bits of a signal, least significant first.
pub type Bits = Vec<Bit>;

/// The gates of an operator whose operands `values` has, by signal.
pub fn operator(network: &mut Network, values: &[Bits], driver: &Driver, width: u32) -> Bits {
    let of = |id: &SignalId| values[id.index()].as_slice();
    match driver {
        Driver::Constant(value) => constant(*value, width),
        Driver::Not(a) => of(a).iter().map(|&a| network.not(a)).collect(),
        Driver::And(a, b) => each(of(a), of(b), |a, b| network.and(a, b)),
        Driver::Or(a, b) => each(of(a), of(b), |a, b| network.or(a, b)),
        Driver::Xor(a, b) => each(of(a), of(b), |a, b| network.xor(a, b)),
        Driver::Add(a, b) => sum(network, of(a), of(b)),
        Driver::Sub(a, b) => {
            let borrows = borrows(network, of(a), of(b));
            let pairs = of(a).iter().zip(of(b)).zip(borrows);
            pairs.map(|((&a, &b), borrow)| network.xor3(a, b, borrow)).collect()
        }
        Driver::Mul(a, b) => product(network, of(a), of(b)),
        Driver::Equal(a, b) => vec![equal(network, of(a), of(b))],
        Driver::Less(a, b) => borrows(network, of(a), of(b)).split_off(of(a).len()),
        Driver::Any(a) => vec![network.any(of(a))],
        Driver::All(a) => vec![network.all(of(a))],
        Driver::ShiftLeft(a, amount) => {
            let mut reversed: Bits = of(a).iter().rev().copied().collect();
            reversed = shifted_right(network, reversed, of(amount));
            reversed.reverse();
            reversed
        }
        Driver::ShiftRight(a, amount) => shifted_right(network, of(a).to_vec(), of(amount)),
        Driver::Mux { select, if_true, if_false } => select_bits(network, of(select)[0], of(if_true), of(if_false)),
        Driver::Case { selector, arms, default } => {
            let mut bits = of(default).to_vec();
            // Labels are distinct: an arm that is the default needs no test.
            for arm in arms.iter().filter(|arm| arm.value != *default) {
                let label = constant(arm.label.value, of(selector).len() as u32);
                let matches = equal(network, of(selector), &label);
                bits = select_bits(network, matches, of(&arm.value), &bits);
            }
            bits
        }
        Driver::Concat(parts) => parts.iter().rev().flat_map(of).copied().collect(),
        Driver::Slice { source, low } => of(source)[*low as usize..][..width as usize].to_vec(),
        Driver::Alias(a) => of(a).to_vec(),
        Driver::Input | Driver::Register(_) | Driver::Instance { .. } | Driver::Memory { .. } => {
            unreachable!("the graph makes operations of their own of these")
        }
    }
}

fn select_bits(network: &mut Network, select: Bit, if_true: &[Bit], if_false: &[Bit]) -> Bits {
    each(if_true, if_false, |if_true, if_false| network.mux(select, if_true, if_false))
}

fn constant(value: u64, width: u32) -> Bits {
    (0..width).map(|bit| Bit::from(value >> bit & 1 == 1)).collect()
}

fn each(a: &[Bit], b: &[Bit], gate: impl FnMut(Bit, Bit) -> Bit) -> Bits {
    let mut gate = gate;
    a.iter().zip(b).map(|(&a, &b)| gate(a, b)).collect()
}

/// All carries before all sums: gates of a kind that follow each other are cheaper.
fn sum(network: &mut Network, a: &[Bit], b: &[Bit]) -> Bits {
    let mut carries = vec![Bit::ZERO];
    for (place, (&a, &b)) in a.iter().zip(b).enumerate() {
        carries.push(network.majority(a, b, carries[place]));
    }
    a.iter().zip(b).zip(carries).map(|((&a, &b), carry)| network.xor3(a, b, carry)).collect()
}

/// The borrows into each bit of a difference, and the last one out of it: whether `a` is less than `b`.
fn borrows(network: &mut Network, a: &[Bit], b: &[Bit]) -> Bits {
    let complements: Bits = a.iter().map(|&a| network.not(a)).collect();
    let mut borrows = vec![Bit::ZERO];
    for (place, (&a, &b)) in complements.iter().zip(b).enumerate() {
        borrows.push(network.majority(a, b, borrows[place]));
    }
    borrows
}

fn product(network: &mut Network, a: &[Bit], b: &[Bit]) -> Bits {
    let mut bits = vec![Bit::ZERO; a.len() + b.len()];
    for (place, &factor) in b.iter().enumerate() {
        let mut row: Bits = a.iter().map(|&a| network.and(a, factor)).collect();
        row.push(Bit::ZERO);
        let above = sum(network, &bits[place..][..row.len()], &row);
        bits[place..][..above.len()].copy_from_slice(&above);
    }
    bits
}

fn equal(network: &mut Network, a: &[Bit], b: &[Bit]) -> Bit {
    let (mut differ, mut alike) = (Vec::new(), Vec::new());
    for (&a, &b) in a.iter().zip(b) {
        let bit = network.xor(a, b);
        if b <= Bit::ONE { alike.push(network.not(bit)) } else { differ.push(bit) }
    }
    let (differ, alike) = (network.any(&differ), network.all(&alike));
    network.and_not(alike, differ)
}

/// A barrel shifter; an amount of the width or more gives zero.
fn shifted_right(network: &mut Network, mut bits: Bits, amount: &[Bit]) -> Bits {
    let width = bits.len();
    let reaches = |place: usize| u32::try_from(place).ok().and_then(|p| 1usize.checked_shl(p)).filter(|&by| by < width);
    let near = (0..amount.len()).take_while(|&place| reaches(place).is_some()).count();
    let far = network.any(&amount[near..]);
    for (place, &select) in amount[..near].iter().enumerate() {
        let mut shifted = bits[1 << place..].to_vec();
        shifted.resize(width, Bit::ZERO);
        bits = select_bits(network, select, &shifted, &bits);
    }
    bits.into_iter().map(|bit| network.and_not(bit, far)).collect()
}
