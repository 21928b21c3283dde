//! The texts of the unit's modules, with parameters in the place of numbers.
//!
//! The modules are printed for a few values of the parameters. Where only numbers differ, each number is a sum of
//! parameters, which follows from the differences: the text is the same for all values, and states what depends on
//! what.

use super::parameters::UnitParameters;
use super::queue::bits;
use super::structured::structured;
use crate::error::UnitError;
use raypath_float::{DivSqrt, Format};
use raypath_hdl::{Builder, Module, text, verilog};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::sync::Arc;

/// The parameters. The width of a context follows from the number of contexts.
const NAMES: [&str; 4] = ["Contexts", "IdWidth", "AddressWidth", "ContextWidth"];
const CONTEXT_WIDTH: usize = 3;

/// A value for each parameter.
type Values = [i64; NAMES.len()];

fn values(UnitParameters { contexts, id_width, address_width, .. }: UnitParameters) -> Values {
    [contexts, id_width, address_width, bits(contexts)].map(i64::from)
}

/// The other values for which the modules are printed. A width of one bit is printed without a range, so that a width
/// that is 1 or may become 1 here is no parameter; nor is an address without a base.
fn samples(unit: UnitParameters) -> Vec<UnitParameters> {
    let UnitParameters { contexts, id_width, address_width, .. } = unit;
    let near = if bits(contexts - 1) == bits(contexts) { contexts - 1 } else { contexts + 1 };
    let mut samples = [near, contexts.div_ceil(2)].map(|contexts| UnitParameters { contexts, ..unit }).to_vec();
    samples.extend((id_width > 2).then_some(UnitParameters { id_width: id_width - 1, ..unit }));
    samples.extend((address_width > 34).then_some(UnitParameters { address_width: address_width - 1, ..unit }));
    samples
}

/// The names of the parameters that the text of a unit has.
pub fn names(unit: UnitParameters) -> impl Iterator<Item = &'static str> {
    let (at, samples) = (values(unit), samples(unit));
    let varies = move |place: &usize| samples.iter().any(|sample| values(*sample)[*place] != at[*place]);
    (0..CONTEXT_WIDTH).filter(varies).map(|place| NAMES[place])
}

/// The unit `top`, which `build` builds around a datapath, with parameters in the texts of its modules.
///
/// # Errors
/// What `build` returns; a text that does not follow from parameters.
pub fn parametric(
    top: &Arc<Module>,
    datapath: &Arc<Module>,
    unit: UnitParameters,
    build: impl Fn(&Arc<Module>, UnitParameters) -> Result<Arc<Module>, UnitError>,
) -> Result<Arc<Module>, UnitError> {
    let inside: BTreeSet<String> = verilog::modules(datapath)?.iter().map(|module| module.name().to_string()).collect();
    let printed = |top: &Arc<Module>| -> Result<Vec<(Arc<Module>, String)>, UnitError> {
        let modules = verilog::modules(top)?.into_iter();
        let own = modules.filter(|module| !inside.contains(module.name()) && module.text().template.is_none());
        own.map(|module| {
            let text = verilog::print_module(&module, &[])?;
            let from = text.find("\nmodule ").map_or(0, |place| place + 1);
            Ok((module, text[from..].to_string()))
        })
        .collect()
    };
    let mut others = Vec::new();
    for sample in samples(unit) {
        let narrower = bits(unit.contexts) - bits(sample.contexts);
        let texts = printed(&build(&stub(datapath, narrower)?, sample)?)?;
        others.push((values(sample), texts));
    }
    let mut uses: BTreeMap<String, BTreeSet<usize>> = BTreeMap::new();
    let mut texts = Vec::new();
    for (place, (module, text)) in printed(top)?.into_iter().enumerate() {
        let others: Vec<(Values, &str)> =
            others.iter().filter_map(|(values, texts)| Some((*values, texts.get(place)?.1.as_str()))).collect();
        let no_text = || UnitError::Text { module: module.name().to_string() };
        let (filled, mut used) = unified(&text, values(unit), &others).ok_or_else(no_text)?;
        let below = module.instances().iter().filter_map(|instance| uses.get(instance.module.name()));
        used.extend(below.flatten());
        if used.is_empty() && !module.name().starts_with("raypath_unit") {
            continue;
        }
        used.extend(used.contains(&CONTEXT_WIDTH).then_some(0));
        let mut filled = with_header(&filled, &used, values(unit));
        for instance in module.instances() {
            let child = instance.module.name();
            if let Some(passed) = uses.get(child) {
                let passed = passed.iter().filter(|name| **name != CONTEXT_WIDTH).map(|name| NAMES[*name]);
                let passed: Vec<String> = passed.map(|name| format!(".{name} ({name})")).collect();
                let (from, to) = (format!("\n  {child} u_"), format!("\n  {child} #({}) u_", passed.join(", ")));
                filled = filled.replace(&from, &to);
            }
        }
        if module.name() == top.name() {
            let tag = datapath.port_width("tag_i").unwrap_or(1);
            filled = with_tag(&with_checks(&filled, unit), tag, tag - bits(unit.contexts));
        }
        texts.push((module.name().to_string(), filled));
        if !used.is_empty() {
            uses.insert(module.name().to_string(), used);
        }
    }
    let (mut texts, package) = structured(&texts, unit.step.features);
    texts.extend(DivSqrt::looped_quotient(Format::BINARY32, unit.divider_latency)?);
    let texts = texts.into_iter().map(|(name, text)| (name, laid_out(&text))).collect();
    Ok(text::with_texts(top, &texts, &Arc::new(package)))
}

