//! `raypath search`: nearest-neighbour search with the distance operations, and by jobs of the unit.

mod saved;
mod unit;

use crate::commands::full::{DivisionArguments, MemoryArguments, print_rows, watched, write_and_name};
use crate::{CliError, ConfigArguments, number, whole};
use clap::{Args, ValueEnum};
use raypath_float::Format;
use raypath_ops::Rounding;
use raypath_rtl::{Config, Lanes};
use raypath_search::{
    Clusters, Dataset, Exact, GraphParameters, Layer, Metric, Neighbour, Neighbours, SearchResults, StoredAs, UnitJobs,
    UnitPlace, UnitSearch, UnitSpec, Work, recall, write_ivecs,
};
use raypath_timing::Progress;
use raypath_traversal::search::SearchParameters;
use saved::SavedResults;
use std::io::Write;
use std::ops::Range;
use std::path::PathBuf;
use std::time::Instant;

#[derive(Debug, Args)]
pub struct Arguments {
    /// The vectors to search: .fvecs, .bvecs, .ivecs, .npy, .hdf5 in the layout of ann-benchmarks, or an HNSW graph that
    /// hnswlib or faiss saved (.bin, .hnsw, .index, .faiss) [default: generated vectors]
    base: Option<PathBuf>,
    /// The query vectors; an .hdf5 file has its own
    queries: Option<PathBuf>,
    /// The distance metric [default: that of the .hdf5 file, or euclidean]
    #[arg(long, value_name = "euclidean|angular")]
    metric: Option<Metric>,
    /// The number of neighbours per query
    #[arg(short, long, default_value_t = 10, value_parser = whole(1..=1usize << 20), value_name = "N")]
    k: usize,
    /// Compare with every vector; the default without --index
    #[arg(long, conflicts_with = "index")]
    exact: bool,
    /// Search by jobs of the unit, in its functional model, and time them in its cycle-exact model
    #[arg(long, value_enum, conflicts_with_all = ["shard", "part", "merge"])]
    through: Option<Through>,
    /// The elements of vectors in the unit's memory
    #[arg(long, requires = "through", default_value = "binary32", value_name = "binary32|binary16|int8")]
    elements: StoredAs,
    /// Build an index for the unit
    #[arg(long, value_enum, requires = "through")]
    index: Option<Index>,
    /// The greatest distance of a neighbour, for boxes
    #[arg(long, requires = "index", value_parser = number(0.0..=1e30, "a distance, 0 to 1e30"), value_name = "R")]
    radius: Option<f64>,
    /// The true neighbours: .ivecs or .npy; an .hdf5 file has its own [default with --index: from exact search]
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Write the neighbours found
    #[arg(long, value_name = "FILE.ivecs")]
    out: Option<PathBuf>,
    /// Maximum connections of a vector in the graph
    #[arg(long, requires = "index", default_value_t = 16, value_parser = whole(2..=255usize), value_name = "M")]
    connections: usize,
    /// Candidates kept during construction of the graph
    #[arg(long, requires = "index", default_value_t = 200, value_parser = whole(1..=65_536usize), value_name = "N")]
    ef_construction: usize,
    /// Candidates kept during a graph search [default: five times the neighbours, at most 256]
    #[arg(long, value_parser = whole(1..=MOST_CANDIDATES), value_name = "N")]
    ef: Option<usize>,
    /// Seed of generated vectors and of the graph
    #[arg(long, default_value_t = 1, value_parser = whole(0..=u64::MAX))]
    seed: u64,
    #[command(flatten)]
    unit: unit::UnitArguments,
    #[command(flatten)]
    memory: MemoryArguments,
    #[command(flatten)]
    division: DivisionArguments,
    #[command(flatten)]
    config: ConfigArguments,
}

