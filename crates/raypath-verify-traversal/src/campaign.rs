//! A campaign of the whole unit: netlist and functional model return the same for random scenes, rays, memories and
//! users of the channels, and the cycle-exact model has the netlist's outputs in every cycle.

use crate::built;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_ops::Rules;
use raypath_rtl::{Config, Control};
use raypath_traversal::blocks::NodeKind;
use raypath_traversal::search::{SearchImage, SearchParameters, SearchReply, SearchStatus, Searches, search};
use raypath_traversal::state::status;
use raypath_traversal::traffic::{
    Behaviour, BlockScene, Environment, SearchBehaviour, SearchTraffic, TwoLevelScene, random_ray, random_searches,
    verdict_of,
};
use raypath_traversal::{
    Front, LEVELS, NODE_LIMIT, NetlistEngine, Queries, RayRequest, Reply, StepParameters, Unit, UnitEngine,
    UnitFeatures, UnitModel, UnitNetlist, UnitParameters,
};
use raypath_verify::Error;
use serde::{Deserialize, Serialize};

/// What episodes had in common, and what they found.
#[derive(Debug, Default, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// Episodes that ran.
    pub episodes: u64,
    /// Cycles of netlists.
    pub cycles: u64,
    /// Rays that ended as the functional model says.
    pub rays: u64,
    /// Searches that ended as the functional model says.
    pub searches: u64,
    /// Rays and searches that ended in an error of the memory.
    pub errors: u64,
    /// Rays that a reset ended.
    pub lost: u64,
    /// Resets while rays were inside.
    pub resets: u64,
}

impl Counts {
    /// Adds the counts of other episodes.
    pub fn add(&mut self, other: &Self) {
        self.episodes += other.episodes;
        self.cycles += other.cycles;
        self.rays += other.rays;
        self.searches += other.searches;
        self.errors += other.errors;
        self.lost += other.lost;
        self.resets += other.resets;
    }
}

/// The rays of an episode.
const RAYS: usize = 96;
/// The rays of an episode whose rays visit thousands of nodes.
const DEEP_RAYS: usize = 8;

/// The searches of an episode.
const SEARCHES: usize = 12;

/// Barycentric coordinates alone.
const WEIGHTS: UnitFeatures = UnitFeatures { barycentrics: true, ..UnitFeatures::OFF };

/// A unit of the campaign: the flow control of its datapath, and its parameters.
type Setting = (Control, UnitParameters);

const fn unit(
    control: Control,
    [contexts, stack, memory_width, id_width, divider_latency, ram_latency]: [u32; 6],
) -> Setting {
    let (node, front) = (NodeKind::Wide4, Front::CounterClockwise);
    let step = StepParameters { stack, node, front, node_limit: NODE_LIMIT, features: UnitFeatures::OFF };
    (
        control,
        UnitParameters {
            contexts,
            step,
            memory_width,
            divider_latency,
            id_width,
            address_width: 32,
            ram_latency,
            parity: false,
            search: Searches(None),
        },
    )
}

/// Rays end with an error before they have read many nodes.
const fn short((control, mut parameters): Setting) -> Setting {
    parameters.step.node_limit = 12;
    (control, parameters)
}

/// With searches.
const fn searching((control, mut parameters): Setting) -> Setting {
    parameters.search = Searches(Some(SearchParameters {
        neighbours: 40,
        candidates: 40,
        contexts: 3,
        dimensions: 100,
        blocks: 64,
        remembered: 64,
        turns: 2,
        trees: 1,
    }));
    (control, parameters)
}

const fn with((control, mut parameters): Setting, node: NodeKind, features: UnitFeatures) -> Setting {
    (parameters.step.node, parameters.step.features) = (node, features);
    (control, parameters)
}

