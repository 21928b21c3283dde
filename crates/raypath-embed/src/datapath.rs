use crate::general::General;
use crate::job::{Beat, Job, Outcome, no_operation};
use crate::layout::{Bounds, QuadboxResult, Ray, TriangleResult, Vertices};
use crate::state::owner;
use crate::{Error, native};
use raypath_float::Format;
use raypath_model::{Shape, ShortFormat, WordModel};
use raypath_ops::{EdgeRule, JobKind, Port, Rounding, Rules};
use raypath_oracle::added_operation;
use raypath_rtl::{self as rtl, Config, Features, Lanes, Semantics, package};
use raypath_sim::files::{in_folder, write_all};
use raypath_sim::{OperationId, configuration, engine};
use std::path::Path;

/// A datapath: a configuration with its operations, netlist and models. It does not change, so that threads share it.
///
/// ```
/// use raypath_embed::{Bounds, Datapath, QuadboxResult, Ray};
///
/// let datapath = Datapath::open("preset = \"credit\"", &[])?;
/// let ray = Ray::new([0.0, 0.0, -5.0], [0.0, 0.0, 1.0], f32::INFINITY)?;
/// let boxes = [Bounds { min: [-1.0; 3], max: [1.0; 3] }; 4];
/// let mut results = [QuadboxResult::default()];
/// datapath.quadbox(&[ray], &[boxes], &mut results)?;
/// assert_eq!((results[0].is_intersect, results[0].tmin), ([1; 4], [4.0; 4]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Datapath {
    whole: raypath_sim::Datapath,
    netlist: rtl::DatapathNetlist,
    shape: Shape,
    description: String,
    model: WordModel,
}

impl Datapath {
    /// The datapath of a configuration as TOML (`docs/reference/configurations.md`; an empty text is the default), and
    /// of added operations by name (`docs/reference/operations.md`).
    ///
    /// # Errors
    /// Text that is not a configuration, with its line; a name that is not an added operation; what cannot be
    /// elaborated.
    pub fn open(toml: &str, added: &[&str]) -> Result<Self, Error> {
        Self::new(configuration::parse(toml, Path::new("configuration"))?, added)
    }

    /// The datapath of a configuration and of added operations by name.
    ///
    /// # Errors
    /// Those of [`open`](Self::open), except those of the text.
    pub fn new(config: Config, added: &[&str]) -> Result<Self, Error> {
        config.check()?;
        let mut whole = raypath_sim::Datapath::paper(config);
        for name in added {
            let unknown = |expected| Error::Argument(format!("'{name}' is not an added operation, {expected}"));
            whole = whole.with_any(added_operation(name).map_err(unknown)?.operation());
        }
        let netlist = whole.elaborate()?;
        let description =
            if added.is_empty() { config.to_string() } else { format!("{config}, with {}", added.join(", ")) };
        Ok(Self { shape: engine::shape(config, &netlist), model: whole.model(), description, netlist, whole })
    }

    /// The configuration and the added operations in words.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// A digest of the configuration, of the added operations and of the release.
    pub fn digest(&self) -> String {
        owner(&self.description)
    }

    /// The configuration.
    pub fn config(&self) -> Config {
        self.whole.config()
    }

    /// The elaborated netlist, with schedule, units and registers.
    pub fn netlist(&self) -> &rtl::DatapathNetlist {
        &self.netlist
    }

    /// The properties of the pipeline that determine its timing.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// The operations in the order of their opcodes.
    pub fn operations(&self) -> Vec<OperationId> {
        self.model.kinds()
    }

    /// The operation of this name.
    ///
    /// # Errors
    /// A datapath without it.
    pub fn operation(&self, name: &str) -> Result<OperationId, Error> {
        self.model.kind(name).ok_or_else(|| no_operation(&self.operations(), name))
    }

    /// The ports of an operation's jobs, without those of the handshake and the opcode.
    pub fn inputs(&self, operation: OperationId) -> &[Port] {
        self.model.inputs(operation)
    }

    /// The ports of an operation's outcomes.
    pub fn outputs(&self, operation: OperationId) -> &[Port] {
        self.model.outputs(operation)
    }

    /// The coordinates of a Euclidean beat; an angular beat has half as many. 0 without distance operations.
    pub fn lanes(&self) -> usize {
        self.config().semantics.lanes.count()
    }

    /// The number of flip-flops of the netlist.
    pub fn flip_flops(&self) -> u64 {
        self.netlist.top().register_bits()
    }

    /// Tests each ray against four boxes, and sorts the boxes of each job.
    ///
    /// # Errors
    /// Slices of different lengths; a datapath without the operation.
    pub fn quadbox(&self, rays: &[Ray], boxes: &[[Bounds; 4]], results: &mut [QuadboxResult]) -> Result<(), Error> {
        self.operation(JobKind::Quadbox.name())?;
        same_length("boxes", boxes.len(), "rays", rays.len())?;
        same_length("results", results.len(), "rays", rays.len())?;
        match self.native_semantics() {
            Some(semantics) => native::quadbox(semantics, rays, boxes, results),
            None => {
                let mut general = General::new(self);
                let jobs = rays.iter().zip(boxes);
                for ((ray, boxes), result) in jobs.zip(results) {
                    if let Outcome::Quadbox(found) = general.run(&Job::Quadbox { ray, boxes }) {
                        *result = found;
                    }
                }
            }
        }
        Ok(())
    }

