//! The golden vectors, recorded from the original hardware, in every engine, order and handshake pattern.

use crate::recorded::golden;
use raypath::model::{Shape, WordModel, Words};
use raypath::ops::Rules;
use raypath::rtl::{Config, Control, Encoding, Multiplier, Sharing, UnitLatency};
use raypath::sim::Datapath;
use raypath::sim::engine::{CycleEngine, Engine, NetlistEngine, Run, drive, evaluate};
use raypath::sim::traffic::{Traffic, interleave};
use raypath::sim::transactions::Transaction;

const CHISEL: Config = Config::DEFAULT.rules(Rules::Chisel);

fn model() -> WordModel {
    Datapath::paper(CHISEL).model()
}

/// The stream as recorded, and with the operations interleaved.
fn orders() -> [(&'static str, Vec<Transaction>); 2] {
    let recorded = golden();
    let mixed = interleave(recorded.clone(), |transaction| transaction.job.kind().opcode(), 5);
    assert_ne!(recorded, mixed);
    [("recorded", recorded), ("interleaved", mixed)]
}

/// Runs a stream and checks the order and every outcome.
fn check(what: &str, stream: &[Transaction], run: impl FnOnce(&mut dyn FnMut(usize, Words) -> bool) -> Run) -> Run {
    let mut mismatches = 0;
    let run = run(&mut |index, outcome| {
        let transaction = &stream[index];
        if outcome != transaction.expected {
            mismatches += 1;
            if mismatches <= 3 {
                eprintln!("{what}, seq {:06x}: {outcome:?}, recorded {:?}", transaction.seq, transaction.expected);
            }
        }
        true
    });
    assert_eq!((run.jobs, mismatches), (stream.len(), 0), "{what}: jobs, mismatches");
    run
}

#[test]
fn functional_model_answers_as_the_original() {
    for (order, stream) in orders() {
        check(order, &stream, |each| evaluate(model(), stream.iter().map(|t| &t.job), each));
    }
}

/// Runs all orders through new engines, under two handshake patterns.
fn check_engine(seed: u64, new: impl Fn() -> Box<dyn Engine>) {
    for (order, stream) in orders() {
        for (handshake, mut traffic) in [("always", Traffic::always()), ("random", Traffic::random(seed))] {
            let (what, jobs) = (format!("{order}, {handshake}"), stream.iter().map(|t| &t.job));
            let run = check(&what, &stream, |each| drive(new().as_mut(), jobs, &mut traffic, each));
            let least = stream.len() as u64 + 12;
            assert!(if handshake == "always" { run.cycles == least } else { run.cycles > 2 * least }, "{run:?}");
        }
    }
}

#[test]
fn cycle_model_answers_as_the_original() {
    check_engine(2, || Box::new(CycleEngine::new(model(), &Shape::default())));
}

#[test]
fn netlist_answers_as_the_original() {
    check_engine(3, || Box::new(NetlistEngine::new(model(), CHISEL, |_| false).expect("a datapath")));
}

/// Every microarchitecture gives the original's outcomes.
#[test]
fn netlists_of_other_microarchitectures_answer_as_the_original() {
    let [_, (order, stream)] = orders();
    let configs = [
        CHISEL.io(Encoding::Recoded).registers(Encoding::Ieee).sharing(Sharing::Segregated),
        CHISEL.registers(Encoding::Ieee).control(Control::Credit),
        CHISEL.unit_latency(UnitLatency::TWO),
        CHISEL.unit_latency(UnitLatency::THREE).control(Control::Credit),
        CHISEL.unit_latency(UnitLatency::TWO).multiplier(Multiplier::Inferred),
    ];
    for config in configs {
        let mut engine = NetlistEngine::new(model(), config, |_| false).expect("a datapath");
        let jobs = stream.iter().map(|t| &t.job);
        let mut traffic = Traffic::random(4);
        check(&format!("{order}, {config}"), &stream, |each| drive(&mut engine, jobs, &mut traffic, each));
    }
}
