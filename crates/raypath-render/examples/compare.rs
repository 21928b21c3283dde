//! Times the tracer beside obvhs on the built-in scene: `compare [RUNS]`.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use raypath_ops::{Binary32, Ray};
use raypath_render::compare::compare;
use raypath_render::{Camera, Scene, Tracing, builtin};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let runs = std::env::args().nth(1).map_or(Ok(5), |runs| runs.parse())?;
    let scene = Scene::new(builtin()?)?;
    let view = Camera::framing(scene.mesh(), 4.0 / 3.0).view(640, 480);
    let pixels = (0..480).flat_map(|y| (0..640).map(move |x| (f64::from(x) + 0.5, f64::from(y) + 0.5)));
    let primary = pixels.map(|(x, y)| view.ray(x, y)).collect::<Result<Vec<_>, _>>()?;
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let bounds = scene.bounds();
    let mut point = || -> [f32; 3] { std::array::from_fn(|k| random.random_range(bounds.min[k]..bounds.max[k])) };
    let pairs = (0..300_000).map(|_| (point(), point()));
    let scattered = pairs.map(|(a, b)| Ray::new(a, std::array::from_fn(|k| b[k] - a[k]), f32::INFINITY));
    let scattered = scattered.collect::<Result<Vec<Ray<Binary32>>, _>>()?;
    for (name, rays) in [("primary", &primary), ("random", &scattered)] {
        for two_sided in [false, true] {
            let tracing = Tracing { two_sided, ..Tracing::default() };
            let comparison = compare(&scene, rays, tracing, runs, &|_| true)?;
            let [ours, obvhs] = comparison.nanoseconds();
            let quotient = ours / obvhs;
            println!(
                "{name}, two-sided {two_sided}: {ours:.0} ns a ray, obvhs {obvhs:.0}: {quotient:.2} times; {comparison:?}"
            );
        }
    }
    Ok(())
}
