//! A file that a command writes must be none that it reads or writes besides.

use clap::ArgMatches;
use std::path::{Path, PathBuf};

/// The options that name a file to write, of all commands.
const OUTPUTS: [&str; 7] = ["out", "hits", "heatmap", "camera_rays", "report", "konata", "part"];

/// The first output that another argument of the command names too, as a message.
pub fn overwritten(matches: &ArgMatches) -> Option<String> {
    let (_, matches) = matches.subcommand()?;
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
