//! Boolean functions in Liberty's syntax: `(!((A B)+C))`, `(A&!B) | (!A&B)`.

/// The truth table of a function of at most six inputs. Bit i is the value for the inputs whose bits form i, input 0
/// the lowest. None if the text is not such a function.
pub fn truth_table(function: &str, inputs: &[&str]) -> Option<u64> {
    let mut reader = Reader { rest: function.trim(), inputs, levels: 0 };
    let table = reader.sum()?;
    (reader.rest.is_empty() && inputs.len() <= MASKS.len()).then(|| table & used(inputs.len()))
}

/// The limit on the nesting of parentheses and negations: each level is a call.
const MAX_LEVELS: usize = 100;

/// The truth table of each of six inputs.
const MASKS: [u64; 6] = [
    0xaaaa_aaaa_aaaa_aaaa,
    0xcccc_cccc_cccc_cccc,
    0xf0f0_f0f0_f0f0_f0f0,
    0xff00_ff00_ff00_ff00,
    0xffff_0000_ffff_0000,
    0xffff_ffff_0000_0000,
];

/// The mask of a truth table of this many inputs.
fn used(inputs: usize) -> u64 {
    u64::MAX >> (64 - (1_u32 << inputs))
}

struct Reader<'a> {
    rest: &'a str,
    inputs: &'a [&'a str],
    /// The number of open parentheses and negations.
    levels: usize,
}

impl Reader<'_> {
    fn sum(&mut self) -> Option<u64> {
        let mut table = self.product()?;
        while self.takes(&['+', '|']) {
            table |= self.product()?;
        }
        Some(table)
    }

    /// Factors with an operator between them, or none.
    fn product(&mut self) -> Option<u64> {
        let mut table = self.exclusive()?;
        while self.takes(&['*', '&']) || self.rest.starts_with(|c: char| c == '(' || c == '!' || is_name(c)) {
            table &= self.exclusive()?;
        }
        Some(table)
    }

    fn exclusive(&mut self) -> Option<u64> {
        let mut table = self.factor()?;
        while self.takes(&['^']) {
            table ^= self.factor()?;
        }
        Some(table)
    }

    fn factor(&mut self) -> Option<u64> {
        self.levels += 1;
        if self.levels > MAX_LEVELS {
            return None;
        }
        let mut table = if self.takes(&['!']) {
            !self.factor()?
        } else if self.takes(&['(']) {
            let inner = self.sum()?;
            self.takes(&[')']).then_some(inner)?
        } else {
            let end = self.rest.find(|c| !is_name(c)).unwrap_or(self.rest.len());
            let (name, rest) = self.rest.split_at(end);
            self.rest = rest.trim_start();
            match name {
                "0" => 0,
                "1" => u64::MAX,
                _ => *MASKS.get(self.inputs.iter().position(|input| *input == name)?)?,
            }
        };
        while self.takes(&['\'']) {
            table = !table;
        }
        self.levels -= 1;
        Some(table)
    }

    fn takes(&mut self, any: &[char]) -> bool {
        let Some(rest) = self.rest.strip_prefix(any) else { return false };
        self.rest = rest.trim_start();
        true
    }
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_' || c == '[' || c == ']'
}

#[cfg(test)]
mod tests {
    use super::truth_table;

    type Function = fn(bool, bool, bool) -> bool;

    #[test]
    fn all_syntax_variants() {
        let inputs = ["A", "B", "C"];
        let by_rust =
            |f: Function| (0..8_u64).map(|i| u64::from(f(i & 1 != 0, i & 2 != 0, i & 4 != 0)) << i).sum::<u64>();
        let cases: [(&str, Function); 8] = [
            ("(!((A B)+C))", |a, b, c| !((a && b) || c)),
            ("(A&!B) | (!A&B)", |a, b, _| a != b),
            ("A*B'+C", |a, b, c| (a && !b) || c),
            ("((A^B)^C)", |a, b, c| a ^ b ^ c),
            ("!A^B C", |a, b, c| (!a ^ b) && c),
            (" A ", |a, _, _| a),
            ("1", |_, _, _| true),
            ("(((A B)+(B C))+(C A))", |a, b, c| u8::from(a) + u8::from(b) + u8::from(c) >= 2),
        ];
        for (text, function) in cases {
            assert_eq!(truth_table(text, &inputs), Some(by_rust(function)), "{text}");
        }
    }

    #[test]
    fn other_texts_are_refused() {
        for text in ["", "IQ", "A +", "(A", "A)", "A ? B"] {
            assert_eq!(truth_table(text, &["A", "B"]), None, "{text}");
        }
        assert_eq!(truth_table("1", &[]), Some(1));
    }

    /// A million levels would overflow the stack.
    #[test]
    fn depth_is_bounded() {
        let negated = |levels: usize| truth_table(&format!("{}A", "!".repeat(levels)), &["A"]);
        let nested = |levels: usize| truth_table(&format!("{}A{}", "(".repeat(levels), ")".repeat(levels)), &["A"]);
        assert_eq!((negated(98), nested(99)), (Some(0b10), Some(0b10)));
        for levels in [100, 1_000_000] {
            assert_eq!((negated(levels), nested(levels)), (None, None));
        }
        // Terms side by side do not count as levels.
        assert_eq!(truth_table(&vec!["(!A)"; 10_000].join("+"), &["A"]), Some(0b01));
    }
}
