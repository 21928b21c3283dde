//! `docs/verification/plan.md`: every requirement has evidence that exists, everything that can be required has a row,
//! and the stages of sign-off are those that the records show.

use raypath_ops::operations::NAMES;
use raypath_rtl::{PRESETS, Preset, parameters};
use raypath_unit::UnitParameters;
use raypath_verify::parsers::TARGETS;
use raypath_verify::record::{Record, current_subject, root};
use raypath_verify::{ITEMS, Item};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// The plan.
struct Plan {
    text: String,
}

/// A row of a table of requirements.
#[derive(Debug)]
struct Requirement<'p> {
    text: &'p str,
    concerns: Vec<&'p str>,
    items: Vec<&'p str>,
    tests: Vec<&'p str>,
}

const HEADER: &str = "| requirement | concerns | items | tests |";
const STAGES: &str = "| presets | items for S2 | further items for S3 |";

/// The words in backticks.
fn quoted(cell: &str) -> Vec<&str> {
    cell.split('`').skip(1).step_by(2).collect()
}

/// The cells of the rows below each header of this form.
fn rows<'p>(text: &'p str, header: &str) -> Vec<Vec<&'p str>> {
    let tables = text.split(header).skip(1);
    let lines = tables.flat_map(|table| table.lines().skip(2).take_while(|line| line.starts_with('|')));
    lines.map(|line| line.trim_matches('|').split(" |").map(str::trim).collect()).collect()
}

impl Plan {
    fn read() -> Self {
        Self { text: fs::read_to_string(root().join("docs/verification/plan.md")).expect("the plan") }
    }

    fn requirements(&self) -> Vec<Requirement<'_>> {
        rows(&self.text, HEADER)
            .into_iter()
            .map(|cells| {
                let [text, concerns, items, tests] = cells[..] else { panic!("{cells:?}: expected four cells") };
                Requirement { text, concerns: quoted(concerns), items: quoted(items), tests: quoted(tests) }
            })
            .collect()
    }

    /// What is wrong with the plan.
    fn faults(&self) -> Vec<String> {
        let requirements = self.requirements();
        let mut faults = Vec::new();
        for Requirement { text, items, tests, .. } in &requirements {
            if items.is_empty() && tests.is_empty() {
                faults.push(format!("no evidence: {text}"));
            }
            let unknown = items.iter().filter(|name| !ITEMS.iter().any(|item| item.name == **name));
            faults.extend(unknown.map(|name| format!("no item {name}: {text}")));
            faults.extend(tests.iter().filter(|test| !exists(test)).map(|test| format!("no test {test}: {text}")));
        }
        let all: BTreeSet<String> = subjects().into_iter().collect();
        let concerned: BTreeSet<String> =
            requirements.iter().flat_map(|row| &row.concerns).map(|concern| concern.to_string()).collect();
        faults.extend(all.difference(&concerned).map(|subject| format!("in no row: {subject}")));
        faults.extend(concerned.difference(&all).map(|subject| format!("no subject {subject}")));
        let used: BTreeSet<&str> = requirements.iter().flat_map(|row| &row.items).copied().collect();
        faults.extend(
            ITEMS.iter().filter(|item| !used.contains(item.name)).map(|item| format!("in no row: item {}", item.name)),
        );
        faults
    }

    /// The items for S2, and the further ones for S3.
    fn stage_items(&self, preset: &str) -> [Vec<&'static Item>; 2] {
        let rows = rows(&self.text, STAGES);
        let row = rows.iter().find(|cells| quoted(cells[0]).contains(&preset)).expect("a row of the preset");
        let find = |name: &str| ITEMS.iter().find(|item| item.name == name).unwrap_or_else(|| panic!("no item {name}"));
        [1, 2].map(|column| quoted(row[column]).into_iter().map(find).collect())
    }
}

/// Everything that needs a row.
fn subjects() -> Vec<String> {
    let semantics = fs::read_to_string(root().join("docs/reference/semantics.md")).expect("the rulings");
    let in_prose = ["ruling ", "Ruling "].into_iter().flat_map(|before| semantics.split(before).skip(1));
    let numbers = in_prose.filter_map(|rest| rest.split_once([':', ')'])).map(|(number, _)| number);
    // The tables have rows such as "| 5: order |".
    let in_tables =
        semantics.lines().filter_map(|line| line.strip_prefix("| ")?.split_once(':')).map(|(start, _)| start);
    let rulings: BTreeSet<&str> = numbers.chain(in_tables).filter(|number| number.parse::<u32>().is_ok()).collect();
    assert!(rulings.len() >= 8, "{rulings:?}");
    let paper = ["quadbox", "triangle", "euclidean", "angular"];
    let named =
        |kind: &str, names: Vec<&str>| -> Vec<String> { names.iter().map(|name| format!("{kind} {name}")).collect() };
    [
        named("ruling", rulings.into_iter().collect()),
        named("parameter", parameters().map(|parameter| parameter.name).collect()),
        named("unit", UnitParameters::NAMES.to_vec()),
        named("operation", paper.into_iter().chain(NAMES).collect()),
        named("preset", PRESETS.iter().map(|preset| preset.name).collect()),
        named("format", TARGETS.iter().map(|target| target.name).collect()),
    ]
    .concat()
}

/// Whether a test exists: a file below `crates`, with a function after `::`.
fn exists(test: &str) -> bool {
    let (file, function) = test.split_once("::").map_or((test, None), |(file, function)| (file, Some(function)));
    let path = root().join("crates").join(file);
    let Ok(text) = fs::read_to_string(&path) else { return false };
    // The tests of a file with modules may all be in these.
    let has_modules = path.with_extension("").is_dir();
    match function {
        Some(function) => is_test(&text, function),
        None => has_modules || text.contains("#[test]") || text.contains("def test_"),
    }
}

