//! The page in Chromium: it loads, shows the numbers of the recording, zooms, and runs no embedded script.

use crate::report::chromium::Page;
use crate::report::common;
use raypath_model::Control;
use raypath_timing::report::{Recording, html};

impl Page {
    /// The first and last cycle in view.
    fn range(&self) -> (u64, u64) {
        let text = self.value("document.getElementById('range').textContent");
        let numbers: Vec<u64> = text.split(' ').filter_map(|word| word.parse().ok()).collect();
        (numbers[0], numbers[1])
    }

    /// A hash of the pixels of the canvas after drawing.
    fn pixels(&self) -> String {
        self.value(
            "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => { let h = 0; \
             for (const x of document.getElementById('canvas').toDataURL()) h = (h * 31 + x.charCodeAt(0)) | 0; \
             done(h); })))",
        )
    }

    fn at_canvas(&self, event: &str) {
        self.value(&format!(
            "(() => {{ const c = document.getElementById('canvas'), b = c.getBoundingClientRect(); \
             const at = (x, y) => ({{ clientX: b.left + x, clientY: b.top + y, bubbles: true, cancelable: true, \
             pointerId: 1 }}); \
             c.setPointerCapture = () => {{}}; {event} }})()"
        ));
    }
}

#[test]
fn the_page_shows_the_recordings_numbers() {
    for control in [Control::Skid, Control::Credit] {
        let recording = Recording { sweep: Some(SWEEP.to_string()), ..common::recording(control, 2000, 0.15) };
        let page = Page::open(&html(&recording));
        assert_eq!(page.value("document.title"), recording.title);
        for (id, pairs) in [("counts", &recording.counts), ("configuration", &recording.configuration)] {
            let rows = page.value(&format!(
                "JSON.stringify([...document.querySelectorAll('#{id} tr')] \
                 .map(r => [...r.children].map(c => c.textContent)))"
            ));
            assert_eq!(serde_json::from_str::<Vec<(String, String)>>(&rows).expect("rows"), *pairs);
        }
        let shown = page.value(
            "JSON.stringify([...document.querySelectorAll('#heat td[data-total]')] \
             .map(c => c.querySelector('b').textContent))",
        );
        let percents = |part: &dyn Fn(&raypath_timing::report::UnitUse) -> f64| -> Vec<String> {
            let of = |kind: &str| -> Vec<String> {
                let units = recording.utilisation.iter().flat_map(|stage| &stage.units);
                units.filter(|unit| unit.name == kind).map(|unit| format!("{:.1}%", 100.0 * part(unit))).collect()
            };
            // In the order of first occurrence.
            let mut kinds = Vec::new();
            for unit in recording.utilisation.iter().flat_map(|stage| &stage.units) {
                if !kinds.contains(&unit.name) {
                    kinds.push(unit.name.clone());
                }
            }
            kinds.iter().flat_map(|kind| of(kind)).collect()
        };
        assert_eq!(serde_json::from_str::<Vec<String>>(&shown).expect("cells"), percents(&|unit| unit.total));
        page.value("document.querySelector('button[data-heat=\"2\"]').click()");
        let shown = page.value(
            "JSON.stringify([...document.querySelectorAll('#heat td[data-total]')] \
             .map(c => c.querySelector('b').textContent))",
        );
        assert_eq!(serde_json::from_str::<Vec<String>>(&shown).expect("cells"), percents(&|unit| unit.by_operation[2]));
        // The positions of all jobs as the script computes them.
        let jobs = page.value(
            "JSON.stringify(model.jobs.map(j => ({ operation: j.operation, owner: j.owner, accepted: j.accepted, \
             entered: j.enters.slice(0, -1), left: j.left ? j.gone - 1 : null })))",
        );
        let jobs: Vec<raypath_timing::report::JobTrace> = serde_json::from_str(&jobs).expect("jobs");
        assert!(jobs == recording.window.jobs);
        let size = "i => i.complete && [i.naturalWidth, i.naturalHeight].join()";
        assert_eq!(page.value(&format!("({size})(document.querySelector('#image img'))")), "5,3");
        assert_eq!(page.value(&format!("({size})(document.querySelector('#sweep img'))")), "40,30");
        assert_eq!(page.value("document.querySelectorAll('section.table tbody tr').length"), "2");
        page.assert_console_empty();
    }
}

