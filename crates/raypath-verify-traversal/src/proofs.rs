//! Proofs of the control of the unit's modules.

use super::bindings;
use super::claims::{CLAIMS, Claim, LEMMAS};
use super::setting::LEAST;
pub use super::setting::{Setting, Variant};
use crate::built;
use raypath_hdl::mutate::replace;
use raypath_hdl::{Module, expand_memories};
use raypath_rtl::Config;
use raypath_tools::{ToolError, pool};
use raypath_traversal::UnitParameters;
use raypath_verify::safety::{CheckResult, Method, ModelChecker, ModuleTexts, RESET, SafetyProblem, TextFault};
use raypath_verify::{Error, Level, Progress, Shard};
use std::fmt::Write as _;
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
/// The most contexts of a unit for which these modules are proved: more take many minutes.
const LIMITED: [(&str, u32); 3] =
    [("raypath_unit_contexts", 16), ("raypath_unit_distance", 16), ("raypath_unit_rays", 16)];

/// Further units.
const MORE: [UnitParameters; 3] = [
    UnitParameters { contexts: 11, memory_width: 128, divider_latency: 3, ..LEAST },
    UnitParameters { contexts: 16, divider_latency: 9, ..LEAST },
    UnitParameters { contexts: 64, memory_width: 512, divider_latency: 9, ..LEAST },
];

impl Setting {
    /// The problems that the properties of this module's claim hold for a faulty copy, which must fail without lemmas
    /// in few cycles, and which would be a proof with them; none if there is no claim.
    ///
    /// # Errors
    /// The module cannot be printed.
    pub fn faulty(&self, module: &Arc<Module>) -> Result<Option<[Obligation; 2]>, Error> {
        let Some(claim) = self.claims().find(|claim| claim.module == module.name()) else { return Ok(None) };
        let unit = built(Config::DEFAULT, self.unit.parameters)?;
        let modules = self.modules.iter().map(|own| if own.name() == module.name() { module } else { own });
        let setting = Self { unit, modules: modules.cloned().collect(), ..*self };
        let properties = claim.properties.split(LEMMAS).next().unwrap_or_default();
        let assertions = properties.matches(": assert (").count();
        let text = setting.text(claim, None, properties)?;
        let Obligation { problem, expected } = setting.refuted(claim, "a fault".to_string(), text, assertions)?;
        let refutation =
            Obligation { problem: SafetyProblem { method: Method::Bounded(FEW_CYCLES), ..problem }, expected };
        Ok(Some([refutation, setting.claim(claim)?]))
    }

    fn claims(&self) -> impl Iterator<Item = &'static Claim> + use<> {
        let variant = self.variant;
        CLAIMS.iter().filter(move |claim| claim.variant == variant)
    }

    /// The module of a claim, with registers in place of the memories that its properties see.
    fn subject(&self, claim: &Claim) -> Result<Arc<Module>, Error> {
        let module = self.module(claim.module)?;
        match claim.queue {
            _ if claim.expands => Ok(expand_memories(module)?),
            Some((_, queue)) => Ok(replace(module, &expand_memories(self.module(queue)?)?)?),
            None => Ok(module.clone()),
        }
    }

    fn text(&self, claim: &Claim, fault: Option<TextFault>, inside: &str) -> Result<String, Error> {
        let module = self.subject(claim)?;
        let mut texts = ModuleTexts::new(&module)?;
        if let Some(fault) = fault
            && !texts.insert(fault)
        {
            return Err(ToolError::unexpected("a fault", format!("{fault:?}"), "a text of its module").into());
        }
        let contexts = self.unit.parameters.contexts;
        let mut bound = format!("  localparam int N = {contexts};\n");
        if let Some((path, queue)) = claim.queue {
            bound += &bindings::of_queue(path, self.module(queue)?, contexts);
        }
        bound += &(claim.bindings)(self, &module);
        Ok(texts.with(claim.module, &format!("{bound}{inside}{RESET}")) + include_str!("properties/lemmas.sv"))
    }

    /// The problem that the claim holds.
    ///
    /// # Errors
    /// The module cannot be printed.
    fn claim(&self, claim: &Claim) -> Result<Obligation, Error> {
        let assertions = claim.properties.matches(": assert (").count();
        let name = format!("{} of {} contexts, {:?}", claim.module, self.unit.parameters.contexts, self.variant);
        let text = self.text(claim, None, claim.properties)?;
        let problem = SafetyProblem { name, top: claim.module.to_string(), text, assertions, method: claim.method };
        Ok(Obligation { problem, expected: CheckResult::Holds })
    }

    /// The problem that the claim's properties hold in spite of a fault, without lemmas.
    ///
    /// # Errors
    /// The module does not have the text of the fault.
    fn fault(&self, claim: &Claim, (from, to): (&'static str, &'static str)) -> Result<Obligation, Error> {
        let properties = claim.properties.split(LEMMAS).next().unwrap_or_default();
        let fault = TextFault { module: claim.module, from, to };
        let text = self.text(claim, Some(fault), properties)?;
        let assertions = properties.matches(": assert (").count();
        self.refuted(claim, format!("{from} replaced by {to}"), text, assertions)
    }

    /// The problem that what happens does not.
    ///
    /// # Errors
    /// The module cannot be printed.
    fn never(&self, claim: &Claim) -> Result<Obligation, Error> {
        let properties = claim.properties.split(LEMMAS).next().unwrap_or_default();
        let mut only = String::new();
        for line in properties.lines() {
            // Assertions may take several lines, the last of which ends the statement.
            let _ = writeln!(only, "{}", line.replace(": assert (", ": assume ("));
        }
        let _ = writeln!(only, "  always_comb never: assert (!({}));", claim.happens);
        let text = self.text(claim, None, &only)?;
        self.refuted(claim, "never happens".to_string(), text, 1)
    }

    /// The problems of all faults of all claims, and that what happens does not.
    ///
    /// # Errors
    /// The module cannot be printed.
    pub fn faults(&self) -> Result<Vec<Obligation>, Error> {
        let all = self.claims().filter(|claim| is_representative(claim));
        let of = |claim: &'static Claim| {
            let faults = claim.faults.iter().map(move |fault| self.fault(claim, *fault));
            std::iter::once(self.never(claim)).chain(faults)
        };
        all.flat_map(of).collect()
    }

    fn refuted(&self, claim: &Claim, what: String, text: String, assertions: usize) -> Result<Obligation, Error> {
        let name = format!("{}: {what}", claim.module);
        let method = Method::Bounded(CYCLES);
        let problem = SafetyProblem { name, top: claim.module.to_string(), text, assertions, method };
        Ok(Obligation { problem, expected: CheckResult::Fails })
    }
}

