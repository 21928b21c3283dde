//! Arrays and pipelines against the recorded outcomes of the original hardware, and against the simulated netlist.

use raypath_embed::{
    AngularResult, Beat, Bounds, Datapath, EuclideanResult, Job, Outcome, Pipeline, QuadboxResult, Ray, Tagged,
    TriangleResult, Vertices, Words,
};
use raypath_ops::JobKind;
use raypath_sim::engine::{Engine, NetlistEngine};
use raypath_sim::traffic::interleave;
use raypath_sim::transactions::{Transaction, read};
use std::path::Path;

/// The original's rules: in native arithmetic; with a feature, through the words at the ports.
const CONFIGURATIONS: [&str; 2] = ["preset = \"original\"", "preset = \"original\"\ntag = 3"];

/// The recorded jobs of an operation.
fn recorded(kind: JobKind) -> Vec<Transaction> {
    let config = Datapath::open(CONFIGURATIONS[0], &[]).expect("the preset").config();
    let model = raypath_sim::Datapath::paper(config).model();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../raypath/tests/data/golden/{kind}.txt.gz"));
    read(&path, None, &model, config).expect("the recorded file")
}

fn number(words: &Words, port: &str) -> f32 {
    f32::from_bits(words.port(port) as u32)
}

fn vector(words: &Words, port: &str) -> [f32; 3] {
    ["x", "y", "z"].map(|axis| number(words, &format!("{port}_{axis}")))
}

fn ray(words: &Words) -> Ray {
    let [kx, ky, kz] = ["ray_kx", "ray_ky", "ray_kz"].map(|port| words.port(port) as u32);
    Ray {
        origin: vector(words, "ray_origin"),
        direction: vector(words, "ray_dir"),
        inverse: vector(words, "ray_inv"),
        extent: number(words, "ray_extent"),
        shear: vector(words, "ray_shear"),
        kx,
        ky,
        kz,
    }
}

fn boxes(words: &Words) -> [Bounds; 4] {
    let bound = |i: usize, side: &str| ["x", "y", "z"].map(|axis| number(words, &format!("aabb_{i}_{axis}_{side}")));
    [0, 1, 2, 3].map(|i| Bounds { min: bound(i, "min"), max: bound(i, "max") })
}

fn vertices(words: &Words) -> Vertices {
    Vertices { a: vector(words, "triangle_a"), b: vector(words, "triangle_b"), c: vector(words, "triangle_c") }
}

fn coordinates(words: &Words, of: &str, lanes: usize) -> Vec<f32> {
    (0..lanes).map(|lane| number(words, &format!("euclidean_{of}_{lane}"))).collect()
}

/// Bits of a result, so that equality is that of bits.
fn quadbox_bits(result: &QuadboxResult) -> ([u32; 4], [u8; 4], [u8; 4]) {
    (result.tmin.map(f32::to_bits), result.is_intersect, result.box_index)
}

fn triangle_bits(result: &TriangleResult) -> [u32; 3] {
    [result.t_num.to_bits(), result.t_denom.to_bits(), result.triangle_hit]
}

/// The bits of a recorded outcome or of one from a pipeline.
fn bits(outcome: &Outcome) -> Vec<u32> {
    match outcome {
        Outcome::Quadbox(result) => {
            let (tmin, hits, indices) = quadbox_bits(result);
            tmin.into_iter().chain(hits.map(u32::from)).chain(indices.map(u32::from)).collect()
        }
        Outcome::Triangle(result) => triangle_bits(result).into(),
        Outcome::Euclidean(EuclideanResult { accumulator, reset_accum }) => vec![accumulator.to_bits(), *reset_accum],
        Outcome::Angular(AngularResult { dot_product, norm, reset_accum }) => {
            vec![dot_product.to_bits(), norm.to_bits(), *reset_accum]
        }
        Outcome::Words(opcode) | Outcome::Timing(opcode) => vec![*opcode as u32],
    }
}

fn expected(outcome: &Words) -> Outcome {
    outcome.paper_outcome().expect("an outcome of the paper's operations").into()
}

#[test]
fn arrays_have_the_outcomes_of_the_original() {
    let (quadbox, triangle) = (recorded(JobKind::Quadbox), recorded(JobKind::Triangle));
    assert!(quadbox.len() > 1000 && triangle.len() > 1000);
    let rays: Vec<Ray> = quadbox.iter().map(|recorded| ray(&recorded.job)).collect();
    let bounds: Vec<[Bounds; 4]> = quadbox.iter().map(|recorded| boxes(&recorded.job)).collect();
    let triangle_rays: Vec<Ray> = triangle.iter().map(|recorded| ray(&recorded.job)).collect();
    let triangles: Vec<Vertices> = triangle.iter().map(|recorded| vertices(&recorded.job)).collect();
    for toml in CONFIGURATIONS {
        let datapath = Datapath::open(toml, &[]).expect("a configuration");
        // All jobs, and a number that does not fill a block.
        for count in [quadbox.len(), 1003] {
            let mut results = vec![QuadboxResult::default(); count];
            datapath.quadbox(&rays[..count], &bounds[..count], &mut results).expect("equal lengths");
            for (found, recorded) in results.iter().zip(&quadbox) {
                assert_eq!(bits(&Outcome::Quadbox(*found)), bits(&expected(&recorded.expected)), "{:?}", recorded.job);
            }
        }
        let mut results = vec![TriangleResult::default(); triangle.len()];
        datapath.triangle(&triangle_rays, &triangles, &mut results).expect("equal lengths");
        for (found, recorded) in results.iter().zip(&triangle) {
            assert_eq!(bits(&Outcome::Triangle(*found)), bits(&expected(&recorded.expected)), "{:?}", recorded.job);
        }
    }
}