/// Contexts, entries of the stack, bits of the memory and of ids, latencies of division and of the memories of a step;
/// nodes and features.
const UNITS: [Setting; 8] = [
    searching(unit(Control::Skid, [8, 2, 256, 16, 2, 1])),
    searching(unit(Control::Credit, [16, 4, 512, 64, 9, 2])),
    with(unit(Control::Credit, [11, 8, 128, 4, 1, 1]), NodeKind::Wide4, WEIGHTS),
    unit(Control::Skid, [64, 16, 1024, 7, 5, 1]),
    with(unit(Control::Skid, [32, 32, 512, 16, 27, 2]), NodeKind::Wide4, WEIGHTS),
    with(unit(Control::Credit, [9, 2, 128, 4, 9, 2]), NodeKind::Wide8, UnitFeatures { instances: true, ..WEIGHTS }),
    with(
        short(unit(Control::Skid, [40, 2, 512, 16, 2, 1])),
        NodeKind::Quantised,
        UnitFeatures { instances: true, ..WEIGHTS },
    ),
    with(unit(Control::Skid, [12, 2, 512, 5, 3, 2]), NodeKind::Wide4, UnitFeatures::ALL),
];

/// The units of the campaign.
///
/// # Errors
/// A unit cannot be built.
pub fn units() -> Result<Vec<UnitNetlist>, Error> {
    UNITS.into_iter().map(|(control, parameters)| built(Config::DEFAULT.control(control), parameters)).collect()
}

/// What is random in an episode.
pub struct Episode {
    /// The scene.
    pub scene: BlockScene,
    /// The rays, whose numbers are their places.
    pub rays: Vec<RayRequest>,
    /// The searches of a unit that has them: their memory, and the addresses of jobs.
    searches: Option<(SearchImage, Vec<u32>)>,
    behaviour: Behaviour,
    /// The cycles of the longest stall.
    longest_stall: u64,
    /// Rays may end in an error of the scene.
    is_odd: bool,
    /// The probability of a reset in a cycle, in 65,536ths.
    resets: u32,
}

impl Episode {
    /// The episode with this number in the campaign of this seed, for a unit with these parameters, and the generator
    /// of what else is random in it.
    ///
    /// One in nine, so that each of eight units in turn has its share, has a scene as deep as a unit can walk, and no
    /// reset and no error that ends a ray before.
    pub fn of(unit: UnitParameters, seed: u64, number: u64) -> (Self, ChaCha8Rng) {
        let StepParameters { node, features, .. } = unit.step;
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(number);
        let random = &mut generator;
        let is_deepest = number % 9 == 8;
        let has_instances = features.instances && !is_deepest && random.random_range(0..4) > 0;
        let size = if is_deepest { 4 } else { random.random_range(0..5) };
        let is_odd = has_instances && random.random();
        let ((scene, root), count) = match [1, 8, 40, 300].get(size) {
            _ if has_instances => {
                let TwoLevelScene { blocks, root, .. } =
                    TwoLevelScene::random(node, 1 + 4 * size as u32, is_odd, random);
                ((blocks, root), RAYS)
            }
            Some(&triangles) => (BlockScene::random_of(node, triangles, random), RAYS),
            None if is_deepest => (BlockScene::deep_of(node, LEVELS, random), DEEP_RAYS),
            // The last of these is too deep.
            None => (BlockScene::deep_of(node, random.random_range(30..66), random), DEEP_RAYS),
        };
        let (mut scene, mut root) = (scene, root);
        if features.queries != Queries::None {
            root = scene.give_geometries(root, features.queries, random);
        }
        let rays = (0..count).map(|_| random_ray(root, random)).collect();
        // A slow memory would take most of the cycles of deep scenes.
        let slowest = if count == DEEP_RAYS { 2 } else { 4 };
        let least = [1, 1, 5, 40][random.random_range(0..slowest)];
        let latency = (least, least + [0, 3, 60, 460][random.random_range(0..slowest)]);
        let longest_stall = [1, 1, 1, 200][random.random_range(0..4)];
        let shares = if longest_stall == 1 { [0, 0, 26, 128, 240] } else { [0, 1, 2, 4, 8] };
        let stalls = std::array::from_fn(|_| shares[random.random_range(0..5)]);
        let errors = if is_odd { 0 } else { [0, 0, 200, 4000][random.random_range(0..4)] };
        let resets = [0, 0, 40, 400][random.random_range(0..4)];
        let (errors, resets) = if is_deepest { (0, 0) } else { (errors, resets) };
        let behaviour = Behaviour { latency, stalls, errors };
        let searches = unit.search.0.and_then(|searches| {
            let mut image = SearchImage::new();
            let jobs = random_searches(random.random(), SEARCHES, searches, &mut image).ok()?;
            Some((image, jobs))
        });
        (Self { scene, rays, searches, behaviour, longest_stall, is_odd, resets }, generator)
    }

