//! Options of `replay` and `wave` for the transactions and their handshakes.

use crate::{CliError, whole};
use clap::Args;
use raypath_rtl::Config;
use raypath_sim::WordModel;
use raypath_sim::traffic::{Traffic, interleave, read_recorded};
use raypath_sim::transactions::{Transaction, kind_named, merge, read};
use std::path::PathBuf;

/// Options for a stream of transactions.
#[derive(Debug, Args)]
pub struct StreamArguments {
    /// Transaction files, plain or gzip; several merge by seq into one stream
    files: Vec<PathBuf>,
    /// The kind of jobs in the files, if the names of the files do not begin with it
    #[arg(long, value_name = "triangle|quadbox|euclidean|angular|NAME")]
    kind: Option<String>,
    /// Handshakes: active in every cycle, random stalls and bubbles, or recorded in a file
    #[arg(long, default_value = "always", value_name = "always|random|FILE")]
    handshake: String,
    /// Mix the kinds of jobs; each kind keeps its order
    #[arg(long)]
    interleave: bool,
    /// Seed of all random choices
    #[arg(long, default_value_t = 1, value_parser = whole(0..=u64::MAX))]
    seed: u64,
}

impl StreamArguments {
    /// Reads all files into one stream for a configuration and its model.
    pub fn read(&self, model: &WordModel, config: Config) -> Result<Vec<Transaction>, CliError> {
        let kind = self.kind.as_ref().map(|name| kind_named(name, model)).transpose()?;
        if self.files.is_empty() {
            return Err(CliError::unusable("no FILES are given, expected at least one file of transactions"));
        }
        let mut files = Vec::new();
        for path in &self.files {
            files.push(read(path, kind, model, config)?);
        }
        let stream = merge(files);
        if stream.is_empty() {
            let names: Vec<String> = self.files.iter().map(|path| path.display().to_string()).collect();
            return Err(CliError::unusable(format!("{}: no transactions, expected at least one", names.join(", "))));
        }
        Ok(if self.interleave {
            interleave(stream, |transaction| transaction.job.kind().opcode(), self.seed)
        } else {
            stream
        })
    }

    /// When source and sink act.
    pub fn traffic(&self) -> Result<Traffic, CliError> {
        Ok(match self.handshake.as_str() {
            "always" => Traffic::always(),
            "random" => Traffic::random(self.seed),
            path => Traffic::recorded(read_recorded(path.as_ref())?),
        })
    }

    /// The seed of all random choices.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Whether the handshakes are those of a file, with resets perhaps.
    pub fn is_recorded(&self) -> bool {
        !["always", "random"].contains(&self.handshake.as_str())
    }
}
