//! The names of registers. Synthesis keeps one of the names of a net. A record of all names, written before they are
//! dropped, tells the register that drives it.

use crate::design::{RegisterKind, Words};
use crate::netlist::{Net, YosysDesign};
use std::collections::{BTreeMap, HashMap};

/// The register that drives each named net.
#[derive(Debug, Default)]
pub struct RegisterNames {
    nets: HashMap<(String, usize), Net>,
    registers: HashMap<Net, String>,
}

impl RegisterNames {
    /// From all names of a module's nets, and the module's registers.
    pub fn new(
        mut names: YosysDesign,
        module: &str,
        registers: &BTreeMap<String, RegisterKind>,
        words: &Words,
    ) -> Self {
        let mut result = Self::default();
        let names = names.take(module).map(|(_, names)| names).unwrap_or_default();
        for (name, net) in names.into_iter().filter(|(name, _)| !name.starts_with('$')) {
            let is_register = registers.contains_key(&name);
            let held: Vec<String> = words.get(&name).map(|word| bits(word)).unwrap_or_default();
            for (position, bit) in net.bits.iter().enumerate() {
                if is_register {
                    let of = if net.bits.len() > 1 { format!("{name}[{position}]") } else { name.clone() };
                    result.registers.entry(*bit).or_insert(of);
                } else if let Some(register) = held.get(position) {
                    result.registers.entry(*bit).or_insert(register.clone());
                }
                result.nets.insert((name.clone(), net.offset.saturating_add(position)), *bit);
            }
        }
        result
    }

    /// The register that drives the net of this name, such as `u_stage_3.num_4_q[7]`.
    pub fn register(&self, net: &str) -> Option<&str> {
        self.registers.get(self.nets.get(&bit(net))?).map(String::as_str)
    }
}

/// The bits of the registers in a word, the least significant first.
fn bits(word: &[(String, u32)]) -> Vec<String> {
    let bits = |(name, width): &(String, u32)| {
        let (name, width) = (name.clone(), *width);
        (0..width).map(move |bit| if width > 1 { format!("{name}[{bit}]") } else { name.clone() })
    };
    word.iter().rev().flat_map(bits).collect()
}

/// The signal and bit of a net: `num_4_q[7]` is bit 7 of `num_4_q`; a name without an index is bit 0.
fn bit(net: &str) -> (String, usize) {
    let split = net.strip_suffix(']').and_then(|net| net.rsplit_once('['));
    match split.and_then(|(name, index)| Some((name.to_string(), index.parse().ok()?))) {
        Some(bit) => bit,
        None => (net.to_string(), 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_gives_the_register() {
        let names = r#"{"creator": "Yosys", "modules": {"raypath": {"ports": {}, "netnames": {
            "$1": {"bits": [9]},
            "stage_1_flags": {"hide_name": 0, "bits": [7, 8], "attributes": {}},
            "u_stage_1.flags_q": {"bits": [7, 8]},
            "u_stage_2.hit": {"bits": [8]},
            "u_stage_2.constant": {"bits": ["0"]},
            "u_stage_3.u_skid.data_q": {"bits": [11, 12, 13]},
            "valid_q": {"bits": [9], "offset": 0}}}}}"#;
        let names: YosysDesign = serde_json::from_str(names).expect("names");
        let kind = RegisterKind { group: 0, is_control: false };
        let registers = ["u_stage_1.flags_q", "valid_q"].map(|name| (name.to_string(), kind.clone()));
        let held = vec![("u_stage_3.opcode_q".to_string(), 2), ("u_stage_3.hit_q".to_string(), 1)];
        let words = Words::from([("u_stage_3.u_skid.data_q".to_string(), held)]);
        let names = RegisterNames::new(names, "raypath", &BTreeMap::from(registers), &words);
        assert_eq!(names.register("stage_1_flags[0]"), Some("u_stage_1.flags_q[0]"));
        assert_eq!(names.register("u_stage_2.hit"), Some("u_stage_1.flags_q[1]"));
        assert_eq!(names.register("valid_q"), Some("valid_q"));
        assert_eq!(names.register("u_stage_3.u_skid.data_q[0]"), Some("u_stage_3.hit_q"));
        assert_eq!(names.register("u_stage_3.u_skid.data_q[2]"), Some("u_stage_3.opcode_q[1]"));
        assert_eq!(names.register("u_stage_2.constant"), None);
        assert_eq!(names.register("elsewhere[1]"), None);
    }

    /// The file may contain any index.
    #[test]
    fn no_index_is_too_large() {
        let names =
            format!(r#"{{"modules": {{"m": {{"netnames": {{"a": {{"bits": [1, 2], "offset": {}}}}}}}}}}}"#, usize::MAX);
        let names: YosysDesign = serde_json::from_str(&names).expect("names");
        let kind = RegisterKind { group: 0, is_control: false };
        let names = RegisterNames::new(names, "m", &BTreeMap::from([("a".to_string(), kind)]), &Words::new());
        assert!(names.register(&format!("a[{}]", usize::MAX)).is_some());
    }
}
