//! `raypath search`: nearest neighbours by the datapath's beats, and how busy the datapath was.

mod timing;

use crate::commands::configuration::ConfigArguments;
use crate::commands::full::timed::{Timed, TimingArguments};
use crate::commands::full::view::{ViewArguments, print_rows};
use crate::commands::numbers::whole;
use crate::commands::output::write_and_name;
use crate::error::CliError;
use crate::progress::watched;
use clap::{Args, ValueEnum};
use raypath_float::Format;
use raypath_rtl::{Config, Lanes};
use raypath_search::{
    Answers, Clusters, Dataset, Exact, Graph, GraphParameters, Metric, Neighbours, Report, recall, write_ivecs,
};
use raypath_timing::report::Table;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct Arguments {
    /// The vectors to search: .fvecs, .bvecs, .ivecs, .npy, or .hdf5 as ann-benchmarks has them [default: generated ones]
    base: Option<PathBuf>,
    /// The vectors to search for; an .hdf5 file brings its own
    queries: Option<PathBuf>,
    /// Which distance [default: what the .hdf5 file says, or euclidean]
    #[arg(long, value_name = "euclidean|angular")]
    metric: Option<Metric>,
    /// How many neighbours
    #[arg(short, long, default_value_t = 10, value_parser = whole(1..=1usize << 20), value_name = "N")]
    k: usize,
    /// Look at every vector, as is done where no index is named
    #[arg(long, conflicts_with = "index")]
    exact: bool,
    /// Look at few vectors, led by an index
    #[arg(long, value_enum)]
    index: Option<Index>,
    /// The true neighbours: .ivecs or .npy; an .hdf5 file brings its own [default: found by exact search with an index]
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Write the neighbours found
    #[arg(long, value_name = "FILE.ivecs")]
    out: Option<PathBuf>,
    /// Connections of a vector in the graph
    #[arg(long, default_value_t = 16, value_parser = whole(2..=255usize), value_name = "M")]
    connections: usize,
    /// Candidates kept while the graph is built
    #[arg(long, default_value_t = 200, value_parser = whole(1..=65_536usize), value_name = "N")]
    ef_construction: usize,
    /// Candidates kept while the graph is searched [default: five times the neighbours]
    #[arg(long, value_parser = whole(1..=65_536usize), value_name = "N")]
    ef: Option<usize>,
    /// Seed of generated vectors and of the graph
    #[arg(long, default_value_t = 1, value_parser = whole(0..=u64::MAX))]
    seed: u64,
    /// Queries under way at a time in the timing
    #[arg(long, default_value_t = 32, value_parser = whole(1..=1usize << 20), value_name = "R")]
    queries_in_flight: usize,
    /// Time so many queries, the first ones [default: as many as take five million beats]
    #[arg(long, value_parser = whole(1..=usize::MAX), value_name = "N")]
    timed: Option<usize>,
    #[command(flatten)]
    timing: TimingArguments,
    #[command(flatten)]
    view: ViewArguments,
    #[command(flatten)]
    config: ConfigArguments,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Index {
    /// A hierarchical navigable small world
    Hnsw,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let config = arguments.config.paper()?;
    if config.semantics.format != Format::BINARY32 {
        let problem = format!("--format {}: vectors are searched in fp32 only", config.semantics.format);
        return Err(CliError::unusable(problem));
    }
    let search = Search { arguments, config, out };
    match config.semantics.lanes {
        Lanes::None => {
            let problem = "--lanes none: a datapath without distances cannot search, expected 2 to 64";
            Err(CliError::unusable(problem))
        }
        Lanes::Two => search.run::<2, 1>(),
        Lanes::Four => search.run::<4, 2>(),
        Lanes::Eight => search.run::<8, 4>(),
        Lanes::Sixteen => search.run::<16, 8>(),
        Lanes::ThirtyTwo => search.run::<32, 16>(),
        Lanes::SixtyFour => search.run::<64, 32>(),
    }
}

/// A search to be done in a datapath of lanes that are known when this is compiled: `E` Euclidean ones, `A` angular.
struct Search<'a> {
    arguments: &'a Arguments,
    config: Config,
    out: &'a mut dyn Write,
}