    /// Tests each ray against a triangle. With the feature `range`, the rays begin at a distance of 0.
    ///
    /// # Errors
    /// Slices of different lengths; a datapath without the operation.
    pub fn triangle(&self, rays: &[Ray], triangles: &[Vertices], results: &mut [TriangleResult]) -> Result<(), Error> {
        self.operation(JobKind::Triangle.name())?;
        same_length("triangles", triangles.len(), "rays", rays.len())?;
        same_length("results", results.len(), "rays", rays.len())?;
        match self.native_semantics() {
            Some(semantics) => native::triangle(semantics, rays, triangles, results),
            None => {
                let mut general = General::new(self);
                let jobs = rays.iter().zip(triangles);
                for ((ray, triangle), result) in jobs.zip(results) {
                    if let Outcome::Triangle(found) = general.run(&Job::Triangle { ray, triangle }) {
                        *result = found;
                    }
                }
            }
        }
        Ok(())
    }

    /// Computes the squared Euclidean distance of each pair of vectors: `dimensions` numbers of `a` and of `b` for each
    /// distance. Vectors are divided into beats; the last is masked.
    ///
    /// # Errors
    /// No dimensions; slices of other lengths; a datapath without the operation.
    pub fn euclidean(&self, a: &[f32], b: &[f32], dimensions: usize, distances: &mut [f32]) -> Result<(), Error> {
        self.operation(JobKind::Euclidean.name())?;
        vectors(a, b, dimensions, distances.len())?;
        if distances.is_empty() {
            return Ok(());
        }
        let Some(semantics) = self.native_semantics() else {
            let mut general = General::new(self);
            let pairs = a.chunks(dimensions).zip(b.chunks(dimensions));
            for ((a, b), distance) in pairs.zip(distances) {
                for beat in beats(a, b, self.lanes()) {
                    if let Outcome::Euclidean(found) = general.run(&Job::Euclidean(beat)) {
                        *distance = found.accumulator;
                    }
                }
            }
            return Ok(());
        };
        match semantics.lanes {
            Lanes::None | Lanes::Two => native::euclidean::<2>(semantics, a, b, dimensions, distances),
            Lanes::Four => native::euclidean::<4>(semantics, a, b, dimensions, distances),
            Lanes::Eight => native::euclidean::<8>(semantics, a, b, dimensions, distances),
            Lanes::Sixteen => native::euclidean::<16>(semantics, a, b, dimensions, distances),
            Lanes::ThirtyTwo => native::euclidean::<32>(semantics, a, b, dimensions, distances),
            Lanes::SixtyFour => native::euclidean::<64>(semantics, a, b, dimensions, distances),
        }
        Ok(())
    }

    /// Computes the dot product of each pair of vectors, and the squared norm of the vector of `b`. Shapes are those of
    /// [`euclidean`](Self::euclidean).
    ///
    /// # Errors
    /// Those of [`euclidean`](Self::euclidean).
    pub fn angular(
        &self,
        a: &[f32],
        b: &[f32],
        dimensions: usize,
        dot_products: &mut [f32],
        norms: &mut [f32],
    ) -> Result<(), Error> {
        self.operation(JobKind::Angular.name())?;
        vectors(a, b, dimensions, dot_products.len())?;
        same_length("norms", norms.len(), "dot products", dot_products.len())?;
        if norms.is_empty() {
            return Ok(());
        }
        let Some(semantics) = self.native_semantics() else {
            let mut general = General::new(self);
            let pairs = a.chunks(dimensions).zip(b.chunks(dimensions));
            for ((a, b), (dot, norm)) in pairs.zip(dot_products.iter_mut().zip(norms)) {
                for beat in beats(a, b, self.lanes() / 2) {
                    if let Outcome::Angular(found) = general.run(&Job::Angular(beat)) {
                        (*dot, *norm) = (found.dot_product, found.norm);
                    }
                }
            }
            return Ok(());
        };
        match semantics.lanes {
            Lanes::None | Lanes::Two => native::angular::<1>(semantics, a, b, dimensions, dot_products, norms),
            Lanes::Four => native::angular::<2>(semantics, a, b, dimensions, dot_products, norms),
            Lanes::Eight => native::angular::<4>(semantics, a, b, dimensions, dot_products, norms),
            Lanes::Sixteen => native::angular::<8>(semantics, a, b, dimensions, dot_products, norms),
            Lanes::ThirtyTwo => native::angular::<16>(semantics, a, b, dimensions, dot_products, norms),
            Lanes::SixtyFour => native::angular::<32>(semantics, a, b, dimensions, dot_products, norms),
        }
        Ok(())
    }

