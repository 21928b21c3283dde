//! The datapaths that campaigns run: a configuration, and added operations.

use crate::covering::{Space, presets_and_pairs};
use raypath_float::Format;
use raypath_oracle::added_operations;
use raypath_rtl::{Config, Lanes};
use raypath_sim::Datapath;
use raypath_verify::Request;
use std::fmt;

/// A datapath.
#[derive(Debug, Clone, PartialEq)]
pub struct TestedDatapath {
    /// The configuration.
    pub config: Config,
    /// The names of the operations in addition to the configuration's.
    pub added: Vec<String>,
}

impl TestedDatapath {
    /// The datapath of a request.
    pub fn of(request: &Request<'_>) -> Self {
        Self { config: request.config, added: request.added.clone() }
    }

    /// The datapath of a configuration with these operations in addition.
    pub fn with(config: Config, added: &[&str]) -> Self {
        Self { config, added: added.iter().map(ToString::to_string).collect() }
    }

    /// The datapath.
    pub fn datapath(&self) -> Datapath {
        let added = added_operations().into_iter().filter(|spec| self.added.iter().any(|name| name == spec.name()));
        added.fold(Datapath::paper(self.config), |datapath, spec| datapath.with_any(spec.operation()))
    }

    /// The command-line options that select the datapath.
    pub fn options(&self) -> String {
        let with = if self.added.is_empty() { String::new() } else { format!("--with {}", self.added.join(",")) };
        [with, self.config.options()].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
    }
}

/// A datapath without added operations.
impl From<Config> for TestedDatapath {
    fn from(config: Config) -> Self {
        Self { config, added: Vec::new() }
    }
}

impl fmt::Display for TestedDatapath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.config)?;
        if self.added.is_empty() { Ok(()) } else { write!(f, ", with {}", self.added.join(", ")) }
    }
}

/// All datapaths of the campaigns: the presets, every pair of values of two parameters, and the added operations.
pub fn all() -> Vec<TestedDatapath> {
    let small = Config::DEFAULT.lanes(Lanes::Two);
    let boxes = Config::DEFAULT.lanes(Lanes::None);
    let mut subjects: Vec<TestedDatapath> =
        presets_and_pairs(&Space::new(&|_| true)).into_iter().map(TestedDatapath::from).collect();
    subjects.extend([
        TestedDatapath::with(boxes, &["key_compare", "octbox"]),
        TestedDatapath::with(boxes, &["point_in_box", "sphere"]),
        TestedDatapath::with(boxes.format(Format::BINARY16), &["octbox", "quantised_box", "sphere"]),
        TestedDatapath::with(
            small.exception_flags(true).tag(5),
            &["key_compare", "octbox", "point_in_box", "quantised_box", "sphere"],
        ),
    ]);
    subjects
}
