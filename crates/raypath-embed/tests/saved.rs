//! Saved states: a model that takes one over goes on as the one that saved it, in every cycle.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_embed::{
    BlockRequest, Bounds, Datapath, Job, Outcome, Pipeline, Ray, Response, SearchInputs, Unit, UnitInputs, UnitModel,
    UnitRay, UnitVerdict, Vertices,
};
use raypath_traversal::search::{Elements, Place, SearchImage, SearchJob, SearchMetric, VectorLayout};
use std::collections::VecDeque;

fn random_ray(random: &mut ChaCha8Rng) -> Ray {
    let mut vector = || [(); 3].map(|()| random.random_range(-1.0..1.0));
    Ray::new(vector(), vector(), 9.0).expect("a ray")
}

/// A cycle of a pipeline with random inputs: what it accepts and delivers.
fn cycle(pipeline: &mut Pipeline, datapath: &Datapath, random: &mut ChaCha8Rng) -> String {
    let (ray, tag) = (random_ray(random), random.random());
    let mut floats = |count: usize| (0..count).map(|_| random.random_range(-1.0..1.0)).collect::<Vec<f32>>();
    let (a, b) = (floats(datapath.lanes()), floats(datapath.lanes()));
    let beat = |lanes: usize, last: bool| raypath_embed::Beat {
        a: &a[..lanes],
        b: &b[..lanes],
        mask: u64::MAX >> (64 - lanes),
        reset_accum: last,
    };
    let boxes = [0.0, 1.0, 2.0, 3.0].map(|z| Bounds { min: [-1.0, -1.0, z], max: [1.0, 1.0, z + tag as u8 as f32] });
    let triangle = Vertices { a: [-1.0, -1.0, 2.0], b: [0.0, 1.0, 2.0], c: [1.0, -1.0, 2.0] };
    let sphere = datapath.operation("sphere").expect("an added operation");
    let words: Vec<u64> = (0..datapath.inputs(sphere).len()).map(|_| random.random_range(0..1 << 31)).collect();
    let last = random.random_bool(0.2);
    let job = match random.random_range(0..7) {
        0 => Job::Quadbox { ray: &ray, boxes: &boxes },
        1 => Job::Triangle { ray: &ray, triangle: &triangle },
        2 => Job::Euclidean(beat(datapath.lanes(), last)),
        3 => Job::Angular(beat(datapath.lanes() / 2, last)),
        4 => Job::Words { opcode: sphere.opcode(), inputs: &words },
        5 => Job::Timing { opcode: 0 },
        _ => return format!("{:?}", pipeline.step(random.random_bool(0.6))),
    };
    let accepted = pipeline.offer(&job, tag).expect("a job");
    let left = pipeline.step(random.random_bool(0.6)).copied();
    let words = left.filter(|left| matches!(left.outcome, Outcome::Words(_))).and_then(|_| pipeline.left_words());
    format!("{accepted} {left:?} {words:?}")
}

#[test]
fn a_restored_pipeline_goes_on_as_the_saved_one() {
    for text in [
        "",
        "control = \"credit\"\nlanes = 4",
        "interval = 4",
        "interval = 2\ncontrol = \"credit\"",
        "format = \"fp16\"",
    ] {
        let datapath = Datapath::open(text, &["sphere"]).expect("a datapath");
        let (mut saved, mut random) = (Pipeline::new(&datapath), ChaCha8Rng::seed_from_u64(1));
        for round in 0..30 {
            (0..random.random_range(0..60)).for_each(|_| drop(cycle(&mut saved, &datapath, &mut random)));
            let mut restored = Pipeline::new(&datapath);
            restored.restore(&saved.save()).expect("a state");
            let mut cloned = saved.clone();
            let cycles = |pipeline: &mut Pipeline| {
                let mut random = ChaCha8Rng::seed_from_u64(round);
                (0..60).map(|_| cycle(pipeline, &datapath, &mut random)).collect::<Vec<_>>()
            };
            let expected = cycles(&mut saved);
            assert_eq!(cycles(&mut restored), expected, "{text}, round {round}");
            assert_eq!(cycles(&mut cloned), expected, "{text}, round {round}");
            assert_eq!(restored.save(), saved.save());
        }
    }
}

/// A unit with a memory of random blocks, which answers in order.
struct System {
    model: UnitModel,
    queue: VecDeque<(u32, usize)>,
    asked: VecDeque<u32>,
    random: ChaCha8Rng,
}

