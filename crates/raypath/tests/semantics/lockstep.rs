//! In every cycle the netlist and the cycle-exact model show the same at their ports.

use crate::answers::{model, with_netlist, words};
use crate::random::{mixed_jobs, rng};
use rand::RngExt;
use raypath::model::{Shape, Words};
use raypath::ops::Rules;
use raypath::sim::engine::{CycleEngine, Engine};
use raypath::sim::traffic::{Cycle, Traffic};

fn in_words(count: usize, seed: u64) -> Vec<Words> {
    mixed_jobs(count, seed).iter().map(words).collect()
}

/// Bubbles, stalls, all operations mixed, resets at any time; the input ports also change while no job is offered.
#[test]
fn netlist_and_cycle_model_agree_in_every_cycle() {
    for rules in [Rules::Paper, Rules::Chisel] {
        for seed in 0..4 {
            let cycles = 12_000;
            let jobs = in_words(cycles, 100 + seed);
            let noise = in_words(64, 200 + seed);
            let mut rng = rng(300 + seed);
            let mut traffic = Traffic::random(seed);
            let mut modelled = CycleEngine::new(model(rules), &Shape::default());
            let mut seen = Seen::default();
            with_netlist(rules, |netlist| {
                let mut next = 0;
                for cycle in 0..cycles {
                    if rng.random_bool(0.002) {
                        netlist.reset();
                        modelled.reset();
                        seen.resets += 1;
                    }
                    let Cycle { offers, takes: output_ready, .. } = traffic.next_cycle();
                    let job = if offers { &jobs[next] } else { &noise[rng.random_range(0..noise.len())] };
                    netlist.present(job);
                    modelled.present(job);
                    let shown = netlist.cycle(offers, output_ready);
                    assert_eq!(shown, modelled.cycle(offers, output_ready), "cycle {cycle}, seed {seed}, {rules}");
                    if let Some(outcome) = &shown.output {
                        let improper = netlist.improper_outputs(outcome);
                        assert!(improper.is_empty(), "cycle {cycle}: {improper:?} with {outcome:?}");
                    }
                    next += usize::from(offers && shown.input_ready);
                    seen.accepted += usize::from(offers && shown.input_ready);
                    seen.refused += usize::from(!shown.input_ready);
                    seen.held += usize::from(shown.output.is_some() && !output_ready);
                    seen.left += usize::from(shown.output.is_some() && output_ready);
                }
            });
            let Seen { resets, accepted, refused, held, left } = seen;
            assert!(resets > 5 && accepted > 2000 && refused > 500 && held > 1000 && left > 2000, "{seen:?}");
        }
    }
}

#[derive(Debug, Default)]
struct Seen {
    resets: usize,
    accepted: usize,
    refused: usize,
    held: usize,
    left: usize,
}

/// A reset in the cycle of each handshake, and several resets in a row.
#[test]
fn resets_at_every_moment_of_a_burst() {
    let jobs = in_words(64, 5);
    for moment in 0..50 {
        let mut modelled = CycleEngine::new(model(Rules::Paper), &Shape::default());
        with_netlist(Rules::Paper, |netlist| {
            let mut next = 0;
            for cycle in 0..90 {
                if cycle == moment || cycle == moment + 1 || cycle == moment + 20 {
                    netlist.reset();
                    modelled.reset();
                }
                let output_ready = cycle % 3 != 0 && !(15..30).contains(&cycle);
                netlist.present(&jobs[next]);
                modelled.present(&jobs[next]);
                let shown = netlist.cycle(cycle < 60, output_ready);
                assert_eq!(shown, modelled.cycle(cycle < 60, output_ready), "cycle {cycle}, reset at {moment}");
                next += usize::from(cycle < 60 && shown.input_ready);
            }
        });
    }
}
