//! The `raypath` command.

fn main() -> std::process::ExitCode {
    let is_clean = option_env!("RAYPATH_CLEAN") == Some("true");
    let (commit, lock) = (option_env!("RAYPATH_COMMIT"), option_env!("RAYPATH_LOCK"));
    raypath_cli::Build { commit, is_clean, lock }.set();
    raypath_cli::main()
}
