//! `raypath generate --unit`: the traversal unit, its ports and memories, and a comparison with the models.

use super::{Arguments, VERSION};
use crate::{CliError, Progress};
use comfy_table::presets::ASCII_MARKDOWN;
use comfy_table::{ContentArrangement, Table};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_hdl::Module;
use raypath_rtl::package::Prefix;
use raypath_sim::files::{in_folder, write_design};
use raypath_traversal::search::{SearchImage, SearchParameters, search};
use raypath_traversal::traffic::{
    Behaviour, BlockScene, Environment, SearchBehaviour, SearchTraffic, TwoLevelScene, random_ray, random_searches,
    verdict_of,
};
use raypath_traversal::{NetlistEngine, RayRequest, Reply, Unit, UnitModel, UnitNetlist};
use std::io::Write;
use std::time::Instant;

/// The triangles of the random scene.
const TRIANGLES: u32 = 500;
/// The instances of the random scene of a unit that has them.
const INSTANCES: u32 = 50;
/// The memory and the users of the ports in the check.
const BEHAVIOUR: Behaviour = Behaviour { latency: (1, 60), stalls: [32; 4], errors: 0 };
/// The most cycles that a ray takes in the check, by far.
const CYCLES_PER_RAY: u64 = 100_000;
/// The most differences that are printed.
const SHOWN: usize = 5;

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let config = arguments.datapath.config()?;
    let unit = UnitNetlist::new(config, arguments.unit_parameters.parameters())?;
    let prefix = &arguments.prefix;
    let files = unit.files(arguments.period)?;
    let modules = files.iter().filter(|(path, _)| path.starts_with("rtl")).count();
    write_design(&arguments.out, &in_folder(&arguments.out, prefix.rename(files)))?;

    writeln!(out, "raypath {VERSION}: {}\n", unit.description())?;
    writeln!(out, "Ports of {prefix}_unit\n\n{}\n", ports(&unit.top))?;
    let bits = unit.top.memory_bits();
    writeln!(out, "Memories: instances of {prefix}_ram_1r1w, {bits} bits\n\n{}\n", memories(&unit.top))?;
    let (all, datapath) = (unit.top.register_bits(), unit.datapath.top().register_bits());
    let control = all - datapath;
    writeln!(out, "Flip-flops: {control} around the datapath, {datapath} in it\n\n{}\n", parts(&unit.top, prefix))?;
    let (folder, has_searches) = (arguments.out.display(), unit.parameters.search.0.is_some());
    writeln!(out, "Wrote {modules} files to {folder}/rtl, listed in {folder}/{prefix}_unit.f, {}with structures", {
        let wrappers = format!(
            "with the AXI4 wrapper\n{prefix}_unit_axi in {folder}/{prefix}_unit_axi.f, the device with registers and \
             rings\n{prefix}_device in {folder}/{prefix}_device.f, and "
        );
        if has_searches { String::new() } else { wrappers }
    })?;
    writeln!(out, "{prefix}_unit_wrapper in {folder}/{prefix}_unit_wrapper.f;")?;
    writeln!(out, "all but the wrappers to {folder}/{prefix}_unit.sv,")?;
    writeln!(out, "and without structures to {folder}/{prefix}_unit_plain.sv; assertions to")?;
    writeln!(out, "{folder}/{prefix}_properties.sv; for FuseSoC and Bender: {folder}/{prefix}_unit.core and")?;
    let of = if has_searches { "unit" } else { "unit_axi" };
    writeln!(out, "{folder}/Bender.yml; constraints (.sdc, .xdc) and IP-XACT (.xml): {folder}/{prefix}_{of}.*.\n")?;
    check(&unit, arguments, out)
}

fn table<const N: usize>(header: [&str; N]) -> Table {
    let mut table = Table::new();
    table.load_preset(ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Dynamic).set_width(118);
    table.set_header(header);
    table
}

