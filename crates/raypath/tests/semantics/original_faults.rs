//! The four accumulator faults of the original hardware: raypath reproduces none of them, under either rule set. A beat
//! of these tests adds 16: sixteen lanes of (1 − 0)².

use crate::semantics::answers::{self, Typed};
use raypath::ops::{
    Aabb, Beat, BeatInput, Binary32, Flags, Job, Outcome, Ray, RayBoxInput, RayTriangleInput, Rules, Triangle,
};

fn beat(a: [f32; 16], reset: bool) -> Job {
    let (a, b) = (a.map(Into::into), [0.0.into(); 16]);
    let mask = Flags::from_mask(0xffff);
    Job::Euclidean(BeatInput { euclidean: Beat { a, b, mask, reset_accum: reset.into() } })
}

fn adds_16() -> Job {
    beat([1.0; 16], false)
}

fn ray() -> Ray<Binary32> {
    Ray::new([0.0; 3], [0.0, 0.0, 1.0], 9.0).unwrap()
}

/// Every engine with a clock, under both rule sets, each after a reset.
fn on_engines(scenario: impl Fn(&mut Typed<'_>)) {
    [Rules::Paper, Rules::Chisel].into_iter().for_each(|rules| answers::on_engines(rules, &scenario));
}

/// Offers the job on the ports until it is accepted.
fn offer(engine: &mut Typed<'_>, output_ready: bool) -> Option<Outcome> {
    let shown = engine.cycle(true, output_ready);
    assert!(shown.input_ready);
    shown.output.filter(|_| output_ready)
}

/// The Euclidean sums that leave in the next cycles, without new jobs.
fn drain(engine: &mut Typed<'_>) -> Vec<f32> {
    let outcomes = (0..100).filter_map(|_| engine.cycle(false, true).output);
    outcomes.filter_map(|outcome| euclidean_sum(&outcome)).collect()
}

fn euclidean_sum(outcome: &Outcome) -> Option<f32> {
    match outcome {
        Outcome::Euclidean(o) => Some(o.euclidean_accumulator.into()),
        _ => None,
    }
}

/// Euclidean, box with a[0] = 1000 left on the Euclidean ports, Euclidean.
#[test]
fn fault_1_other_jobs_add_nothing_32_not_1032() {
    let quadbox = Job::Quadbox(RayBoxInput { ray: ray(), aabb: [Aabb::new([-1.0; 3], [1.0; 3]); 4] });
    let triangle =
        Job::Triangle(RayTriangleInput { ray: ray(), triangle: Triangle::new([1.0; 3], [2.0; 3], [3.0; 3]) });
    let angular = Job::from_ports(raypath::ops::JobKind::Angular, |name| match name {
        "euclidean_a_0" => 1000f32.to_bits().into(),
        name => u64::from(name == "euclidean_mask"),
    });
    for between in [quadbox, triangle, angular] {
        for reset_left_behind in [false, true] {
            on_engines(|engine| {
                engine.present(&adds_16());
                offer(engine, true);
                let mut thousand = [0.0; 16];
                thousand[0] = 1000.0;
                // Ports keep their values: a[0], mask and reset are present while the other job is offered.
                engine.present(&beat(thousand, reset_left_behind));
                engine.present(&between);
                offer(engine, true);
                engine.present(&adds_16());
                offer(engine, true);
                assert_eq!(drain(engine), [16.0, 32.0]);
            });
        }
    }
}

/// In the original, any job that is not angular cleared the angular sums.
#[test]
fn fault_1_other_jobs_do_not_clear_angular_sums() {
    let angular = Job::from_ports(raypath::ops::JobKind::Angular, |name| match name {
        "euclidean_reset_accum" => 0,
        "euclidean_mask" => 0xff,
        name if name.starts_with("euclidean_a") => 3f32.to_bits().into(),
        _ => 2f32.to_bits().into(),
    });
    let quadbox = Job::Quadbox(RayBoxInput { ray: ray(), aabb: [Aabb::new([-1.0; 3], [1.0; 3]); 4] });
    on_engines(|engine| {
        for job in [&angular, &quadbox, &adds_16(), &angular] {
            engine.present(job);
            offer(engine, true);
        }
        let sums: Vec<[f32; 2]> = (0..100)
            .filter_map(|_| match engine.cycle(false, true).output? {
                Outcome::Angular(o) => Some([o.angular_dot_product.into(), o.angular_norm.into()]),
                _ => None,
            })
            .collect();
        assert_eq!(sums, [[48.0, 32.0], [96.0, 64.0]]);
    });
}

#[test]
fn fault_2_bubbles_add_nothing_32_not_112() {
    for bubbles in [1, 5, 12, 40] {
        on_engines(|engine| {
            engine.present(&adds_16());
            offer(engine, true);
            let mut sums: Vec<f32> =
                (0..bubbles).filter_map(|_| euclidean_sum(&engine.cycle(false, true).output?)).collect();
            sums.extend(offer(engine, true).and_then(|outcome| euclidean_sum(&outcome)));
            sums.extend(drain(engine));
            assert_eq!(sums, [16.0, 32.0], "{bubbles} bubbles");
        });
    }
}

/// Forty beats; the sink is not ready for a long time after the first outcomes.
#[test]
fn fault_3_a_stall_adds_nothing_640_not_1376() {
    for stall_begins in [0, 5, 13, 20, 30] {
        for stall in [1, 2, 11, 60] {
            on_engines(|engine| {
                engine.present(&adds_16());
                let (mut accepted, mut sums) = (0, Vec::new());
                for cycle in 0..300 {
                    let output_ready = !(stall_begins..stall_begins + stall).contains(&cycle);
                    let shown = engine.cycle(accepted < 40, output_ready);
                    accepted += usize::from(accepted < 40 && shown.input_ready);
                    sums.extend(shown.output.filter(|_| output_ready).and_then(|outcome| euclidean_sum(&outcome)));
                }
                let expected: Vec<f32> = (1..=40).map(|beats| 16.0 * beats as f32).collect();
                assert_eq!(sums, expected, "stall of {stall} from cycle {stall_begins}");
                assert_eq!(sums.last(), Some(&640.0));
            });
        }
    }
}

/// After a reset with the first job's beats at any position, the next job starts from zero, and no old outcome appears.
#[test]
fn fault_4_a_reset_in_mid_job_clears_all_16_not_320() {
    for cycles_before_reset in 1..40 {
        for sink_ready in [true, false] {
            on_engines(|engine| {
                engine.present(&adds_16());
                for _ in 0..cycles_before_reset {
                    engine.cycle(true, sink_ready);
                }
                engine.reset();
                let shown = engine.cycle(false, true);
                assert!(shown.input_ready && shown.output.is_none(), "empty after a reset");
                // Bubbles with the stale beat still on the ports, then one beat.
                for _ in 0..20 {
                    assert_eq!(engine.cycle(false, true).output, None);
                }
                offer(engine, true);
                assert_eq!(drain(engine), [16.0], "reset after {cycles_before_reset} cycles");
            });
        }
    }
}
