//! The cycle-exact simulation does the renderer's work, no more and no less.

mod common;

use common::meshes;
use common::rays::{Kind, rays};
use raypath_model::{Control, PipelinePosition, Shape};
use raypath_ops::{JobKind, Ray, RayError};
use raypath_render::{
    Bundle, Camera, Counts, Mesh, PictureError, RenderError, Scene, Shading, Still, Tracing, render, sweep_picture,
    sweep_rays, time_picture, time_rays, trace_closest,
};
use raypath_timing::{Cycle, Hardware, Machine, Observer, Sample, SimulationError, Sink, Timing};
use std::num::NonZeroUsize;

fn machines() -> [Hardware; 4] {
    let machine = |in_flight, memory_latency, sink| Machine { in_flight, memory_latency, sink };
    let stalls = Sink::Stalls { probability: 0.3, seed: 1 };
    let credit = Shape { control: Control::Credit, latency: 20, ..Shape::default() };
    [
        Hardware::default(),
        Hardware { machine: machine(1, 0, Sink::Always), ..Hardware::default() },
        Hardware { machine: machine(300, 17, Sink::Always), shape: credit },
        Hardware { machine: machine(8, 40, stalls), ..Hardware::default() },
    ]
}

fn does_the_jobs_of(timing: &Timing, counts: Counts) {
    assert_eq!(timing.jobs_of(JobKind::Quadbox), counts.quadbox);
    assert_eq!(timing.jobs_of(JobKind::Triangle), counts.triangle + counts.behind);
    assert_eq!(timing.all_jobs(), counts.jobs());
    assert_eq!(timing.fetches, counts.nodes + counts.leaves);
}

#[test]
fn pictures_are_those_of_the_renderer() {
    for (name, two_sided) in [("suzanne", false), ("truck", true)] {
        let mesh = meshes::real(name).mesh;
        let (size, camera) = ((32, 24), Camera::framing(&mesh, 4.0 / 3.0));
        let tracing = Tracing { two_sided, ..Tracing::default() };
        let shading = Shading { tracing, shadows: true, ambient_occlusion: 3, samples: 2, seed: 5 };
        let scene = Scene::new(mesh).unwrap();
        let rendering = render(&scene, &camera, size, &shading, &|_| true).unwrap();
        let still = Still { scene: &scene, camera, size, shading };
        for hardware in machines() {
            let (timing, picture) = time_picture(&still, Sample::ALL, &hardware, &mut (), &|_| true).unwrap();
            assert_eq!(picture, rendering.picture);
            assert_eq!(timing.agents, 32 * 24);
            let costs = [rendering.primary, rendering.shadow, rendering.occlusion];
            does_the_jobs_of(&timing, costs.iter().map(|costs| costs.counts).sum());
        }
    }
}

#[test]
fn a_sample_has_its_pixels_only() {
    let mesh = meshes::real("teapot").mesh;
    let (size, camera) = ((40, 30), Camera::framing(&mesh, 4.0 / 3.0));
    let shading = Shading { shadows: true, ambient_occlusion: 1, ..Shading::default() };
    let scene = Scene::new(mesh).unwrap();
    let rendering = render(&scene, &camera, size, &shading, &|_| true).unwrap();
    let still = Still { scene: &scene, camera, size, shading };
    let sample = Sample { every: NonZeroUsize::new(7).unwrap(), most: 100 };
    let (timing, picture) = time_picture(&still, sample, &Hardware::default(), &mut (), &|_| true).unwrap();
    let sampled: Vec<usize> = (0..100).map(|number| 7 * number).collect();
    let jobs = sampled.iter().map(|&pixel| u64::from(rendering.jobs[pixel])).sum::<u64>();
    assert_eq!((timing.agents, timing.all_jobs()), (100, jobs));
    for (pixel, (timed, rendered)) in picture.pixels().iter().zip(rendering.picture.pixels()).enumerate() {
        assert_eq!(timed, if sampled.contains(&pixel) { rendered } else { &[0; 3] });
    }
}

#[test]
fn rays_hit_what_they_hit_otherwise() {
    let scene = Scene::new(meshes::real("truck").mesh).unwrap();
    let rays = rays(scene.mesh(), Kind::Random, 2_000, 10);
    for two_sided in [false, true] {
        let tracing = Tracing { two_sided, ..Tracing::default() };
        let (hits, counts) = trace_closest(&scene, &rays, tracing, &|_| true).unwrap();
        let bundle = Bundle { scene: &scene, rays: &rays, tracing };
        for hardware in machines() {
            let (timing, timed) = time_rays(&bundle, Sample::ALL, &hardware, &mut (), &|_| true).unwrap();
            assert_eq!(timed, hits);
            does_the_jobs_of(&timing, counts);
        }
    }
}

fn triangle() -> Scene {
    let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    Scene::new(Mesh::new(corners, vec![[0, 1, 2]]).unwrap()).unwrap()
}

/// One past the box, two at the triangle.
fn three() -> Result<[Ray<raypath_ops::Binary32>; 3], RayError> {
    let down = |x| Ray::new([x, 0.25, 5.0], [0.0, 0.0, -1.0], f32::INFINITY);
    Ok([down(7.0)?, down(0.25)?, down(0.5)?])
}