/// A module with the ports of the datapath, whose tag is narrower by some bits.
fn stub(datapath: &Module, narrower: u32) -> Result<Arc<Module>, UnitError> {
    let m = Builder::new(datapath.name());
    datapath.text().package.iter().for_each(|package| m.package(package));
    let width = |name: &str, width: u32| if name.starts_with("tag_") { width - narrower } else { width };
    for port in datapath.inputs() {
        let wire = m.input(&port.name, width(&port.name, datapath.signal(port.signal).width));
        m.unused(&format!("unused_{}", port.name), &[wire]);
    }
    // For its clock and reset.
    let state = m.register("state_q", 1).reset_to(0);
    state.next(state.wire());
    for port in datapath.outputs() {
        m.output(&port.name, m.constant(width(&port.name, datapath.signal(port.signal).width), 0));
    }
    Ok(m.finish()?)
}

/// A part of a text: a decimal number that is not in a name, or what is between.
#[derive(PartialEq)]
enum Part<'t> {
    Number(i64),
    Other(&'t str),
}

/// The parts of a text, which make it again.
fn parts(text: &str) -> Vec<Part<'_>> {
    let mut parts = Vec::new();
    let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '\'';
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let name = rest.find(|c: char| !is_of_name(c)).unwrap_or(rest.len());
        let digits = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
        // A number, or the width of a literal and its value.
        let literal = rest[digits..name].strip_prefix("'d").and_then(|value| value.parse().ok());
        let length = match (rest[..digits].parse(), literal) {
            (Ok(width), Some(value)) => {
                parts.extend([Part::Number(width), Part::Other("'d"), Part::Number(value)]);
                name
            }
            (Ok(number), None) if digits == name => {
                parts.push(Part::Number(number));
                name
            }
            _ => {
                let length = if name > 0 { name } else { first.len_utf8() };
                parts.push(Part::Other(&rest[..length]));
                length
            }
        };
        rest = &rest[length..];
    }
    parts
}