/// The most candidates of a unit.
const MOST_CANDIDATES: usize = SearchParameters::MOST.candidates as usize;

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Through {
    Unit,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Index {
    /// A hierarchical navigable small-world graph, of which the unit searches the lowest layer
    Hnsw,
    /// A tree of boxes around vectors of 1 to 3 dimensions, of which those within --radius are found
    Boxes,
    /// A tree of keys, which are vectors of one dimension; a query has two, the least and the greatest key
    Keys,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let config = arguments.config.paper()?;
    if config.semantics.format != Format::BINARY32 {
        let problem = format!("--format {}: vectors are searched in fp32 only", config.semantics.format);
        return Err(CliError::unusable(problem));
    }
    if config.semantics.rounding != Rounding::Unit {
        let problem = format!("--rounding {}: vectors are searched with rounding unit only", config.semantics.rounding);
        return Err(CliError::unusable(problem));
    }
    if config.semantics.lanes != Lanes::Sixteen {
        let problem = format!("--lanes {}: vectors are searched with 16 lanes only", config.semantics.lanes);
        return Err(CliError::unusable(problem));
    }
    let dataset = arguments.dataset()?;
    let metric = arguments.metric.or(dataset.metric).unwrap_or(Metric::Euclidean);
    let (base, queries) = (&dataset.base, &dataset.queries);
    let searched = format!("{} vectors of {} dimensions", base.len(), base.dimensions());
    writeln!(out, "{searched}, {} queries, {metric} distance", queries.len())?;
    let tree = arguments.tree()?;
    let is_built = matches!(arguments.index, Some(Index::Hnsw));
    let has_graph = is_built || dataset.layer.is_some() && !arguments.exact && tree.is_none();
    if let Some(ef) = arguments.ef.filter(|_| !has_graph) {
        let problem = format!("--ef {ef}: candidates are kept in a graph, expected --index hnsw or a saved graph");
        return Err(CliError::unusable(problem));
    }
    let graph = is_built.then(|| arguments.graph(&dataset, metric, out)).transpose()?;
    if has_graph && arguments.through.is_none() {
        let problem =
            format!("{}: the unit searches a saved graph, expected --through unit or --exact", arguments.name());
        return Err(CliError::unusable(problem));
    }
    let of_unit = match arguments.through {
        None => None,
        Some(Through::Unit) => {
            let layer = graph.as_ref().or(dataset.layer.as_ref().filter(|_| has_graph));
            let of_graph = layer.map_or(UnitPlace::All, |layer| UnitPlace::Graph(layer, arguments.ef()));
            let spec = UnitSpec {
                base,
                queries,
                metric: metric.into(),
                elements: arguments.elements.elements([base, queries]),
                neighbours: arguments.k,
                bound: f32::INFINITY,
                place: tree.unwrap_or(of_graph),
                unit: SearchParameters::MOST,
            };
            let jobs = UnitJobs::new(&spec)?;
            let found = watched("queries", queries.len(), |progress| jobs.search(progress))?;
            Some((jobs, found))
        }
    };
    let results = match &of_unit {
        Some((_, found)) => found.results(metric),
        None => match arguments.divided(&dataset, metric, config)? {
            Ok(results) => results,
            Err(message) => return Ok(writeln!(out, "{message}")?),
        },
    };
    let mut rows = describe(&results, base.dimensions());
    if let Some((_, found)) = &of_unit {
        let of_query = |total: u64| format!("{:.1}", results.per_query(total));
        rows.push(("bytes that a query reads".to_string(), of_query(found.bytes())));
        rows.push(("candidates that a query expands".to_string(), of_query(found.expansions)));
    }
    if let (Some((_, found)), Some(tree)) = (&of_unit, tree) {
        let differing = arguments.differing(&dataset, tree, found)?;
        rows.push(("queries whose neighbours are not those of a scan".to_string(), differing.to_string()));
    } else if let Some((source, truth)) = arguments.truth(&dataset, metric)? {
        let recall = recall(&results, &truth, base, queries, metric, arguments.k).map_err(CliError::unusable)?;
        rows.push((format!("recall at {} against {source}", arguments.k), format!("{recall:.4}")));
    }
    writeln!(out)?;
    print_rows(&rows, out)?;
    writeln!(out)?;
    let mut files = Vec::new();
    if let Some(path) = &arguments.out {
        let mut bytes = Vec::new();
        write_ivecs(&results, &mut bytes)?;
        files.push((path.clone(), bytes));
    }
    if let Some((jobs, found)) = &of_unit {
        let candidates = if has_graph { arguments.ef() } else { arguments.k };
        let (dimensions, has_tree) = (base.dimensions(), tree.is_some());
        let needs = unit::Needs { neighbours: arguments.k, candidates, dimensions, has_tree };
        let title = format!("{}: {} nearest of {searched}, {metric}", arguments.name(), arguments.k);
        let subject = unit::Subject { title, metric, jobs, found, needs, rows: &rows };
        files.extend(arguments.unit.time(&subject, config, out)?);
    }
    write_and_name(&files, out)
}

impl Arguments {
    fn ef(&self) -> usize {
        self.ef.unwrap_or((5 * self.k).min(MOST_CANDIDATES)).max(self.k)
    }

    /// The tree that is searched.
    fn tree(&self) -> Result<Option<UnitPlace<'static>>, CliError> {
        match (self.index, self.radius) {
            (Some(Index::Boxes), Some(radius)) => Ok(Some(UnitPlace::Boxes(radius as f32))),
            (Some(Index::Boxes), None) => Err(CliError::unusable("--index boxes: expected --radius")),
            (_, Some(radius)) => Err(CliError::unusable(format!("--radius {radius}: expected --index boxes"))),
            (Some(Index::Keys), None) => Ok(Some(UnitPlace::Keys)),
            _ => Ok(None),
        }
    }

    /// The queries whose neighbours have other distances in a tree than among all vectors.
    fn differing(&self, dataset: &Dataset, tree: UnitPlace<'_>, found: &UnitSearch) -> Result<usize, CliError> {
        let Dataset { base, queries, .. } = dataset;
        let scanned: Vec<Vec<f32>> = if let UnitPlace::Boxes(radius) = tree {
            let results = self.exact(dataset, Metric::Euclidean)?;
            let is_near = |near: &&Neighbour| near.distance.powi(2) as f32 <= radius * radius;
            let row = |row: &Vec<Neighbour>| row.iter().filter(is_near).map(|near| near.distance as f32).collect();
            results.rows.iter().map(row).collect()
        } else {
            let mut keys = base.data().to_vec();
            keys.sort_by(f32::total_cmp);
            let row = |range: &[f32]| {
                let from = keys.partition_point(|key| *key < range[0]);
                keys[from..].iter().copied().take_while(|key| *key <= range[1]).take(self.k).collect()
            };
            queries.iter().map(row).collect()
        };
        let differs = |(row, scanned): &(&Vec<_>, &Vec<f32>)| {
            !row.iter().map(|near: &raypath_traversal::search::Neighbour| near.distance).eq(scanned.iter().copied())
        };
        Ok(found.rows.iter().zip(&scanned).filter(differs).count())
    }

    fn name(&self) -> String {
        self.base.as_ref().map_or_else(|| "generated vectors".to_string(), |path| path.display().to_string())
    }

    fn dataset(&self) -> Result<Dataset, CliError> {
        match &self.base {
            Some(base) => Dataset::read(base, self.queries.as_deref(), self.truth.as_deref(), self.memory.limit)
                .map_err(CliError::unusable),
            None if self.truth.is_some() => {
                let problem = "--truth: generated vectors have no file of true neighbours, expected BASE and QUERIES";
                Err(CliError::unusable(problem))
            }
            None => Clusters { seed: self.seed, ..Clusters::default() }.generate().map_err(CliError::unusable),
        }
    }

    fn graph(&self, dataset: &Dataset, metric: Metric, out: &mut dyn Write) -> Result<Layer, CliError> {
        let parameters =
            GraphParameters { connections: self.connections, ef_construction: self.ef_construction, seed: self.seed };
        let (layer, work) = watched("vectors indexed", dataset.base.len(), |progress| {
            Layer::build(&dataset.base, metric, &parameters, progress)
        })?;
        writeln!(out, "the graph took {} beats to build", work.beats)?;
        Ok(layer)
    }

    fn exact(&self, dataset: &Dataset, metric: Metric) -> Result<SearchResults, CliError> {
        let Dataset { base, queries, .. } = dataset;
        watched("queries", queries.len(), |progress| Exact::new(base, metric).search(queries, self.k, progress))
    }

    /// An exact search of the shard's queries; or the results of all shards. For a part, its message.
    fn divided(
        &self,
        dataset: &Dataset,
        metric: Metric,
        config: Config,
    ) -> Result<Result<SearchResults, String>, CliError> {
        const TASK: &str = "search";
        let Dataset { base, queries, .. } = dataset;
        let (vectors, dimensions, k, seed) = (base.len(), base.dimensions(), self.k, self.seed);
        let of = format!("{vectors} vectors, {dimensions} dimensions, {} queries", queries.len());
        let mut division = self.division.begin_whole(format!("search {of}, {metric}, k {k}, seed {seed}, {config}"))?;
        let mut parts = division.parts(TASK)?;
        let begin = Instant::now();
        let shards = parts.phase(|| {
            let Range { start, end } = self.division.shard().range(queries.len() as u64);
            let Some(queries) = queries.range(start as usize..end as usize) else { return Ok(SavedResults::default()) };
            let search = |progress: Progress<'_>| Exact::new(base, metric).search(&queries, k, progress);
            let results = watched("queries", queries.len(), search)?;
            Ok::<_, CliError>(SavedResults::from(results))
        })?;
        division.keep(TASK, parts, begin.elapsed().as_secs_f64());
        let message = division.write()?;
        Ok(message.map_or_else(|| Ok(SearchResults::joined(shards.into_iter().map(SearchResults::from))), Err))
    }

    /// The truth for recall, with its source. Exact search uses the truth of the file only.
    fn truth(&self, dataset: &Dataset, metric: Metric) -> Result<Option<(&'static str, Neighbours)>, CliError> {
        let is_of_metric = dataset.metric.is_none_or(|own| own == metric);
        match &dataset.truth {
            Some(truth) if is_of_metric => Ok(Some(("the file's truth", truth.clone()))),
            _ if self.index.is_some() || self.through.is_some() => {
                let results = self.exact(dataset, metric)?;
                let indices: Vec<i64> = results.rows.iter().flatten().map(|near| i64::from(near.index)).collect();
                let neighbours = Neighbours::new(self.k, &indices, dataset.base.len()).map_err(CliError::unusable)?;
                Ok(Some(("exact search", neighbours)))
            }
            _ => Ok(None),
        }
    }
}

fn describe(results: &SearchResults, dimensions: usize) -> Vec<(String, String)> {
    let Work { evaluations, beats } = results.work;
    let of_vector = |metric: Metric| metric.beats(dimensions).to_string();
    vec![
        ("queries per second, functional model".to_string(), format!("{:.1}", results.queries_per_second())),
        ("distances".to_string(), evaluations.to_string()),
        ("distances of a query".to_string(), format!("{:.1}", results.per_query(evaluations))),
        ("beats".to_string(), beats.to_string()),
        ("beats of a query".to_string(), format!("{:.1}", results.per_query(beats))),
        ("beats of a vector, euclidean (16 lanes)".to_string(), of_vector(Metric::Euclidean)),
        ("beats of a vector, angular (8 lanes)".to_string(), of_vector(Metric::Angular)),
    ]
}