#[test]
fn the_timeline_zooms_moves_and_shows_tips() {
    let recording = common::recording(Control::Skid, 2000, 0.15);
    let page = Page::open(&html(&recording));
    let (start, drawn) = (page.range(), page.pixels());
    let wheel = |delta: i32| {
        page.at_canvas(&format!("c.dispatchEvent(new WheelEvent('wheel', {{ ...at(400, 200), deltaY: {delta} }}))"));
        page.range()
    };
    let closer = wheel(-300);
    assert!(closer.1 - closer.0 < start.1 - start.0, "{start:?} {closer:?}");
    assert_ne!(page.pixels(), drawn);
    // Zooming keeps the cycle below the pointer, so zooming out restores the view.
    assert_eq!(wheel(300), start);
    assert_eq!(page.pixels(), drawn);
    for _ in 0..30 {
        wheel(300);
    }
    let (first, end) = (recording.window.first, recording.window.end);
    assert_eq!(page.range(), (first, end));

    page.at_canvas("c.dispatchEvent(new MouseEvent('dblclick', at(400, 200)))");
    assert_eq!((page.range(), page.pixels()), (start, drawn.clone()));
    page.at_canvas(
        "c.dispatchEvent(new PointerEvent('pointerdown', at(600, 200))); \
         c.dispatchEvent(new PointerEvent('pointermove', at(240, 200))); \
         c.dispatchEvent(new PointerEvent('pointerup', at(240, 200)))",
    );
    // 360 pixels are 20 cycles of 18 pixels.
    assert_eq!(page.range().0, start.0 + 20);
    for (key, forward) in [("ArrowRight", true), ("ArrowLeft", false)] {
        let before = page.range().0;
        page.at_canvas(&format!("c.dispatchEvent(new KeyboardEvent('keydown', {{ key: '{key}', bubbles: true }}))"));
        assert_eq!(page.range().0 > before, forward, "{key}");
    }
    page.value("document.getElementById('reset').click()");
    page.value("document.getElementById('zoom-in').click()");
    assert!(page.range().1 < start.1);
    page.value("document.getElementById('all').click()");
    assert_eq!(page.range(), (first, end));
    page.value("document.getElementById('reset').click()");

    // The first row, in the cycle after acceptance of the first job: the view starts one cycle earlier, after 132
    // pixels of labels.
    let job = &recording.window.jobs[0];
    page.at_canvas("c.dispatchEvent(new PointerEvent('pointermove', at(132 + 18 * 2 + 9, 35 + 22)))");
    let tip = page.value("document.getElementById('tip').innerText");
    let name = &recording.operations[job.operation];
    assert!(tip.starts_with(&format!("{name}, ray {}\n", job.owner)), "{tip}");
    assert!(tip.contains(&format!("accepted in cycle {}", job.accepted)), "{tip}");
    assert!(tip.contains(&format!("▸ stage 1: cycle {}", job.entered[0])), "{tip}");
    assert!(tip.contains(&format!("left in cycle {}", job.left.expect("it left"))), "{tip}");

    let by_job = page.pixels();
    page.value("document.getElementById('by-stage').click()");
    assert_ne!(page.pixels(), by_job);
    page.assert_console_empty();
}

#[test]
fn windows_of_all_sizes_are_drawn() {
    for jobs in [1, 100, 20_000] {
        let recording = common::recording(Control::Skid, jobs, 0.15);
        assert_eq!(recording.window.jobs.len(), jobs);
        let (page, mut drawn) = (Page::open(&html(&recording)), 0);
        for button in ["all", "reset", "by-stage", "all", "later", "stall", "by-job"] {
            let before = page.pixels();
            page.value(&format!("document.getElementById('{button}').click()"));
            drawn += u32::from(page.pixels() != before);
        }
        assert!(drawn > 1, "{jobs} jobs: {drawn} of the buttons changed the picture");
        page.assert_console_empty();
    }
}

#[test]
fn text_from_files_is_not_executed() {
    let hostile = |field: &str| {
        format!(
            "</script><!--<script>window.ran='{field}'</script><img src=x onerror=\"window.ran='{field}'\">'\"&amp;"
        )
    };
    let mut recording = common::recording(Control::Skid, 100, 0.15);
    recording.title = hostile("title");
    recording.configuration = vec![(hostile("name"), hostile("value"))];
    recording.counts = vec![(hostile("label"), hostile("count"))];
    recording.operations = (0..4).map(|_| hostile("operation")).collect();
    recording.window.owner = hostile("owner");
    recording.utilisation[0].titles[0] = hostile("does");
    recording.utilisation[0].units[0].name = hostile("unit");
    recording.sweep =
        Some(format!("<svg xmlns=\"http://www.w3.org/2000/svg\"><script>window.ran='svg'</script>{SWEEP}</svg>"));
    recording.tables[0].title = hostile("table");
    recording.tables[0].rows[0][0] = hostile("cell");
    if let Some(image) = &mut recording.image {
        image.title = hostile("image");
    }
    let page = Page::open(&html(&recording));
    page.at_canvas("c.dispatchEvent(new PointerEvent('pointermove', at(132 + 18 * 2 + 9, 35 + 22)))");
    assert!(page.value("document.getElementById('tip').innerText").starts_with("</script><!--"));
    assert_eq!(page.value("window.ran"), "undefined");
    assert_eq!(page.value("document.querySelector('h1').textContent"), recording.title);
    assert_eq!(page.value("document.querySelectorAll('script').length"), "5");
    assert_eq!(page.value("document.querySelectorAll('#configuration td')[0].textContent"), hostile("value"));
    assert_eq!(page.value("model.owner"), recording.window.owner);
    page.assert_console_empty();
}

/// An empty recording gives a page without sections. The page loads no resources.
#[test]
fn an_empty_recording_is_a_page() {
    let page = Page::open(&html(&Recording { title: "Nothing".to_string(), ..Recording::default() }));
    assert_eq!(page.value("document.querySelectorAll('section').length"), "0");
    assert_eq!(
        page.value("performance.getEntriesByType('resource').filter(e => !e.name.startsWith('data:')).length"),
        "0"
    );
    page.assert_console_empty();
}

/// A check of the tests themselves: console messages are collected.
#[test]
fn console_messages_are_collected() {
    let page = Page::open(&html(&Recording::default()));
    page.value("console.error('a message')");
    page.value("setTimeout(() => nothing.here, 0)");
    page.value("new Promise(done => setTimeout(done, 200))");
    let messages = page.messages().join("\n");
    assert!(messages.contains("a message") && messages.contains("nothing is not defined"), "{messages}");
}

const SWEEP: &str =
    "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"40\" height=\"30\"><rect width=\"9\" height=\"9\"/></svg>";
