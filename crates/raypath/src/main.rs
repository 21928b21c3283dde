//! The `raypath` command.

fn main() -> std::process::ExitCode {
    raypath_cli::main()
}
