//! The option that adds operations which the paper does not have: shared by all commands that take it.

use clap::Args;
use raypath_oracle::{AnyOperationSpec, added_operations};
use raypath_rtl::{Config, alternatives};
use raypath_sim::Datapath;

/// Operations beside the paper's.
#[derive(Debug, Args)]
pub struct Additions {
    /// Add an operation beside the paper's; `raypath operations` lists them
    #[arg(long = "with", value_name = "NAME,...", value_delimiter = ',', value_parser = find)]
    pub specs: Vec<AnyOperationSpec>,
}

impl Additions {
    /// The datapath of a configuration with these operations besides.
    pub fn datapath(&self, config: Config) -> Datapath {
        self.specs.iter().fold(Datapath::paper(config), |datapath, spec| datapath.with_any(spec.operation()))
    }

    /// What a configuration with these operations is called.
    pub fn name(&self, config: Config) -> String {
        let names: Vec<&str> = self.specs.iter().map(AnyOperationSpec::name).collect();
        if names.is_empty() { config.to_string() } else { format!("{config}, with {}", names.join(", ")) }
    }
}

fn find(name: &str) -> Result<AnyOperationSpec, String> {
    let all = added_operations();
    let names: Vec<&str> = all.iter().map(AnyOperationSpec::name).collect();
    let expected = format!("expected {}", alternatives(&names));
    all.into_iter().find(|spec| spec.name() == name).ok_or(expected)
}
