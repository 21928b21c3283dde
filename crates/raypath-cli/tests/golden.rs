//! The files of two presets and of the default unit, compared with those in `golden`, so that a change to the hardware
//! is seen in review as a change of text. `RAYPATH_UPDATE=1 cargo test -p raypath-cli golden` writes them anew.

use raypath_rtl::package::{self, Files};
use raypath_rtl::{DatapathNetlist, Preset};
use raypath_traversal::{UnitNetlist, UnitParameters};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

const UPDATE: &str = "RAYPATH_UPDATE";

#[test]
fn the_text_of_presets_is_the_golden_one() {
    for name in ["paper", "credit"] {
        let preset: Preset = name.parse().expect("a preset");
        let datapath = DatapathNetlist::new(preset.config).expect("a datapath");
        let files =
            package::design(&datapath, preset.config, &preset.config.to_string(), package::PERIOD_NS).expect("files");
        compare(name, files);
    }
}

#[test]
fn the_text_of_the_unit_is_the_golden_one() {
    let unit = UnitNetlist::new(raypath_rtl::Config::DEFAULT, UnitParameters::default()).expect("a unit");
    compare("unit", unit.files(package::PERIOD_NS).expect("files"));
}

/// A wrong line is found, and so are files that are missing on either side.
#[test]
fn differences_are_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str, text: &str| (PathBuf::from(name), text.to_string());
    let files = [file("rtl/a.sv", "one\ntwo\n"), file("b.f", "b\n")];
    write(folder.path(), &files);
    assert_eq!(differences(folder.path(), &files), [""; 0]);
    let others = [file("rtl/a.sv", "one\nthree\n"), file("c.f", "b\n")];
    let found = differences(folder.path(), &others).join("\n");
    for part in ["a.sv:2: 'two', printed as 'three'", "c.f: printed, but not there", "b.f: there, but not printed"] {
        assert!(found.contains(part), "{found}");
    }
}

/// Compares the files of a design with those in a folder of `golden`, or writes them there.
fn compare(name: &str, files: Files) {
    // The pipeline's picture, and the files that repeat the modules or other files.
    let repeats = |path: &Path| {
        path.extension().is_some_and(|extension| ["svg", "xdc", "xml"].iter().any(|kind| extension == *kind))
            || path.parent() == Some(Path::new(""))
                && path.extension().is_some_and(|extension| extension == "sv")
                && !path.to_string_lossy().ends_with("_properties.sv")
    };
    let files: Files = files.into_iter().filter(|(path, _)| !repeats(path)).collect();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    if std::env::var_os(UPDATE).is_some() {
        write(&folder, &files);
    }
    let found = differences(&folder, &files);
    assert!(
        found.is_empty(),
        "{}\nIf the change is intended, run {UPDATE}=1 cargo test -p raypath-cli golden, and review the change of text",
        found.join("\n")
    );
}

/// Replaces the content of a folder.
fn write(folder: &Path, files: &[(PathBuf, String)]) {
    if folder.exists() {
        fs::remove_dir_all(folder).expect("a folder that can be removed");
    }
    for (path, text) in files {
        let path = folder.join(path);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, text).expect("a file");
    }
}

/// The first line that differs of each file, and the files that are missing.
fn differences(folder: &Path, files: &[(PathBuf, String)]) -> Vec<String> {
    let mut found = Vec::new();
    for (path, printed) in files {
        let path = folder.join(path);
        let Ok(kept) = fs::read_to_string(&path) else {
            found.push(format!("{}: printed, but not there", path.display()));
            continue;
        };
        if kept != *printed {
            let same = kept.lines().zip(printed.lines()).take_while(|(kept, printed)| kept == printed).count();
            let [kept, printed] = [&kept, printed].map(|text| text.lines().nth(same).unwrap_or_default());
            found.push(format!("{}:{}: '{kept}', printed as '{printed}'", path.display(), same + 1));
        }
    }
    let expected: BTreeSet<PathBuf> = files.iter().map(|(path, _)| folder.join(path)).collect();
    let kept = [folder.to_path_buf(), folder.join("rtl")].into_iter().filter_map(|folder| fs::read_dir(folder).ok());
    let kept = kept.flatten().filter_map(Result::ok).map(|entry| entry.path()).filter(|path| path.is_file());
    found.extend(
        kept.filter(|path| !expected.contains(path)).map(|path| format!("{}: there, but not printed", path.display())),
    );
    found
}
