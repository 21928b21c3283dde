//! The cycle-exact simulation: pictures, hits, jobs and fetches equal those of the renderer.

use crate::common::meshes;
use crate::common::rays::{Kind, rays};
use image::Rgb;
use raypath_model::{Control, Shape};
use raypath_ops::{JobKind, Ray, RayError};
use raypath_render::{
    Camera, Counts, Mesh, PictureError, PictureSpec, RayBatch, RenderError, Scene, Shading, Tracing, render,
    sweep_picture, sweep_rays, time_picture, time_rays, trace_closest,
};
use raypath_timing::report::Recorder;
use raypath_timing::{Environment, Sample, SimulationError, Sink, System, Timing};
use std::num::NonZeroUsize;

fn systems() -> [System; 4] {
    let environment = |in_flight, memory_latency, sink| Environment { in_flight, memory_latency, sink };
    let stalls = Sink::Stalls { probability: 0.3, seed: 1 };
    let credit = Shape { control: Control::Credit, latency: 20, ..Shape::default() };
    [
        System::default(),
        System { environment: environment(1, 0, Sink::Always), ..System::default() },
        System { environment: environment(300, 17, Sink::Always), shape: credit },
        System { environment: environment(8, 40, stalls), ..System::default() },
    ]
}

fn assert_counts(timing: &Timing, counts: Counts) {
    assert_eq!(timing.jobs_of(JobKind::Quadbox), counts.quadbox);
    assert_eq!(timing.jobs_of(JobKind::Triangle), counts.triangle + counts.behind);
    assert_eq!(timing.total_jobs(), counts.jobs());
    assert_eq!(timing.fetches, counts.nodes + counts.leaves);
}

#[test]
fn pictures_equal_those_of_the_renderer() {
    for (name, two_sided) in [("suzanne", false), ("truck", true)] {
        let mesh = meshes::real(name).mesh;
        let (size, camera) = ((32, 24), Camera::framing(&mesh, 4.0 / 3.0));
        let tracing = Tracing { two_sided, ..Tracing::default() };
        let shading = Shading { tracing, shadows: true, ambient_occlusion: 3, samples: 2, seed: 5 };
        let scene = Scene::new(mesh).unwrap();
        let rendering = render(&scene, &camera, size, &shading, &|_| true).unwrap();
        let spec = PictureSpec { scene: &scene, camera, size, shading };
        for system in systems() {
            let (timing, picture) = time_picture(&spec, Sample::ALL, &system, &mut (), &|_| true).unwrap();
            assert_eq!(picture, rendering.picture);
            assert_eq!(timing.agents, 32 * 24);
            let costs = [rendering.primary, rendering.shadow, rendering.occlusion];
            assert_counts(&timing, costs.iter().map(|costs| costs.counts).sum());
        }
    }
}

#[test]
fn a_sample_renders_only_its_pixels() {
    let mesh = meshes::real("teapot").mesh;
    let (size, camera) = ((40, 30), Camera::framing(&mesh, 4.0 / 3.0));
    let shading = Shading { shadows: true, ambient_occlusion: 1, ..Shading::default() };
    let scene = Scene::new(mesh).unwrap();
    let rendering = render(&scene, &camera, size, &shading, &|_| true).unwrap();
    let spec = PictureSpec { scene: &scene, camera, size, shading };
    let sample = Sample { stride: NonZeroUsize::new(7).unwrap(), max: 100 };
    let (timing, picture) = time_picture(&spec, sample, &System::default(), &mut (), &|_| true).unwrap();
    let sampled: Vec<usize> = (0..100).map(|number| 7 * number).collect();
    let jobs = sampled.iter().map(|&pixel| u64::from(rendering.jobs[pixel])).sum::<u64>();
    assert_eq!((timing.agents, timing.total_jobs()), (100, jobs));
    for (pixel, (timed, rendered)) in picture.pixels().zip(rendering.picture.pixels()).enumerate() {
        assert_eq!(timed, if sampled.contains(&pixel) { rendered } else { &Rgb([0; 3]) });
    }
}

#[test]
fn hits_equal_those_of_the_tracer() {
    let scene = Scene::new(meshes::real("truck").mesh).unwrap();
    let rays = rays(scene.mesh(), Kind::Random, 2_000, 10);
    for two_sided in [false, true] {
        let tracing = Tracing { two_sided, ..Tracing::default() };
        let (hits, counts) = trace_closest(&scene, &rays, tracing, &|_| true).unwrap();
        let batch = RayBatch { scene: &scene, rays: &rays, tracing };
        for system in systems() {
            let (timing, timed) = time_rays(&batch, Sample::ALL, &system, &mut (), &|_| true).unwrap();
            assert_eq!(timed, hits);
            assert_counts(&timing, counts);
        }
    }
}

fn triangle() -> Scene {
    let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    Scene::new(Mesh::new(corners, vec![[0, 1, 2]]).unwrap()).unwrap()
}

