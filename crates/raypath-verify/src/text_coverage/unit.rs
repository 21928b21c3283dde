//! A traversal unit, with the scenes, rays, memories and users of the channels of its campaign.

use super::design::{Design, Run, episodes_of};
use crate::Error;
use crate::unit::campaign::{DEEP_RAYS, Episode, episode_random};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_hdl::{Module, verilog};
use raypath_rtl::Config;
use raypath_tools::CoveragePoint;
use raypath_unit::traffic::{BlockScene, Recorder, invalid_child};
use raypath_unit::{LEVELS, UnitModel, UnitNetlist, UnitParameters, outputs_of};
use std::collections::BTreeSet;
use std::sync::Arc;

/// The episodes of a run.
const EPISODES: u64 = 24;
/// Those of them, from the first on, whose rays follow the longest path.
const PATHS: usize = 2;
/// The bits of a ray's number. The rays of an episode need them all.
const ID_WIDTH: u32 = 7;

/// The bits of a count of nodes or triangles that count.
const COUNT_BITS: u32 = 8;

/// A traversal unit.
pub struct UnitDesign(UnitNetlist);

impl UnitDesign {
    pub fn new(config: Config, parameters: UnitParameters) -> Result<Self, Error> {
        Ok(Self(UnitNetlist::new(config, UnitParameters { id_width: ID_WIDTH, ..parameters })?))
    }
}

impl Design for UnitDesign {
    fn top(&self) -> &Arc<Module> {
        &self.0.top
    }

    /// The modules of the datapath, which are covered as a design of their own.
    fn covered_elsewhere(&self) -> Result<BTreeSet<String>, Error> {
        Ok(verilog::modules(self.0.datapath.top())?.iter().map(|module| module.name().to_string()).collect())
    }

    /// The upper bits of the counts of nodes and triangles: a ray of the campaign visits fewer. The bits inside of a
    /// block of the address of a leaf's next block: the environment checks that they are 0 in all requests.
    fn is_left_out(&self, point: &CoveragePoint) -> bool {
        let Some((name, bit)) = point.name.strip_suffix(']').and_then(|name| name.split_once('[')) else {
            return false;
        };
        let Ok(bit) = bit.parse::<u32>() else { return false };
        let is_count = name.split('_').any(|part| ["nodes", "triangles"].contains(&part));
        let is_address = ["leaf_address", "request_address"].iter().any(|part| name.contains(part));
        let offset_bits = self.0.parameters.step.node.offset_bits();
        is_count && bit >= COUNT_BITS || is_address && bit < offset_bits
    }

    fn omissions(&self) -> Vec<String> {
        vec!["nodes".to_string()]
    }

    /// Episodes one after another, the first with the longest paths, and with blocks anywhere in memory.
    fn run(&self, seed: u64, number: u64, omitted: Option<usize>) -> Result<Run, String> {
        let mut recorder = Recorder::new(UnitModel::of(&self.0), &self.0.top);
        for (place, episode) in episodes_of(number, EPISODES).enumerate() {
            let shape = match omitted {
                None => (place < PATHS).then_some(Shape::Path),
                Some(_) => Some(Shape::Leaf),
            };
            self.record(&mut recorder, shape, &mut episode_random(seed, episode))?;
        }
        let (frames, outputs): (Vec<_>, Vec<_>) =
            recorder.cycles.into_iter().map(|cycle| (cycle.frame, cycle.outputs)).unzip();
        let fault = move |cycle: usize, words: &[u64]| {
            let (found, expected) = (outputs_of(words), outputs.get(cycle)?.as_ref()?);
            // Equal texts, because no NaN is equal to itself.
            let (found, expected) = (format!("{found:?}"), format!("{expected:?}"));
            (found != expected).then(|| format!("found {found}, expected {expected}"))
        };
        Ok(Run { frames, fault: Box::new(fault) })
    }
}

/// The shape of a scene.
#[derive(Debug, Clone, Copy)]
enum Shape {
    /// A leaf without nodes.
    Leaf,
    /// A path through all levels, with leaves at each.
    Path,
}

impl UnitDesign {
    /// Runs an episode, whose scene has this shape, if given.
    fn record(
        &self,
        recorder: &mut Recorder<UnitModel>,
        shape: Option<Shape>,
        random: &mut ChaCha8Rng,
    ) -> Result<(), String> {
        let UnitNetlist { parameters, .. } = self.0;
        let mut episode = Episode::new(parameters.step, random);
        let mut root = episode.rays.first().map_or(0, |ray| ray.root);
        match shape {
            None => {}
            Some(Shape::Leaf) => (episode.scene, root) = BlockScene::random_of(parameters.step.node, 1, random),
            Some(Shape::Path) => {
                (episode.scene, root) = BlockScene::deep_of(parameters.step.node, LEVELS, random);
                episode.rays.truncate(DEEP_RAYS);
            }
        }
        if episode.rays.len() == DEEP_RAYS {
            episode = episode.undisturbed();
        }
        root = episode.scene.scatter(root, random);
        for ray in &mut episode.rays {
            // Some roots are not valid, and some rays reach backwards.
            let is_odd = random.random_range(0..16) == 0;
            ray.root = if is_odd { invalid_child(root, parameters.step.node, random) } else { root };
            if random.random_range(0..4) == 0 {
                // A product has all bits of a significand.
                ray.t_min = random.random_range(-3.0..1.0) * random.random_range(0.5..1.0);
            }
        }
        let mut environment =
            episode.environment(parameters, random.random()).ignoring_upper_bits(episode.scene.address_mask());
        environment.reset(&mut [recorder]);
        episode.drive(&mut environment, &mut [recorder], u64::MAX, random).map(|_| ())
    }
}
