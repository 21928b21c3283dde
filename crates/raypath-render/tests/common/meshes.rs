//! The meshes of `tests/data`, read by independent code, because other tests cover the readers of the crate.

use flate2::read::GzDecoder;
use raypath_render::{Mesh, builtin};
use std::io::Read;

/// A mesh with its name.
pub struct Named {
    pub name: &'static str,
    pub mesh: Mesh,
}

/// All meshes, or the one that `RAYPATH_MESH` names.
pub fn all() -> Vec<Named> {
    let selected = std::env::var("RAYPATH_MESH").ok();
    everything().into_iter().filter(|mesh| selected.as_ref().is_none_or(|name| name == mesh.name)).collect()
}

fn everything() -> Vec<Named> {
    vec![real("truck"), real("teapot"), real("suzanne"), Named { name: "builtin", mesh: builtin().unwrap() }]
}

pub fn real(name: &'static str) -> Named {
    let mesh = match name {
        "truck" => obj(include_bytes!("../data/truck.obj.gz")),
        "teapot" => obj(include_bytes!("../data/teapot.obj.gz")),
        _ => ply(include_bytes!("../data/suzanne.ply.gz")),
    };
    Named { name, mesh }
}

fn text(compressed: &[u8]) -> String {
    let mut text = String::new();
    GzDecoder::new(compressed).read_to_string(&mut text).unwrap();
    text
}

fn obj(compressed: &[u8]) -> Mesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for line in text(compressed).lines() {
        let (kind, rest) = line.split_at(2);
        match kind {
            "v " => positions.push(numbers(rest)),
            _ => triangles.push(numbers::<u32>(rest).map(|index| index - 1)),
        }
    }
    Mesh::new(positions, triangles).unwrap()
}

fn ply(compressed: &[u8]) -> Mesh {
    let text = text(compressed);
    let (_, body) = text.split_once("end_header\n").unwrap();
    let lines: Vec<&str> = body.lines().collect();
    let positions = lines[..7503].iter().map(|line| numbers(line)).collect();
    let triangles = lines[7503..].iter().map(|line| numbers(line.trim().strip_prefix("3 ").unwrap())).collect();
    Mesh::new(positions, triangles).unwrap()
}

fn numbers<T: std::str::FromStr<Err: std::fmt::Debug>>(line: &str) -> [T; 3] {
    let mut numbers = line.split_whitespace().map(|number| number.parse().unwrap());
    std::array::from_fn(|_| numbers.next().unwrap())
}
