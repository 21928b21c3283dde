use super::recording::{Recording, Table, Window};
use super::timeline;
use super::{COLOURS, heat};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// Renders a recording as one self-contained HTML page, without references to other files.
///
/// All strings of the recording are escaped. The SVG of the sweep is embedded as an image, in which scripts do not run.
pub fn html(recording: &Recording) -> String {
    let Recording { title, configuration, counts, utilisation, window, image, sweep, tables, .. } = recording;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                link rel="icon" href="data:,";
                title { (title) }
                style { (PreEscaped(include_str!("page/page.css"))) }
            }
            body {
                header { p { "raypath" } h1 { (title) } }
                main {
                    div.columns {
                        @if !counts.is_empty() { section #counts { h2 { "Counts and rates" } (pairs(counts)) } }
                        @if !configuration.is_empty() {
                            section #configuration { h2 { "Configuration" } (pairs(configuration)) }
                        }
                        @if let Some(image) = image {
                            section #image {
                                h2 { (image.title) }
                                img alt=(image.title)
                                    src={ "data:image/png;base64," (BASE64_STANDARD.encode(&image.png)) };
                            }
                        }
                    }
                    @if !window.jobs.is_empty() { section #timeline { (view(recording, window)) } }
                    @if !utilisation.is_empty() {
                        section #utilisation { h2 { "Utilisation by stage and unit" } (heat::table(recording)) }
                    }
                    @if let Some(sweep) = sweep {
                        section #sweep {
                            h2 { "Throughput by agents in flight" }
                            img alt="Throughput by agents in flight and memory latency"
                                src={ "data:image/svg+xml;base64," (BASE64_STANDARD.encode(sweep)) };
                        }
                    }
                    @for table in tables { section.table { h2 { (table.title) } (grid(table)) } }
                }
                script #data type="application/json" { (PreEscaped(timeline::json(recording))) }
                script { (PreEscaped(include_str!("page/heat.js"))) }
                script { (PreEscaped(include_str!("page/model.js"))) }
                script { (PreEscaped(include_str!("page/drawing.js"))) }
                script { (PreEscaped(include_str!("page/timeline.js"))) }
            }
        }
    };
    page.into_string()
}

fn pairs(pairs: &[(String, String)]) -> Markup {
    html! { table.pairs { tbody { @for (name, value) in pairs { tr { th scope="row" { (name) } td { (value) } } } } } }
}

fn grid(table: &Table) -> Markup {
    html! {
        div.scroll {
            table.grid {
                thead { tr { @for head in &table.head { th scope="col" { (head) } } } }
                tbody { @for row in &table.rows { tr { @for cell in row { td { (cell) } } } } }
            }
        }
    }
}

/// The canvas of the timeline and its controls.
fn view(recording: &Recording, window: &Window) -> Markup {
    let cycles = window.end.saturating_sub(window.first);
    let summary = format!(
        "{} jobs in {cycles} cycles, from cycle {}, through {} stages",
        window.jobs.len(),
        window.first,
        window.stages
    );
    html! {
        h2 { "Timeline" }
        p.summary { (summary) }
        div.bar {
            div.choice role="group" aria-label="Rows" {
                button type="button" #by-job aria-pressed="true" { "rows: jobs" }
                button type="button" #by-stage aria-pressed="false" { "rows: stages" }
            }
            div.choice role="group" aria-label="View" {
                button type="button" #zoom-in aria-label="zoom in" { "+" }
                button type="button" #zoom-out aria-label="zoom out" { "−" }
                button type="button" #earlier aria-label="earlier" { "←" }
                button type="button" #later aria-label="later" { "→" }
                button type="button" #stall aria-label="to the next stall" { "next stall" }
                button type="button" #all { "all" }
                button type="button" #reset { "reset" }
            }
            output #range aria-live="polite" {}
        }
        ul.legend {
            @for (opcode, operation) in recording.named_operations() {
                li { i.key.{ "op" (opcode % COLOURS) } {} (operation) }
            }
            li { i.key.stalled {} "stalled: stays in its stage" }
            li { i.key.refused {} "job not accepted" }
            li { i.key.unsunk {} "sink not ready" }
            li { i.key.bubble {} "bubble" }
        }
        canvas #overview height="44" aria-hidden="true" {}
        div.stage {
            canvas #canvas tabindex="0" role="img"
                aria-label={
                    "Timeline: " (summary) ". Arrows move, plus and minus zoom, 0 resets, s finds the next stall."
                } {}
            div #tip role="status" hidden {}
        }
        p.hint {
            "Wheel zooms about the pointer (with Shift it moves in time), drag moves, double click resets. "
            "Keys: arrows, "
            kbd { "+" } " " kbd { "−" } " " kbd { "0" } ", " kbd { "s" } " next stall."
        }
    }
}
