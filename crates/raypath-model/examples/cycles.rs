//! The cycle-exact model: latency and back pressure.

use raypath_model::{CycleModel, Functional, Shape};
use raypath_ops::{Aabb, Job, Ray, RayBoxInput, Rules};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let ray = Ray::new([0.0, 0.0, -5.0], [0.0, 0.0, 1.0], f32::INFINITY)?;
    let job: Job = Job::Quadbox(RayBoxInput { ray, aabb: [Aabb::new([-1.0; 3], [1.0; 3]); 4] });

    // ANCHOR: latency
    let mut datapath = CycleModel::new(Functional::new(Rules::Paper), &Shape::default());
    datapath.cycle(Some(&job), true);
    let mut cycles = 1;
    while datapath.output().is_none() {
        datapath.cycle(None, true);
        cycles += 1;
    }
    println!("latency {cycles}");
    // ANCHOR_END: latency

    // ANCHOR: pressure
    datapath.reset();
    let mut inside = 0;
    while datapath.cycle(Some(&job), false).accepted {
        inside += 1;
    }
    println!("{inside} jobs fit while the sink is not ready");

    let mut taken = 0;
    while datapath.output().is_some() {
        taken += u32::from(datapath.cycle(None, true).output.is_some());
    }
    println!("{taken} leave, one per cycle");
    // ANCHOR_END: pressure
    Ok(())
}
