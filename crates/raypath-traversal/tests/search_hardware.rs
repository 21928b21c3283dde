//! The hardware of searches against their functional model, with random memories and datapaths that stall.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_hdl::Simulator;
use raypath_ops::{Angular, AngularState, Binary32, Euclidean, EuclideanState, Operation, Rounding, from_words};
use raypath_rtl::Config;
use raypath_tools::Sources;
use raypath_traversal::search::{
    Elements, Place, SearchImage, SearchJob, SearchMetric, SearchParameters, SearchStatus, VectorLayout, search,
};
use raypath_traversal::{Memory, SearchPorts, UnitNetlist, UnitParameters, search_engine};
use std::collections::{HashMap, VecDeque};

const LANES: usize = 16;

/// What a bench does besides the jobs.
#[derive(Clone, Copy)]
struct Traffic {
    seed: u64,
    latency: u64,
    /// One in so many cycles, a channel is not ready; 0: never.
    stalls: u32,
    memory_width: u32,
}

/// A result: status, found, index and the distance's bits.
type Found = (u64, u64, u64, u32);

/// Runs jobs through the hardware. Returns the results by the number of the job, and the cycles.
fn run(
    image: &SearchImage,
    jobs: &[u32],
    parameters: SearchParameters,
    Traffic { seed, latency, stalls, memory_width }: Traffic,
) -> (HashMap<u64, Vec<Found>>, u64) {
    let ports = SearchPorts { memory_width, address_width: 40, id_width: 16, divider_latency: 11 };
    let module = search_engine(parameters, ports).expect("the engine");
    let mut simulator = Simulator::new(&module).expect("a simulator");
    simulator.restart_randomly(seed);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let input = |simulator: &Simulator, name: &str| simulator.input(name).expect("an input");
    let mut results: HashMap<u64, Vec<Found>> = HashMap::new();
    let (mut next_job, mut done, mut cycles) = (0, 0, 0_u64);
    let mut responses: Vec<(u64, u32, u64, u32)> = Vec::new();
    let mut outcomes: VecDeque<(u64, [u32; 3])> = VecDeque::new();
    let mut euclidean = EuclideanState::zero(Binary32);
    let mut angular = AngularState::zero(Binary32);
    let beats = 512 / memory_width;
    while done < jobs.len() {
        cycles += 1;
        assert!(cycles < 2_000_000, "the engine does not end: {done} of {} jobs", jobs.len());
        let mut ready = || u64::from(stalls == 0 || !random.random_range(0..stalls.max(1)).eq(&0));
        let channels = ["search_valid_i", "result_ready_i", "vec_req_ready_i", "beat_ready_i"].map(|name| {
            let value = ready();
            let port = input(&simulator, name);
            simulator.set(port, value);
            value
        });
        let offers = channels[0] == 1 && next_job < jobs.len();
        for (name, value) in [
            ("search_valid_i", u64::from(offers)),
            ("search_id_i", next_job as u64),
            ("search_job_i", jobs.get(next_job).copied().unwrap_or(0).into()),
            ("search_base_i", 0),
        ] {
            let port = input(&simulator, name);
            simulator.set(port, value);
        }
        // A beat of any block that is due.
        let due: Vec<usize> = (0..responses.len()).filter(|k| responses[*k].0 <= cycles).collect();
        let chosen = due.first().map(|first| if stalls == 0 { *first } else { due[random.random_range(0..due.len())] });
        let port = input(&simulator, "vec_rsp_valid_i");
        simulator.set(port, u64::from(chosen.is_some()));
        if let Some(chosen) = chosen {
            let (_, tag, address, beat) = responses[chosen];
            let block = image.block(address, 64);
            let bytes = block.unwrap_or(&[0; 64]);
            let part = &bytes[(beat * memory_width / 8) as usize..][..memory_width as usize / 8];
            for (k, word) in part.as_chunks::<4>().0.iter().enumerate() {
                let port = input(&simulator, &format!("vec_rsp_data_{k}_i"));
                simulator.set(port, u32::from_le_bytes(*word).into());
            }
            for (name, value) in [("tag", u64::from(tag)), ("error", u64::from(block.is_err() && beat == 0))] {
                let port = input(&simulator, &format!("vec_rsp_{name}_i"));
                simulator.set(port, value);
            }
            if beat + 1 == beats { _ = responses.remove(chosen) } else { responses[chosen].3 += 1 }
        }
        let outcome = outcomes.front().filter(|outcome| outcome.0 <= cycles).copied();
        let port = input(&simulator, "outcome_valid_i");
        simulator.set(port, outcome.is_some().into());
        if let Some((_, sums)) = outcome {
            outcomes.pop_front();
            for (name, value) in ["squares", "dot", "norm"].into_iter().zip(sums.map(u64::from)) {
                let port = input(&simulator, &format!("outcome_{name}_i"));
                simulator.set(port, value);
            }
        }
        simulator.settle();
        let get = |name: &str| simulator.get(simulator.output(name).expect("an output"));
        if offers && get("search_ready_o") == 1 {
            next_job += 1;
        }
        if get("result_valid_o") == 1 && channels[1] == 1 {
            let rows = results.entry(get("result_id_o")).or_default();
            if get("result_found_o") == 1 {
                assert_eq!(get("result_rank_o"), rows.len() as u64);
            }
            let is_last = get("result_last_o") == 1;
            let status = if is_last { get("result_status_o") } else { 0 };
            rows.push((status, get("result_found_o"), get("result_index_o"), get("result_distance_o") as u32));
            done += usize::from(is_last);
        }
        if get("vec_req_valid_o") == 1 && channels[2] == 1 {
            let wait = if stalls == 0 { latency } else { random.random_range(1..=latency) };
            responses.push((cycles + wait, get("vec_req_tag_o") as u32, get("vec_req_addr_o"), 0));
        }
        if get("beat_valid_o") == 1 && channels[3] == 1 {
            let (code, is_last) = (get("beat_is_angular_o"), get("beat_is_last_o"));
            let beat = |lanes: usize| {
                let lane = |stem: &'static str| (0..lanes).map(move |k| format!("beat_{stem}_{k}_o"));
                let mask: u64 = lane("mask").enumerate().map(|(k, name)| get(&name) << k).sum();
                lane("a").chain(lane("b")).map(|name| get(&name)).chain([mask, is_last]).collect::<Vec<u64>>()
            };
            let sums = if code == 0 {
                let operation = Euclidean::<LANES> { rounding: Rounding::Unit };
                let (out, next) = operation.run(Binary32, from_words(Binary32, &beat(LANES)), euclidean);
                euclidean = next;
                [f32::from(out.euclidean_accumulator).to_bits(), random.random(), random.random()]
            } else {
                let operation = Angular::<{ LANES / 2 }> { rounding: Rounding::Unit };
                let (out, next) = operation.run(Binary32, from_words(Binary32, &beat(LANES / 2)), angular);
                angular = next;
                let sums = [out.angular_dot_product, out.angular_norm].map(|sum| f32::from(sum).to_bits());
                [random.random(), sums[0], sums[1]]
            };
            if is_last == 1 {
                outcomes.push_back((cycles + 12, sums));
            }
        }
        simulator.cycle();
    }
    (results, cycles)
}

