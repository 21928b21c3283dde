//! The traversal unit: its cycle-exact model, and Verilator on the same rays and searches.

use crate::commands::full::bench::result::{Results, seconds};
use crate::error::CliError;
use raypath_model::Shape;
use raypath_render::{Camera, Scene, builtin};
use raypath_rtl::Config;
use raypath_search::{Clusters, Dataset, GraphParameters, Layer, Metric, SearchMemory, UnitJobs, UnitPlace, UnitSpec};
use raypath_tools::{Options, ToolError, Verilated, temporary_folder};
use raypath_traversal::search::{Elements, SearchMetric, SearchParameters, Searches};
use raypath_traversal::system::{RayUser, SystemParameters, simulate};
use raypath_traversal::traffic::{Behaviour, Environment, RecordedEngine, SearchBehaviour, SearchTraffic};
use raypath_traversal::{RayRequest, Reply, UnitModel, UnitNetlist, UnitParameters};

/// The size of the picture whose rays are traced.
const SIZE: (u32, u32) = (160, 120);
/// The rays in a run of Verilator: few, because its frames are recorded.
const RECORDED: usize = 800;
/// The searches in such a run.
const RECORDED_SEARCHES: usize = 8;
/// The memory's latency in cycles.
const LATENCY: u64 = 100;

/// Measures the model with camera rays in the built-in scene, and the default parameters.
pub fn run(results: &mut Results, repetitions: usize, with_verilator: bool) -> Result<(), CliError> {
    let mesh = builtin().map_err(CliError::unusable)?;
    let camera = Camera::framing(&mesh, SIZE.0 as f32 / SIZE.1 as f32);
    let scene = Scene::new(mesh).map_err(CliError::unusable)?;
    let scene = scene.through_unit().map_err(CliError::unusable)?;
    let Some(blocks) = scene.blocks() else { return Ok(()) };
    let rays = camera.rays(SIZE.0, SIZE.1).map_err(CliError::unusable)?;
    let rays: Vec<RayRequest> = rays.iter().map(|ray| blocks.request(ray, false, false)).collect();
    for latency in [LATENCY, 10 * LATENCY] {
        let around = SystemParameters::of_latency(latency);
        let mut cycles = 0;
        let time = seconds(repetitions.div_ceil(8), || {
            let mut user = List { rays: &rays, next: 0 };
            let unit = UnitParameters::default();
            cycles = simulate(&Shape::default(), unit, blocks.bytes(), &around, &mut user).unit.cycles;
        });
        let name = format!("traversal unit, cycle-exact, camera rays, memory {latency} cycles");
        results.rate(name, "unit cycles", cycles as f64 / time, None);
    }
    if with_verilator {
        let unit = UnitNetlist::new(Config::DEFAULT, UnitParameters::default())?;
        match verilator(&unit, blocks.bytes(), &rays, None, repetitions.div_ceil(8)) {
            Ok(per_second) => results.beside("unit cycles", "Verilator", per_second),
            Err(problem) => results.missing(format!("the traversal unit in Verilator: {problem}")),
        }
    }
    Ok(())
}

/// Measures the model with searches in the lowest layer of a graph, and no rays.
pub fn searches(results: &mut Results, repetitions: usize, with_verilator: bool) -> Result<(), CliError> {
    let clusters = Clusters { vectors: 4000, ..Clusters::default() };
    let Dataset { base, queries, .. } = clusters.generate().map_err(CliError::unusable)?;
    let layer = Layer::build(&base, Metric::Euclidean, &GraphParameters::default(), &|_| true);
    let (layer, _) = layer.map_err(CliError::unusable)?;
    let search = SearchParameters::default();
    let jobs = UnitJobs::new(&UnitSpec {
        base: &base,
        queries: &queries,
        metric: SearchMetric::Euclidean,
        elements: Elements::Binary32,
        neighbours: 10,
        bound: f32::INFINITY,
        place: UnitPlace::Graph(&layer, 64),
        unit: search,
    });
    let jobs = jobs.map_err(CliError::unusable)?;
    let found = jobs.search(&|_| true).map_err(CliError::unusable)?;
    let parameters = UnitParameters { search: Searches(Some(search)), ..UnitParameters::default() };
    let unit = UnitNetlist::new(Config::DEFAULT, parameters)?;
    let memory = SearchMemory { width: parameters.memory_width, latency: LATENCY };
    let mut cycles = Ok(0);
    let time = seconds(repetitions.div_ceil(8), || {
        let timed = jobs.time(&found, (&unit.shape(), parameters), memory, [usize::MAX, 0], &|_| true);
        cycles = timed.map(|timing| timing.cycles);
    });
    let per_second = cycles.map_err(CliError::unusable)? as f64 / time;
    let name = format!("traversal unit, cycle-exact, searches in a graph, memory {LATENCY} cycles");
    results.rate(name, "search cycles", per_second, None);
    if with_verilator {
        let behaviour = SearchBehaviour {
            latency: (LATENCY, LATENCY),
            stalls: 0,
            errors: 0,
            memory_width: parameters.memory_width,
        };
        let few = jobs.addresses().iter().copied().take(RECORDED_SEARCHES).collect();
        let traffic = SearchTraffic::new(jobs.image(), few, behaviour, 1);
        match verilator(&unit, &[], &[], Some(traffic), repetitions.div_ceil(8)) {
            Ok(per_second) => results.beside("search cycles", "Verilator", per_second),
            Err(problem) => results.missing(format!("the searches in Verilator: {problem}")),
        }
    }
    Ok(())
}

/// The cycles per second of Verilator, with one thread and all optimisations of Verilator and the C++ compiler.
fn verilator(
    unit: &UnitNetlist,
    scene: &[u8],
    rays: &[RayRequest],
    searches: Option<SearchTraffic<'_>>,
    repetitions: usize,
) -> Result<f64, CliError> {
    let stride = (rays.len() / RECORDED).max(1);
    let rays: Vec<RayRequest> = rays.iter().copied().step_by(stride).collect();
    let behaviour = Behaviour { latency: (LATENCY, LATENCY), stalls: [0; 4], errors: 0 };
    let mut environment = Environment::new(scene, unit.parameters, rays, behaviour, 1);
    environment.searches = searches;
    let top = &unit.top;
    let mut recorder = RecordedEngine::new(UnitModel::of(unit), top);
    while !environment.is_done() {
        environment.cycle(&mut [&mut recorder]).map_err(CliError::unusable)?;
    }
    let folder = temporary_folder()?;
    let options = Options { c_optimisation: 3, native: true, ..Options::default() };
    let verilated = Verilated::build_with(top, folder.path(), &options)?;
    let count = recorder.cycles.len() as f64;
    let frames = recorder.cycles.into_iter().map(|cycle| cycle.frame);
    let times: Result<Vec<f64>, ToolError> = verilated.time(frames, repetitions);
    Ok(count / times?.into_iter().fold(f64::INFINITY, f64::min))
}

/// Rays one after another.
struct List<'r> {
    rays: &'r [RayRequest],
    next: usize,
}

impl RayUser for List<'_> {
    fn next_ray(&mut self) -> Option<(u64, RayRequest)> {
        let ray = self.rays.get(self.next)?;
        self.next += 1;
        Some((self.next as u64, *ray))
    }

    fn receive(&mut self, _: u64, _: &Reply) -> bool {
        true
    }
}
