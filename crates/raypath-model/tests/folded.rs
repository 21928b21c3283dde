//! Folded pipelines, compared in every cycle with a model that keeps the place of each job and the distance between
//! neighbours.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_model::{Control, Elastic, Shape};

/// Jobs by their places, the oldest first. The place `end` is the exit.
struct Reference {
    shape: Shape,
    end: usize,
    jobs: Vec<(u64, usize)>,
    now: u64,
    entered: Option<u64>,
}

impl Reference {
    fn new(shape: &Shape) -> Self {
        Self { shape: shape.clone(), end: shape.latency - 1, jobs: vec![], now: 0, entered: None }
    }

    fn in_exit(&self) -> usize {
        self.jobs.iter().filter(|(_, place)| *place == self.end).count()
    }

    /// The place of each job after this cycle. A job waits where it may if it would come too close to the one before
    /// it, and the last place waits for the exit.
    fn places(&self) -> Vec<usize> {
        let mut after: Vec<usize> = vec![];
        for &(_, place) in &self.jobs {
            let may_wait = self.shape.control == Control::Skid
                && (self.end - 1 - place.min(self.end - 1)).is_multiple_of(self.shape.interval);
            let waits = if place == self.end {
                true
            } else if place == self.end - 1 {
                may_wait && self.in_exit() >= 2
            } else {
                may_wait
                    && after.last().is_some_and(|older| older - (place + 1) < self.shape.interval && *older < self.end)
            };
            after.push(if waits { place } else { place + 1 });
        }
        after
    }

    fn input_ready(&self) -> bool {
        let interval = self.shape.interval;
        match self.shape.control {
            Control::Skid => self.places().last().is_none_or(|youngest| *youngest >= interval),
            Control::Credit => {
                // The first credit is back one cycle after the first outcome.
                let credits = (self.shape.latency + 1).div_ceil(interval);
                self.jobs.len() < credits && self.entered.is_none_or(|then| self.now >= then + interval as u64)
            }
        }
    }

    fn cycle(&mut self, input: Option<u64>, output_ready: bool) {
        let accepted = input.filter(|_| self.input_ready());
        let places = self.places();
        let taken = output_ready && self.in_exit() > 0;
        self.jobs.iter_mut().zip(places).for_each(|(job, place)| job.1 = place);
        if taken {
            self.jobs.remove(0);
        }
        if let Some(id) = accepted {
            self.jobs.push((id, 0));
            self.entered = Some(self.now);
        }
        self.now += 1;
    }
}

fn shapes() -> Vec<Shape> {
    let mut shapes = vec![];
    for control in [Control::Skid, Control::Credit] {
        for (interval, latencies) in [(2, [13, 14]), (3, [14, 15]), (4, [16, 19]), (8, [21, 33])] {
            shapes.extend(latencies.map(|latency| Shape { latency, control, interval, loops: vec![] }));
        }
    }
    shapes
}

#[test]
fn every_folded_shape_matches_the_reference() {
    for shape in shapes() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let (mut pipeline, mut reference) = (Elastic::<u64>::new(&shape), Reference::new(&shape));
        let (mut source_rate, mut sink_rate, mut next, mut fullest) = (1.0, 1.0, 0, 0);
        for cycle in 0..20_000 {
            if rng.random_bool(0.01) {
                source_rate = [0.1, 0.5, 1.0][rng.random_range(0..3)];
                sink_rate = [0.0, 0.1, 0.5, 1.0][rng.random_range(0..4)];
            }
            let ready = pipeline.input_ready(0);
            assert_eq!(ready, reference.input_ready(), "{shape:?}, cycle {cycle}");
            let shown = (reference.in_exit() > 0).then(|| reference.jobs[0].0);
            assert_eq!(pipeline.output().copied(), shown, "{shape:?}, cycle {cycle}");
            let stages: Vec<usize> = pipeline.positions().map(|position| position.stage).collect();
            let expected: Vec<usize> = reference.jobs.iter().map(|(_, place)| place + 1).collect();
            assert_eq!(stages, expected, "{shape:?}, cycle {cycle}");
            let input = rng.random_bool(source_rate).then_some(next);
            let output_ready = rng.random_bool(sink_rate);
            next += u64::from(pipeline.cycle(input.map(|id| (0, id)), output_ready).accepted);
            reference.cycle(input, output_ready);
            fullest = fullest.max(reference.jobs.len());
            if rng.random_bool(0.05) {
                let limit = rng.random_range(0..50);
                let passed = pipeline.idle(limit);
                let mut walked = 0;
                while walked < limit && reference.in_exit() == 0 {
                    reference.cycle(None, false);
                    walked += 1;
                }
                assert_eq!(passed, walked, "{shape:?}, cycle {cycle}");
            }
        }
        assert!(next > 500, "{shape:?}: {next} jobs");
        assert_eq!(fullest, shape.capacity(), "{shape:?}");
    }
}

#[test]
fn a_job_takes_the_latency_and_the_next_one_the_interval() {
    for shape in shapes() {
        let mut pipeline = Elastic::new(&shape);
        let left: Vec<usize> = (0..400).filter(|_| pipeline.cycle(Some((0, ())), true).output.is_some()).collect();
        let expected: Vec<usize> = (shape.latency..400).step_by(shape.interval).collect();
        assert_eq!(left, expected, "{shape:?}");
    }
}
