//! The cache in Verilator: in every cycle that of the model, and every block that of the memory.

use rand::rngs::ChaCha8Rng;
use rand::{Rng, RngExt, SeedableRng};
use raypath_hdl::{Builder, Module};
use raypath_tools::{Options, Verilated};
use raypath_traversal::system::{Cache, CacheBeat, CacheEdge, CacheParameters, rtl};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

const WIDTH: u32 = 64;
const BLOCK_BYTES: u32 = 16;
const REQUESTERS: u32 = 12;
const CYCLES: usize = 20_000;

/// The ports of the bench.
fn shell() -> Arc<Module> {
    let m = Builder::new("cache_bench");
    let inputs = [
        ("invalidate", 1),
        ("req_valid", 1),
        ("req_addr", 20),
        ("req_tag", 4),
        ("mem_req_ready", 1),
        ("mem_rsp_valid", 1),
        ("mem_rsp_tag", 5),
        ("mem_rsp_error", 1),
        ("mem_rsp_data", 64),
    ];
    inputs.iter().for_each(|(name, width)| {
        m.input(&format!("{name}_i"), *width);
    });
    // For its clock and reset.
    let state = m.register("state_q", 1).reset_to(0);
    state.next(state.wire());
    for (name, width) in OUTPUTS {
        m.output(&format!("{name}_o"), m.constant(width, 0));
    }
    m.finish().expect("a module")
}

const OUTPUTS: [(&str, u32); 12] = [
    ("idle", 1),
    ("hits", 1),
    ("merges", 1),
    ("misses", 1),
    ("req_ready", 1),
    ("mem_req_valid", 1),
    ("mem_req_addr", 20),
    ("mem_req_tag", 5),
    ("rsp_valid", 1),
    ("rsp_tag", 4),
    ("rsp_error", 1),
    ("rsp_data", 64),
];

/// The bench: the cache with these parameters.
fn bench(CacheParameters { sets, ways, line, misses }: CacheParameters) -> String {
    let tag = misses.trailing_zeros();
    format!(
        "module cache_bench (input logic clk_i, rst_ni, invalidate_i, req_valid_i, input logic [19:0] req_addr_i, \
         input logic [3:0] req_tag_i, input logic mem_req_ready_i, mem_rsp_valid_i, input logic [4:0] mem_rsp_tag_i, \
         input logic mem_rsp_error_i, input logic [63:0] mem_rsp_data_i, output logic idle_o, hits_o, merges_o, \
         misses_o, req_ready_o, mem_req_valid_o, output logic [19:0] mem_req_addr_o, output logic [4:0] mem_req_tag_o, \
         output logic rsp_valid_o, output logic [3:0] rsp_tag_o, output logic rsp_error_o, output logic [63:0] \
         rsp_data_o);\n  assign mem_req_tag_o[4:{tag}] = '0;\n  logic unused_tag;\n  assign unused_tag = ^mem_rsp_tag_i;\n  raypath_cache #(.Sets ({sets}), .Ways ({ways}), .Misses \
         ({misses}), .LineBytes ({line}), .BlockBytes ({BLOCK_BYTES}), .DataWidth ({WIDTH}), .AddressWidth (20), \
         .Requesters ({REQUESTERS})) u_cache (.mem_req_tag_o (mem_req_tag_o[{0}:0]), .mem_rsp_tag_i \
         (mem_rsp_tag_i[{0}:0]), .*);\nendmodule\n",
        tag - 1
    )
}

/// What the memory has at an address of a beat.
fn word(address: u64) -> u64 {
    (address / 8).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(17)
}

/// The requests of lines in the memory.
struct Line {
    due: usize,
    address: u64,
    beat: u64,
}