/// The ports of each channel.
fn ports(top: &Module) -> Table {
    let channels = [
        ("ray, in", "ray_"),
        ("hit, out", "hit_"),
        ("memory request, out", "mem_req_"),
        ("response, in", "mem_rsp_"),
        ("search, in", "search_"),
        ("result, out", "result_"),
        ("request of searches, out", "vec_req_"),
        ("response, in", "vec_rsp_"),
    ];
    let mut table = table(["channel", "ports"]);
    table.add_row(["", "clk_i, rst_ni"]);
    for (channel, prefix) in channels {
        let range = |width: u32| if width == 1 { String::new() } else { format!(" [{}:0]", width - 1) };
        let found = top.text_ports().into_iter().filter(|port| port.name.starts_with(prefix));
        let cells: Vec<String> = found.map(|port| port.name + &range(port.width)).collect();
        if !cells.is_empty() {
            table.add_row([channel, &cells.join(", ")]);
        }
    }
    table
}

/// The memories by their paths.
fn memories(top: &Module) -> Table {
    fn walk(module: &Module, path: &str, table: &mut Table) {
        for memory in module.memories() {
            let width: u32 = memory.columns.iter().map(|column| module.signal(column.read).width).sum();
            let bits = u64::from(memory.depth) * u64::from(width);
            table.add_row([
                format!("{path}{}", memory.name),
                memory.depth.to_string(),
                width.to_string(),
                bits.to_string(),
                memory.latency.to_string(),
            ]);
        }
        for instance in module.instances() {
            walk(&instance.module, &format!("{path}{}.", instance.name), table);
        }
    }
    let mut table = table(["memory", "words", "bits of a word", "bits", "cycles of a read"]);
    walk(top, "", &mut table);
    table
}

/// The flip-flops of the parts of the unit, and the bits of their memories.
fn parts(top: &Module, prefix: &Prefix) -> Table {
    let mut table = table(["part", "module", "flip-flops", "bits of memories"]);
    for instance in top.instances() {
        let module = &instance.module;
        let (flip_flops, bits) = (module.register_bits().to_string(), module.memory_bits().to_string());
        table.add_row([&instance.name, &prefix.name(module.name()), &flip_flops, &bits]);
    }
    let name = prefix.name(top.name());
    let own: u64 = top.instances().iter().map(|instance| instance.module.memory_bits()).sum();
    let rest = top.memory_bits() - own;
    if rest > 0 {
        table.add_row(["", &name, "", &rest.to_string()]);
    }
    table.add_row(["all", &name, &top.register_bits().to_string(), &top.memory_bits().to_string()]);
    table
}

