//! Configurations in TOML: presets, parameters, sweeps, and errors.

use raypath::rtl::{Config, Control, Lanes, PRESETS, UnitLatency, parameters};
use raypath::sim::configuration::{parse_sweep, read, sweep};
use std::path::Path;

/// The configuration of a file with this text, or the error.
fn parse(text: &str) -> Result<Config, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("raypath.toml");
    std::fs::write(&path, text).expect("a file");
    read(&path).map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
}

/// The options of the command line, `--lanes 4 --io recoded --range`, as lines of a file.
fn lines(options: &str) -> String {
    let line = |option: &str| match option.trim().split_once(' ') {
        Some((name, value)) => format!("{name} = \"{value}\"\n"),
        None => format!("{} = true\n", option.trim()),
    };
    options.split("--").filter(|option| !option.is_empty()).map(line).collect()
}

#[test]
fn presets_by_name_and_parameter_by_parameter() {
    assert_eq!(PRESETS[0].config, Config::DEFAULT);
    for preset in PRESETS {
        assert_eq!(parse(&format!("preset = \"{}\"", preset.name)), Ok(preset.config));
        assert_eq!(parse(&lines(&preset.config.options())), Ok(preset.config), "{}", preset.name);
    }
    // For every parameter there is a preset that differs from the default.
    let all = PRESETS.iter().map(|preset| preset.config.options()).collect::<String>() + "--format";
    for key in ["lanes", "rules", "format", "io", "registers", "control", "sharing", "unit-latency"] {
        assert!(all.contains(&format!("--{key}")), "{key}: {all}");
    }
}

#[test]
fn a_file_overrides_its_preset_in_any_order() {
    let expected = PRESETS.iter().find(|preset| preset.name == "compact").expect("compact").config;
    let expected = expected.lanes(Lanes::Four).unit_latency(UnitLatency::THREE);
    assert_eq!(parse("lanes = 4 # a comment\npreset = \"compact\"\n\nunit-latency = '3'\n"), Ok(expected));
    assert_eq!(parse(""), Ok(Config::DEFAULT));
}

#[test]
fn wrong_input_is_named() {
    let cases = [
        ("\nlans = 2", "raypath.toml:2: 'lans' is not a valid parameter, expected preset, lanes, rules, box-bits,"),
        ("unit_latency = 2", "raypath.toml:1: 'unit_latency' is not a valid parameter"),
        (
            "lanes = 3",
            "raypath.toml:1: lanes: '3' is not a valid number of lanes, expected none, 2, 4, 8, 16, 32 or 64",
        ),
        ("lanes = true", "raypath.toml:1: lanes: 'true' is not a valid number"),
        ("tag = 'x'", "raypath.toml:1: tag: 'x', expected a whole number from 0 to 32"),
        ("tag = 33", "raypath.toml:1: tag: '33', expected a whole number from 0 to 32"),
        ("range = 'yes'", "raypath.toml:1: range: 'yes', expected true or false"),
        ("lanes = 16.0", "raypath.toml:1: lanes: '16.0' is not a valid number"),
        ("lanes = [16,\n 2]", "raypath.toml:1: lanes: '[16,' is not a valid number"),
        ("lanes = { count = 2 }", "raypath.toml:1: lanes: '{ count = 2 }' is not a valid number"),
        ("rules = 'paper'\n[lanes]\ncount = 2", "raypath.toml:2: lanes: '[lanes]' is not a valid number"),
        ("rules = ''", "raypath.toml:1: rules: '' is not a valid rule set, expected paper, chisel or bounds"),
        ("format = 'e5s90'", "raypath.toml:1: format: 'e5s90': format with a significand of 90 bits, expected 3 to 11"),
        ("preset = 'big'", "raypath.toml:1: preset: 'big' is not a valid preset, expected paper, original, graphics,"),
        // The first wrong line of the file is reported.
        ("io = 1\ncontrol = 1", "raypath.toml:1: io: '1' is not a valid encoding of numbers, expected ieee or recoded"),
        ("io = 'ieee'\nlanes = none", "raypath.toml:2: 'lanes = none': "),
        (
            "lanes = 2\nlanes = 4",
            "raypath.toml:2: 'lanes = 4': duplicate key; expected lines like lanes = 16 or rules =",
        ),
    ];
    for (text, expected) in cases {
        let error = parse(text).expect_err(text);
        assert!(error.starts_with(expected), "{text:?}: {error}");
    }
    let nowhere = read(Path::new("/nonexistent/raypath.toml")).expect_err("no file").to_string();
    assert!(nowhere.starts_with("/nonexistent/raypath.toml: No such file"), "{nowhere}");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bytes.toml");
    std::fs::write(&path, b"lanes = 2\nio = \xff").expect("a file");
    let bytes = read(&path).expect_err("no text").to_string();
    assert!(bytes.ends_with("bytes.toml:2: a byte that is not UTF-8, expected text"), "{bytes}");
}