fn jobs_of(seed: u64, image: &mut SearchImage) -> Vec<u32> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut jobs = Vec::new();
    for _ in 0..40 {
        let elements =
            [Elements::Binary32, Elements::Binary16, Elements::Int8 { scale: 0.25 }][random.random_range(0..3)];
        let dimensions = [1, 3, 8, 16, 17, 31, 40, 64, 65, 100][random.random_range(0..10)];
        let count = random.random_range(0..120);
        let layout = VectorLayout { elements, dimensions };
        let mut numbers = |count: u32| -> Vec<f32> {
            (0..count * dimensions).map(|_| f32::from(random.random_range(-9_i8..=9)) * 0.25).collect()
        };
        let (rows, query) = (numbers(count), numbers(1));
        let vectors = image.vectors(layout, &rows).expect("vectors");
        let query = image.vectors(layout, &query).expect("a query");
        let metric = [SearchMetric::Euclidean, SearchMetric::Dot, SearchMetric::Cosine][random.random_range(0..3)];
        let place = match random.random_range(0..4) {
            0 => Place::Scan,
            1 => {
                let len = random.random_range(0..70);
                let list: Vec<u32> = (0..len).map(|_| random.random_range(0..count + 20)).collect();
                let list = image.lists(len, [&list[..]].into_iter()).expect("a list");
                Place::Gather { list, len }
            }
            _ => {
                let degree = random.random_range(0..40);
                let lists: Vec<Vec<u32>> =
                    (0..count).map(|_| (0..degree).map(|_| random.random_range(0..count + 3)).collect()).collect();
                let neighbours = image.lists(degree, lists.iter().map(Vec::as_slice)).expect("a graph");
                let entry_count = random.random_range(0..20);
                let entries: Vec<u32> = (0..entry_count).map(|_| random.random_range(0..count + 3)).collect();
                let entries = image.lists(entry_count, [&entries[..]].into_iter()).expect("a list");
                let expansions = [0, 1, 5, 1000][random.random_range(0..4)];
                Place::Graph {
                    neighbours,
                    degree,
                    entries,
                    entry_count,
                    candidates: random.random_range(12..=64),
                    expansions,
                }
            }
        };
        let bound = if random.random_range(0..4) == 0 { 2.0 } else { f32::INFINITY };
        // Some jobs are refused, and some read behind the memory.
        let (k, count) = match random.random_range(0..8) {
            0 => (0, count),
            1 => (5, count + 1_000_000),
            _ => (random.random_range(1..=12), count),
        };
        let job =
            SearchJob { metric, elements, dimensions, query, vectors, stride: layout.bytes(), count, k, bound, place };
        jobs.push(image.job(&job).expect("a job"));
    }
    jobs
}

