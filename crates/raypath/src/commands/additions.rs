//! The option that adds operations which the paper does not have: shared by all commands that take it.

use clap::Args;
use raypath::lab::{AnyStudy, Datapath, registered};
use raypath::rtl::{Config, alternatives};

/// Operations beside the paper's.
#[derive(Debug, Args)]
pub struct Additions {
    /// Add an operation beside the paper's; `raypath operations` lists them
    #[arg(long = "with", value_name = "NAME,...", value_delimiter = ',', value_parser = find)]
    pub studies: Vec<AnyStudy>,
}

impl Additions {
    /// The datapath of a configuration with these operations besides.
    pub fn datapath(&self, config: Config) -> Datapath {
        self.studies.iter().fold(Datapath::paper(config), |datapath, study| datapath.with_any(study.operation()))
    }

    /// What a configuration with these operations is called.
    pub fn name(&self, config: Config) -> String {
        let names: Vec<&str> = self.studies.iter().map(AnyStudy::name).collect();
        if names.is_empty() { config.to_string() } else { format!("{config}, with {}", names.join(", ")) }
    }
}

fn find(name: &str) -> Result<AnyStudy, String> {
    let all = registered();
    let names: Vec<&str> = all.iter().map(AnyStudy::name).collect();
    let expected = format!("expected {}", alternatives(&names));
    all.into_iter().find(|study| study.name() == name).ok_or(expected)
}
