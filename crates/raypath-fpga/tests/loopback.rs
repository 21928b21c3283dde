//! Jobs through the shell, as a host sends and receives them.
//!
//! Known bugs of such shells, without a published source: a word that is lost or doubled when a stream stalls, bytes in
//! another order than the host's, and a port that is cut at a word.
//!
//! Mutations: `full_q` set a word early; `sends` without `ready_i`; the words of a number exchanged in `Frame::encode`.

use raypath_fpga::{Comparison, Host, Shell, StreamWidth};
use raypath_hdl::Simulator;
use raypath_model::Model;
use raypath_rtl::{Config, Control, Encoding, Lanes, Multiplier, UnitLatency};
use raypath_sim::{Datapath, Words, jobs};
use raypath_tools::{Options, Sources, VerilatedStream};

struct Case {
    config: Config,
    properties: String,
    shell: Shell,
    jobs: Vec<Words>,
    outcomes: Vec<Words>,
}

/// Jobs of all operations in numbers of 33 bits at most, and their outcomes.
fn case(config: Config, width: StreamWidth, count: usize) -> Case {
    let datapath = Datapath::paper(config);
    let elaborated = datapath.elaborate().expect("a datapath");
    let shell = Shell::new(elaborated.top(), width).expect("a shell");
    let jobs: Vec<Words> = jobs::any_jobs(datapath.model(), 5).take(count).collect();
    let mut model = datapath.model();
    let outcomes = jobs.iter().map(|job| model.run(job)).collect();
    Case { config, properties: elaborated.properties().to_string(), shell, jobs, outcomes }
}

/// The smallest number format, whose datapath compiles fast.
fn small() -> Config {
    Config::DEFAULT.format("e3s3".parse().expect("a format")).multiplier(Multiplier::Inferred)
}

/// The bytes that the simulated shell sends for these bytes, with stalls on both sides.
fn simulate(shell: &Shell, bytes: &[u8], count: usize) -> Vec<u8> {
    let word = shell.job.width.bits() as usize / 8;
    let mut simulator = Simulator::new(&shell.top).expect("a simulator");
    simulator.restart_randomly(7);
    let input = |name| simulator.input(name).expect("an input");
    let output = |name| simulator.output(name).expect("an output");
    let [data, valid, ready] = ["data_i", "valid_i", "ready_i"].map(input);
    let [data_out, valid_out, ready_out] = ["data_o", "valid_o", "ready_o"].map(output);
    simulator.set_reset(true);
    simulator.cycle();
    simulator.set_reset(false);
    let mut words = bytes.chunks(word).map(|word| word.iter().rev().fold(0, |all, &byte| all << 8 | u64::from(byte)));
    let mut offered = words.next();
    let mut sent = Vec::new();
    let mut random = 1_u32;
    // Stalls take three of four cycles. A shell that loses a word never ends.
    for _ in 0..20 * (bytes.len() + count) {
        if sent.len() == count {
            break;
        }
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let (offers, takes) = (offered.is_some() && random >> 31 == 1, random >> 30 & 1 == 1);
        simulator.set(data, offered.unwrap_or(0));
        simulator.set(valid, offers.into());
        simulator.set(ready, takes.into());
        simulator.cycle();
        if offers && simulator.get(ready_out) == 1 {
            offered = words.next();
        }
        if takes && simulator.get(valid_out) == 1 {
            sent.extend(&simulator.get(data_out).to_le_bytes()[..word]);
        }
    }
    sent
}

#[test]
fn the_simulated_shell_answers_as_the_model() {
    let configs = [
        small(),
        small().lanes(Lanes::Two).io(Encoding::Recoded).tag(9).control(Control::Credit),
        Config::DEFAULT.lanes(Lanes::None).io(Encoding::Recoded).unit_latency(UnitLatency::TWO),
    ];
    for config in configs {
        for width in [StreamWidth::Eight, StreamWidth::ThirtyTwo] {
            let Case { shell, jobs, outcomes, .. } = case(config, width, 60);
            let host = Host::new(&shell, config);
            let bytes: Vec<u8> = jobs.iter().flat_map(|job| host.job(job)).collect();
            let answer = simulate(&shell, &bytes, outcomes.len() * shell.outcome.bytes());
            let found = host.compare(&jobs, &outcomes, Vec::new(), answer.as_slice()).expect("streams in memory");
            assert_eq!(found, Comparison { received: 60, ..Comparison::default() }, "{config}, {width} bits");
        }
    }
}

/// A wrong bit is reported with its port, and missing outcomes by their number.
#[test]
fn the_host_reports_what_differs() {
    let Case { config, shell, jobs, outcomes, .. } = case(small().lanes(Lanes::None), StreamWidth::Eight, 3);
    let host = Host::new(&shell, config);
    let mut bytes: Vec<u8> = outcomes.iter().flat_map(|outcome| host.outcome(outcome)).collect();
    let (frame, fields) = (shell.outcome.bytes(), &shell.outcome.fields);
    bytes[frame + 1] ^= 1;
    bytes.truncate(2 * frame + 4);
    let found = host.compare(&jobs, &outcomes, Vec::new(), bytes.as_slice()).expect("streams in memory");
    assert_eq!((found.received, found.different), (2, 1));
    let [difference] = &found.differences[..] else { panic!("{found:?}") };
    assert!(difference.starts_with(&format!("job 1: {} is ", fields[1].port)), "{difference}");
}

/// The same bytes as for a board go through pipes to the shell in Verilator, with the assertions of the datapath bound,
/// and the linters report nothing about it.
#[test]
fn verilator_answers_as_the_model() {
    let config = small().lanes(Lanes::None);
    let Case { properties, shell, jobs, outcomes, .. } = case(config, StreamWidth::Eight, 300);
    let folder = tempfile::tempdir().expect("a folder");
    let mut sources = Sources::write(&shell.top, folder.path()).expect("files");
    sources.lint().unwrap_or_else(|fault| panic!("{fault}"));
    sources.add(folder.path().join("raypath_properties.sv"), &properties).expect("the assertions");
    let options = Options::default();
    let stream = VerilatedStream::build(&sources.files, &shell.top, folder.path(), &options).expect("Verilator");
    let host = Host::new(&shell, config);
    let found = stream.run(1, |to, from| host.compare(&jobs, &outcomes, to, from)).expect("the program runs");
    assert_eq!(found, Comparison { received: 300, ..Comparison::default() });
}
