//! `raypath render`.

use crate::command_line::{ends_with, file, folder, page, printed, raypath, said, text};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A square of two triangles in the plane z = 0 that face +z, and behind it a triangle that faces -z.
const SQUARE: &str =
    "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -1 -1 -1\nv 1 -1 -1\nv 0 1 -1\nf 1 2 3\nf 1 3 4\nf 5 7 6\n";

/// Width and height of a PNG file, from its header.
fn size(png: &Path) -> (u32, u32) {
    let bytes = std::fs::read(png).expect("a picture");
    assert_eq!(bytes[..8], *b"\x89PNG\r\n\x1a\n");
    let word = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().expect("four"));
    (word(16), word(20))
}

#[test]
fn pictures_and_their_cost() {
    let folder = folder();
    let below = |name: &str| folder.path().join(name);
    let scene = file(folder.path(), "square.obj", SQUARE);
    let options =
        "--size 48x32 --shadows --ao 2 --camera 0 0 4 0 0 0 --rays-in-flight 8 --memory-latency 30 --clock 500";
    let arguments: Vec<&str> = ["render", &scene].into_iter().chain(options.split(' ')).collect();
    let pictures = [("--out", "image.png"), ("--heatmap", "heat.png"), ("--sweep", "sweep.svg")];
    let others = [("--hits", "hits.txt"), ("--report", "report.html"), ("--konata", "log.txt")];
    let said = page::writes(&arguments, folder.path(), &[pictures, others].concat());
    assert_eq!(size(&below("image.png")), (48, 32));
    assert_eq!(size(&below("heat.png")).0, 48);
    assert!(std::fs::read_to_string(below("log.txt")).expect("a log").starts_with("Kanata\t0004\n"));
    assert!(std::fs::read_to_string(below("sweep.svg")).expect("a plot").contains("<svg"));

    // The camera looks at the middle of the square. Each ray passes through the centre of a pixel.
    let hits = std::fs::read_to_string(below("hits.txt")).expect("hits");
    let hits: Vec<&str> = hits.lines().filter(|line| !line.starts_with('#')).collect();
    assert_eq!(hits.len(), 48 * 32);
    let reach = (18.0f64).to_radians().tan() * 4.0;
    let mut hit = 0;
    for (pixel, line) in hits.iter().enumerate() {
        let centre = |place: usize, all: f64| (place as f64 + 0.5) / all * 2.0 - 1.0;
        let (x, y) = (centre(pixel % 48, 48.0) * reach * 1.5, -centre(pixel / 48, 32.0) * reach);
        if x.abs() > 1.0 || y.abs() > 1.0 {
            assert_eq!(*line, "miss");
            continue;
        }
        hit += 1;
        // On the common edge either triangle is right.
        let triangles = [(x > y - 1e-6, "0"), (x < y + 1e-6, "1")];
        let triangle = line.split(' ').next().expect("a triangle");
        assert!(triangles.contains(&(true, triangle)), "pixel {pixel}, ({x}, {y}): {line}");
    }
    // Each pixel has one ray from the eye; each hit has one to the sun and two to the sky, which hit nothing.
    let row = |name: &str| -> Vec<u64> {
        printed(&said, name).split_whitespace().map(|number| number.parse().expect("a number")).collect()
    };
    assert_eq!(row("from the eye")[..2], [48 * 32, hit]);
    assert_eq!(row("to the sun")[..2], [hit, 0]);
    assert_eq!(row("to the sky")[..2], [2 * hit, 0]);
    let jobs: u64 = ["from the eye", "to the sun", "to the sky"].iter().map(|name| row(name)[2] + row(name)[3]).sum();
    assert_eq!(printed(&said, "jobs "), jobs.to_string());
    assert_eq!(printed(&said, "pixels timed"), "1536 of 1536");
    let cycles: f64 = printed(&said, "cycles ").parse().expect("cycles");
    let pixels_per_second: f64 = printed(&said, "pixels per second at 500 MHz").parse().expect("a rate");
    assert!((pixels_per_second / (1536.0 * 500e6 / cycles) - 1.0).abs() < 1e-3);
    page::agrees(&below("report.html"), &said);
}