/// One ray that misses the box, and two that hit the triangle.
fn three() -> Result<[Ray<raypath_ops::Binary32>; 3], RayError> {
    let down = |x| Ray::new([x, 0.25, 5.0], [0.0, 0.0, -1.0], f32::INFINITY);
    Ok([down(7.0)?, down(0.25)?, down(0.5)?])
}

/// A fetch takes 100 cycles, and a job 12 and one more at the output.
#[test]
fn cycles_follow_from_the_latencies() {
    let (scene, rays) = (triangle(), three().unwrap());
    let time = |tracing, in_flight| {
        let environment = Environment { in_flight, ..Environment::default() };
        let system = System { environment, ..System::default() };
        let batch = RayBatch { scene: &scene, rays: &rays, tracing };
        time_rays(&batch, Sample::ALL, &system, &mut (), &|_| true).unwrap().0.cycles
    };
    let one_sided = Tracing::default();
    assert_eq!(time(one_sided, 1), 113 + 226 + 226);
    // The job for the back of the triangle follows in the next cycle.
    assert_eq!(time(Tracing { two_sided: true, ..one_sided }, 1), 113 + 227 + 227);
    // With all rays in flight, the jobs of the last ray are delayed by two cycles and then by one.
    assert_eq!(time(one_sided, 3), 226 + 2);
}

fn new_recorder() -> Recorder {
    Recorder::new("ray", Shape::default().latency, 0, usize::MAX)
}

/// The owners of the recorded jobs, in the order of acceptance.
fn owners(recorder: Recorder) -> Vec<u64> {
    recorder.window().jobs.iter().map(|job| job.owner).collect()
}

#[test]
fn owners_are_numbers_of_rays_and_pixels() {
    let (scene, rays) = (triangle(), three().unwrap());
    let mut recorder = new_recorder();
    let batch = RayBatch { scene: &scene, rays: &rays, tracing: Tracing::default() };
    time_rays(&batch, Sample::ALL, &System::default(), &mut recorder, &|_| true).unwrap();
    assert_eq!(owners(recorder), [0, 1, 2, 1, 2]);

    let camera = Camera::framing(scene.mesh(), 2.0);
    let (size, shading) = ((20, 10), Shading { shadows: true, ambient_occlusion: 2, ..Shading::default() });
    let jobs = render(&scene, &camera, size, &shading, &|_| true).unwrap().jobs;
    let mut recorder = new_recorder();
    let spec = PictureSpec { scene: &scene, camera, size, shading };
    time_picture(&spec, Sample::ALL, &System::default(), &mut recorder, &|_| true).unwrap();
    let owners = owners(recorder);
    let of = |pixel| owners.iter().filter(|&&owner| owner == pixel).count() as u32;
    assert_eq!((0..200).map(of).collect::<Vec<u32>>(), jobs);
}

#[test]
fn sweep_points_equal_single_timings() {
    let scene = Scene::new(meshes::real("teapot").mesh).unwrap();
    let camera = Camera::framing(scene.mesh(), 1.0);
    let shading = Shading { shadows: true, ..Shading::default() };
    let spec = PictureSpec { scene: &scene, camera, size: (20, 20), shading };
    let rays = rays(scene.mesh(), Kind::Random, 300, 11);
    let batch = RayBatch { scene: &scene, rays: &rays, tracing: Tracing::default() };
    let (sample, system) = (Sample::spread(400, 100), System::default());
    let (in_flight, latencies) = ([1, 16, 64], [0, 100]);
    let pictures = sweep_picture(&spec, sample, &in_flight, &latencies, &system, &|_| true).unwrap();
    let lists = sweep_rays(&batch, sample, &in_flight, &latencies, &system, &|_| true).unwrap();
    assert_eq!((pictures.points.len(), lists.points.len()), (6, 6));
    for (picture, list) in pictures.points.iter().zip(&lists.points) {
        assert_eq!(picture.environment, list.environment);
        let system = System { environment: picture.environment, ..System::default() };
        assert_eq!(picture.timing, time_picture(&spec, sample, &system, &mut (), &|_| true).unwrap().0);
        assert_eq!(list.timing, time_rays(&batch, sample, &system, &mut (), &|_| true).unwrap().0);
        assert_eq!((picture.timing.agents, list.timing.agents), (100, 75));
    }
}

#[test]
fn invalid_simulations_are_errors() {
    let scene = triangle();
    let (camera, shading) = (Camera::framing(scene.mesh(), 1.0), Shading::default());
    let timed = |size, in_flight, progress| {
        let system = System { environment: Environment { in_flight, ..Environment::default() }, ..System::default() };
        time_picture(&PictureSpec { scene: &scene, camera, size, shading }, Sample::ALL, &system, &mut (), progress)
    };
    let size = RenderError::Size { width: 0, height: 3 };
    assert_eq!(timed((0, 3), 1, &|_| true), Err(PictureError::Render(size)));
    assert_eq!(timed((3, 3), 0, &|_| true), Err(PictureError::Simulation(SimulationError::NoSlots)));
    let stopped = timed((300, 300), 32, &|done| done < 1_000);
    assert!(matches!(stopped, Err(PictureError::Simulation(SimulationError::Stopped { .. }))), "{stopped:?}");
}