/// Whether the faults of a claim are refuted. One of the queues stands for all: they differ in the width of words.
fn is_representative(claim: &Claim) -> bool {
    claim.module == CLAIMS[0].module || claim.queue.is_none_or(|(path, _)| !path.is_empty())
}

/// Whether no claim before is one of the same module, in another unit.
fn is_first(claim: &Claim) -> bool {
    CLAIMS.iter().find(|other| other.module == claim.module).is_some_and(|first| first.variant == claim.variant)
}

/// The obligations of a level: all claims of one unit or of several, what must happen, and faults.
///
/// # Errors
/// A unit cannot be built.
pub fn obligations(level: Level) -> Result<Vec<Obligation>, Error> {
    let is_thorough = level > Level::Regression;
    let mut all = Vec::new();
    for variant in Variant::ALL {
        // A refutation needs no more than the lowest bits.
        let (least, least_bits) = (Setting::least(variant, is_thorough)?, Setting::least(variant, false)?);
        let claims = || least.claims().filter(|claim| is_thorough || is_first(claim));
        for claim in claims() {
            all.push(least.claim(claim)?);
        }
        for claim in claims().filter(|claim| is_representative(claim)) {
            let faults = if is_thorough { claim.faults } else { &claim.faults[..1] };
            if is_thorough {
                all.push(least_bits.never(claim)?);
            }
            for &fault in faults {
                all.push(least_bits.fault(claim, fault)?);
            }
        }
        for parameters in MORE.into_iter().filter(|_| is_thorough) {
            let setting = Setting::new(variant, parameters, false)?;
            let is_limited = |claim: &&Claim| {
                LIMITED.iter().any(|(module, most)| *module == claim.module && parameters.contexts > *most)
            };
            for claim in setting.claims().filter(|claim| !is_limited(claim)) {
                all.push(setting.claim(claim)?);
            }
        }
    }
    Ok(all)
}

/// The result of one obligation: whether it was a proof, and what went wrong.
pub type Checked = (bool, Option<String>);

/// Checks the shard's obligations on all cores. Those that were not reached when the run was stopped are missing.
///
/// # Errors
/// A program is missing or fails.
pub fn check(
    obligations: &[Obligation],
    shard: Shard,
    proceed: &mut dyn FnMut(Progress) -> bool,
) -> Result<Vec<Option<Checked>>, Error> {
    let checker = ModelChecker::find()?;
    let own: Vec<&Obligation> =
        (0..).zip(obligations).filter(|(number, _)| shard.takes(*number)).map(|(_, obligation)| obligation).collect();
    let results = pool::map(&own, pool::ALL_CORES, proceed, |obligation, stop| {
        let found: Option<CheckResult> = checker.check(&obligation.problem, stop)?;
        Ok::<_, Error>(found)
    })?;
    let verdict = |(obligation, result): (&&Obligation, Option<CheckResult>)| {
        let Obligation { problem, expected } = obligation;
        let found = result?;
        let failure = (found != *expected).then(|| format!("{}: {found:?}, expected {expected:?}", problem.name));
        Some((*expected == CheckResult::Holds, failure))
    };
    Ok(own.iter().zip(results).map(verdict).collect())
}