#[test]
fn rays_are_traced_from_files() {
    let folder = folder();
    let scene = file(folder.path(), "square.obj", SQUARE);
    let rays = "# through the square, past it, stopped before it, from behind\n\
                0.5 -0.25 3 0 0 -2 inf\n3 0 3 0 0 -1 inf\n0 0 3 0 0 -1 2.5\n0.25 0.5 -0.5 0 0 1 inf\n";
    let rays = file(folder.path(), "rays.txt", rays);
    let lines = |arguments: &[&str]| -> Vec<String> {
        let output = raypath(&[&["render", &scene, "--rays", &rays], arguments].concat());
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        let text = String::from_utf8(output.stdout).expect("text");
        text.lines().filter(|line| !line.starts_with('#')).map(str::to_string).collect()
    };
    let hits = lines(&[]);
    // t is in units of the direction's length; t_num / t_denom is t, and the last columns are the bits of the three.
    let first: Vec<&str> = hits[0].split(' ').collect();
    assert_eq!((first[0], first[1], first[4]), ("0", "1.5e0", "3fc00000"));
    let number = |text: &str| text.parse::<f32>().expect("a number");
    assert_eq!(number(first[2]) / number(first[3]), 1.5);
    assert_eq!(hits[1..], ["miss", "miss", "miss"]);
    // With --two-sided the last ray hits the back of the square.
    let hits = lines(&["--two-sided"]);
    assert!(hits[3].starts_with("1b 5e-1 "), "{}", hits[3]);

    let out = folder.path().join("hits.txt");
    let said = page::succeeds(&["render", &scene, "--rays", &rays, "--hits", &text(&out)]);
    assert!(said.contains("4 rays, 1 hits") && said.contains("rays timed"), "{said}");
    assert_eq!(std::fs::read_to_string(&out).expect("hits").lines().filter(|line| *line == "miss").count(), 3);
}

/// The functional model of the traversal unit draws the picture that the traversal in software draws.
#[test]
fn the_unit_draws_the_same_picture() {
    let folder = folder();
    let out = |name: &str| text(&folder.path().join(name));
    let options = ["--size", "96x64", "--shadows", "--ao", "2", "--no-timing"];
    let render = |name: &str, through: &str| {
        page::succeeds(&[&["render", "--out", &out(name), "--through", through][..], &options].concat());
        std::fs::read(folder.path().join(name)).expect("a picture")
    };
    assert!(render("datapath.png", "datapath") == render("unit.png", "unit"));
    ends_with(&["render", "--through", "unit", "--report", &out("r.html")], 2, &["no timeline", "no --report"]);
    ends_with(&["render", "--through", "memory"], 2, &["memory", "datapath, unit"]);

    let said = page::succeeds(&["scene", "--out", &out("scene.bin")]);
    assert!(said.contains("root 0x00000020"), "{said}");
    let bytes = std::fs::read(folder.path().join("scene.bin")).expect("a scene");
    assert!(!bytes.is_empty() && bytes.len().is_multiple_of(128));
    page::succeeds(&["scene", "--refit", &out("scene.bin"), "--out", &out("same.bin")]);
    assert!(std::fs::read(folder.path().join("same.bin")).expect("a scene") == bytes);
    let (node, words) = ("quantised", ["scene.bin", "expected"]);
    ends_with(&["scene", "--refit", &out("scene.bin"), "--node", node, "--out", &out("other.bin")], 2, &words);
    let missing = out("missing.obj");
    ends_with(&["scene", &missing, "--out", &out("other.bin")], 2, &[&missing]);
    assert!(!folder.path().join("other.bin").exists());
}

/// Many triangles in one place are hit through the unit as through the datapath. A ray that the unit ends with an error
/// is no miss: the command says so and ends with 1.
#[test]
fn the_unit_misses_nothing_in_silence() {
    let folder = folder();
    let at = |name: &str, text: &str| file(folder.path(), name, text);
    let triangle = "v 0 0 1\nv 1 0 1\nv 0 1 1\n";
    let rays = at("rays.txt", "0.25 0.25 5 0 0 -1 inf\n");
    for copies in [200, 5_000] {
        let mesh = at("coincident.obj", &(triangle.to_string() + &"f 1 2 3\n".repeat(copies)));
        for through in ["datapath", "unit"] {
            let said = page::succeeds(&["render", &mesh, "--rays", &rays, "--no-timing", "--through", through]);
            assert!(said.lines().any(|line| line.starts_with("0 4e0 ")), "{copies}, {through}: {said}");
        }
    }
    // An instance so large that the second ray is too short to invert in the space of the mesh.
    let small = at("small.obj", "v 0 0 1e-9\nv 1e-9 0 1e-9\nv 0 1e-9 1e-9\nf 1 2 3\n");
    let places = at("places.txt", "1e9 0 0 0 0 1e9 0 0 0 0 1e9 0\n");
    let rays = at("short.txt", "0.25 0.25 5 0 0 -1 inf\n0.25 0.25 5 0 0 -1e-30 inf\n");
    let hits = text(&folder.path().join("hits.txt"));
    let arguments = ["render", &small, "--instances", &places, "--rays", &rays, "--hits", &hits, "--through", "unit"];
    ends_with(&arguments, 1, &["what 1 rays hit is not known", "ended 1 with an error"]);
    assert!(!Path::new(&hits).exists());
}