    /// Computes jobs of any operation, in order: a word for each of its [`inputs`](Self::inputs), job after job, to a
    /// word for each of its [`outputs`](Self::outputs). Numbers are in the IEEE 754 layout of the datapath's format.
    /// Accumulators are zero before the first job.
    ///
    /// # Errors
    /// A datapath without the operation; slices whose lengths do not belong to the same number of jobs.
    pub fn run(&self, operation: OperationId, inputs: &[u64], outputs: &mut [u64]) -> Result<(), Error> {
        self.run_watched(operation, inputs, outputs, &|_| true)
    }

    /// As [`run`](Self::run). `progress` gets the number of outcomes now and then, and returns false to stop.
    ///
    /// # Errors
    /// Those of [`run`](Self::run).
    pub fn run_watched(
        &self,
        operation: OperationId,
        inputs: &[u64],
        outputs: &mut [u64],
        progress: &dyn Fn(u64) -> bool,
    ) -> Result<(), Error> {
        let [per_job, per_outcome] = [self.inputs(operation).len(), self.outputs(operation).len()];
        if per_job == 0 || per_outcome == 0 {
            return Err(no_operation(&self.operations(), operation.name()));
        }
        if !inputs.len().is_multiple_of(per_job) || outputs.len() != inputs.len() / per_job * per_outcome {
            let (given, room) = (inputs.len(), outputs.len());
            let problem = format!(
                "{given} words of input and {room} of output, expected {per_job} and {per_outcome} for each job of \
                 {operation}"
            );
            return Err(Error::Argument(problem));
        }
        let mut model = self.model.clone();
        for (job, (inputs, outputs)) in (0..).zip(inputs.chunks(per_job).zip(outputs.chunks_mut(per_outcome))) {
            if job % 1024 == 0 && !progress(job) {
                break;
            }
            let outcome = raypath_model::Model::run(&mut model, &self.model.job_of_words(operation, inputs));
            outputs.copy_from_slice(outcome.as_words());
        }
        Ok(())
    }

    /// Writes SystemVerilog, assertions, wrapper, manifests and a picture into a folder, as `raypath generate` does.
    /// Returns the number of files.
    ///
    /// # Errors
    /// A file or folder that cannot be written; then no file is changed.
    pub fn generate(&self, folder: &Path) -> Result<usize, Error> {
        let files = package::design(&self.netlist, self.config(), &self.description, package::PERIOD_NS)?;
        let count = files.len();
        write_all(&in_folder(folder, files))?;
        Ok(count)
    }

    /// The functional model, with accumulators of zero.
    pub(crate) fn model(&self) -> WordModel {
        self.model.clone()
    }

    /// The semantics, if arrays of the paper's operations can be computed in SIMD lanes. Features that typed jobs do
    /// not show, such as a tag, change nothing.
    fn native_semantics(&self) -> Option<Semantics> {
        let semantics = self.config().semantics;
        let rounds_every_number =
            semantics.rounding == Rounding::Unit && !matches!(semantics.rules_in_full(), Rules::Bounds(_));
        // Lanes know the residues of binary32 alone.
        let has_residues = semantics.features.edges == EdgeRule::Once;
        let is_short = || rounds_every_number && !has_residues && ShortFormat::lanes(semantics.format).is_some();
        let is_native = semantics.format == Format::BINARY32 || is_short();
        (is_native && !semantics.features.quantised_boxes).then_some(semantics)
    }

    /// The rules, if single jobs can be computed in native binary32.
    pub(crate) fn native_rules(&self) -> Option<Rules> {
        let Semantics { format, features, rules, rounding, .. } = self.config().semantics;
        let is_native = format == Format::BINARY32 && rounding == Rounding::Unit && features == Features::OFF;
        is_native.then_some(rules)
    }
}

pub(crate) fn same_length(what: &str, found: usize, like: &str, expected: usize) -> Result<(), Error> {
    let problem = || Error::Argument(format!("{found} {what} and {expected} {like}, expected as many"));
    if found == expected { Ok(()) } else { Err(problem()) }
}

fn vectors(a: &[f32], b: &[f32], dimensions: usize, count: usize) -> Result<(), Error> {
    if dimensions == 0 {
        return Err(Error::Argument("vectors of 0 dimensions, expected at least 1".to_string()));
    }
    if count.checked_mul(dimensions) != Some(a.len()) || a.len() != b.len() {
        let (a, b) = (a.len(), b.len());
        let problem = format!("{a} and {b} numbers, expected {count} vectors of {dimensions} dimensions each");
        return Err(Error::Argument(problem));
    }
    Ok(())
}

/// The beats of two vectors, with up to `lanes` coordinates each. The last has `reset_accum` set.
fn beats<'v>(a: &'v [f32], b: &'v [f32], lanes: usize) -> impl Iterator<Item = Beat<'v>> {
    let last = a.len().div_ceil(lanes) - 1;
    let chunks = a.chunks(lanes).zip(b.chunks(lanes)).enumerate();
    chunks.map(move |(i, (a, b))| Beat { a, b, mask: u64::MAX >> (64 - a.len()), reset_accum: i == last })
}