impl System {
    fn cycle(&mut self, scene: &[u8], width: usize, block: usize) -> String {
        let Self { model, queue, asked, random } = self;
        let outputs = model.outputs();
        let mut vector = || [(); 3].map(|()| random.random_range(-1.0..1.0));
        let ray = UnitRay { origin: vector(), direction: vector(), t_max: 9.0, root: 32, ..UnitRay::default() };
        let answers = random.random_bool(0.7);
        let beat = queue.front_mut().filter(|_| answers).map(|(tag, left)| {
            *left -= 1;
            Response { tag: *tag, is_error: false, beat: &scene[*left * width..][..width] }
        });
        let inputs = UnitInputs {
            flush: false,
            ray: random.random_bool(0.3).then_some((3, &ray)),
            hit_ready: random.random_bool(0.8),
            candidate_ready: random.random_bool(0.8),
            verdict: asked.pop_front().map(|tag| (tag, UnitVerdict { accept: tag % 2, end: tag / 2 % 2, t: 1.0 })),
            request_ready: random.random_bool(0.8),
            response: beat,
            search: SearchInputs::default(),
        };
        model.step(&inputs).expect("a cycle");
        if queue.front().is_some_and(|(_, left)| *left == 0) {
            queue.pop_front();
        }
        asked.extend(outputs.candidate.filter(|_| inputs.candidate_ready).map(|(tag, ..)| tag));
        if let Some(request) = outputs.request.filter(|_| inputs.request_ready) {
            queue.push_back((request.tag, block / width));
        }
        format!("{outputs:?}")
    }
}

#[test]
fn a_restored_unit_goes_on_as_the_saved_one() {
    let mut scene = [0; 128];
    let bounds = [-1.0_f32, -1.0, -1.0, 1.0, 1.0, 1.0];
    // Each child is the node itself, a leaf, or nothing; with candidates, the leaves are not opaque, and one is a box.
    let set = |scene: &mut [u8; 128], child: usize, word: u32| {
        let bytes = bounds.iter().flat_map(|bound| bound.to_le_bytes());
        bytes.zip(&mut scene[24 * child..]).for_each(|(byte, to)| *to = byte);
        scene[96 + 4 * child..][..4].copy_from_slice(&word.to_le_bytes());
    };
    for (text, block, leaves) in [
        ("contexts = 8", 128, [1, 2]),
        ("barycentrics = true\nnode = \"quantised\"", 64, [1, 2]),
        ("instances = true\nqueries = \"full\"", 128, [9, 17]),
    ] {
        let [first, second] = leaves;
        (0..).zip([32_u32, first, second, 0]).for_each(|(child, word)| set(&mut scene, child, word));
        let unit = Unit::open(text).expect("a unit");
        let width = unit.parameters().memory_width as usize / 8;
        let mut saved = System {
            model: UnitModel::new(&unit),
            queue: VecDeque::new(),
            asked: VecDeque::new(),
            random: ChaCha8Rng::seed_from_u64(2),
        };
        for round in 0..20 {
            (0..200).for_each(|_| drop(saved.cycle(&scene, width, block)));
            saved.random = ChaCha8Rng::seed_from_u64(round);
            let random = ChaCha8Rng::seed_from_u64(round);
            let mut restored =
                System { model: UnitModel::new(&unit), queue: saved.queue.clone(), asked: saved.asked.clone(), random };
            restored.model.restore(&saved.model.save()).expect("a state");
            for cycle in 0..300 {
                let expected = saved.cycle(&scene, width, block);
                assert_eq!(restored.cycle(&scene, width, block), expected, "{text}, round {round}, cycle {cycle}");
            }
            assert_eq!(restored.model.save(), saved.model.save());
        }
        assert!(saved.model.counts().rays > 20, "{text}: {:?}", saved.model.counts());
    }
}

/// A unit with jobs of searches and a memory of them, whose responses and stalls are drawn.
struct Searching {
    model: UnitModel,
    /// The requests, and the beats that they have had.
    queue: VecDeque<(BlockRequest, usize)>,
    random: ChaCha8Rng,
}