/// Traces random rays through a random scene by the netlist and the models.
fn check(unit: &UnitNetlist, arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let (begin, nodes) = (Instant::now(), unit.parameters.step.node);
    let mut random = ChaCha8Rng::seed_from_u64(arguments.seed);
    let (scene, root, described) = if unit.parameters.step.features.instances {
        let TwoLevelScene { blocks, root, .. } = TwoLevelScene::random(nodes, INSTANCES, false, &mut random);
        (blocks, root, format!("{INSTANCES} instances"))
    } else {
        let (scene, root) = BlockScene::random_of(nodes, TRIANGLES, &mut random);
        (scene, root, format!("{TRIANGLES} triangles"))
    };
    let mut scene = scene;
    let root = scene.give_geometries(root, unit.parameters.step.features.queries, &mut random);
    let total = arguments.rays as usize;
    let rays: Vec<RayRequest> = (0..total).map(|_| random_ray(root, &mut random)).collect();
    let (mut netlist, mut model) = (NetlistEngine::new(unit)?, UnitModel::of(unit));
    let mut environment = Environment::new(&scene.0, unit.parameters, rays.clone(), BEHAVIOUR, arguments.seed);
    let searches = Checked::new(unit, arguments.seed)?;
    environment.searches = searches.as_ref().map(|searches| searches.traffic(unit, arguments.seed));
    let mut progress = Progress::new("rays", total);
    let limit = CYCLES_PER_RAY.saturating_mul(total as u64);
    while !environment.is_done() && progress.at(environment.replies.len()) {
        let cycle = environment.cycle(&mut [&mut netlist, &mut model]);
        cycle.map_err(|problem| CliError::Mismatch(format!("netlist and cycle-exact model: {problem}")))?;
        if environment.cycles() > limit {
            let ended = environment.replies.len();
            return Err(CliError::Mismatch(format!("{ended} of {total} rays ended in {limit} cycles, expected all")));
        }
    }
    let ended = environment.replies.len();
    let stopped = progress.finish(ended);

    let mut functional = Unit::new(unit.config.semantics.rules_in_full(), unit.parameters.step);
    let mut different: Vec<(u64, Reply, Reply)> = Vec::new();
    let mut by_status = [0; 4];
    for (&id, &found) in &environment.replies {
        let Some(ray) = rays.get(id as usize) else { continue };
        let expected = functional.trace_with(&scene.0[..], ray, &mut verdict_of);
        if let Some(count) = by_status.get_mut(expected.status as usize) {
            *count += 1;
        }
        if found != expected {
            different.push((id, found, expected));
        }
    }
    let [missed, hit, procedural, refused] = by_status;
    let hit = hit + procedural;
    let (cycles, seconds) = (environment.cycles(), begin.elapsed().as_secs_f64());
    writeln!(
        out,
        "Checked {ended} random rays ({hit} hit, {missed} miss, {refused} are refused) in a random scene of"
    )?;
    writeln!(
        out,
        "{described} in {cycles} cycles with stalls at all channels and a memory that answers in any order:"
    )?;
    writeln!(out, "{} mismatches between netlist, cycle-exact and functional model. {seconds:.2} s", different.len())?;
    for (id, found, expected) in different.iter().take(SHOWN) {
        writeln!(out, "  ray {id}: {found:?}, expected {expected:?}")?;
    }
    if !different.is_empty() {
        return Err(CliError::Mismatch(format!("netlist and functional model differ for {} rays", different.len())));
    }
    stopped?;
    searches.as_ref().map_or(Ok(()), |searches| searches.compare(&environment, out))
}

/// The searches that are done beside the rays.
struct Checked {
    parameters: SearchParameters,
    image: SearchImage,
    jobs: Vec<u32>,
}

/// The random jobs of a check.
const JOBS: usize = 100;

impl Checked {
    fn new(unit: &UnitNetlist, seed: u64) -> Result<Option<Self>, CliError> {
        let Some(parameters) = unit.parameters.search.0 else { return Ok(None) };
        let mut image = SearchImage::new();
        let jobs = random_searches(seed, JOBS, parameters, &mut image).map_err(CliError::unusable)?;
        Ok(Some(Self { parameters, image, jobs }))
    }

    fn traffic(&self, unit: &UnitNetlist, seed: u64) -> SearchTraffic<'_> {
        let memory_width = unit.parameters.memory_width;
        let behaviour = SearchBehaviour { latency: BEHAVIOUR.latency, stalls: 16, errors: 0, memory_width };
        SearchTraffic::new(&self.image, self.jobs.clone(), behaviour, seed)
    }

    /// Compares the results with those of the functional model.
    fn compare(&self, environment: &Environment<'_>, out: &mut dyn Write) -> Result<(), CliError> {
        let Some(searches) = &environment.searches else { return Ok(()) };
        let (mut neighbours, mut different) = (0, 0);
        for (number, job) in (0..).zip(&self.jobs) {
            let expected = search(&self.image, 0, *job, &self.parameters);
            neighbours += expected.neighbours.len();
            let is_same = searches.replies.get(&number) == Some(&(expected.status, expected.neighbours));
            different += usize::from(!is_same);
        }
        let count = self.jobs.len();
        writeln!(out, "Beside them {count} random searches with {neighbours} neighbours: {different} mismatches.")?;
        if different > 0 {
            return Err(CliError::Mismatch(format!("netlist and functional model differ for {different} searches")));
        }
        Ok(())
    }
}
