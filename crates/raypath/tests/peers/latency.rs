//! The latency at the netlist's ports, in the cycle-exact model, and in the printed text is the same.
//!
//! Known bug, without a published source: a model with another latency than the hardware, so that a simulated system
//! fails as hardware. The item `configurations` compares both in every cycle; here each is measured alone and compared
//! with the latency in the head of the printed text.
//!
//! Mutation: `latency + 1` in `raypath-model/src/shape.rs` or `raypath_sim::engine::shape`; a number in `datapath.rs`'s
//! text.

use raypath::model::Words;
use raypath::ops::JobKind;
use raypath::rtl::{Config, Control, DatapathNetlist, PRESETS, UnitLatency};
use raypath::sim;
use raypath::sim::engine::{CycleEngine, Engine, NetlistEngine};
use raypath::sim::jobs::random;

#[test]
fn every_preset() {
    for preset in PRESETS {
        measure(preset.config);
    }
}

#[test]
fn every_control_and_unit_latency() {
    for &control in Control::ALL {
        for unit_latency in UnitLatency::REPRESENTATIVES {
            let config = Config::DEFAULT.control(control).unit_latency(unit_latency);
            measure(config);
        }
    }
}

fn measure(config: Config) {
    let model = sim::Datapath::paper(config).model();
    let datapath = DatapathNetlist::new(config).expect("a datapath");
    let mut netlist = NetlistEngine::of(model.clone(), config, &datapath, |_| false).expect("a netlist");
    let mut modelled = CycleEngine::new(model.clone(), netlist.shape());
    let printed = datapath.top().doc().join("\n");
    for &kind in config.kinds() {
        let job = random(&model, config.semantics.format, 5, &[kind]).next().expect("an endless stream");
        let [hardware, software] = [&mut netlist as &mut dyn Engine, &mut modelled].map(|engine| {
            let alone = alone(engine, &job);
            (alone, apart(engine, &job))
        });
        assert_eq!(hardware, software, "{config}, {kind}: latency and distance of jobs");
        let (latency, apart) = hardware;
        assert!(printed.contains(&format!("latency {latency},")), "{config}, {kind}: {latency} in {printed}");
        let sums = matches!(kind, JobKind::Euclidean | JobKind::Angular);
        let unit_latency = config.microarchitecture.unit_latency;
        assert_eq!(apart, if sums { unit_latency.sums as usize } else { 1 }, "{config}, {kind}");
        assert!(if unit_latency == UnitLatency::ONE { latency == 12 } else { latency > 12 }, "{config}: {latency}");
    }
}

/// Cycles from the one that accepts a job, in an empty pipeline, to the one that shows its outcome.
fn alone(engine: &mut dyn Engine, job: &Words) -> usize {
    engine.reset();
    engine.present(job);
    let shown = engine.cycle(true, true);
    assert!(shown.input_ready && shown.output.is_none());
    (1..200).find(|_| engine.cycle(false, true).output.is_some()).expect("an outcome")
}

/// Cycles from one outcome to the next if the source always offers and the sink is always ready.
fn apart(engine: &mut dyn Engine, job: &Words) -> usize {
    engine.reset();
    engine.present(job);
    let shown: Vec<usize> = (0..300).filter(|_| engine.cycle(true, true).output.is_some()).collect();
    let apart = shown[1] - shown[0];
    assert!(shown.windows(2).all(|pair| pair[1] - pair[0] == apart), "always the same: {shown:?}");
    apart
}