#[test]
fn a_file_that_is_too_large_is_an_error() {
    let comment = |bytes: usize| format!("#{}", "a".repeat(bytes - 1));
    assert_eq!(parse(&comment(65536)), Ok(Config::DEFAULT));
    let error = parse(&comment(65537)).expect_err("too large");
    assert_eq!(error, "raypath.toml: more than 65536 bytes, expected at most that");
    // A message shows the beginning of a long value or key. The cut does not make a wrong value valid.
    for text in [format!("format = 'e5s{}11x'", "0".repeat(75)), format!("{} = 1", "k".repeat(10_000))] {
        let error = parse(&text).expect_err("too long");
        let keys: usize = parameters().map(|parameter| parameter.name.len() + 2).sum();
        assert!(error.contains('…') && error.len() < keys + 180, "{error}");
    }
}

/// The parser recurses into nested values.
#[test]
fn depth_is_bounded() {
    for (open, close) in [("[", "]"), ("{a=", "}"), ("a.", "")] {
        let text = format!("lanes = {}2{}", open.repeat(15_000), close.repeat(15_000));
        let text = if open == "a." { format!("{}a = 2", open.repeat(15_000)) } else { text };
        assert!(parse(&text).is_err());
    }
}

/// A sweep of seven lists with a few hundred values each would have 10¹⁷ configurations.
#[test]
fn a_sweep_is_bounded() {
    let path = Path::new("sweep.toml");
    let list = |key: &str, value: &str, times| format!("{key} = [{}]\n", vec![value; times].join(","));
    let hundred = list("lanes", "2", 100) + &list("unit-latency", "1", 100);
    assert_eq!(parse_sweep(&hundred, path).expect("configurations").len(), 10_000);
    let error = parse_sweep(&(hundred + &list("io", "'ieee'", 300)), path).expect_err("too many").to_string();
    assert_eq!(error, "sweep.toml:3: io: makes more than 10000 configurations, expected at most that");
}

#[test]
fn lists_are_all_combinations() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("sweep.toml");
    let sweep = |text: &str| {
        std::fs::write(&path, text).expect("a file");
        sweep(&path).map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
    };
    let found = sweep("lanes = ['none', 4]\nrules = 'chisel'\npreset = ['paper', 'credit']").expect("configurations");
    let preset = |name: &str| PRESETS.iter().find(|preset| preset.name == name).expect(name).config;
    let config = |name: &str, lanes| preset(name).lanes(lanes).rules(raypath::ops::Rules::Chisel);
    let expected = [
        ("lanes-none-paper", config("paper", Lanes::None)),
        ("lanes-none-credit", config("credit", Lanes::None)),
        ("lanes-4-paper", config("paper", Lanes::Four)),
        ("lanes-4-credit", config("credit", Lanes::Four)),
    ];
    assert_eq!(found, expected.map(|(name, config)| (name.to_string(), config)));
    assert_eq!(found[1].1.microarchitecture.control, Control::Credit);
    assert_eq!(sweep("lanes = [2]"), Ok(vec![("only".to_string(), Config::DEFAULT.lanes(Lanes::Two))]));

    let cases = [
        ("\nlanes = [2,\n 3]", "sweep.toml:2: lanes: '3' is not a valid number of lanes"),
        ("lanes = []", "sweep.toml:1: lanes: an empty list, expected a value"),
        ("lane = [2]", "sweep.toml:1: 'lane' is not a valid parameter"),
        ("lanes = [[2]]", "sweep.toml:1: lanes: '[2]' is not a valid number of lanes"),
    ];
    for (text, problem) in cases {
        let found = sweep(text).expect_err(text);
        assert!(found.starts_with(problem), "{text}: {found}");
    }
}
