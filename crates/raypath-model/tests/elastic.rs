//! Elastic pipelines of many shapes, compared with an independent reference model and with formulas.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_model::{Control, Elastic, Loop, PipelinePosition, Shape, Transfer};
use std::collections::HashMap;

/// Opcodes.
const OPCODES: [u64; 4] = [TRIANGLE, QUADBOX, EUCLIDEAN, ANGULAR];
const TRIANGLE: u64 = 0;
const QUADBOX: u64 = 1;
const EUCLIDEAN: u64 = 2;
const ANGULAR: u64 = 3;

fn shape(latency: usize, control: Control, loops: &[(u64, usize, usize)]) -> Shape {
    let loops = loops.iter().map(|&(opcode, first, last)| Loop { opcode, first, last }).collect();
    Shape { latency, control, interval: 1, loops }
}

/// Pipelines of several lengths under both controls, with and without loops.
fn shapes() -> Vec<Shape> {
    let mut shapes = vec![];
    for control in [Control::Skid, Control::Credit] {
        shapes.extend([1, 2, 3, 12].map(|latency| shape(latency, control, &[])));
        shapes.push(shape(4, control, &[(EUCLIDEAN, 1, 3)]));
        shapes.push(shape(21, control, &[(EUCLIDEAN, 18, 19), (ANGULAR, 16, 17)]));
        shapes.push(shape(29, control, &[(EUCLIDEAN, 24, 26), (ANGULAR, 21, 23)]));
        // Loops of one kind that overlap, follow each other, or do not delay jobs.
        shapes.push(shape(9, control, &[(TRIANGLE, 2, 5), (TRIANGLE, 4, 6), (EUCLIDEAN, 1, 2), (EUCLIDEAN, 2, 8)]));
        shapes.push(shape(5, control, &[(TRIANGLE, 0, 2), (TRIANGLE, 3, 3), (EUCLIDEAN, 2, 5)]));
    }
    shapes
}

/// A reference model that tracks the position and arrival time of each item.
struct Reference {
    shape: Shape,
    now: u64,
    /// Items inside, oldest first.
    items: Vec<Item>,
    /// When an item of a kind last entered.
    entered: HashMap<u64, u64>,
}

#[derive(Clone, Copy)]
struct Item {
    id: u64,
    kind: u64,
    /// The buffer that holds the item; 0 is the input's.
    place: usize,
    since: u64,
}

impl Reference {
    fn new(shape: &Shape) -> Self {
        Self { shape: shape.clone(), now: 0, items: vec![], entered: HashMap::new() }
    }

    fn loops(&self, kind: u64) -> impl Iterator<Item = &Loop> {
        let inside = |l: &&Loop| l.first >= 1 && l.last < self.shape.latency && l.last > l.first;
        self.shape.loops.iter().filter(move |l| l.opcode == kind).filter(inside)
    }

    fn input_ready(&self, kind: u64) -> bool {
        match self.shape.control {
            Control::Skid => self.at(0).len() < 2,
            Control::Credit => {
                let too_soon = |l: &Loop| {
                    self.entered.get(&kind).is_some_and(|then| self.now < then + (l.last - l.first) as u64 + 1)
                };
                self.items.len() <= self.shape.latency && !self.loops(kind).any(too_soon)
            }
        }
    }

    fn output(&self) -> Option<u64> {
        let oldest = self.items.first()?;
        let is_there = match self.shape.control {
            Control::Skid => oldest.place == self.shape.latency - 1,
            Control::Credit => self.now >= oldest.since + self.shape.latency as u64,
        };
        is_there.then_some(oldest.id)
    }

    /// The items in a buffer, oldest first.
    fn at(&self, place: usize) -> Vec<Item> {
        self.items.iter().copied().filter(|item| item.place == place).collect()
    }

    /// Whether the item, first in its buffer, moves to the next in this cycle.
    fn moves(&self, item: &Item) -> bool {
        let next = item.place + 1;
        let between = |l: &Loop| self.items.iter().any(|i| i.kind == l.opcode && (l.first..l.last).contains(&i.place));
        next < self.shape.latency
            && self.at(next).len() < 2
            && !self.loops(item.kind).any(|l| l.first == next && between(l))
    }

    fn places(&self) -> Vec<PipelinePosition> {
        let stage = |item: &Item| match self.shape.control {
            Control::Skid => item.place + 1,
            Control::Credit => self.shape.latency.min((self.now - item.since) as usize),
        };
        let is_behind = |index: usize| index > 0 && stage(&self.items[index]) == stage(&self.items[index - 1]);
        self.items
            .iter()
            .enumerate()
            .map(|(i, item)| PipelinePosition { stage: stage(item), waits: is_behind(i) })
            .collect()
    }