#[test]
fn words_have_the_outcomes_of_the_original() {
    let datapath = Datapath::open(CONFIGURATIONS[0], &[]).expect("the preset");
    for kind in JobKind::ALL {
        let recorded = recorded(kind);
        let operation = datapath.operation(kind.name()).expect("one of the paper's operations");
        let words = |of: fn(&Transaction) -> &Words| -> Vec<u64> {
            recorded.iter().flat_map(|transaction| of(transaction).as_words().to_vec()).collect()
        };
        let expected = words(|transaction| &transaction.expected);
        let mut outputs = vec![0; expected.len()];
        datapath.run(operation, &words(|transaction| &transaction.job), &mut outputs).expect("whole jobs");
        assert!(outputs == expected, "{kind}");
    }
}

/// In every cycle under random handshakes, the pipeline shows what the netlist shows, and the outcomes are the recorded
/// ones, whether jobs are offered in their own types or as words.
#[test]
fn a_pipeline_equals_the_netlist_in_every_cycle() {
    let first = |kind: JobKind| recorded(kind).into_iter().take(400);
    let jobs: Vec<Transaction> = JobKind::ALL.into_iter().flat_map(first).collect();
    let jobs = interleave(jobs, |transaction| transaction.job.kind().opcode(), 3);
    for extra in
        ["", "\ncontrol = \"credit\"", "\nunit-latency = 2", "\ntag = 3", "\ncontrol = \"credit\"\nunit-latency = 2"]
    {
        let datapath = Datapath::open(&format!("{}{extra}", CONFIGURATIONS[0]), &[]).expect("a configuration");
        let model = raypath_sim::Datapath::paper(datapath.config()).model();
        let netlist = NetlistEngine::new(model.clone(), datapath.config(), |_| false);
        let (mut netlist, mut pipeline) = (netlist.expect("a netlist"), Pipeline::new(&datapath));
        let (mut offered, mut received) = (0, 0);
        let mut random = 1u64;
        let mut chance = |percent: u64| {
            random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (random >> 33) % 100 < percent
        };
        while received < jobs.len() {
            let Transaction { job, .. } = &jobs[offered.min(jobs.len() - 1)];
            let words = model.job_of_words(job.kind(), job.as_words());
            netlist.present(&words);
            let (valid, ready) = (offered < jobs.len() && chance(70), chance(60));
            let input_ready = pipeline.input_ready(job.kind().opcode());
            let output_valid = pipeline.output_valid();
            if valid {
                let lanes = if job.kind() == JobKind::Angular { 8 } else { 16 };
                let (ray, boxes, triangle) = (ray(job), boxes(job), vertices(job));
                let (a, b) = (coordinates(job, "a", lanes), coordinates(job, "b", lanes));
                let beat = Beat {
                    a: &a,
                    b: &b,
                    mask: job.port("euclidean_mask"),
                    reset_accum: job.port("euclidean_reset_accum") != 0,
                };
                let typed = match job.kind().paper().expect("one of the paper's operations") {
                    _ if offered % 3 == 0 => Job::Words { opcode: job.kind().opcode(), inputs: words.as_words() },
                    JobKind::Quadbox => Job::Quadbox { ray: &ray, boxes: &boxes },
                    JobKind::Triangle => Job::Triangle { ray: &ray, triangle: &triangle },
                    JobKind::Euclidean => Job::Euclidean(beat),
                    JobKind::Angular => Job::Angular(beat),
                };
                let accepted = pipeline.offer(&typed, offered as u64).expect("a job of the datapath");
                assert_eq!(accepted, input_ready);
                offered += usize::from(accepted);
            }
            let shown = netlist.cycle(valid, ready);
            assert_eq!((shown.input_ready, shown.output.is_some()), (input_ready, output_valid), "{extra}, {offered}");
            if let Some(&Tagged { tag, outcome }) = pipeline.step(ready) {
                assert_eq!(tag, received as u64);
                let shown = shown.output.expect("both outputs are valid");
                let recorded = &jobs[received].expected;
                assert_eq!(bits(&expected(&shown)), bits(&expected(recorded)));
                let found = match outcome {
                    Outcome::Words(_) => expected(pipeline.left_words().expect("words of a job of words")),
                    typed => typed,
                };
                assert_eq!(bits(&found), bits(&expected(recorded)), "{extra}: {:?}", jobs[received].job);
                received += 1;
            }
        }
    }
}