/// Random traffic for the model: the frames, and the outputs that are expected, with the data of each beat.
fn traffic(parameters: CacheParameters, seed: u64) -> (Vec<Vec<u64>>, Vec<Vec<u64>>) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut cache = Cache::new(parameters, BLOCK_BYTES, WIDTH, REQUESTERS);
    let mut store: BTreeMap<(u32, u32), u64> = BTreeMap::new();
    // Requests that are not answered: the address, and the beats that have come.
    let mut asked: BTreeMap<u64, (u64, u64)> = BTreeMap::new();
    let mut lines: BTreeMap<u64, Line> = BTreeMap::new();
    let mut offered: Option<(u64, u64)> = None;
    let (mut frames, mut outputs) = (Vec::new(), Vec::new());
    let (mut answered, mut failed, mut read) = (0, 0, 0);
    let line_beats = u64::from(parameters.line * 8 / WIDTH);
    for now in 0..CYCLES {
        // Busy, slow and quiet times.
        let (share, stall) = [(8, 0), (8, 5), (2, 2), (0, 0)][now / 200 % 4];
        if offered.is_none() && random.random_range(0..8) < share {
            let tag = random.random_range(0..u64::from(REQUESTERS));
            let spread = [4, 40, 400][random.random_range(0..3)];
            let address = random.random_range(0..spread) * u64::from(BLOCK_BYTES);
            offered = Some((address, tag)).filter(|_| !asked.contains_key(&tag));
        }
        let memory_ready = random.random_range(0..8) >= stall;
        let due: Vec<u64> = lines.iter().filter(|(_, line)| line.due <= now).map(|(miss, _)| *miss).collect();
        let chosen =
            (!due.is_empty() && random.random_range(0..8) >= stall).then(|| due[random.random_range(0..due.len())]);
        let beat = chosen.map(|miss| {
            let line = lines.get_mut(&miss).expect("a line");
            line.beat += 1;
            (miss, random.random_range(0..1500) == 0, word(line.address + (line.beat - 1) * 8))
        });
        let invalidates = random.random_range(0..1000) == 0;

        let (ready, response, request, counts) = (cache.ready(), cache.response(), cache.request(), cache.counts());
        let is_idle = cache.is_idle();
        assert_eq!(is_idle, asked.is_empty(), "cycle {now}");
        let mut arbitrary = || random.next_u64();
        let (address, tag) = offered.unwrap_or((arbitrary() & 0xf_ffff, arbitrary() & 15));
        let (miss, is_error, data) = beat.unwrap_or((arbitrary() & 31, arbitrary() & 1 == 1, arbitrary()));
        let [valid, takes, arrives, error, invalidate] =
            [offered.is_some(), memory_ready, beat.is_some(), is_error, invalidates].map(u64::from);
        frames.push(vec![1, invalidate, valid, address, tag, takes, arrives, miss, error, data]);
        let filled = beat.map(|(miss, ..)| cache.place_of(miss as u32));
        cache.cycle(&CacheEdge {
            invalidates,
            request: offered.map(|(address, tag)| (address, tag as u32)),
            memory_ready,
            beat: beat.map(|(miss, is_error, _)| (miss as u32, is_error)),
        });
        let after = cache.counts();
        let [hits, merges, misses] =
            [after.hits - counts.hits, after.merges - counts.merges, after.misses - counts.misses];
        let (line, number) = request.unwrap_or_default();
        let mut row = vec![u64::from(is_idle), hits, merges, misses, ready.into(), request.is_some().into()];
        row.extend([line, number.into()]);
        row.extend(response.map_or([0; 4], |CacheBeat { tag, is_error, stored }| {
            let (address, beats) = asked.get_mut(&u64::from(tag)).expect("a request with this tag");
            assert!(is_error || read == word(*address + 8 * *beats), "cycle {now}: tag {tag}, {stored:?}");
            *beats += 1;
            failed += u64::from(is_error);
            [1, tag.into(), is_error.into(), read]
        }));
        outputs.push(row);
        // What leaves in the next cycle was read before the beat of this one is written.
        let next = cache.response().and_then(|CacheBeat { stored, .. }| store.get(&(stored.place, stored.beat)));
        read = next.copied().unwrap_or_default();
        store.extend(filled.map(|stored| ((stored.place, stored.beat), data)));

        if let Some((_, beats)) = response.and_then(|response| asked.get(&u64::from(response.tag)))
            && *beats == u64::from(BLOCK_BYTES * 8 / WIDTH)
        {
            answered += 1;
            asked.remove(&u64::from(response.expect("a response").tag));
        }
        if let Some((address, tag)) = offered.filter(|_| ready) {
            assert_eq!(asked.insert(tag, (address, 0)), None);
            offered = None;
        }
        if beat.is_some_and(|(miss, ..)| lines[&miss].beat == line_beats) {
            lines.remove(&chosen.expect("a line"));
        }
        if let Some((address, miss)) = request.filter(|_| memory_ready) {
            let due = now + 1 + random.random_range(0..[1, 30][now / 100 % 2]);
            let known = lines.insert(miss.into(), Line { due, address, beat: 0 });
            assert!(known.is_none(), "two requests of a line have the number {miss}");
        }
    }
    let counts = cache.counts();
    assert!(answered > 800 && failed > 0, "{answered} requests answered, {failed} with an error");
    assert!(counts.hits > 100 && counts.merges > 50 && counts.misses > 100, "{counts:?}");
    (frames, outputs)
}

