//! Proofs of the control of the unit's modules.

use super::bindings;
use super::claims::{CLAIMS, Claim, alike, queues};
use super::setting::LEAST;
pub use super::setting::{Setting, Variant};
use super::system;
use raypath_hdl::Module;
use raypath_hdl::verilog::RAM;
use raypath_tools::ToolError;
use raypath_traversal::UnitParameters;
use raypath_verify::safety::{CheckResult, Method, ModuleTexts, RESET, SafetyProblem, TextFault};
use raypath_verify::{Error, Level};
use std::sync::Arc;

/// A problem, and the result that it must have.
pub struct Obligation {
    /// The problem.
    pub problem: SafetyProblem,
    /// What the model checker must find.
    pub expected: CheckResult,
}

/// The cycles in which a fault must be refuted.
const CYCLES: u32 = 24;
/// The cycles in which any fault may be refuted: more take minutes if it cannot be.
const FEW_CYCLES: u32 = 11;

/// Further units: the default, with its 64 contexts, and the greatest number of contexts.
fn more() -> [UnitParameters; 3] {
    let default = UnitParameters::default();
    [
        UnitParameters { contexts: 11, memory_width: 128, divider_latency: 3, ram_latency: 2, ..LEAST },
        default,
        UnitParameters { contexts: 256, divider_latency: 5, ..default },
    ]
}

/// The beginning of an assertion's statement, before and after its name.
pub(crate) const ASSERTION: [&str; 2] = ["  always_comb ", ": assert ("];

/// The properties with each assertion as this turns it, from its name and what follows the opening parenthesis.
fn turned(properties: &str, mut turn: impl FnMut(&str, &str) -> String) -> String {
    let mut statements = properties.split(ASSERTION[0]);
    let first = statements.next().unwrap_or_default().to_string();
    let rest = statements.map(|statement| match statement.split_once(ASSERTION[1]) {
        Some((name, rest)) if !name.contains([' ', '\n']) => turn(name, rest),
        _ => format!("{}{statement}", ASSERTION[0]),
    });
    first + &rest.collect::<String>()
}

/// The properties of which only the one of this name is asserted; the others become wires without a reader.
pub(crate) fn only(properties: &str, name: &str) -> String {
    let [before, after] = ASSERTION;
    turned(properties, |other, rest| match other == name {
        true => format!("{before}{other}{after}{rest}"),
        false => format!("  wire p_not_{other} = ({rest}"),
    })
}

/// Each property by itself, with its name, if all hold in the cycles before: together they are an induction, of which a
/// solver finds each part faster than the whole.
fn each(properties: &str) -> Vec<(String, String)> {
    let mut names = Vec::new();
    let text = turned(properties, |name, rest| {
        names.push(name.to_string());
        format!("  wire p_is_{name} = ({rest}")
    });
    let all: Vec<String> = names.iter().map(|name| format!("p_is_{name}")).collect();
    let held = format!(
        "  logic p_held_q;\n  always_ff @(posedge clk_i or negedge rst_ni)\n    if (!rst_ni) p_held_q <= 1;\n    \
         else p_held_q <= p_held_q && {};\n",
        all.join(" && ")
    );
    let one = |name: &String| format!("{text}{held}  always_comb {name}: assert (!p_held_q || p_is_{name});\n");
    names.iter().map(|name| (name.clone(), one(name))).collect()
}

impl Setting {
    /// The problems that the properties of this module's claim hold for a faulty copy, which must fail without lemmas
    /// in few cycles, and which would be a proof with them; none if there is no claim.
    ///
    /// # Errors
    /// The module cannot be printed.
    pub fn faulty(&self, module: &Arc<Module>) -> Result<Option<[Obligation; 2]>, Error> {
        // Queues have the same properties in every unit.
        let mut claims = self.claims().chain(queues());
        let Some(claim) = claims.find(|claim| claim.module == module.name()) else { return Ok(None) };
        let problem = |name: &str, properties, method, expected| {
            let text = self.text(&claim, module, None, properties)?;
            Ok::<_, Error>(obligation(&claim, name, text, method, expected))
        };
        let fails = problem("a fault", claim.stated(), Method::Bounded(FEW_CYCLES), CheckResult::Fails)?;
        Ok(Some([fails, problem("a fault", claim.properties, claim.method(), CheckResult::Holds)?]))
    }

    /// The claims about modules of this unit.
    fn claims(&self) -> impl Iterator<Item = Claim> + use<> {
        let variant = self.variant;
        CLAIMS.iter().copied().chain(queues()).chain(alike()).filter(move |claim| claim.variant == variant)
    }

