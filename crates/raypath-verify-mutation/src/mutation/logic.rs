//! Symbolic words: functions of variables, represented such that equal literals are equal functions.
//!
//! Conjunctions are shared by structure. Operators that are not bitwise are uninterpreted functions of their name and
//! arguments. Different literals can still be equal functions.

use raypath_verify::sat::{Miter, SOURCE};
use std::collections::{BTreeSet, HashMap};
use std::fmt::Write as _;

/// A bit: twice the number of its node, plus one if it is inverted.
pub type Literal = u32;
/// Bits, the least significant first.
pub type Word = Vec<Literal>;

pub const FALSE: Literal = 0;
pub const TRUE: Literal = 1;

/// All functions built so far.
#[derive(Debug, Default)]
pub struct Logic {
    nodes: u32,
    conjunctions: HashMap<(Literal, Literal), Literal>,
    functions: HashMap<(String, Word), Word>,
}

impl Logic {
    pub fn constant(&self, width: u32, value: u64) -> Word {
        (0..width).map(|bit| (value >> bit & 1) as Literal).collect()
    }

    /// The result of an uninterpreted function; a variable if it has no arguments.
    pub fn function(&mut self, name: String, arguments: Word, width: u32) -> Word {
        let nodes = &mut self.nodes;
        let fresh = || {
            let new = (0..width).map(|bit| 2 * (*nodes + 1 + bit)).collect();
            *nodes += width;
            new
        };
        self.functions.entry((name, arguments)).or_insert_with(fresh).clone()
    }

    pub fn and(&mut self, a: Literal, b: Literal) -> Literal {
        let (a, b) = (a.min(b), a.max(b));
        match (a, b) {
            (FALSE, _) => FALSE,
            (TRUE, b) => b,
            (a, b) if a == b => a,
            (a, b) if a == b ^ 1 => FALSE,
            _ => {
                let nodes = &mut self.nodes;
                *self.conjunctions.entry((a, b)).or_insert_with(|| {
                    *nodes += 1;
                    2 * *nodes
                })
            }
        }
    }

    pub fn or(&mut self, a: Literal, b: Literal) -> Literal {
        self.and(a ^ 1, b ^ 1) ^ 1
    }

    pub fn xor(&mut self, a: Literal, b: Literal) -> Literal {
        let (only_a, only_b) = (self.and(a, b ^ 1), self.and(a ^ 1, b));
        self.or(only_a, only_b)
    }

    pub fn mux(&mut self, select: Literal, a: Literal, b: Literal) -> Literal {
        if a == b {
            return a;
        }
        let (a, b) = (self.and(select, a), self.and(select ^ 1, b));
        self.or(a, b)
    }

    pub fn all(&mut self, word: &[Literal]) -> Literal {
        word.iter().fold(TRUE, |all, &bit| self.and(all, bit))
    }

    pub fn equal(&mut self, a: &[Literal], b: &[Literal]) -> Literal {
        a.iter().zip(b).fold(TRUE, |equal, (&a, &b)| {
            let differ = self.xor(a, b);
            self.and(equal, differ ^ 1)
        })
    }

    /// Applies a function bit by bit.
    pub fn bitwise(&mut self, a: &[Literal], b: &[Literal], f: fn(&mut Self, Literal, Literal) -> Literal) -> Word {
        a.iter().zip(b).map(|(&a, &b)| f(self, a, b)).collect()
    }

    /// A circuit whose output is 1 where two functions of a pair differ. Its inputs are the variables and the bits of
    /// uninterpreted functions.
    pub fn miter(&self, pairs: &[[Literal; 2]]) -> Miter {
        let operands: HashMap<u32, [Literal; 2]> =
            self.conjunctions.iter().map(|(&(a, b), &and)| (and / 2, [a, b])).collect();
        let mut nodes = BTreeSet::new();
        let mut open: Vec<u32> = pairs.iter().flatten().map(|literal| literal / 2).collect();
        while let Some(node) = open.pop() {
            if node > 0 && nodes.insert(node) {
                open.extend(operands.get(&node).into_iter().flatten().map(|literal| literal / 2));
            }
        }
        let text = |literal: Literal| match literal {
            FALSE | TRUE => format!("1'b{literal}"),
            _ => format!("{}n{}", if literal % 2 == 1 { "~" } else { "" }, literal / 2),
        };
        let (mut inputs, mut wires) = (Vec::new(), String::new());
        // The operands of a conjunction have smaller numbers.
        for node in nodes {
            match operands.get(&node) {
                Some(&[a, b]) => drop(writeln!(wires, "wire n{node} = {} & {};", text(a), text(b))),
                None => inputs.push((format!("n{node}"), 1)),
            }
        }
        let ports: String = inputs.iter().map(|(name, _)| format!("input {name}, ")).collect();
        let differences: Vec<String> = pairs.iter().map(|&[a, b]| format!("{} ^ {}", text(a), text(b))).collect();
        let differences = differences.join(", ");
        let source =
            format!("module miter({ports}output differ);\n{wires}assign differ = |{{{differences}}};\nendmodule\n");
        Miter {
            name: "jobs".to_string(),
            sources: vec![("jobs.sv".to_string(), source)],
            commands: vec![format!("read_verilog -sv {SOURCE}jobs.sv"), "hierarchy -check -top miter".to_string()],
            inputs,
        }
    }

    /// Selects one of two words.
    pub fn choose(&mut self, select: Literal, a: &[Literal], b: &[Literal]) -> Word {
        a.iter().zip(b).map(|(&a, &b)| self.mux(select, a, b)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_literals_are_equal_functions() {
        let mut logic = Logic::default();
        let [a, b] = ["a", "b"].map(|name| logic.function(name.to_string(), vec![], 1)[0]);
        assert_ne!(a, b);
        assert_eq!(logic.function("a".to_string(), vec![], 1), [a]);
        assert_eq!((logic.and(a, b), logic.and(a, a), logic.and(a, a ^ 1)), (logic.and(b, a), a, FALSE));
        assert_eq!((logic.or(a, FALSE), logic.xor(a, a), logic.xor(a, TRUE)), (a, FALSE, a ^ 1));
        assert_eq!((logic.mux(TRUE, a, b), logic.mux(FALSE, a, b), logic.mux(a, b, b)), (a, b, b));
        let one = logic.constant(4, 5);
        assert_eq!((logic.equal(&one, &one), logic.equal(&one, &[1, 0, 0, 0])), (TRUE, FALSE));
        assert_ne!(logic.function("f".to_string(), vec![a], 1), logic.function("f".to_string(), vec![b], 1));
        let (and, or) = (logic.and(a, b), logic.or(a, b));
        assert!(and != or && and != a && or != a);
    }
}
