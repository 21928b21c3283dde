//! Outputs of commands, checked before the work: a file that a command writes must be none that it reads or writes
//! besides, and its folder must permit it.

use clap::ArgMatches;
use clap::parser::ValueSource;
use std::path::{Path, PathBuf};

/// The options that name a file to write, of all commands.
const OUTPUTS: [&str; 7] = ["out", "hits", "heatmap", "camera_rays", "report", "konata", "part"];

/// What is wrong with an output of the command, as a message.
pub fn problem(matches: &ArgMatches) -> Option<String> {
    let (_, matches) = matches.subcommand()?;
    overwritten(matches).or_else(|| unwritable(matches))
}

/// The first output that the user names and that cannot be made.
fn unwritable(matches: &ArgMatches) -> Option<String> {
    let is_given = |name: &&str| {
        let is_known = matches.ids().any(|id| id.as_str() == *name);
        is_known && matches.value_source(name) == Some(ValueSource::CommandLine)
    };
    OUTPUTS.iter().filter(|name| is_given(name)).find_map(|name| {
        let path = matches.try_get_one::<PathBuf>(name).ok().flatten()?;
        let folder = path.ancestors().skip(1).find(|folder| folder.exists() || folder.as_os_str().is_empty())?;
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let refused = if can_be_lost(path) { tempfile::tempfile_in(folder).err()? } else { return None };
        Some(format!("{} {}: cannot write in {}: {refused}", shown(name), path.display(), folder.display()))
    })
}

/// The first output that another argument of the command names too.
fn overwritten(matches: &ArgMatches) -> Option<String> {
    let mut files: Vec<(&str, PathBuf)> = Vec::new();
    for id in matches.ids() {
        // Values of other types are no paths.
        if let Ok(Some(paths)) = matches.try_get_many::<PathBuf>(id.as_str()) {
            files.extend(paths.map(|path| (id.as_str(), absolute(path))));
        }
    }
    let is_output = |name: &&str| OUTPUTS.contains(name);
    let pairs = files.iter().enumerate().flat_map(|(at, first)| files[..at].iter().map(move |second| [first, second]));
    let mut same = pairs.filter(|[first, second]| first.1 == second.1 && can_be_lost(&first.1));
    let [first, second] = same.find(|pair| pair.iter().any(|(name, _)| is_output(name)))?;
    let path = first.1.display();
    Some(format!("{path}: the file of both {} and {}, expected two files", shown(first.0), shown(second.0)))
}

/// The path that two names of a file have in common.
fn absolute(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let below = || Some(folder.canonicalize().ok()?.join(path.file_name()?));
    path.canonicalize().ok().or_else(below).unwrap_or_else(|| path.to_path_buf())
}

/// Whether a write replaces contents: not in a folder, a pipe or a terminal.
fn can_be_lost(path: &Path) -> bool {
    path.is_file() || !path.exists()
}

fn shown(name: &str) -> String {
    if OUTPUTS.contains(&name) { format!("--{}", name.replace('_', "-")) } else { format!("'{name}'") }
}