#[test]
fn the_hardware_returns_what_the_model_returns() {
    let parameters = SearchParameters {
        contexts: 4,
        neighbours: 16,
        candidates: 64,
        dimensions: 128,
        blocks: 32,
        remembered: 64,
        turns: 1,
    };
    for (seed, memory_width, stalls) in [(1, 512, 0), (2, 512, 3), (3, 128, 4), (4, 256, 2)] {
        let mut image = SearchImage::new();
        let jobs = jobs_of(seed, &mut image);
        let (results, _) = run(&image, &jobs, parameters, Traffic { seed, latency: 60, stalls, memory_width });
        for (number, job) in jobs.iter().enumerate() {
            let reply = search(&image, 0, *job, &parameters);
            let status = match reply.status {
                SearchStatus::Done => 0,
                SearchStatus::Refused => 1,
                SearchStatus::Memory => 2,
            };
            let found = &results[&(number as u64)];
            let last = found.last().expect("a result");
            assert_eq!(last.0, status, "job {number} of seed {seed}");
            let neighbours: Vec<(u64, u32)> =
                found.iter().filter(|row| row.1 == 1).map(|row| (row.2, canonical(f32::from_bits(row.3)))).collect();
            let expected: Vec<(u64, u32)> =
                reply.neighbours.iter().map(|near| (near.index.into(), canonical(near.distance))).collect();
            assert_eq!(neighbours, expected, "job {number} of seed {seed}");
        }
    }
}

fn canonical(x: f32) -> u32 {
    if x.is_nan() { 0x7fc0_0000 } else { x.to_bits() }
}

#[test]
fn the_text_of_a_unit_with_searches_has_no_report_of_the_linters() {
    for text in ["k=32,m=64", "k=1,m=9,contexts=3,dimensions=100,blocks=16,remembered=64,turns=3"] {
        let search = text.parse().expect("searches");
        let parameters = UnitParameters { search, contexts: 16, memory_width: 256, ..UnitParameters::default() };
        let unit = UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit");
        let folder = tempfile::tempdir().expect("a folder");
        let sources = Sources::write(&unit.emitted().expect("a text"), folder.path()).expect("sources");
        sources.lint().expect("no report of the linters");
    }
}
