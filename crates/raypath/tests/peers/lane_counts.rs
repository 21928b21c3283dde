//! Unusual numbers of lanes are either rejected or computed correctly.
//!
//! Known bug: Spatz's reductions ran two rounds for any number of lanes, so that 8 lanes gave wrong sums (pull request
//! 86); its tests had 2 and 4 lanes. The effect here would be a sum without some of its lanes.
//!
//! Mutation: a level fewer in the tree of `raypath-ops/src/distance.rs`; a value more in `Lanes`.

use raypath::model::Words;
use raypath::ops::JobKind;
use raypath::rtl::{Config, Lanes};
use raypath::sim::Datapath;
use raypath::sim::configuration::{parse, parse_sweep};
use raypath::sim::engine::{NetlistEngine, drive};
use raypath::sim::traffic::Traffic;
use std::path::Path;

#[test]
fn unlisted_numbers_of_lanes_are_refused_from_every_source() {
    let expected = "expected none, 2, 4, 8, 16, 32 or 64";
    for lanes in
        ["0", "1", "3", "5", "6", "7", "12", "15", "17", "24", "48", "63", "65", "128", "-2", "2.0", "0x2", "٢"]
    {
        let refused = lanes.parse::<Lanes>().map(Lanes::count).expect_err(lanes).to_string();
        assert_eq!(refused, format!("'{lanes}' is not a valid number of lanes, {expected}"));
        let text = format!("lanes = '{lanes}'");
        for message in [
            parse(&text, Path::new("a.toml")).expect_err(lanes).to_string(),
            parse_sweep(&text, Path::new("a.toml")).expect_err(lanes).to_string(),
        ] {
            assert!(message.starts_with("a.toml:1: lanes: ") && message.ends_with(expected), "{message}");
        }
    }
    assert!(Lanes::ALL.iter().all(|lanes| *lanes == Lanes::None || lanes.count().is_power_of_two()));
}

/// Each lane alone, in the netlist: 2 in lane i of a and 1 in lane i of b give 1 and 2 for every i; beats of all lanes
/// give n times as much. With two lanes an angular beat has one.
#[test]
fn every_lane_of_every_number_of_lanes_counts_once() {
    for &lanes in Lanes::ALL.iter().filter(|lanes| **lanes != Lanes::None) {
        let config = Config::DEFAULT.lanes(lanes);
        let (lanes, model) = (lanes.count(), Datapath::paper(config).model());
        let mut netlist = NetlistEngine::new(model.clone(), config, |_| false).expect("a netlist");
        for (kind, lanes, each) in [(JobKind::Euclidean, lanes, [1.0, 1.0]), (JobKind::Angular, lanes / 2, [2.0, 1.0])]
        {
            let kind = model.kind(kind.name()).expect("a distance operation");
            let beat = |mask: u64| {
                model.job(kind, |port| match port {
                    "euclidean_mask" => mask,
                    "euclidean_reset_accum" => 1,
                    port if port.starts_with("euclidean_a") => 2f32.to_bits().into(),
                    _ => 1f32.to_bits().into(),
                })
            };
            let all = u64::MAX >> (64 - lanes);
            let masks: Vec<u64> = (0..lanes).map(|lane| 1 << lane).chain([all, 0]).collect();
            let jobs: Vec<Words> = masks.iter().map(|&mask| beat(mask)).collect();
            let mut seen = 0;
            drive(&mut netlist, jobs.iter(), &mut Traffic::always(), |index, outcome| {
                let sums: Vec<f32> = outcome
                    .ports()
                    .iter()
                    .filter(|port| !port.name.ends_with("reset_accum"))
                    .map(|port| f32::from_bits(port.bits as u32))
                    .collect();
                let times = masks[index].count_ones() as f32;
                let expected: Vec<f32> = each[..sums.len()].iter().map(|sum| sum * times).collect();
                assert_eq!(sums, expected, "{kind}, {lanes} lanes, mask {:x}", masks[index]);
                seen += 1;
                true
            });
            assert_eq!(seen, lanes + 2);
        }
    }
}