impl Searching {
    fn cycle(&mut self, image: &SearchImage, jobs: &[u32]) -> String {
        let Self { model, queue, random } = self;
        let outputs = model.outputs().search.expect("searches");
        let beat = queue.front().filter(|_| random.random_bool(0.7)).map(|(request, beats)| {
            let bytes = &image.bytes()[request.address as usize + 32 * beats..][..32];
            Response { tag: request.tag, is_error: random.random_bool(0.002), beat: bytes }
        });
        let job = random.random_bool(0.5).then(|| (7, 0, jobs[random.random_range(0..jobs.len())]));
        let [result_ready, request_ready] = [0.6, 0.8].map(|share| random.random_bool(share));
        let search = SearchInputs { job, result_ready, request_ready, response: beat };
        model.step(&UnitInputs { search, ..UnitInputs::default() }).expect("a cycle");
        if let Some((_, beats)) = queue.front_mut().filter(|_| beat.is_some()) {
            *beats += 1;
            if *beats == 2 {
                queue.pop_front();
            }
        }
        queue.extend(outputs.request.filter(|_| request_ready).map(|request| (request, 0)));
        format!("{outputs:?}")
    }
}

#[test]
fn a_restored_unit_goes_on_with_its_searches() {
    let text = "search = \"k=4,m=32,contexts=3,dimensions=32,blocks=16,remembered=64\"\nmemory-width = 256";
    let unit = Unit::open(text).expect("a unit");
    let (mut image, mut random) = (SearchImage::new(), ChaCha8Rng::seed_from_u64(8));
    let mut jobs = Vec::new();
    for elements in [Elements::Binary32, Elements::Int8 { scale: 0.5 }] {
        let layout = VectorLayout { elements, dimensions: 20 };
        let numbers: Vec<f32> = (0..20 * 40).map(|_| elements.nearest(random.random_range(-9.0..9.0))).collect();
        let vectors = image.vectors(layout, &numbers).expect("vectors");
        let lists: Vec<Vec<u32>> = (0..40).map(|_| (0..5).map(|_| random.random_range(0..41)).collect()).collect();
        let neighbours = image.lists(5, lists.iter().map(Vec::as_slice)).expect("lists");
        let graph =
            Place::Graph { neighbours, degree: 5, entries: neighbours, entry_count: 2, candidates: 20, expansions: 9 };
        for (metric, place) in [
            (SearchMetric::Euclidean, Place::Scan),
            (SearchMetric::Dot, Place::Gather { list: neighbours, len: 5 }),
            (SearchMetric::Cosine, graph),
            (SearchMetric::Euclidean, graph),
        ] {
            let (query, stride, bound) = (vectors + layout.bytes(), layout.bytes(), f32::INFINITY);
            let shape =
                SearchJob { metric, elements, dimensions: 20, query, vectors, stride, count: 40, k: 4, bound, place };
            jobs.push(image.job(&shape).expect("a job"));
        }
    }
    // A job that is refused: the words of a vector.
    jobs.push(0);
    let mut saved = Searching { model: UnitModel::new(&unit), queue: VecDeque::new(), random };
    let mut results = 0;
    for round in 0..60 {
        (0..97).for_each(|_| drop(saved.cycle(&image, &jobs)));
        saved.random = ChaCha8Rng::seed_from_u64(round);
        let random = ChaCha8Rng::seed_from_u64(round);
        let mut restored = Searching { model: UnitModel::new(&unit), queue: saved.queue.clone(), random };
        restored.model.restore(&saved.model.save()).expect("a state");
        for cycle in 0..400 {
            let expected = saved.cycle(&image, &jobs);
            results += usize::from(expected.contains("is_last: true"));
            assert_eq!(restored.cycle(&image, &jobs), expected, "round {round}, cycle {cycle}");
        }
        assert_eq!(restored.model.save(), saved.model.save());
    }
    assert!(results > 50, "{results}");
}

#[test]
fn bytes_of_others_are_refused() {
    let datapath = |text| Datapath::open(text, &[]).expect("a datapath");
    let mut pipeline = Pipeline::new(&datapath(""));
    let state = pipeline.save();
    let mut refused = |bytes: &[u8]| pipeline.restore(bytes).expect_err("an error").to_string();
    assert_eq!(refused(b""), "0 bytes of a state, expected those that a model saved");
    assert!(refused(&state[..state.len() - 1]).ends_with("expected all that a model saved, unchanged"));
    let mut other = state.clone();
    other[14] = 9;
    assert_eq!(refused(&other), "a state of version 9, expected version 2");
    other.clone_from(&state);
    other[90] ^= 1;
    assert!(refused(&other).ends_with("expected all that a model saved, unchanged"));
    let others = Pipeline::new(&datapath("lanes = 4")).save();
    assert!(refused(&others).starts_with("a state of another configuration or release, expected that of lanes 16"));
}
