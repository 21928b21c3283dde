//! The committed header is the one that cbindgen makes from the crate. `RAYPATH_UPDATE=1` writes it.

use std::path::Path;

#[test]
fn the_header_is_current() {
    let crate_folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut text = Vec::new();
    cbindgen::generate(crate_folder).expect("cbindgen reads the crate").write(&mut text);
    let (text, path) = (String::from_utf8(text).expect("UTF-8"), crate_folder.join("include/raypath.h"));
    if std::env::var_os("RAYPATH_UPDATE").is_some() {
        std::fs::write(&path, &text).expect("the header can be written");
    }
    let committed = std::fs::read_to_string(&path).expect("the header can be read");
    assert!(
        committed == text,
        "include/raypath.h is stale; run RAYPATH_UPDATE=1 cargo test -p raypath-capi --test header"
    );
}