    /// What searches find, by the functional model.
    fn found(&self, parameters: UnitParameters) -> Vec<SearchReply> {
        let (Some((image, jobs)), Some(searches)) = (&self.searches, parameters.search.0) else { return Vec::new() };
        jobs.iter().map(|job| search(image, 0, *job, &searches)).collect()
    }

    /// The memory with the scene, and the users of the other channels.
    pub fn environment(&self, parameters: UnitParameters, seed: u64) -> Environment<'_> {
        let mut environment = Environment::new(&self.scene.0, parameters, self.rays.clone(), self.behaviour, seed)
            .with_longest_stall(self.longest_stall);
        environment.searches = self.searches.as_ref().map(|(image, jobs)| {
            let Behaviour { latency, stalls, errors } = self.behaviour;
            let memory_width = parameters.memory_width;
            let behaviour = SearchBehaviour { latency, stalls: stalls[1], errors, memory_width };
            SearchTraffic::new(image, jobs.clone(), behaviour, seed)
        });
        environment
    }

    /// Drives engines in lockstep until all rays have ended or were lost, in at most so many cycles. Returns the number
    /// of resets and flushes.
    ///
    /// # Errors
    /// What the engines did wrong.
    pub fn drive(
        &self,
        environment: &mut Environment<'_>,
        engines: &mut [&mut dyn UnitEngine],
        limit: u64,
        random: &mut ChaCha8Rng,
    ) -> Result<u64, String> {
        let mut resets = 0;
        while !environment.is_done() {
            if random.random_range(0..65_536) < self.resets && resets < MOST_RESETS {
                // A unit that is flushed is not reset: both lose the rays inside.
                match random.random() {
                    true => environment.reset(engines, true),
                    false => environment.flush(),
                }
                resets += 1;
            }
            environment.cycle(engines).map_err(|problem| problem.to_string())?;
            if environment.idle() > IDLE || environment.cycles() > limit {
                let (ended, cycles) = (environment.replies.len(), environment.cycles());
                return Err(format!("{ended} of {} rays ended within {cycles} cycles", self.rays.len()));
            }
        }
        Ok(resets)
    }
}