/// Whether a text has this function as a test.
fn is_test(text: &str, function: &str) -> bool {
    let tests = text.split("#[test]").skip(1);
    let begins = format!("fn {function}(");
    tests.filter_map(|rest| rest.split_once("fn ")).any(|(_, rest)| format!("fn {rest}").starts_with(&begins))
}

/// The stage of a preset by the records.
fn stage(plan: &Plan, preset: &Preset, records: &[Record], root: &Path) -> u32 {
    let record = |item: &Item| {
        let covers_presets = item.claim.contains("every preset") || !["campaign", "models"].contains(&item.name);
        let found = records.iter().find(|record| record.item == item.name)?;
        let is_long = ["--level full", "--level long"].iter().any(|level| found.command.contains(level));
        let is_own = covers_presets || found.configuration == Some(preset.config.to_string());
        (is_long && is_own && found.result == "as claimed").then_some(found)
    };
    let [verified, signed_off] = plan.stage_items(preset.name);
    let is_current = |item: &&&Item| {
        record(item)
            .is_some_and(|found| found.is_dirty == Some(false) && !found.is_stale(item, root).expect("a subject"))
    };
    if !verified.iter().all(|item| record(item).is_some()) {
        return 1;
    }
    let all: Vec<&Item> = verified.into_iter().chain(signed_off).collect();
    if all.iter().filter(is_current).count() == all.len() { 3 } else { 2 }
}

#[test]
fn every_requirement_has_evidence_and_nothing_is_left_out() {
    let plan = Plan::read();
    assert!(plan.requirements().len() > 50);
    let faults = plan.faults();
    assert!(faults.is_empty(), "docs/verification/plan.md:\n{}", faults.join("\n"));
}

/// The checks find what they are for.
#[test]
fn faults_of_a_plan_are_found() {
    let good = Plan::read();
    let changed = |from: &str, to: &str| {
        assert!(good.text.contains(from), "{from}");
        Plan { text: good.text.replace(from, to) }.faults()
    };
    let has =
        |faults: Vec<String>, what: &str| assert!(faults.iter().any(|fault| fault.starts_with(what)), "{faults:?}");
    has(changed("`ruling 5`", ""), "in no row: ruling 5");
    has(changed("`ruling 5`", "`ruling 50`"), "no subject ruling 50");
    has(changed("`parameter facing`", ""), "in no row: parameter facing");
    has(changed("`unit stack`", ""), "in no row: unit stack");
    has(changed("`operation sphere`", ""), "in no row: operation sphere");
    has(changed("`format npy`", ""), "in no row: format npy");
    has(changed("`gates`", ""), "in no row: item gates");
    has(changed("`adder-proof`", "`adder-prof`"), "no item adder-prof");
    has(changed("rule_5_order.rs", "rule_50.rs"), "no test raypath/tests/semantics/rule_50.rs");
    has(changed("::accumulators_do_not_mix", "::accumulators_mix"), "no test raypath-ops/tests/triangle_features.rs::");
    let row = format!("{HEADER}\n| --- | --- | --- | --- |\n");
    has(changed(&row, &format!("{row}| it flies | | | |\n")), "no evidence: it flies");
}

/// README's stages follow from the records.
#[test]
fn stages_of_sign_off_follow_from_the_records() {
    let (plan, root) = (Plan::read(), root());
    let records = Record::read_all(&root.join("docs/records")).expect("records");
    let readme = fs::read_to_string(root.join("README.md")).expect("README");
    for preset in PRESETS {
        let stage = format!("| S{} |", stage(&plan, preset, &records, &root));
        let row = readme.lines().find(|line| line.starts_with(&format!("| `{}`", preset.name))).expect("a row");
        assert!(row.ends_with(&stage), "README.md: expected '{stage}' at the end of {row}");
    }
}

/// Records of all items lead to S3, a stale one to S2, and a missing or wrong one to S1.
#[test]
fn stages_need_records() {
    let (plan, root) = (Plan::read(), root());
    let paper = &PRESETS[0];
    let any = Record::read_all(&root.join("docs/records")).expect("records").remove(0);
    let record = |item: &Item| {
        let mut made = Record { item: item.name.to_string(), result: "as claimed".to_string(), ..any.clone() };
        made.command = format!("verify {} --level full", item.name);
        (made.is_dirty, made.configuration) = (Some(false), Some(paper.config.to_string()));
        made.subject = Some(current_subject(item, &root).expect("a subject"));
        made
    };
    let [verified, signed_off] = plan.stage_items(paper.name);
    let good: Vec<Record> = verified.iter().chain(&signed_off).map(|item| record(item)).collect();
    let stage_of = |change: &dyn Fn(&mut Record)| {
        let mut records = good.clone();
        change(&mut records[0]);
        stage(&plan, paper, &records, &root)
    };
    assert_eq!(stage_of(&|_| ()), 3);
    assert_eq!(stage_of(&|record| record.subject = None), 2);
    assert_eq!(stage_of(&|record| record.is_dirty = Some(true)), 2);
    assert_eq!(stage_of(&|record| record.result = "wrong".to_string()), 1);
    assert_eq!(stage_of(&|record| record.command = "verify control --level regression".to_string()), 1);
    assert_eq!(stage(&plan, paper, &good[1..], &root), 1);
    assert_eq!(stage(&plan, paper, &good[..verified.len()], &root), 2);
}
