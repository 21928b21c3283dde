//! A traversal unit, with the scenes, rays, memories and users of the channels of its campaign.

use super::design::{Design, Run, episodes_of};
use rand::RngExt;
use raypath_hdl::{Module, verilog};
use raypath_rtl::Config;
use raypath_tools::CoveragePoint;
use raypath_traversal::traffic::{BlockScene, RecordedEngine, invalid_child};
use raypath_traversal::{UnitModel, UnitNetlist, UnitParameters, outputs_of};
use raypath_verify::Error;
use raypath_verify_traversal::campaign::Episode;
use std::collections::BTreeSet;
use std::sync::Arc;

/// The episodes of a run.
const EPISODES: u64 = 24;
/// The bits of a ray's number. The rays of an episode need them all.
const ID_WIDTH: u32 = 7;

/// The bits of a count of nodes or triangles that count.
const COUNT_BITS: u32 = 8;

/// A traversal unit.
pub struct UnitDesign(UnitNetlist);

impl UnitDesign {
    pub fn new(config: Config, parameters: UnitParameters) -> Result<Self, Error> {
        Ok(Self(UnitNetlist::new(config, UnitParameters { id_width: ID_WIDTH, ..parameters }).map_err(Error::subject)?))
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

    fn c_optimisation(&self) -> u32 {
        1
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

    /// Episodes one after another, with blocks anywhere in memory.
    fn run(&self, seed: u64, number: u64, omitted: Option<usize>) -> Result<Run, String> {
        let mut recorder = RecordedEngine::new(UnitModel::of(&self.0), &self.0.top);
        for number in episodes_of(number, EPISODES) {
            self.record(&mut recorder, omitted.is_none(), [seed, number])?;
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

impl UnitDesign {
    /// Runs the episode of a seed and a number, whose scene is a single leaf if it has no nodes.
    fn record(
        &self,
        recorder: &mut RecordedEngine<UnitModel>,
        has_nodes: bool,
        [seed, number]: [u64; 2],
    ) -> Result<(), String> {
        let UnitNetlist { parameters, .. } = self.0;
        let (mut episode, mut random) = Episode::of(parameters.step, seed, number);
        let mut root = episode.rays.first().map_or(0, |ray| ray.root);
        if !has_nodes {
            (episode.scene, root) = BlockScene::random_of(parameters.step.node, 1, &mut random);
        }
        root = episode.scene.scatter(root, &mut random);
        for ray in &mut episode.rays {
            // Some roots are not valid, and some rays reach backwards.
            let is_odd = random.random_range(0..16) == 0;
            ray.root = if is_odd { invalid_child(root, parameters.step.node, &mut random) } else { root };
            if random.random_range(0..4) == 0 {
                // A product has all bits of a significand.
                ray.t_min = random.random_range(-3.0..1.0) * random.random_range(0.5..1.0);
            }
        }
        let mut environment =
            episode.environment(parameters, random.random()).ignoring_upper_bits(episode.scene.address_mask());
        environment.reset(&mut [recorder]);
        episode.drive(&mut environment, &mut [recorder], u64::MAX, &mut random).map(|_| ())
    }
}