#[test]
fn the_cache_is_that_of_the_model_in_every_cycle() {
    for (seed, (sets, ways, blocks, misses)) in [(4, 1, 1, 2), (2, 2, 2, 4), (8, 4, 4, 8)].into_iter().enumerate() {
        let parameters = CacheParameters { sets, ways, line: blocks * BLOCK_BYTES, misses };
        parameters.check(BLOCK_BYTES).expect("parameters");
        let folder = tempfile::tempdir().expect("a folder");
        let mut files: Vec<PathBuf> = Vec::new();
        let below = ["raypath_ram_1r1w", "raypath_queue", "raypath_cache"];
        let texts = below.map(|name| (name.to_string(), rtl::text(name).to_string())).into_iter();
        for (name, text) in texts.chain([("cache_bench".to_string(), bench(parameters))]) {
            files.push(folder.path().join(format!("{name}.sv")));
            std::fs::write(files.last().expect("a file"), text).expect("a file");
        }
        raypath_tools::lint_verilator(&files, "cache_bench", &[]).expect("no report of Verilator");
        let texts: Vec<String> = files.iter().map(|file| std::fs::read_to_string(file).expect("a text")).collect();
        let all = folder.path().join("all.sv");
        std::fs::write(&all, texts.concat()).expect("a file");
        raypath_tools::lint_yosys(&all, "cache_bench").expect("no report of Yosys");
        raypath_tools::lint_slang(&[all]).expect("no report of slang");
        let shell = shell();
        let verilated = Verilated::build_sources(&files, &shell, folder.path(), &Options::default()).expect("a build");
        let (frames, outputs) = traffic(parameters, seed as u64);
        let mut seen = 0;
        verilated
            .run_randomly(seed as u32, frames, |cycle, found| {
                let mut expected = outputs[cycle].clone();
                let names = OUTPUTS.iter().map(|(name, _)| *name);
                // What belongs to a channel that is not valid may have any value.
                let is_shown = |name: &str| match name {
                    "mem_req_addr" | "mem_req_tag" => expected[5] == 1,
                    "rsp_tag" | "rsp_error" => expected[8] == 1,
                    "rsp_data" => expected[8] == 1 && expected[10] == 0,
                    _ => true,
                };
                let shown: Vec<bool> = names.map(is_shown).collect();
                expected
                    .iter_mut()
                    .zip(found)
                    .zip(&shown)
                    .filter(|(_, is_shown)| !**is_shown)
                    .for_each(|((expected, found), _)| *expected = *found);
                assert_eq!(found, expected, "{parameters:?}, cycle {cycle}");
                seen += 1;
            })
            .expect("a run");
        assert_eq!(seen, CYCLES);
    }
}

#[test]
fn impossible_caches_are_errors() {
    let good = CacheParameters { sets: 64, ways: 4, line: 128, misses: 8 };
    assert_eq!((good.check(128), good.bytes()), (Ok(()), 32_768));
    for (wrong, message) in [
        (CacheParameters { sets: 3, ..good }, "the cache's sets is 3, expected a power of two from 2 to 65536"),
        (CacheParameters { ways: 16, ..good }, "the cache's ways is 16, expected 1, 2, 4 or 8"),
        (CacheParameters { line: 64, ..good }, "the cache's line is 64, expected 128, 256 or 512 bytes"),
        (CacheParameters { misses: 1, ..good }, "the cache's misses is 1, expected a power of two from 2 to 64"),
    ] {
        assert_eq!(wrong.check(128).expect_err("an error").to_string(), message);
    }
}