    fn cycle(&mut self, input: Option<(u64, u64)>, output_ready: bool) {
        let accepted = input.filter(|(kind, _)| self.input_ready(*kind));
        let moving: Vec<u64> = (0..self.shape.latency)
            .filter_map(|place| self.at(place).first().copied())
            .filter(|first| self.moves(first))
            .map(|first| first.id)
            .collect();
        let taken = self.output().filter(|_| output_ready);
        self.items.iter_mut().filter(|item| moving.contains(&item.id)).for_each(|item| item.place += 1);
        self.items.retain(|item| Some(item.id) != taken);
        if let Some((kind, id)) = accepted {
            self.items.push(Item { id, kind, place: 0, since: self.now });
            self.entered.insert(kind, self.now);
        }
        self.now += 1;
    }
}

/// With random operations, bubbles, stalls and resets, the pipeline agrees with the reference in every cycle, and items
/// leave once and in order.
#[test]
fn every_shape_matches_the_reference() {
    for shape in shapes() {
        for seed in 0..8 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut pipeline = Elastic::<u64>::new(&shape);
            let mut reference = Reference::new(&shape);
            let (mut source_rate, mut sink_rate, mut repeats) = (0.5, 0.5, 0.5);
            let (mut kind, mut next, mut expected) = (TRIANGLE, 0, 0);
            let (mut fullest, mut was_empty, mut kept_apart) = (0, 0, 0);
            for cycle in 0..6000 {
                if rng.random_bool(0.02) {
                    source_rate = [0.0, 0.1, 0.5, 1.0, 1.0][rng.random_range(0..5)];
                    sink_rate = [0.0, 0.1, 0.5, 1.0, 1.0][rng.random_range(0..5)];
                    repeats = [0.0, 0.3, 0.9][rng.random_range(0..3)];
                }
                if rng.random_bool(0.002) {
                    pipeline.reset();
                    reference = Reference::new(&shape);
                    expected = next;
                }
                if rng.random_bool(1.0 - repeats) {
                    kind = OPCODES[rng.random_range(0..4)];
                }
                let input = rng.random_bool(source_rate).then_some((kind, next));
                let output_ready = rng.random_bool(sink_rate);
                for kind in OPCODES {
                    let ready = pipeline.input_ready(kind);
                    assert_eq!(ready, reference.input_ready(kind), "{shape:?}, seed {seed}, cycle {cycle}, {kind}");
                    kept_apart += usize::from(ready != pipeline.input_ready(QUADBOX));
                }
                let shown = pipeline.output().copied();
                assert_eq!(shown, reference.output(), "{shape:?}, seed {seed}, cycle {cycle}");
                let places: Vec<PipelinePosition> = pipeline.positions().collect();
                assert_eq!(places, reference.places(), "{shape:?}, seed {seed}, cycle {cycle}");
                let ready = pipeline.input_ready(kind);
                let Transfer { accepted, output } = pipeline.cycle(input, output_ready);
                reference.cycle(input, output_ready);
                assert_eq!((accepted, output), (input.is_some() && ready, shown.filter(|_| output_ready)));
                if let Some(item) = output {
                    assert_eq!(item, expected, "{shape:?}, seed {seed}, cycle {cycle}: in order, each once");
                    expected += 1;
                }
                next += u64::from(accepted);
                fullest = fullest.max(next - expected);
                was_empty += usize::from(next == expected);
            }
            assert!(next > 300 && was_empty > 0, "{shape:?}, seed {seed}: {next} {was_empty}");
            let closes_the_entrance =
                shape.control == Control::Credit && OPCODES.iter().any(|&k| shape.interval(k) > 1);
            assert_eq!(kept_apart > 0, closes_the_entrance, "{shape:?}");
            assert!(fullest <= shape.capacity() as u64);
            assert!(fullest == shape.capacity() as u64 || shape.loops.len() > 2, "{shape:?}: {fullest}");
        }
    }
}

