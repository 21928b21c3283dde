//! The heat map of utilisation: a table with a column per stage and a row per kind of unit.

use super::COLOURS;
use super::recording::{Recording, StageUse, UnitUse};
use maud::{Markup, html};

/// The heat map, preceded by rows that describe each operation stage by stage.
pub fn table(recording: &Recording) -> Markup {
    let stages = &recording.utilisation;
    let mut kinds: Vec<&str> = Vec::new();
    for unit in stages.iter().flat_map(|stage| &stage.units) {
        if !kinds.contains(&unit.name.as_str()) {
            kinds.push(&unit.name);
        }
    }
    html! {
        div.choice role="group" aria-label="Utilisation of" {
            button type="button" data-heat="-1" aria-pressed="true" { "all operations" }
            @for (opcode, operation) in recording.named_operations() {
                button type="button" data-heat=(opcode) aria-pressed="false" {
                    i.key.{ "op" (opcode % COLOURS) } {} (operation)
                }
            }
        }
        div.scroll {
            table.heat #heat {
                thead { tr { th { "stage" } @for stage in stages { th scope="col" { (stage.number) } } } }
                tbody {
                    @for (opcode, operation) in recording.named_operations() {
                        tr.does {
                            th scope="row" { i.key.{ "op" (opcode % COLOURS) } {} (operation) }
                            @for stage in stages { td { (stage.titles.get(opcode).map_or("", |title| title)) } }
                        }
                    }
                    @for kind in kinds {
                        tr.units { th scope="row" { (kind) } @for stage in stages { (cell(recording, stage, kind)) } }
                    }
                }
            }
        }
    }
}

fn cell(recording: &Recording, stage: &StageUse, kind: &str) -> Markup {
    let Some(unit) = stage.units.iter().find(|unit| unit.name == kind) else { return html! { td.none {} } };
    let shares: Vec<String> = unit.by_operation.iter().map(f64::to_string).collect();
    html! {
        td style={ "--use:" (format!("{:.4}", unit.total.clamp(0.0, 1.0))) } title=(tooltip(recording, stage, unit))
            data-total=(unit.total) data-by=(shares.join(" ")) {
            b { (percent(unit.total)) }
            small { "× " (unit.count) }
        }
    }
}

fn tooltip(recording: &Recording, stage: &StageUse, unit: &UnitUse) -> String {
    let UnitUse { name, count, total, by_operation } = unit;
    let part = |opcode: usize| percent(by_operation.get(opcode).copied().unwrap_or(0.0));
    let by = recording.named_operations().map(|(opcode, name)| format!("\n{name}: {}", part(opcode)));
    format!("stage {}, {name} × {count}: busy in {} of cycles{}", stage.number, percent(*total), by.collect::<String>())
}

fn percent(part: f64) -> String {
    format!("{:.1}%", part * 100.0)
}
