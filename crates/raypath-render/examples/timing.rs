//! Times a picture of the built-in scene, and says how fast that went: `timing [WIDTH] [IN_FLIGHT]`.

use raypath_render::{Camera, Hardware, Sample, Scene, Shading, Still, builtin, render, sweep_picture, time_picture};
use raypath_timing::Machine;
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let mut numbers = std::env::args().skip(1).map(|number| number.parse::<usize>());
    let (width, in_flight) = (numbers.next().unwrap_or(Ok(320))?, numbers.next().unwrap_or(Ok(32))?);
    let scene = Scene::new(builtin()?)?;
    let camera = Camera::framing(scene.mesh(), 4.0 / 3.0);
    let size = (width as u32, width as u32 * 3 / 4);
    let shading = Shading { shadows: true, ambient_occlusion: 4, ..Shading::default() };
    let still = Still { scene: &scene, camera, size, shading };
    let hardware = Hardware { machine: Machine { in_flight, ..Machine::default() }, ..Hardware::default() };

    let start = Instant::now();
    let rendering = render(&scene, &camera, size, &shading, &|_| true)?;
    println!("rendered in {:.2?}", start.elapsed());
    let start = Instant::now();
    let (timing, picture) = time_picture(&still, Sample::ALL, &hardware, &mut (), &|_| true)?;
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "simulated in {seconds:.2} s: {:.2} million cycles and {:.2} million jobs a second; same picture: {}",
        timing.cycles as f64 / seconds / 1e6,
        timing.all_jobs() as f64 / seconds / 1e6,
        picture == rendering.picture,
    );
    println!("{timing:?}: {:.3} jobs a cycle", timing.jobs_per_cycle());

    let sample = Sample::spread(rendering.jobs.len(), 1_000);
    let start = Instant::now();
    let sweep =
        sweep_picture(&still, sample, &[1, 2, 4, 8, 16, 32, 64, 128, 256], &[0, 100, 400], &hardware, &|_| true)?;
    println!("sweep over {} points of 1,000 pixels in {:.2?}", sweep.points.len(), start.elapsed());
    Ok(())
}