    /// The module's text with these properties, and memories of which one word is known.
    fn text(
        &self,
        claim: &Claim,
        module: &Arc<Module>,
        fault: Option<TextFault>,
        properties: &str,
    ) -> Result<String, Error> {
        let mut texts = ModuleTexts::new(module)?;
        if let Some(fault) = fault
            && !texts.insert(fault)
        {
            return Err(ToolError::unexpected("a fault", format!("{fault:?}"), "a text of its module").into());
        }
        texts.replace(RAM, include_str!("properties/ram.sv"));
        let UnitParameters { contexts, search, .. } = self.unit.parameters;
        let contexts = search.0.map_or(contexts, |search| search.contexts);
        let queue = claim.queue.map(|(path, name)| Ok::<_, Error>((path, self.module(name)?))).transpose()?;
        let depth = queue.and_then(|(_, queue)| queue.memories().first()).map_or(contexts, |words| words.depth);
        let mut bound = format!("  localparam int N = {depth};\n");
        bound += &queue.map(|(path, queue)| bindings::of_queue(path, queue, depth)).unwrap_or_default();
        bound += &(claim.bindings)(self, module);
        Ok(texts.with(claim.module, &format!("{bound}{properties}{RESET}")) + include_str!("properties/lemmas.sv"))
    }

    /// The problems that the claims hold.
    fn proofs(&self) -> Result<Vec<Obligation>, Error> {
        let name = format!("{} contexts, {:?}", self.unit.parameters.contexts, self.variant);
        let proof = |claim: Claim, name: &str, properties: &str| {
            let text = self.text(&claim, self.module(claim.module)?, None, properties)?;
            Ok(obligation(&claim, name, text, claim.method(), CheckResult::Holds))
        };
        let proofs = |claim: Claim| match claim.variant {
            Variant::Searches => {
                let all = each(claim.properties).into_iter();
                all.map(|(property, text)| proof(claim, &format!("{property}, {name}"), &text)).collect()
            }
            _ => vec![proof(claim, &name, claim.properties)],
        };
        self.claims().flat_map(proofs).collect()
    }

    /// The problem that a property of the claim holds in spite of a fault, without lemmas.
    fn fault(
        &self,
        claim: &Claim,
        (property, from, to): (&str, &'static str, &'static str),
    ) -> Result<Obligation, Error> {
        let fault = TextFault { module: claim.module, from, to };
        let text = self.text(claim, self.module(claim.module)?, Some(fault), &only(claim.stated(), property))?;
        let name = format!("{property} with {to} in place of {from}");
        Ok(obligation(claim, &name, text, Method::Bounded(CYCLES), CheckResult::Fails))
    }

    /// The problem that what happens does not.
    fn never(&self, claim: &Claim) -> Result<Obligation, Error> {
        let assumed = claim.stated().replace(ASSERTION[1], ": assume (");
        let never = format!("{assumed}  always_comb never: assert (!({}));\n", claim.happens);
        let text = self.text(claim, self.module(claim.module)?, None, &never)?;
        Ok(obligation(claim, "never happens", text, Method::Bounded(CYCLES), CheckResult::Fails))
    }

    /// The problems of all faults of all claims, and that what happens does not.
    fn faults(&self) -> Result<Vec<Obligation>, Error> {
        let of = |claim: Claim| {
            let faults = claim.faults.iter().map(move |fault| self.fault(&claim, *fault));
            std::iter::once(self.never(&claim)).chain(faults)
        };
        self.claims().filter(|claim| !claim.faults.is_empty()).flat_map(of).collect()
    }
}

impl Obligation {
    /// That the assertions of this text have the result.
    pub(crate) fn new(name: String, top: String, text: String, method: Method, expected: CheckResult) -> Self {
        let assertions = text.matches(ASSERTION[1]).count();
        Self { problem: SafetyProblem { name, top, text, assertions, method }, expected }
    }
}

fn obligation(claim: &Claim, name: &str, text: String, method: Method, expected: CheckResult) -> Obligation {
    Obligation::new(format!("{}: {name}", claim.module), claim.module.to_string(), text, method, expected)
}

/// The obligations of a level: all claims, what must happen and all faults in the least units, and above level
/// `regression` the claims in further units.
///
/// # Errors
/// A unit cannot be built.
pub fn obligations(level: Level) -> Result<Vec<Obligation>, Error> {
    let mut all = system::obligations(level > Level::Regression)?;
    for variant in Variant::ALL {
        let least = Setting::least(variant)?;
        // Those of lists take minutes.
        if variant != Variant::Searches || level > Level::Regression {
            all.extend(least.proofs()?);
        }
        all.extend(least.faults()?);
        // Modules of searches do not depend on rays.
        let further = if variant == Variant::Searches { vec![UnitParameters::default()] } else { more().to_vec() };
        for parameters in further.into_iter().filter(|_| level > Level::Regression) {
            all.extend(Setting::new(variant, parameters)?.proofs()?);
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_fault_is_in_the_text_of_its_module() {
        assert!(super::obligations(super::Level::Regression).expect("all faults").len() > 140);
    }
}