/// Runs the episode of a seed and a number on a unit; if `is_tight`, in at most four times the cycles that the
/// cycle-exact model takes.
///
/// # Errors
/// What the unit did wrong.
pub fn run(
    netlist: &mut NetlistEngine,
    unit: &UnitNetlist,
    [seed, number]: [u64; 2],
    is_tight: bool,
) -> Result<Counts, String> {
    let (mut cycle_exact, parameters) = (UnitModel::of(unit), unit.parameters);
    let (episode, mut random) = Episode::of(parameters, seed, number);
    netlist.restart_randomly(random.random());
    let (seed, of_resets) = (random.random(), random.random());
    let resets = || ChaCha8Rng::seed_from_u64(of_resets);
    let mut environment = episode.environment(parameters, seed);
    let Episode { scene, rays, behaviour, longest_stall, is_odd, .. } = &episode;
    let (behaviour, longest_stall) = (*behaviour, *longest_stall);
    let mut counts = Counts { episodes: 1, ..Counts::default() };
    let mut model = Unit::new(Rules::Paper, parameters.step);
    let expected: Vec<Reply> = rays.iter().map(|ray| model.trace_with(&scene.0[..], ray, &mut verdict_of)).collect();
    let expected_searches = episode.found(parameters);
    let limit = if is_tight {
        let mut alone = episode.environment(parameters, seed);
        episode.drive(&mut alone, &mut [&mut UnitModel::of(unit)], u64::MAX, &mut resets())?;
        4 * alone.cycles()
    } else {
        let blocks: u64 = expected.iter().map(|reply| u64::from(2 * reply.nodes + reply.triangles) + 4).sum();
        let of_searches = expected_searches.iter().map(|reply| 2 * reply.counts.blocks + 40).sum::<u64>();
        limit(blocks + of_searches, behaviour, longest_stall)
    };
    counts.resets = episode.drive(&mut environment, &mut [netlist, &mut cycle_exact], limit, &mut resets())?;
    // Rays that end in an error in any memory: a block with an error may have ended them instead.
    let mut always = 0;
    for (&id, reply) in &environment.replies {
        let expected = expected[id as usize];
        // An error of the memory ends a ray earlier.
        let is_error = behaviour.errors > 0 && reply.status == status::MEMORY && expected.status != status::REFUSED;
        if format!("{reply:?}") == format!("{expected:?}") {
            always += u64::from(reply.status >= status::MEMORY);
        } else if is_error
            && reply.hit.is_none()
            && reply.nodes <= expected.nodes
            && reply.triangles <= expected.triangles
        {
            counts.errors += 1;
        } else {
            return Err(format!("ray {id}, {:?}: found {reply:?}, expected {expected:?}", rays[id as usize]));
        }
        counts.rays += 1;
    }
    let (blocks, errors) = (environment.failed_blocks(), counts.errors);
    if counts.resets == 0 && !*is_odd && !(errors..=errors + always).contains(&blocks) {
        return Err(format!("{blocks} blocks had errors, and {errors} rays ended in one"));
    }
    if let Some(searches) = &environment.searches {
        for (id, expected) in (0..).zip(&expected_searches) {
            let Some((found, neighbours)) = searches.replies.get(&id) else { continue };
            if behaviour.errors > 0 && *found == SearchStatus::Memory && neighbours.is_empty() {
                counts.errors += 1;
            } else if (found, neighbours) != (&expected.status, &expected.neighbours) {
                return Err(format!("search {id}: found {found:?}, {neighbours:?}, expected {expected:?}"));
            } else {
                counts.searches += 1;
            }
        }
    }
    counts.lost = (rays.len() - environment.replies.len()) as u64;
    counts.cycles = environment.cycles();
    Ok(counts)
}

/// The most resets in an episode.
const MOST_RESETS: u64 = 8;

/// Cycles after which a unit in which nothing moves has lost a ray. Users of the channels stall for less.
const IDLE: u64 = 4_000;

/// Cycles that suffice for all blocks, one after the other, with the slowest users of the channels.
fn limit(blocks: u64, behaviour: Behaviour, longest_stall: u64) -> u64 {
    let share = u64::from(behaviour.stalls.into_iter().max().unwrap_or(0));
    let slowest = 1 + longest_stall * share / (256 - share);
    20_000 + blocks * (behaviour.latency.1 + 100) * 2 * slowest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_episode_in_nine_walks_the_deepest_scene_to_its_end() {
        for (_, parameters) in UNITS {
            let (episode, _) = Episode::of(parameters, 1, 8);
            assert_eq!((episode.behaviour.errors, episode.resets), (0, 0));
            let mut model = Unit::new(Rules::Paper, parameters.step);
            let nodes = episode.rays.iter().map(|ray| model.trace(&episode.scene.0[..], ray).nodes);
            assert!(nodes.max() >= Some(LEVELS.min(parameters.step.node_limit)), "{parameters}");
        }
    }
}