/// The text with parameters in the place of numbers, and those that it uses; none if the other texts, with these
/// values, do not follow from any.
fn unified(text: &str, at: Values, others: &[(Values, &str)]) -> Option<(String, BTreeSet<usize>)> {
    let is_code = |part: &&Part<'_>| !matches!(part, Part::Other(text) if text.trim().is_empty());
    let others: Vec<(Values, Vec<Part<'_>>)> = others.iter().map(|(values, text)| (*values, parts(text))).collect();
    let mut others: Vec<_> = others.iter().map(|(at, parts)| (at, parts.iter().filter(is_code))).collect();
    let (mut filled, mut used) = (String::new(), BTreeSet::new());
    let parts = parts(text);
    for (place, part) in parts.iter().enumerate() {
        if !is_code(&part) {
            filled += if let Part::Other(text) = part { text } else { "" };
            continue;
        }
        let mut found = Vec::new();
        for (values, parts) in &mut others {
            found.push((**values, parts.next()?));
        }
        match part {
            // The value follows a cast.
            Part::Other("'d") if filled.ends_with("'(") => {}
            Part::Other(text) if found.iter().all(|(_, other)| *other == part) => filled += text,
            Part::Other(_) => return None,
            Part::Number(number) => {
                let numbers = found.iter().map(|(values, other)| match other {
                    Part::Number(other) => Some((*values, *other)),
                    Part::Other(_) => None,
                });
                let sum = Sum::of(*number, at, &numbers.collect::<Option<Vec<_>>>()?)?;
                used.extend(sum.factors.iter().enumerate().filter(|(_, factor)| **factor != 0).map(|(name, _)| name));
                let is_literal = |place: usize| matches!(parts.get(place), Some(Part::Other("'d")));
                sum.write(&mut filled, is_literal(place + 1), is_literal(place.wrapping_sub(1)));
            }
        }
    }
    others.iter_mut().all(|(_, parts)| parts.next().is_none()).then_some((filled, used))
}

/// A number as a sum of parameters.
struct Sum {
    factors: Values,
    constant: i64,
}

impl Sum {
    /// From the number at these values, and from those at others, each of which differs from it in one parameter and,
    /// if that is the number of contexts, in the width of a context.
    fn of(number: i64, at: Values, others: &[(Values, i64)]) -> Option<Self> {
        let mut factors = [0; NAMES.len()];
        for (values, other) in others {
            let mut difference = other - number;
            let changed: Vec<usize> = (0..NAMES.len()).filter(|&name| values[name] != at[name]).collect();
            let (&last, known) = changed.split_last()?;
            known.iter().for_each(|&name| difference -= factors[name] * (values[name] - at[name]));
            let step = values[last] - at[last];
            factors[last] = (difference % step == 0).then_some(difference / step)?;
        }
        let sum: i64 = factors.iter().zip(at).map(|(factor, value)| factor * value).sum();
        Some(Self { factors, constant: number - sum })
    }

    /// Writes it as the width of a literal, as the value of one, or as any other number.
    fn write(&self, text: &mut String, is_width: bool, is_value: bool) {
        let terms = NAMES.iter().zip(self.factors).filter(|(_, factor)| *factor != 0);
        let terms: Vec<String> = terms
            .map(|(name, factor)| if factor == 1 { name.to_string() } else { format!("{factor}*{name}") })
            .collect();
        let is_spaced = is_value || text.ends_with('(');
        let (plus, minus) = if is_spaced { (" + ", " - ") } else { ("+", "-") };
        let of_value = if is_value { "32'd" } else { "" };
        let constant = self.constant.unsigned_abs();
        let sum = match (terms.is_empty(), self.constant) {
            (true, _) => format!("{of_value}{constant}"),
            (false, 0) => terms.join(plus),
            (false, _) => {
                format!("{}{}{of_value}{constant}", terms.join(plus), if self.constant < 0 { minus } else { plus })
            }
        };
        // The width of a literal that depends on parameters is a cast, after which the base of the value follows.
        let is_cast = text.ends_with("'(");
        match (terms.is_empty(), is_width, is_value) {
            (true, true, _) => *text += &constant.to_string(),
            (false, true, _) if terms.len() == 1 && self.constant == 0 => *text += &format!("{sum}'("),
            (false, true, _) => *text += &format!("({sum})'("),
            (true, false, true) if !is_cast => *text += &constant.to_string(),
            (_, false, true) => *text += &format!("{sum})"),
            (_, false, false) => *text += &sum,
        }
    }
}

/// The text with a list of parameters.
fn with_header(text: &str, used: &BTreeSet<usize>, at: Values) -> String {
    if used.is_empty() {
        return text.to_string();
    }
    let is_local = |name: usize| name == CONTEXT_WIDTH;
    let longest = used.iter().map(|name| NAMES[*name].len()).max().unwrap_or(0);
    let kinds = if used.contains(&CONTEXT_WIDTH) { ["parameter ", "localparam"] } else { ["parameter", "localparam"] };
    let line = |name: usize| {
        let value = if is_local(name) { "$clog2(Contexts)".to_string() } else { at[name].to_string() };
        format!("  {} logic [31:0] {:<longest$} = {value}", kinds[usize::from(is_local(name))], NAMES[name])
    };
    let lines: Vec<String> = used.iter().map(|name| line(*name)).collect();
    text.replacen(" (\n", &format!(" #(\n{}\n) (\n", lines.join(",\n")), 1)
}

/// The text of the top module with a check of each parameter.
fn with_checks(text: &str, unit: UnitParameters) -> String {
    let ranges = [("Contexts", 8, unit.contexts), ("IdWidth", 1, 64), ("AddressWidth", 33, 64)];
    let mut checks = String::new();
    for name in names(unit) {
        let (_, least, most) = ranges.iter().find(|(known, ..)| *known == name).copied().unwrap_or_default();
        let block = name.to_lowercase().replace("width", "_width");
        let _ = write!(
            checks,
            "\n  if ({name} < {least} || {name} > {most}) begin : g_{block}\n    $error(\"{name} is %0d, expected \
             {least} to {most}\", {name});\n  end\n"
        );
    }
    text.replacen("\n);\n", &format!("\n);\n{checks}"), 1)
}

/// The text of the top module, whose datapath has a tag of `width` bits for the greatest number of contexts, `more`
/// than those of a context.
fn with_tag(text: &str, width: u32, more: u32) -> String {
    let last = width - 1;
    let lines =
        text.lines().map(|line| match (line.split_whitespace().last(), line.strip_prefix("  assign job_tag ")) {
            (Some("datapath_tag;"), _) => {
                format!("  logic [{last}:0] datapath_tag;\n  logic       unused_datapath_tag;")
            }
            (Some("job_tag;"), _) => format!("  logic [{last}:0] job_tag;"),
            (_, Some(rest)) => format!(
                "  always_comb begin\n    job_tag = '0;\n    job_tag[ContextWidth+{}:0] = {}\n  end\n\n  assign \
             unused_datapath_tag = ^datapath_tag;\n",
                more - 1,
                rest.trim_start_matches([' ', '='])
            ),
            _ => line.to_string(),
        });
    lines.map(|line| line + "\n").collect()
}

/// The text with aligned names of ports and signals, in lines of at most 100 columns.
pub fn laid_out(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let declared: Vec<Option<(usize, &str, &str)>> = lines.iter().map(|line| declaration(line)).collect();
    let mut out = String::new();
    // The lines that are aligned to the same column.
    let (mut until, mut column) = (0, 0);
    for (place, line) in lines.iter().enumerate() {
        let Some((indent, kind, rest)) = declared[place] else {
            verilog::wrap(line.to_string()).iter().for_each(|line| out += &format!("{line}\n"));
            continue;
        };
        if place >= until {
            // Comments do not end a list.
            let is_in = |at: &usize| declared[*at].is_some() || lines[*at].trim_start().starts_with("// ");
            let run: Vec<usize> = (place..lines.len()).take_while(is_in).collect();
            until = place + run.len();
            column = run
                .iter()
                .filter_map(|at| declared[*at].map(|(indent, kind, _)| indent + kind.len()))
                .max()
                .unwrap_or(0);
        }
        let mut rest = rest;
        if let Some((name, remark)) = rest.split_once("//").filter(|_| column + 1 + rest.len() > 100) {
            let _ = writeln!(out, "{:indent$}//{remark}", "");
            rest = name.trim_end();
        }
        let _ = writeln!(out, "{:indent$}{kind:<width$} {rest}", "", width = column - indent);
    }
    out
}

/// The indent of a declaration, its type, and the line from the name on.
pub fn declaration(line: &str) -> Option<(usize, &str, &str)> {
    let code = line.trim_start();
    let indent = line.len() - code.len();
    let of_type = ["input ", "output "].iter().find_map(|direction| code.strip_prefix(direction)).unwrap_or(code);
    let of_type = of_type.trim_start();
    let mut rest = match of_type.strip_prefix("logic ") {
        Some(rest) => rest.trim_start(),
        None => of_type.starts_with("raypath_unit_pkg::").then(|| of_type.split_once(' '))??.1.trim_start(),
    };
    while let Some((_, after)) = rest.strip_prefix('[').and_then(|range| range.split_once(']')) {
        rest = after.trim_start();
    }
    (indent <= 4).then(|| (indent, code[..code.len() - rest.len()].trim_end(), rest))
}
