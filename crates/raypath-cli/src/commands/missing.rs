//! Commands that a build lists, but does not have.

use clap::Args;

/// Any arguments. A build with the command parses them.
#[derive(Debug, Args)]
#[command(disable_help_flag = true)]
pub struct Ignored {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    arguments: Vec<String>,
}

impl Ignored {
    /// The command of this name with its arguments.
    pub fn after(&self, name: &str) -> String {
        let words = std::iter::once(name).chain(self.arguments.iter().map(String::as_str));
        words.collect::<Vec<_>>().join(" ")
    }
}

#[cfg(any(test, not(feature = "full")))]
pub fn needs_full(command: &str) -> String {
    format!(
        "this build has no `{command}`, expected a build with the feature `full`\n\
         help: run `cargo raypath {command}`, in a crate of your own `cargo run --release --features full -- \
         {command}`, or install all commands with `cargo install --path crates/raypath --features full`"
    )
}