/// Input that takes more memory than the limit is an error that names the file, the size and the limit.
#[test]
fn memory_is_limited() {
    let folder = folder();
    let (square, rays) =
        (file(folder.path(), "square.obj", SQUARE), file(folder.path(), "rays.txt", "0 0 9 0 0 1 inf"));
    let out = text(&folder.path().join("out"));
    let of_mesh =
        ["square.obj: ", "7 vertices and 3 triangles take 1816 bytes of memory, expected at most 1815", "--max-memory"];
    for command in ["render", "scene"] {
        ends_with(&[command, &square, "--max-memory", "1815", "--out", &out], 2, &of_mesh);
        ends_with(&[command, &square, "--max-memory", "2GB", "--out", &out], 2, &["'2GB'", "like 8GiB"]);
    }
    page::succeeds(&["scene", &square, "--max-memory", "2KiB", "--out", &out]);
    let of_rays = ["rays.txt: 1 lines take 256 bytes", "at most 200"];
    ends_with(&["render", &square, "--rays", &rays, "--max-memory", "200"], 2, &of_rays);
}

#[test]
fn wrong_input_is_named() {
    let folder = folder();
    let out = text(&folder.path().join("image.png"));
    let mesh = |name: &str, text: &str| file(folder.path(), name, text);
    let square = mesh("square.obj", SQUARE);
    let faceless = mesh("faceless.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    let outside = mesh("outside.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
    let nan = mesh("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let lies = mesh(
        "lies.ply",
        "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\n\
         property float z\nelement face 4000000000\nproperty list uchar int vertex_indices\nend_header\n",
    );
    let stl = file(folder.path(), "lies.stl", [vec![0u8; 80], vec![0xff; 4], vec![0u8; 50]].concat());
    let no_mesh = mesh("mesh.xyz", "1 2 3\n");
    let short_ray = mesh("short.txt", "0 0 5 0 0 -1 inf\n0 0 5 0 0 -1\n");
    let no_ray = mesh("zero.txt", "0 0 5 0 0 0 inf\n");
    let cases: [(&[&str], &[&str]); 18] = [
        (&["/nonexistent/scene.obj"], &["/nonexistent/scene.obj", "No such file"]),
        (&[&no_mesh], &["mesh.xyz", "expected one of"]),
        (&[&faceless], &["faceless.obj", "0 triangles, expected at least 1"]),
        (&[&outside], &["outside.obj"]),
        (&[&nan], &["nan.obj", "line 1: z = 'nan'", "expected a finite number"]),
        (&[&lies], &["lies.ply"]),
        (&[&stl], &["lies.stl"]),
        (&[&square, "--size", "640"], &["'640'", "--size", "like 640x480"]),
        (&[&square, "--size", "0x10"], &["'0x10'", "1 to 16384"]),
        (&[&square, "--ao=-1"], &["--ao"]),
        (&[&square, "--camera", "0", "0", "4", "0", "0", "4"], &["--camera", "eye and target are both"]),
        (&[&square, "--camera", "0", "0", "4", "0", "0", "0", "--fov", "180"], &["--camera", "180 degrees"]),
        (&[&square, "--camera", "0", "0", "4", "0", "0"], &["--camera", "6 values"]),
        (&[&square, "--clock", "0"], &["--clock", "expected MHz"]),
        (&[&square, "--rays-in-flight", "0"], &["--rays-in-flight", "from 1 to"]),
        (&[&square, "--format", "bf16"], &["--format e8s8", "fp32 only"]),
        (&[&square, "--rays", &short_ray], &["short.txt:2", "6 numbers, expected 7"]),
        (&[&square, "--rays", &no_ray], &["zero.txt:1", "direction (0, 0, 0) is zero"]),
    ];
    for (arguments, words) in cases {
        let out: &[&str] = if arguments.contains(&"--rays") { &[] } else { &["--out", &out] };
        ends_with(&[&["render"], arguments, out].concat(), 2, words);
    }
    assert!(!folder.path().join("image.png").exists());
    ends_with(&["render", &square, "--no-timing", "--report", "r.html"], 2, &["cannot be used with"]);
}

/// Ctrl-C ends a long run within a minute. The message has the progress, and no file is written.
#[cfg(unix)]
#[test]
fn long_runs_stop_cleanly() {
    let folder = folder();
    let out = folder.path().join("image.png");
    let child = Command::new(env!("CARGO_BIN_EXE_raypath"))
        .args(["render", "--size", "8000x8000", "--ao", "64", "--shadows", "--out", &text(&out)])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program");
    std::thread::sleep(Duration::from_secs(3));
    let asked = Instant::now();
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(kill.success());
    let output = child.wait_with_output().expect("an end");
    let said = said(&output);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(said.contains("of 64000000 pixels"), "{said}");
    assert!(asked.elapsed() < Duration::from_secs(60), "it took {:?} to stop", asked.elapsed());
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
}