impl Search<'_> {
    fn run<const E: usize, const A: usize>(self) -> Result<(), CliError> {
        let Self { arguments, config, out } = self;
        let dataset = arguments.dataset()?;
        let metric = arguments.metric.or(dataset.metric).unwrap_or(Metric::Euclidean);
        let (base, queries) = (&dataset.base, &dataset.queries);
        let found = format!("{} vectors of {} dimensions", base.len(), base.dimensions());
        writeln!(out, "{found}, {} queries, {metric} distance", queries.len())?;
        let graph = match arguments.index {
            None => None,
            Some(Index::Hnsw) => Some(arguments.graph::<E, A>(&dataset, metric, out)?),
        };
        let answers = match &graph {
            None => arguments.exact::<E, A>(&dataset, metric)?,
            Some(graph) => {
                watched("queries", queries.len(), |watch| graph.search(queries, arguments.k, arguments.ef(), watch))?
            }
        };
        let mut rows = describe::<E, A>(&answers, base.dimensions());
        if let Some((source, truth)) = arguments.truth::<E, A>(&dataset, metric)? {
            let recall =
                recall::<E, A>(&answers, &truth, base, queries, metric, arguments.k).map_err(CliError::unusable)?;
            rows.push((format!("recall at {} against {source}", arguments.k), format!("{recall:.4}")));
        }
        writeln!(out)?;
        print_rows(&rows, out)?;
        writeln!(out)?;

        let mut files = Vec::new();
        if let Some(path) = &arguments.out {
            let mut bytes = Vec::new();
            write_ivecs(&answers, &mut bytes)?;
            files.push((path.clone(), bytes));
        }
        let subject = timing::Queries::<E, A> {
            name: arguments.name(),
            dataset: &dataset,
            metric,
            neighbours: arguments.k,
            ef: arguments.ef(),
            graph: graph.as_ref(),
            most: arguments.timed,
        };
        let timed = arguments.timing.run(&subject, arguments.queries_in_flight, config, &arguments.view, out)?;
        if let Some(Timed { mut recording, files: more }) = timed {
            let head = ["what", "value"].map(str::to_string).to_vec();
            let rows = rows.into_iter().map(|(label, value)| vec![label, value]).collect();
            recording.tables.push(Table { title: "The search".to_string(), head, rows });
            files.extend(more);
            files.extend(arguments.view.files(&recording));
        }
        write_and_name(&files, out)
    }
}

impl Arguments {
    fn ef(&self) -> usize {
        self.ef.unwrap_or(5 * self.k).max(self.k)
    }

    /// What is searched, for a title.
    fn name(&self) -> String {
        self.base.as_ref().map_or_else(|| "generated vectors".to_string(), |path| path.display().to_string())
    }

    fn dataset(&self) -> Result<Dataset, CliError> {
        match &self.base {
            Some(base) => {
                Dataset::read(base, self.queries.as_deref(), self.truth.as_deref()).map_err(CliError::unusable)
            }
            None if self.truth.is_some() => {
                let problem = "--truth: generated vectors have no file of true neighbours, expected BASE and QUERIES";
                Err(CliError::unusable(problem))
            }
            None => Clusters { seed: self.seed, ..Clusters::default() }.generate().map_err(CliError::unusable),
        }
    }

    fn graph<'d, const E: usize, const A: usize>(
        &self,
        dataset: &'d Dataset,
        metric: Metric,
        out: &mut dyn Write,
    ) -> Result<Graph<'d, E, A>, CliError> {
        let parameters =
            GraphParameters { connections: self.connections, ef_construction: self.ef_construction, seed: self.seed };
        let graph = watched("vectors indexed", dataset.base.len(), |watch| {
            Graph::build(&dataset.base, metric, &parameters, watch)
        })?;
        writeln!(out, "the graph took {} beats to build", graph.build_work().beats)?;
        Ok(graph)
    }

    fn exact<const E: usize, const A: usize>(&self, dataset: &Dataset, metric: Metric) -> Result<Answers, CliError> {
        let exact = Exact::<E, A>::new(&dataset.base, metric);
        watched("queries", dataset.queries.len(), |watch| exact.search(&dataset.queries, self.k, watch))
    }

    /// What recall is measured against, and where it is from. Exact search needs none but a file's.
    fn truth<const E: usize, const A: usize>(
        &self,
        dataset: &Dataset,
        metric: Metric,
    ) -> Result<Option<(&'static str, Neighbours)>, CliError> {
        let is_of_metric = dataset.metric.is_none_or(|own| own == metric);
        match &dataset.truth {
            Some(truth) if is_of_metric => Ok(Some(("the file's truth", truth.clone()))),
            _ if self.index.is_some() => {
                let answers = self.exact::<E, A>(dataset, metric)?;
                let indices: Vec<i64> = answers.rows.iter().flatten().map(|near| i64::from(near.index)).collect();
                let neighbours = Neighbours::new(self.k, &indices, dataset.base.len()).map_err(CliError::unusable)?;
                Ok(Some(("exact search", neighbours)))
            }
            _ => Ok(None),
        }
    }
}

fn describe<const E: usize, const A: usize>(answers: &Answers, dimensions: usize) -> Vec<(String, String)> {
    let report = Report::new::<E, A>(answers, dimensions);
    vec![
        ("queries per second, functional model".to_string(), format!("{:.1}", report.queries_per_second)),
        ("distances".to_string(), report.work.evaluations.to_string()),
        ("distances of a query".to_string(), format!("{:.1}", report.evaluations_per_query)),
        ("beats".to_string(), report.work.beats.to_string()),
        ("beats of a query".to_string(), format!("{:.1}", report.beats_per_query)),
        (format!("beats of a vector, euclidean ({E} lanes)"), report.euclidean_beats.to_string()),
        (format!("beats of a vector, angular ({A} lanes)"), report.angular_beats.to_string()),
    ]
}
