//! Operand isolation: with clock gates, the operands of adders and multipliers that a job does not use are zeros.

use raypath_ops::JobKind;
use raypath_rtl::Config;
use raypath_sim::Datapath;
use raypath_sim::engine::{Engine, NetlistEngine};
use raypath_sim::jobs::random;

/// Cycles after which only jobs of the stream are in the pipeline.
const FILLED: usize = 20;

/// The words that the isolated operands of a stage have had in a stream of jobs of one kind, by the operand's name.
fn operands(config: Config, kind: JobKind, stage: &str) -> Vec<(String, Vec<u64>)> {
    let model = Datapath::paper(config).model();
    let is_operand = |name: &str| name.contains(stage) && name.ends_with("_or_zero");
    let mut netlist = NetlistEngine::new(model.clone(), config, is_operand).expect("a netlist");
    // Units have signals of such names, too, of one bit.
    let width = config.semantics.format.recoded_width();
    let probes = netlist.simulator().probes().filter(|(name, bits, _)| is_operand(name) && *bits == width);
    let probes: Vec<_> = probes.map(|(name, _, probe)| (name.to_string(), probe)).collect();
    let mut words = vec![Vec::new(); probes.len()];
    netlist.reset();
    for (cycle, job) in random(&model, config.semantics.format, 3, &[kind]).take(200).enumerate() {
        netlist.present(&job);
        netlist.cycle(true, true);
        if cycle >= FILLED {
            words.iter_mut().zip(&probes).for_each(|(words, (_, probe))| words.push(netlist.simulator().peek(*probe)));
        }
    }
    probes.into_iter().map(|(name, _)| name).zip(words).collect()
}

/// By Table VII, boxes have neither a sum in stage 4 nor a product in stage 5.
#[test]
fn boxes_leave_the_units_of_other_operations_still() {
    let gated = Config::DEFAULT.clock_gating(true);
    for (stage, least) in [("stage_4", 12), ("stage_5", 12)] {
        let of_boxes = operands(gated, JobKind::Quadbox, stage);
        assert!(of_boxes.len() >= least, "{stage}: {of_boxes:?}");
        for (name, words) in of_boxes {
            assert!(words.iter().all(|&word| word == 0), "{name}: {words:x?}");
        }
        let of_triangles = operands(gated, JobKind::Triangle, stage);
        let used = of_triangles.iter().filter(|(_, words)| words.iter().any(|&word| word != 0));
        assert!(used.count() >= least, "{stage}: {of_triangles:?}");
        assert!(operands(Config::DEFAULT, JobKind::Quadbox, stage).is_empty(), "{stage}");
    }
}
