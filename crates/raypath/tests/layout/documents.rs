//! Tables in the documents that are compared with the code.

use crate::layout::manifests::dependencies;
use crate::layout::{root, text};
use raypath::oracle::added_operations;
use raypath::rtl::report::tables::list;
use raypath::rtl::{Config, PARAMETER_GROUPS};
use raypath::sim::Datapath;
use raypath_cli::Cost;
use std::collections::{BTreeMap, BTreeSet};

/// `docs/development/dependencies.md` has a row for every dependency, and no other rows.
#[test]
fn every_dependency_has_a_reason() {
    let mut used: BTreeSet<String> = dependencies().into_values().flat_map(BTreeMap::into_values).flatten().collect();
    used.retain(|name| !name.starts_with("raypath"));
    assert!(used.contains("clap") && used.contains("wellen"), "{used:?}");

    let document = text(&root().join("docs/development/dependencies.md"));
    let crates = document.split("## Programs").next().expect("the crates");
    let rows = crates.lines().filter(|line| line.starts_with("| `"));
    let mut listed = BTreeSet::new();
    for row in rows {
        let names = row.split('|').nth(1).expect("a first column");
        let names: Vec<&str> = names.split('`').skip(1).step_by(2).filter(|name| !name.starts_with('=')).collect();
        // `cranelift-jit`, `-module`: crates of one family share a row, with short names.
        let family = names[0].split_once('-').map_or(names[0], |(family, _)| family);
        listed.extend(names.iter().map(|name| match name.starts_with('-') {
            true => format!("{family}{name}"),
            false => name.to_string(),
        }));
    }
    assert_eq!(used, listed);
}

/// The table of `docs/reference/operations.md` has the latency, units and flip-flops that are counted in the netlists.
#[test]
fn the_table_of_operations_has_the_counted_figures() {
    let document = text(&root().join("docs/reference/operations.md"));
    let table =
        document.split("| operation | for |").nth(1).and_then(|rest| rest.split("\n\n").next()).expect("the table");
    let rows: Vec<Vec<&str>> = table.lines().skip(2).map(|row| row.split('|').map(str::trim).collect()).collect();
    assert!(rows.len() >= 4, "{rows:?}");
    for row in rows {
        let name = row[1].trim_matches('`');
        let paper = Datapath::paper(Config::DEFAULT);
        let added = added_operations().into_iter().find(|spec| spec.name() == name);
        let datapath = added.into_iter().fold(paper, |datapath, spec| datapath.with_any(spec.operation()));
        if !datapath.has(name) {
            // The file of an added operation may have been removed; its row is then not checked.
            continue;
        }
        let cost = Cost::of(&datapath, name).expect("it fits");
        let flip_flops = cost.with.flip_flops as i64 - cost.without.flip_flops as i64;
        let units = list(cost.added_units());
        let units = if units.is_empty() { "none" } else { &units };
        let counted = [cost.with.latency.to_string(), units.to_string(), format!("{flip_flops:+}")];
        assert_eq!(row[3..6], counted, "{name}");
    }
}

/// The table of parameters in the document of configurations is generated from their declarations.
#[test]
fn the_table_of_parameters_has_the_declarations() {
    let document = text(&root().join("docs/reference/configurations.md"));
    for group in PARAMETER_GROUPS {
        let mut table = format!("| {} | values | default | meaning |\n| --- | --- | --- | --- |\n", group.heading);
        for parameter in group.parameters {
            let values = parameter.values.replace('|', "`, `");
            let (name, default, help) = (parameter.name, parameter.default(), parameter.help());
            table += &format!("| `{name}` | `{values}` | `{default}` | {help} |\n");
        }
        assert!(document.contains(&table), "docs/reference/configurations.md lacks this table:\n{table}");
    }
}