/// A fetch and a job take 100 and 12 cycles, and the answer is taken in one more.
#[test]
fn cycles_are_those_of_a_count_by_hand() {
    let (scene, rays) = (triangle(), three().unwrap());
    let time = |tracing, in_flight| {
        let machine = Machine { in_flight, ..Machine::default() };
        let hardware = Hardware { machine, ..Hardware::default() };
        let bundle = Bundle { scene: &scene, rays: &rays, tracing };
        time_rays(&bundle, Sample::ALL, &hardware, &mut (), &|_| true).unwrap().0.cycles
    };
    let one_sided = Tracing::default();
    assert_eq!(time(one_sided, 1), 113 + 226 + 226);
    // The triangle's other side follows in the next cycle.
    assert_eq!(time(Tracing { two_sided: true, ..one_sided }, 1), 113 + 227 + 227);
    // All at once: the last ray's jobs enter two cycles, and then one, after they could have.
    assert_eq!(time(one_sided, 3), 226 + 2);
}

/// Sees whose jobs are accepted.
#[derive(Default)]
struct Owners(Vec<u64>);

impl Observer for Owners {
    fn wants(&self, cycle: u64) -> Option<u64> {
        Some(cycle)
    }
    fn cycle(&mut self, cycle: &Cycle, _: impl Iterator<Item = PipelinePosition>) {
        self.0.extend(cycle.offered.filter(|_| cycle.accepted).map(|(_, owner)| owner));
    }
}

#[test]
fn owners_are_rays_and_pixels() {
    let (scene, rays) = (triangle(), three().unwrap());
    let mut owners = Owners::default();
    let bundle = Bundle { scene: &scene, rays: &rays, tracing: Tracing::default() };
    time_rays(&bundle, Sample::ALL, &Hardware::default(), &mut owners, &|_| true).unwrap();
    assert_eq!(owners.0, [0, 1, 2, 1, 2]);

    let camera = Camera::framing(scene.mesh(), 2.0);
    let (size, shading) = ((20, 10), Shading { shadows: true, ambient_occlusion: 2, ..Shading::default() });
    let jobs = render(&scene, &camera, size, &shading, &|_| true).unwrap().jobs;
    let mut owners = Owners::default();
    let still = Still { scene: &scene, camera, size, shading };
    time_picture(&still, Sample::ALL, &Hardware::default(), &mut owners, &|_| true).unwrap();
    let of = |pixel| owners.0.iter().filter(|&&owner| owner == pixel).count() as u32;
    assert_eq!((0..200).map(of).collect::<Vec<u32>>(), jobs);
}

#[test]
fn sweeps_are_many_timings() {
    let scene = Scene::new(meshes::real("teapot").mesh).unwrap();
    let camera = Camera::framing(scene.mesh(), 1.0);
    let shading = Shading { shadows: true, ..Shading::default() };
    let still = Still { scene: &scene, camera, size: (20, 20), shading };
    let rays = rays(scene.mesh(), Kind::Random, 300, 11);
    let bundle = Bundle { scene: &scene, rays: &rays, tracing: Tracing::default() };
    let (sample, hardware) = (Sample::spread(400, 100), Hardware::default());
    let (in_flight, latencies) = ([1, 16, 64], [0, 100]);
    let pictures = sweep_picture(&still, sample, &in_flight, &latencies, &hardware, &|_| true).unwrap();
    let lists = sweep_rays(&bundle, sample, &in_flight, &latencies, &hardware, &|_| true).unwrap();
    assert_eq!((pictures.points.len(), lists.points.len()), (6, 6));
    for (picture, list) in pictures.points.iter().zip(&lists.points) {
        assert_eq!(picture.machine, list.machine);
        let hardware = Hardware { machine: picture.machine, ..Hardware::default() };
        assert_eq!(picture.timing, time_picture(&still, sample, &hardware, &mut (), &|_| true).unwrap().0);
        assert_eq!(list.timing, time_rays(&bundle, sample, &hardware, &mut (), &|_| true).unwrap().0);
        assert_eq!((picture.timing.agents, list.timing.agents), (100, 75));
    }
}

#[test]
fn what_cannot_be_timed_is_refused() {
    let scene = triangle();
    let (camera, shading) = (Camera::framing(scene.mesh(), 1.0), Shading::default());
    let timed = |size, in_flight, watch| {
        let hardware = Hardware { machine: Machine { in_flight, ..Machine::default() }, ..Hardware::default() };
        time_picture(&Still { scene: &scene, camera, size, shading }, Sample::ALL, &hardware, &mut (), watch)
    };
    let size = RenderError::Size { width: 0, height: 3 };
    assert_eq!(timed((0, 3), 1, &|_| true), Err(PictureError::Render(size)));
    assert_eq!(timed((3, 3), 0, &|_| true), Err(PictureError::Simulation(SimulationError::NoPlace)));
    let stopped = timed((300, 300), 32, &|done| done < 1_000);
    assert!(matches!(stopped, Err(PictureError::Simulation(SimulationError::Stopped { .. }))), "{stopped:?}");
}
