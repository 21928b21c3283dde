//! The traversal unit: its functional model, its cycle-exact model and its files.

mod layout;
mod model;
mod query;
mod scene;
mod user;

use crate::Error;
use crate::datapath::same_length;
use crate::state::owner;
pub use layout::{UnitHit, UnitRay};
pub use model::{UnitInputs, UnitModel, UnitOutputs, UnitStalls};
pub use query::{UnitCandidate, UnitQuery, UnitVerdict};
use raypath_rtl::Config;
use raypath_rtl::package::PERIOD_NS;
use raypath_sim::configuration;
use raypath_sim::files::{in_folder, write_all};
use raypath_traversal::search::{SEARCH_BLOCK, SearchReply, search};
use raypath_traversal::system::{SystemParameters, SystemTiming, simulate};
use raypath_traversal::{self as unit, UnitNetlist, UnitParameters};
pub use scene::{SceneGeometry, SceneInput, SceneInstance, UnitScene};
use std::path::Path;
use user::List;

/// A traversal unit: its parameters with its netlist and its functional model. It does not change, so that threads
/// share it.
///
/// ```
/// use raypath_embed::{Unit, UnitHit, UnitRay};
/// use raypath_ops::Triangle;
/// use raypath_traversal::blocks::{Child, LeafTriangle, NodeKind};
///
/// let unit = Unit::open("contexts = 8\npreset = \"compact\"")?;
/// let triangle = Triangle::new([-1.0, -1.0, 3.0], [0.0, 1.0, 3.0], [1.0, -1.0, 3.0]);
/// let scene = LeafTriangle::to_blocks(&[LeafTriangle { triangle, index: 7 }], 0, NodeKind::Wide4).0;
/// let root = Child::Leaf { address: 0, count: 1, is_opaque: true }.word(NodeKind::Wide4)?;
/// let ray = UnitRay { direction: [0.0, 0.0, 2.0], t_max: f32::INFINITY, root, ..UnitRay::default() };
/// let mut hits = [UnitHit::default()];
/// unit.trace(&scene, &[ray], &mut hits)?;
/// assert_eq!((hits[0].status, hits[0].primitive, hits[0].t), (1, 7, 1.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Unit {
    netlist: UnitNetlist,
    functional: unit::Unit,
    description: String,
}

impl Unit {
    /// The unit of a configuration as TOML: the keys of a datapath's configuration
    /// (`docs/reference/configurations.md`), and the names of [`UnitParameters::NAMES`]. An empty text is the default.
    ///
    /// # Errors
    /// Text that is not a configuration, with its line; a datapath that the unit does not have.
    pub fn open(toml: &str) -> Result<Self, Error> {
        let mut parameters = UnitParameters::default();
        let set = &mut |name: &str, value: &str| parameters.set(name, value).unwrap_or(Ok(()));
        let config = configuration::parse_with(toml, Path::new("configuration"), UnitParameters::NAMES, set)?;
        Self::new(config, parameters)
    }

    /// The unit with these parameters, around a datapath of this configuration.
    ///
    /// # Errors
    /// A parameter out of its range; a datapath that the unit does not have.
    pub fn new(config: Config, parameters: UnitParameters) -> Result<Self, Error> {
        let netlist = UnitNetlist::new(config, parameters)?;
        let functional = unit::Unit::new(netlist.config.semantics.rules_in_full(), netlist.parameters.step);
        Ok(Self { description: netlist.description(), functional, netlist })
    }

    /// The parameters of the unit and of its datapath in words.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// A digest of the parameters of the unit, of its datapath and of the release.
    pub fn digest(&self) -> String {
        owner(&self.description)
    }

    /// The parameters of the unit.
    pub fn parameters(&self) -> UnitParameters {
        self.netlist.parameters
    }

    /// The configuration of the datapath, with what the unit needs.
    pub fn config(&self) -> Config {
        self.netlist.config
    }

    /// The netlists of the unit and of its datapath.
    pub fn netlist(&self) -> &UnitNetlist {
        &self.netlist
    }

    /// An error for a ray with a value that its port does not have.
    ///
    /// # Errors
    /// The first such ray, with its index.
    pub fn check(&self, rays: &[UnitRay]) -> Result<(), Error> {
        for (index, ray) in rays.iter().enumerate() {
            ray.check(self.parameters()).map_err(|problem| Error::Argument(format!("ray {index}: {problem}")))?;
        }
        Ok(())
    }

    /// Traces rays through a scene by the functional model. The first byte of the scene has the address 0
    /// (`docs/reference/unit.md`). An address outside of it is an error of the memory.
    ///
    /// # Errors
    /// Slices of different lengths; a ray with a value that its port does not have. Then no hit is written.
    pub fn trace(&self, scene: &[u8], rays: &[UnitRay], hits: &mut [UnitHit]) -> Result<(), Error> {
        self.check(rays)?;
        same_length("hits", hits.len(), "rays", rays.len())?;
        let mut model = self.functional.clone();
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = (&model.trace(scene, &ray.into())).into();
        }
        Ok(())
    }

    /// Does the job of a search at an address of a memory, whose first byte has the address 0, by the functional model.
    /// `base` has the upper 32 bits of all addresses (`docs/reference/searching.md`).
    ///
    /// # Errors
    /// A unit without searches; an address that is not a multiple of 64.
    pub fn search(&self, memory: &[u8], base: u32, job: u32) -> Result<SearchReply, Error> {
        let Some(parameters) = self.parameters().search.0 else {
            return Err(Error::Argument("a unit without searches, expected one with them".to_string()));
        };
        check_address(job)?;
        Ok(search(memory, base, job, &parameters))
    }

    /// Traces rays through a scene by the cycle-exact model of a cluster of such units with a cache and a memory, and returns what the simulation measured.
    /// Rays are offered in order, as soon as the unit is ready, and hits are taken at once. `progress` gets the number
    /// of hits now and then, and returns false to stop the simulation.
    ///
    /// # Errors
    /// Those of [`trace`](Self::trace); a parameter of the system out of its range.
    pub fn simulate(
        &self,
        scene: &[u8],
        rays: &[UnitRay],
        system: &SystemParameters,
        hits: &mut [UnitHit],
        progress: &dyn Fn(u64) -> bool,
    ) -> Result<SystemTiming, Error> {
        self.check(rays)?;
        same_length("hits", hits.len(), "rays", rays.len())?;
        let (shape, parameters) = (self.netlist.shape(), self.netlist.parameters);
        system.check(parameters).map_err(|problem| Error::Argument(problem.to_string()))?;
        Ok(simulate(&shape, parameters, scene, system, &mut List::new(rays, hits, progress)))
    }

    /// Writes SystemVerilog, assertions, the AXI4 wrapper and manifests into a folder, as `raypath generate --unit`
    /// does. Returns the number of files.
    ///
    /// # Errors
    /// A file or folder that cannot be written; then no file is changed.
    pub fn generate(&self, folder: &Path) -> Result<usize, Error> {
        let files = self.netlist.files(PERIOD_NS)?;
        let count = files.len();
        write_all(&in_folder(folder, files))?;
        Ok(count)
    }
}

/// An error for a job at an address that is not that of a block.
fn check_address(job: u32) -> Result<(), Error> {
    if job.is_multiple_of(SEARCH_BLOCK) {
        return Ok(());
    }
    Err(Error::Argument(format!("a job at the address {job:#x}, expected a multiple of {SEARCH_BLOCK}")))
}
