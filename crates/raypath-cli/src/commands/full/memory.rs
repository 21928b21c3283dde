//! The memory that input files may take.

use clap::Args;
use raypath_tools::MemoryLimit;

#[derive(Debug, Clone, Copy, Default, Args)]
pub struct MemoryArguments {
    /// The memory that an input file may take with what is made of it, in bytes or with KiB, MiB or GiB
    #[arg(long = "max-memory", default_value_t = MemoryLimit::DEFAULT, value_name = "SIZE")]
    pub limit: MemoryLimit,
}
