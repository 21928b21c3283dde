//! Installs the library to a folder, and compiles and runs programs in C and C++ against it, with every warning an
//! error and under AddressSanitizer and UndefinedBehaviorSanitizer.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use tempfile::TempDir;

/// The root of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn run(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|problem| panic!("{command:?}: {problem}"));
    let (out, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{command:?}\n{out}\n{errors}");
    out.into_owned()
}

/// An installation of the libraries that Cargo built for this test.
fn prefix() -> &'static Path {
    static PREFIX: OnceLock<TempDir> = OnceLock::new();
    let folder = PREFIX.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder for the installation");
        let test = std::env::current_exe().expect("the path of this test");
        let built = test.parent().expect("the folder of this test");
        let script = root().join("scripts/install-libraypath.sh");
        run(Command::new(script).arg(folder.path()).env("RAYPATH_BUILT", built));
        folder
    });
    folder.path()
}

/// Compiles a program of `tests/programs` with the flags of pkg-config, and runs it. Returns its output.
fn compile_and_run(compiler: &str, source: &str, flags: &[&str], is_static: bool) -> String {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/programs").join(source);
    let folder = tempfile::tempdir().expect("a folder for the program");
    let program = folder.path().join("program");
    let mut config = Command::new("pkg-config");
    config.env("PKG_CONFIG_PATH", prefix().join("lib/pkgconfig")).args(["--cflags", "--libs", "raypath"]);
    if is_static {
        config.arg("--static");
    }
    let options = run(&mut config);
    let mut compile = Command::new(compiler);
    compile.args(["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O0"]).args(flags);
    compile.args(["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]);
    compile.arg(source).arg("-o").arg(&program);
    // Without the shared library, `-lraypath` finds the static one.
    let libraries = if is_static {
        std::fs::copy(prefix().join("lib/libraypath.a"), folder.path().join("libraypath.a")).expect("a copy");
        format!("-L{} {options}", folder.path().display())
    } else {
        options
    };
    compile.args(libraries.split_whitespace()).args(["-lm", "-pthread"]);
    run(&mut compile);
    let mut started = Command::new(&program);
    if !is_static {
        started.env("LD_LIBRARY_PATH", prefix().join("lib"));
    }
    run(started.arg(folder.path().join("hardware")))
}

/// The code blocks of a language in the documentation of this interface.
fn documented(language: &str) -> Vec<String> {
    let text = std::fs::read_to_string(root().join("docs/integration/c.md")).expect("the page");
    let begin = format!("```{language}\n");
    text.split(&begin).skip(1).filter_map(|block| block.split("```").next()).map(str::to_string).collect()
}

/// The driver of the device on a model of the device around the library's unit.
#[test]
fn the_driver_of_the_device_runs_on_a_model_of_it() {
    let software = root().join("software");
    let (driver, include) = (software.join("raypath_driver.c"), format!("-I{}", software.display()));
    let flags = ["-std=c11", &include, driver.to_str().expect("a path")];
    let said = compile_and_run("cc", "../../../../examples/device/model.c", &flags, false);
    assert!(said.contains("3000 rays"), "{said}");
}

#[test]
fn arrays_are_right_in_double_precision() {
    compile_and_run("cc", "arrays.c", &["-std=c11"], false);
}

#[test]
fn wrong_arguments_are_reported() {
    compile_and_run("cc", "errors.c", &["-std=c11"], false);
}

#[test]
fn pipelines_keep_the_handshake() {
    compile_and_run("cc", "pipeline.c", &["-std=c11"], true);
}

#[test]
fn rays_through_the_unit_are_right_in_double_precision() {
    compile_and_run("cc", "unit.c", &["-std=c11"], false);
}

#[test]
fn searches_find_what_exact_numbers_find() {
    compile_and_run("cc", "search.c", &["-std=c11"], false);
}

#[test]
fn the_cpp_layer_works() {
    compile_and_run("c++", "layer.cpp", &["-std=c++17", "-fno-exceptions"], false);
}

#[test]
fn documented_programs_print_what_the_page_says() {
    let folder = tempfile::tempdir().expect("a folder for the programs");
    let save = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("the program can be written");
        path.to_string_lossy().into_owned()
    };
    let programs = documented("c").into_iter().zip(documented("text"));
    assert_eq!(programs.len(), 2);
    for (program, expected) in programs {
        let printed = compile_and_run("cc", &save("documented.c", &program), &["-std=c11"], false);
        assert_eq!(printed, expected);
    }
    let printed = compile_and_run("c++", &save("first.cpp", &documented("cpp")[0]), &["-std=c++17"], false);
    assert_eq!(printed, "80\n");
}

#[test]
fn a_cmake_project_finds_the_package() {
    let folder = tempfile::tempdir().expect("a folder for the build");
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/programs");
    let prefix_path = format!("-DCMAKE_PREFIX_PATH={}", prefix().display());
    run(Command::new("cmake").arg("-S").arg(sources).arg("-B").arg(folder.path()).arg(prefix_path));
    run(Command::new("cmake").arg("--build").arg(folder.path()));
    for program in ["shared", "static"] {
        run(&mut Command::new(folder.path().join(program)));
    }
}

/// The tests in `integrations`.
fn simulators(options: &[&str]) {
    let folder = tempfile::tempdir().expect("a folder for the build");
    run(Command::new(root().join("integrations/test.sh")).arg(prefix()).arg(folder.path()).args(options));
}

#[test]
fn the_adapters_for_simulators_work() {
    simulators(&[]);
}

#[test]
#[ignore = "compiles two datapaths with Verilator"]
fn the_systemc_module_works_with_credits_and_units_of_two_steps() {
    simulators(&["--long"]);
}

#[test]
#[ignore = "compiles cbindgen"]
fn the_header_is_current() {
    run(Command::new(root().join("scripts/raypath-header.sh")).arg("--check"));
}

#[test]
fn the_shared_library_has_its_version_and_exports_the_interface_alone() {
    let library = prefix().join("lib/libraypath.so");
    let dynamic = run(Command::new("readelf").args(["--dynamic", "--wide"]).arg(&library));
    assert!(dynamic.contains("Library soname: [libraypath.so.1]"), "{dynamic}");
    let symbols = run(Command::new("nm").args(["--dynamic", "--defined-only", "--format=posix"]).arg(&library));
    let others: Vec<&str> = symbols.lines().filter(|line| !line.starts_with("raypath_")).collect();
    assert!(others.is_empty(), "{others:?}");
    let header = std::fs::read_to_string(prefix().join("include/raypath.h")).expect("the header");
    for symbol in symbols.lines().filter_map(|line| line.split(' ').next()) {
        assert!(header.contains(&format!("{symbol}(")), "{symbol} is not declared in raypath.h");
    }
}
