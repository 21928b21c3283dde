//! Negative controls: registers whose reset is lost.

use std::fmt;

/// A register that a reset leaves unknown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LostReset {
    /// The module and the register.
    place: String,
    /// The line of the text in which a reset writes it.
    line: usize,
}

/// The resets of a text, one for each register of each module.
pub fn lost_resets(text: &str) -> Vec<LostReset> {
    let mut found = Vec::new();
    let (mut module, mut is_reset) = ("", false);
    for (number, line) in text.lines().enumerate() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["module", name, ..] => module = name,
            ["if", "(!rst_ni)", "begin"] => is_reset = true,
            ["end", ..] => is_reset = false,
            [register, "<=", ..] if is_reset => {
                found.push(LostReset { place: format!("{module}, {register}"), line: number });
            }
            _ => {}
        }
    }
    found
}

impl LostReset {
    /// The text with this fault.
    pub fn insert(&self, text: &str) -> String {
        let faulty = |(number, line): (usize, &str)| match line.split_once("<=").filter(|_| number == self.line) {
            Some((register, _)) => format!("{register}<= 'x;\n"),
            None => format!("{line}\n"),
        };
        text.lines().enumerate().map(faulty).collect()
    }
}

impl fmt::Display for LostReset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_register_with_a_reset_is_found() {
        let text = "module m (\n);\n  always_ff @(posedge clk_i or negedge rst_ni) begin\n    if (!rst_ni) begin\n      \
                    a_q <= '0;\n      b_q <= 1'b1;\n    end else begin\n      a_q <= a_d;\n    end\n  end\n";
        let found = lost_resets(text);
        let places: Vec<String> = found.iter().map(LostReset::to_string).collect();
        assert_eq!(places, ["m, a_q", "m, b_q"]);
        assert_eq!(found[1].insert(text), text.replace("1'b1", "'x"));
    }
}
