//! The page of a search in Chromium: it shows the numbers of the search, names the configuration under the pointer,
//! shows the stages of a chosen one, and runs no script from data.

#[path = "../../raypath-timing/tests/report/chromium.rs"]
mod chromium;

use crate::common::setting::setting;
use chromium::Page;
use raypath_ppa::explore::{
    Candidate, Found, Goal, LinearPredictor, Metric, Predicted, Search, SearchReport, Status, Terms, Values,
};
use raypath_ppa::{Area, Path, Report, Slowest, Stage, Step, Units};
use serde_json::{Value, json};
use std::collections::BTreeMap;

impl Page {
    /// The value of a JavaScript expression.
    fn json(&self, expression: &str) -> Value {
        let text = self.value(&format!("(async () => JSON.stringify((await ({expression})) ?? null))()"));
        serde_json::from_str(&text).expect("JSON")
    }

    /// Moves the browser's mouse to the middle of an element, and presses its button there if wanted.
    fn mouse(&self, selector: &str, is_pressed: bool) {
        let selector = json!(selector);
        let at = self.json(&format!(
            "(() => {{ const e = document.querySelector({selector}); e.scrollIntoView({{ block: 'center' }}); \
             const b = e.getBoundingClientRect(); return [b.left + b.width / 2, b.top + b.height / 2]; }})()"
        ));
        let mut kinds = vec!["mouseMoved"];
        kinds.extend(is_pressed.then_some(["mousePressed", "mouseReleased"]).into_iter().flatten());
        for kind in kinds {
            let button = if kind == "mouseMoved" { "none" } else { "left" };
            let parameters = json!({ "type": kind, "x": at[0], "y": at[1], "button": button, "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", parameters);
        }
    }
}

/// A report with one stage of this area in mm² and this slowest path.
fn report(mm2: f64, ns: f64) -> Report {
    let units = BTreeMap::from([("mul".to_string(), Units { count: 3, area: mm2 * 0.75e6 })]);
    let area = Area { total: mm2 * 1e6, units, registers: mm2 * 0.25e6, ..Area::default() };
    let step = |through: &str, ns: f64| Step { through: through.to_string(), ns };
    let path = Path {
        ns,
        start: "input num_0_q".to_string(),
        end: "stage 1 num_1_q".to_string(),
        steps: vec![step("input num_0_q", 0.5), step("u_mul_2", ns - 1.0), step("stage 1 num_1_q", ns - 0.5)],
        setup_ns: 0.5,
    };
    let stage = Stage { name: "stage 1".to_string(), area: area.clone(), flip_flops: 1234, slowest: Some(path) };
    Report {
        design: "a design".to_string(),
        setting: setting(),
        area,
        flip_flops: 1234,
        memory_bits: 0,
        kilo_gates: 1.0,
        slowest: Slowest { stage: "stage 1".to_string(), ns },
        clock_mhz: 1000.0 / ns,
        area_period: mm2 * ns,
        stages: vec![stage],
        power: None,
    }
}

/// Four configurations: two on the front, one dominated, and one that was predicted only.
fn search(names: [&str; 4]) -> SearchReport {
    let measured = [(0.5, 12.0), (0.75, 8.0), (0.8, 12.5)];
    let values = |mm2: f64, ns: f64| {
        Values::from([(Metric::Area, mm2), (Metric::Period, ns), (Metric::Throughput, 0.5), (Metric::Latency, 12.0)])
    };
    let terms = |value: f64| Terms { known: value, terms: vec![1.0] };
    let candidates: Vec<Candidate> = names
        .iter()
        .zip([measured[0], measured[1], measured[2], (1.0, 13.0)])
        .map(|(name, (mm2, ns))| Candidate {
            name: name.to_string(),
            options: format!("--name {name}"),
            exact: Values::from([(Metric::Throughput, 0.5), (Metric::Latency, 12.0)]),
            terms: [(Metric::Area, terms(mm2)), (Metric::Period, terms(ns))].into_iter().collect(),
        })
        .collect();
    let goals: [Goal; 1] = ["area<=0.9mm2".parse().expect("a goal")];
    let search = Search {
        candidates: &candidates,
        predictor: &LinearPredictor { candidates: &candidates },
        goals: &goals,
        objectives: &[Metric::Area, Metric::Period],
        first: 3,
        batch: 1,
    };
    let status = [Status::Front, Status::Front, Status::Dominated];
    let mut found: Vec<Found> = measured
        .iter()
        .zip(status)
        .map(|((mm2, ns), status)| Found { status, values: values(*mm2, *ns), predicted: BTreeMap::new() })
        .collect();
    let predicted = BTreeMap::from([
        (Metric::Area, Predicted { value: 1.0, error: 0.05 }),
        (Metric::Period, Predicted { value: 13.0, error: 0.5 }),
    ]);
    found.push(Found { status: Status::Predicted, values: candidates[3].exact.clone(), predicted });
    let outcome = raypath_ppa::explore::Outcome { found, rounds: 1 };
    let reports = measured.iter().map(|(mm2, ns)| report(*mm2, *ns)).enumerate().collect();
    SearchReport::new(&search, outcome, reports, setting(), BTreeMap::new())
}

const NAMES: [&str; 4] = ["small", "fast", "worse", "unmeasured"];

#[test]
fn the_page_shows_the_search() {
    let search = search(NAMES);
    let page = Page::open(&search.page());
    let summary = page.json("[...document.querySelectorAll('#summary p')].map(p => p.textContent)");
    let lines = search.summary();
    let expected: Vec<&str> =
        lines.lines().chain(["Yosys 1, OpenSTA 2, library cells, gates chosen for 7.5 ns"]).collect();
    assert_eq!(summary, json!(expected));
    let front =
        page.json("[...document.querySelectorAll('#front tbody tr')].map(r => [...r.cells].map(c => c.textContent))");
    assert_eq!(front, json!([["small", "0.500", "12.00", "0.500", "12"], ["fast", "0.750", "8.00", "0.500", "12"]]));

    // The measured configurations, those of the front last. A smaller period is further left, a smaller area lower.
    let circles =
        "[...document.querySelectorAll('circle')].map(c => [c.getAttribute('aria-label'), c.className.baseVal])";
    let names = page.json(circles);
    assert_eq!(names, json!([["worse", "dominated"], ["small", "front"], ["fast", "front"]]));
    let place = |page: &Page, name: &str| -> (f64, f64) {
        let at = page.json(&format!(
            "(c => [Number(c.getAttribute('cx')), Number(c.getAttribute('cy'))])(document.querySelector('circle[aria-label={name}]'))"
        ));
        (at[0].as_f64().expect("x"), at[1].as_f64().expect("y"))
    };
    let [small, fast, worse] = ["small", "fast", "worse"].map(|name| place(&page, name));
    assert!(
        fast.0 < small.0 && small.0 < worse.0 && worse.1 < fast.1 && fast.1 < small.1,
        "{small:?} {fast:?} {worse:?}"
    );
    // Linear: the distances are those of 4 and 0.5 ns.
    assert!(((small.0 - fast.0) / (worse.0 - small.0) - 8.0).abs() < 1e-6);

    // What was not measured, with two lines for its errors. The range of the axes now has the goal.
    page.json("document.getElementById('unmeasured').click()");
    assert_eq!(page.json("document.querySelectorAll('circle').length"), json!(4));
    assert_eq!(page.json("document.querySelectorAll('.error').length"), json!(2));
    assert_eq!(page.json("document.querySelectorAll('.goal').length"), json!(1));

    // Other axes: all have the same throughput.
    assert_eq!(page.json("document.getElementById('label-across').textContent"), json!("period, ns"));
    page.json("(() => { const s = document.getElementById('across'); s.value = '2'; s.dispatchEvent(new Event('change')); })()");
    assert_eq!(page.json("document.getElementById('label-across').textContent"), json!("throughput, jobs a cycle"));
    let [small, fast] = ["small", "fast"].map(|name| place(&page, name));
    assert!(small.0 == fast.0 && fast.1 < small.1);
    assert_eq!(
        page.json("performance.getEntriesByType('resource').filter(e => !e.name.startsWith('data:')).length"),
        json!(0)
    );
    page.assert_console_empty();
}

#[test]
fn the_pointer_names_a_configuration_and_a_click_shows_its_stages() {
    let page = Page::open(&search(NAMES).page());
    assert_eq!(
        page.json("[document.getElementById('tip').hidden, document.getElementById('chosen').hidden]"),
        json!([true, true])
    );
    page.mouse("circle[aria-label=fast]", false);
    let tip = page.json("document.getElementById('tip').innerText");
    assert_eq!(tip, json!("fast\n0.750 mm²\n8.00 ns\n0.500 jobs a cycle\n12 cycles"));
    page.mouse("h1", false);
    assert_eq!(page.json("document.getElementById('tip').hidden"), json!(true));

    page.mouse("circle[aria-label=fast]", true);
    let chosen = "[document.querySelector('#chosen h2').textContent, document.querySelector('circle.is-chosen').getAttribute('aria-label')]";
    assert_eq!(page.json(chosen), json!(["fast", "fast"]));
    let tables = page.json(
        "[...document.querySelectorAll('#chosen table')].map(t => [...t.rows].map(r => [...r.cells].map(c => c.textContent)))",
    );
    // The rows of the tables that `ppa` prints: 0.75 mm², three quarters of it in three multipliers.
    assert_eq!(tables[0][0][2], json!("area of units"));
    let row = json!(["stage 1", "3 mul", "562,500", "187,500", "", "", "", "", "", "750,000", "100.0 %", "1,234"]);
    assert_eq!(tables[0][1], row);
    assert_eq!(tables[1][1], json!(["stage 1", "8.00", "input num_0_q", "u_mul_2 7.00", "stage 1 num_1_q"]));

    // By the keyboard, and from the table of the front.
    page.json(
        "(() => { const c = document.querySelector('circle[aria-label=worse]'); c.focus(); \
                c.dispatchEvent(new KeyboardEvent('keydown', { key: 'Enter' })); })()",
    );
    assert_eq!(page.json("document.getElementById('tip').innerText.split('\\n')[0]"), json!("worse"));
    assert_eq!(page.json(chosen), json!(["worse", "worse"]));
    page.mouse("#front tbody tr", true);
    assert_eq!(page.json(chosen), json!(["small", "small"]));
    page.json("document.getElementById('unmeasured').click()");
    page.mouse("circle[aria-label=unmeasured]", true);
    assert_eq!(page.json("document.querySelectorAll('#chosen table').length"), json!(0));
    let text = page.json("document.getElementById('chosen').innerText");
    assert!(text.as_str().expect("text").contains("1.00 ± 0.050, predicted"), "{text}");
    page.assert_console_empty();
}

#[test]
fn names_are_not_executed() {
    let hostile = "</script><!--<script>window.ran=1</script><img src=x onerror=\"window.ran=1\">'\"&amp;/* data */";
    let page = Page::open(&search([hostile, "fast", "worse", "unmeasured"]).page());
    page.mouse("circle[aria-label*=ran]", true);
    assert_eq!(page.json("document.querySelector('#chosen h2').textContent"), json!(hostile));
    assert_eq!(page.json("[document.querySelectorAll('script').length, window.ran ?? null]"), json!([2, null]));
    page.assert_console_empty();
}
