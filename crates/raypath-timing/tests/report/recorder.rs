//! The recorder, compared with known positions and with the positions that the model reports.

use crate::report::common::{self, run, shape};
use crate::simulation::common::Cycles;
use raypath_model::{Control, CycleModel, Functional, PipelinePosition};
use raypath_ops::Rules;
use raypath_timing::report::{Recorder, Window};
use raypath_timing::{Environment, PortActivity, Sink, simulate};

#[test]
fn without_stalls_a_job_spends_one_cycle_in_each_stage() {
    for control in [Control::Skid, Control::Credit] {
        let agents = (0..50).map(|seed| common::Walk::new(seed, 3)).filter(|walk| !walk.distances());
        let pipeline = CycleModel::new(Functional::<16, 8>::new(Rules::Paper), &shape(control));
        let mut recorder = Recorder::new("ray", 12, 0, 80);
        let environment = Environment { in_flight: 5, memory_latency: 9, sink: Sink::Always };
        simulate(agents, &environment, pipeline, &mut recorder, &|_| true).expect("runs");
        let window = recorder.window();
        assert_eq!(window.jobs.len(), 80);
        for job in &window.jobs {
            assert_eq!(job.entered, Vec::from_iter(job.accepted + 1..job.accepted + 13));
            assert_eq!((job.left, job.stalls(window.end)), (Some(job.accepted + 12), 0));
        }
        assert!(window.refused.is_empty() && window.stalled.is_empty());
    }
}

fn everything(control: Control, stalls: f64) -> Vec<(PortActivity, Vec<PipelinePosition>)> {
    let agents = (0..400).map(|seed| common::Walk::new(seed, 4));
    let pipeline = CycleModel::new(Functional::<16, 8>::new(Rules::Paper), &shape(control));
    let sink = Sink::Stalls { probability: stalls, seed: 1 };
    let (environment, mut all) =
        (Environment { in_flight: 24, memory_latency: 40, sink }, Cycles::between(0, u64::MAX));
    simulate(agents, &environment, pipeline, &mut all, &|_| true).expect("runs");
    all.seen
}

/// In every cycle the recording has the same jobs in each stage and in its skid buffer as the model.
#[test]
fn recorded_positions_equal_those_of_the_model_in_every_cycle() {
    let mut waits = 0;
    for control in [Control::Skid, Control::Credit] {
        for from in [0, 700] {
            let all = everything(control, 0.4);
            let window: Window = run(control, from, 300, 0.4).1.window();
            assert_eq!((window.first, window.jobs.len()), (from, 300));
            for (cycle, places) in &all[from as usize..window.end as usize] {
                let now = cycle.cycle;
                // Stages of the recorded jobs, oldest first. Jobs accepted before and after them surround them.
                let stage_of = |job: &raypath_timing::report::JobTrace| {
                    let at = job.stays(window.end).position(|(from, until)| (from..until).contains(&now));
                    at.map(|index| index + 1)
                };
                let stages: Vec<usize> = window.jobs.iter().filter_map(stage_of).collect();
                let older = places.len() - stages.len();
                let shown: Vec<usize> = places.iter().map(|place| place.stage).collect();
                let at = shown.windows(stages.len().max(1)).position(|part| part == stages);
                assert!(stages.is_empty() || at.is_some(), "cycle {now}: {shown:?} {stages:?} {older}");
                for (index, place) in places.iter().enumerate() {
                    let beside = index > 0 && places[index - 1].stage == place.stage;
                    assert_eq!(place.waits, beside, "cycle {now}");
                    waits += usize::from(beside);
                }
                let within = |spans: &[raypath_timing::report::Span]| {
                    spans.iter().any(|span| (span.from..span.from + span.cycles).contains(&now))
                };
                assert_eq!(within(&window.refused), cycle.offered.is_some() && !cycle.accepted, "cycle {now}");
                assert_eq!(within(&window.stalled), cycle.output_valid && !cycle.output_taken, "cycle {now}");
            }
            let accepted = all.iter().filter(|(cycle, _)| cycle.accepted && cycle.cycle >= from);
            let accepted: Vec<_> = accepted
                .map(|(cycle, _)| (cycle.cycle, cycle.offered.map(|(kind, owner)| (kind as usize, owner))))
                .collect();
            let recorded = window.jobs.iter().map(|job| (job.accepted, Some((job.operation, job.owner))));
            assert!(recorded.eq(accepted.into_iter().take(300)));
        }
    }
    assert!(waits > 500, "{waits}");
}

/// Jobs leave in order, so the n-th job to leave is the n-th accepted one.
#[test]
fn jobs_leave_when_the_sink_takes_their_outcome() {
    for control in [Control::Skid, Control::Credit] {
        let all = everything(control, 0.4);
        let taken: Vec<u64> =
            all.iter().filter(|(cycle, _)| cycle.output_taken).map(|(cycle, _)| cycle.cycle).collect();
        let window = run(control, 0, 300, 0.4).1.window();
        assert!(window.jobs.iter().map(|job| job.left).eq(taken.iter().take(300).map(|cycle| Some(*cycle))));
        assert_eq!(window.end, taken[299] + 1);
    }
}

#[test]
fn a_recording_survives_json() {
    let recording = common::recording(Control::Skid, 200, 0.3);
    let text = serde_json::to_string(&recording).expect("JSON");
    assert_eq!(serde_json::from_str::<raypath_timing::report::Recording>(&text).expect("a recording"), recording);
    let bad = r#"{"image": {"title": "", "png": "not base64!"}}"#;
    assert!(serde_json::from_str::<raypath_timing::report::Recording>(bad).is_err());
}