/// Skipping cycles without input gives the same state as simulating them one by one.
#[test]
fn idle_equals_single_cycles() {
    let mut at_once = 0;
    for shape in shapes().into_iter().chain([shape(128, Control::Skid, &[]), shape(128, Control::Credit, &[])]) {
        for seed in 0..20 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let (mut skips, mut walks) = (Elastic::<u64>::new(&shape), Elastic::<u64>::new(&shape));
            for item in 0..300 {
                let input = rng.random_bool(0.6).then_some((OPCODES[rng.random_range(0..4)], item));
                let output_ready = rng.random_bool(0.7);
                assert_eq!(skips.cycle(input, output_ready), walks.cycle(input, output_ready));
                if rng.random_bool(0.2) {
                    let limit = rng.random_range(0..200);
                    let mut passed = 0;
                    while passed < limit && walks.output().is_none() {
                        walks.cycle(None, true);
                        passed += 1;
                    }
                    assert_eq!(skips.idle(limit), passed, "{shape:?}, seed {seed}, item {item}, limit {limit}");
                    at_once += u64::from(passed > 10);
                }
                assert!(skips.positions().eq(walks.positions()), "{shape:?}, seed {seed}, item {item}");
                assert!(OPCODES.iter().all(|&kind| skips.input_ready(kind) == walks.input_ready(kind)));
            }
        }
    }
    assert!(at_once > 1000, "{at_once}");
}

/// The cycles in which items of one kind leave if the source always offers one and the sink is always ready.
fn departures(shape: &Shape, kind: u64) -> Vec<usize> {
    let mut pipeline = Elastic::new(shape);
    (0..400).filter(|_| pipeline.cycle(Some((kind, ())), true).output.is_some()).collect()
}

#[test]
fn an_item_takes_the_latency_and_the_next_follows_at_once() {
    for shape in shapes() {
        let expected: Vec<usize> = (shape.latency..400).collect();
        assert_eq!(departures(&shape, QUADBOX), expected, "{shape:?}");
    }
}

/// Items of a loop are as many cycles apart as the loop has steps. Other items follow in the next cycle.
#[test]
fn items_of_a_loop_keep_their_distance_and_no_others() {
    for control in [Control::Skid, Control::Credit] {
        for distance in 2..=5 {
            let shape = shape(12, control, &[(EUCLIDEAN, 4, 4 + distance - 1)]);
            assert_eq!((shape.interval(EUCLIDEAN), shape.interval(TRIANGLE)), (distance, 1));
            let expected: Vec<usize> = (12..400).step_by(distance).collect();
            assert_eq!(departures(&shape, EUCLIDEAN), expected, "{shape:?}");

            // Every `distance`-th item is of the kind: no item waits.
            let mut pipeline = Elastic::new(&shape);
            for cycle in 0..200 {
                let kind = if cycle % distance == 0 { EUCLIDEAN } else { TRIANGLE };
                assert!(pipeline.input_ready(kind), "cycle {cycle}, {shape:?}");
                assert_eq!(pipeline.cycle(Some((kind, cycle)), true).output, cycle.checked_sub(12));
            }
        }
    }
}

/// 24 in the paper's twelve skid buffers; one more than the latency with credits.
#[test]
fn capacity_while_the_sink_is_not_ready() {
    for (control, latency, capacity) in [(Control::Skid, 12, 24), (Control::Credit, 12, 13), (Control::Credit, 21, 22)]
    {
        let shape = shape(latency, control, &[]);
        assert_eq!(shape.capacity(), capacity);
        let mut pipeline = Elastic::new(&shape);
        let accepted = (0..100).filter(|cycle| pipeline.cycle(Some((TRIANGLE, *cycle)), false).accepted);
        assert!(accepted.eq(0..capacity as i32), "{shape:?}");
        assert_eq!(pipeline.output(), Some(&0));
        let left: Vec<_> = (0..capacity).map(|_| pipeline.cycle(None, true).output).collect();
        assert_eq!(left, (0..capacity as i32).map(Some).collect::<Vec<_>>(), "one a cycle");
        assert_eq!(pipeline.output(), None);
    }
}

/// Ready is a register, whose value does not depend on the transfer of the same cycle.
#[test]
fn a_full_pipeline_accepts_one_cycle_after_an_item_left() {
    for control in [Control::Skid, Control::Credit] {
        let mut one = Elastic::<u8>::new(&shape(1, control, &[]));
        let mut cycle = |item: u8, output_ready: bool| one.cycle(Some((TRIANGLE, item)), output_ready);
        assert!(cycle(1, false).accepted);
        assert!(cycle(2, false).accepted);
        assert!(!cycle(3, false).accepted, "two fit");
        assert_eq!(cycle(3, true), Transfer { accepted: false, output: Some(1) }, "ready is registered");
        assert_eq!(cycle(3, true), Transfer { accepted: true, output: Some(2) });
        assert_eq!(one.output(), Some(&3));
    }
}
