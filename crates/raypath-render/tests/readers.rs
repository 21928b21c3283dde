//! Readers of mesh files: valid files, truncated files, and files with wrong content or headers.

use crate::common::meshes;
use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use flate2::read::GzDecoder;
use raypath_render::{Format, Mesh, ReadError, parse_mesh, read_hits, read_instances, read_mesh, read_rays};
use raypath_tools::MemoryLimit;
use std::io::Read;
use std::path::Path;

/// A tetrahedron.
const POSITIONS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, -2.0]];
const FACES: [[u32; 3]; 4] = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];

const OBJ: &str =
    "# four\no one\nv 0 0 0\nv 1 0 0\nv 0 1.5 0\nv 0 0 -2\nf 1 2 3\nf 1/1 4/2 2/3\nf -4 -2 -1\nf 2//1 4//1 3//1\n";

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    element face 4\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n0 1.5 0\n0 0 -2\n3 0 1 2\n3 0 3 1\n3 0 2 3\n3 1 3 2\n";

fn parse(format: Format, bytes: impl AsRef<[u8]>) -> Result<Mesh, String> {
    parse_mesh(format, bytes.as_ref(), Path::new("a/file"), MemoryLimit::DEFAULT).map_err(|problem| problem.to_string())
}

/// The corners of all triangles, which do not depend on the numbering of vertices.
fn corners(mesh: &Mesh) -> Vec<[[f32; 3]; 3]> {
    (0..mesh.triangles().len() as u32).map(|index| mesh.corners(index)).collect()
}

fn assert_tetrahedron(format: Format, bytes: impl AsRef<[u8]>) {
    let mesh = parse(format, bytes).unwrap();
    let expected: Vec<_> = FACES.iter().map(|face| face.map(|index| POSITIONS[index as usize])).collect();
    assert_eq!(corners(&mesh), expected);
    assert_eq!(mesh.positions().len(), 4);
}

#[track_caller]
fn assert_error(format: Format, bytes: impl AsRef<[u8]>, parts: &[&str]) {
    let message = parse(format, bytes).unwrap_err();
    assert!(message.starts_with("a/file: "), "{message}");
    for part in parts {
        assert!(message.contains(part), "'{message}' does not contain '{part}'");
    }
}

#[test]
fn valid_files_give_the_tetrahedron() {
    assert_tetrahedron(Format::Obj, OBJ);
    assert_tetrahedron(Format::Ply, PLY);
    assert_tetrahedron(Format::Ply, binary_ply("binary_little_endian", f32::to_le_bytes, i32::to_le_bytes));
    assert_tetrahedron(Format::Ply, binary_ply("binary_big_endian", f32::to_be_bytes, i32::to_be_bytes));
    assert_tetrahedron(Format::Stl, text_stl("solid four"));
    assert_tetrahedron(Format::Stl, text_stl("solid"));
    assert_tetrahedron(Format::Stl, binary_stl(b"made by a test", 4));
    assert_tetrahedron(Format::Stl, binary_stl(b"solid but binary", 4));
    assert_tetrahedron(Format::Gltf, gltf(&Gltf::default()));
    assert_tetrahedron(Format::Gltf, glb(&Gltf { uri: "", ..Gltf::default() }));
}

#[test]
fn real_files_equal_those_of_simpler_readers() {
    for (name, format, compressed) in [
        ("truck", Format::Obj, include_bytes!("data/truck.obj.gz").as_slice()),
        ("teapot", Format::Obj, include_bytes!("data/teapot.obj.gz")),
        ("suzanne", Format::Ply, include_bytes!("data/suzanne.ply.gz")),
    ] {
        let mut bytes = Vec::new();
        GzDecoder::new(compressed).read_to_end(&mut bytes).unwrap();
        assert_eq!(corners(&parse(format, bytes).unwrap()), corners(&meshes::real(name).mesh), "{name}");
    }
}

#[test]
fn extensions_determine_the_format() {
    let message = |name: &str| read_mesh(Path::new(name), MemoryLimit::DEFAULT).unwrap_err().to_string();
    assert_eq!(message("a/b.fbx"), "a/b.fbx: extension 'fbx', expected one of obj, gltf, glb, ply, stl");
    assert_eq!(message("a/b"), "a/b: extension none, expected one of obj, gltf, glb, ply, stl");
    assert!(message("a/absent.OBJ").starts_with("a/absent.OBJ: cannot read: "));
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [
        ("four.PLY", PLY.into()),
        ("four.obj", OBJ.into()),
        ("four.stl", binary_stl(b"", 4)),
        ("four.gltf", gltf(&Gltf::default()).into()),
        ("four.glb", glb(&Gltf { uri: "", ..Gltf::default() })),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(read_mesh(&path, MemoryLimit::DEFAULT).unwrap().triangles().len(), 4, "{name}");
    }
}

#[test]
fn polygons_become_triangles() {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    assert_eq!(parse(Format::Obj, square).unwrap().triangles().len(), 2);
    let pentagon = PLY
        .replace("element face 4", "element face 1")
        .replace("3 0 1 2\n3 0 3 1\n3 0 2 3\n3 1 3 2\n", "5 0 1 2 3 1\n");
    assert_eq!(parse(Format::Ply, pentagon).unwrap().triangles(), [[0, 1, 2], [0, 2, 3], [0, 3, 1]]);
}

#[test]
fn invalid_obj_files_are_errors() {
    fn error(bytes: impl AsRef<[u8]>, parts: &[&str]) {
        assert_error(Format::Obj, bytes, parts);
    }
    error("", &["0 triangles"]);
    error("v 0 0 0\nv 1 0 0\nv 0 1 0\n", &["0 triangles, expected at least 1"]);
    error(&OBJ[..OBJ.len() - 14], &["line 10"]);
    error(OBJ.replace("1.5", "nan"), &["line 5", "y = 'nan'", "finite"]);
    error(OBJ.replace("1.5", "1e39"), &["line 5", "y = '1e39'", "finite"]);
    error(OBJ.replace("1.5", "1e38"), &["y = 100000000000000000000000000000000000000", "2^40"]);
    error(OBJ.replace("v 0 1.5 0", "v 0 1.5"), &["line 5", "without z"]);
    error(OBJ.replace("f 1 2 3", "f 1 2 5"), &["line 7", "'5'", "from 1 to 4"]);
    error(OBJ.replace("f 1 2 3", "f 0 2 3"), &["line 7", "'0'"]);
    error(OBJ.replace("f 1 2 3", "f 1 2 -5"), &["line 7", "'-5'"]);
    error(OBJ.replace("f 1 2 3", "f 1 2 9223372036854775807"), &["line 7", "9223372036854775807"]);
    error(OBJ.replace("f 1 2 3", "f 1 2"), &["line 7", "2 corners", "at least 3"]);
    error(OBJ.replace("f 1 2 3", "f"), &["line 7", "0 corners"]);
    error(OBJ.replace("f 1 2 3", "f 1 2 x"), &["line 7", "'x'"]);
    error(b"v 0 0 0\nv \xff", &["line 2", "x = '\u{fffd}'"]);
}

#[test]
fn invalid_ply_files_are_errors() {
    fn error(bytes: impl AsRef<[u8]>, parts: &[&str]) {
        assert_error(Format::Ply, bytes, parts);
    }
    error("", &["not PLY"]);
    error("solid x", &["not PLY"]);
    error(PLY.replace("end_header\n", ""), &["not PLY"]);
    error(&PLY[..PLY.len() - 16], &["element face", "expected 4, got 2"]);
    error(PLY.replace("1.5", "nan"), &["element vertex: Line 12", "'0 nan 0 '"]);
    error(PLY.replace("3 0 1 2", "3 0 1 4"), &["triangle 0 names vertex 4", "less than 4"]);
    error(PLY.replace("3 0 1 2", "3 0 1 -1"), &["face 0", "index -1"]);
    error(PLY.replace("3 0 1 2", "2 0 1"), &["face 0", "2 corners"]);
    error(PLY.replace("3 0 1 2", "4000000000 0 1 2"), &["element face"]);
    error(PLY.replace("vertex 4", "vertex 4000000000"), &["4000000000 of element vertex", "bytes of the file"]);
    error(PLY.replace("element face", "element none 18446744073709551615\nelement face"), &["element none"]);
    error(PLY.replace("property float y\n", ""), &["no property y of element vertex"]);
    error(PLY.replace("vertex_indices", "corners"), &["no list vertex_indices or vertex_index"]);
    let binary = binary_ply("binary_little_endian", f32::to_le_bytes, i32::to_le_bytes);
    error(&binary[..binary.len() - 5], &["element face", "expected 4, got 3"]);
    let mut nan = binary.clone();
    let at = nan.windows(4).position(|bytes| bytes == 1.5_f32.to_le_bytes()).unwrap();
    nan[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    error(nan, &["vertex 2 has y = NaN"]);
    let no_faces = PLY.replace("element face 4", "element face 0");
    error(no_faces, &["0 triangles"]);
}

#[test]
fn invalid_stl_files_are_errors() {
    fn error(bytes: impl AsRef<[u8]>, parts: &[&str]) {
        assert_error(Format::Stl, bytes, parts);
    }
    error("", &["0 bytes", "header of 84"]);
    error("ply\n", &["4 bytes", "header of 84"]);
    error(binary_stl(b"", 4_000_000_000), &["284 bytes", "expected 200000000084", "4000000000 facets"]);
    error(&binary_stl(b"", 4)[..283], &["283 bytes, expected 284"]);
    error(binary_stl(b"", 0), &["0 triangles"]);
    error("solid none\nendsolid none\n", &["0 triangles"]);
    let text = text_stl("solid four");
    error(&text[..text.len() / 2], &["expected endsolid"]);
    error(text.trim_end().strip_suffix("endsolid").unwrap(), &["the end of the file in a solid, expected endsolid"]);
    error(text.replace("1.5", "nan"), &["line 6", "y = 'nan', expected a finite number"]);
    error(text.replace("1.5", "x"), &["line 6", "y = 'x'"]);
    error(text.replace("outer loop", "loop"), &["line 3", "'loop', expected solid, facet, outer, vertex"]);
    error(text.replacen("vertex 0 0 0\n", "", 1), &["line 7", "a facet of 2 vertices, expected 3"]);
    let mut infinite = binary_stl(b"", 4);
    infinite[96..100].copy_from_slice(&f32::INFINITY.to_le_bytes());
    error(infinite, &["vertex 0 has x = inf"]);
}

#[test]
fn invalid_gltf_files_are_errors() {
    fn error(bytes: impl AsRef<[u8]>, parts: &[&str]) {
        assert_error(Format::Gltf, bytes, parts);
    }
    let changed = |fields: Gltf, parts: &[&str]| error(gltf(&fields), parts);
    let good = Gltf::default();
    error("", &["not glTF 2"]);
    error("{}", &["not glTF 2"]);
    error("glTF", &["4 bytes", "header of 12"]);
    let text = gltf(&good);
    error(&text[..text.len() - 20], &["not glTF 2"]);
    let binary = glb(&Gltf { uri: "", ..good });
    error(&binary[..binary.len() - 4], &["bytes, expected", "by its header"]);
    let mut wrong = binary.clone();
    wrong[8..12].copy_from_slice(&3_u32.to_le_bytes());
    error(wrong, &["expected 3 by its header"]);
    let mut wrong = binary;
    wrong[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    error(wrong, &["not glTF 2"]);
    changed(Gltf { length: 1_000_000_000, ..good }, &["buffer 0: 96 bytes, expected 1000000000"]);
    changed(Gltf { vertices: 4_000_000, ..good }, &["POSITION: 4000000 items of 12 bytes"]);
    changed(Gltf { vertices: u64::MAX, ..good }, &["file"]);
    changed(Gltf { vertices: 0, ..good }, &["0 items"]);
    changed(Gltf { vertices: 3, ..good }, &["index 3, expected less than 3"]);
    changed(Gltf { stride: 4, ..good }, &["stride of 4, expected at least 12"]);
    changed(Gltf { offset: 1000, ..good }, &["a view of 48 bytes at 1000"]);
    changed(Gltf { offset: u64::MAX, ..good }, &["file"]);
    changed(Gltf { children: "0", ..good }, &["node 0 has two parents"]);
    changed(Gltf { uri: "absent.bin", ..good }, &["a/absent.bin: cannot read"]);
    for elsewhere in ["https://example.org/x", "/dev/zero", "../a/absent.bin", "%2e%2e/b", "c/../../b"] {
        changed(Gltf { uri: elsewhere, ..good }, &["expected a data URI or a file in the same folder"]);
    }
    changed(Gltf { uri: "data:x;base64,&", ..good }, &["not base64"]);
    error(gltf(&good).replace("POSITION\": 1", "POSITION\": 2"), &["mesh 0 names accessor 2", "less than 2"]);
    changed(Gltf { mode: 1, ..good }, &["0 triangles"]);
    changed(Gltf { scale: "[1e39, 1, 1]", ..good }, &["file"]);
}

#[test]
fn gltf_transforms_apply() {
    let scaled_by = |scale| parse(Format::Gltf, gltf(&Gltf { scale, ..Gltf::default() })).unwrap();
    let scaled = scaled_by("[2, 3, 4]");
    assert_eq!(scaled.positions(), POSITIONS.map(|[x, y, z]| [2.0 * x, 3.0 * y, 4.0 * z]));
    // Faces of a mirrored mesh are reversed, so that they still face outwards.
    let mirrored = scaled_by("[-1, 1, 1]");
    assert_eq!(mirrored.positions(), POSITIONS.map(|[x, y, z]| [-x, y, z]));
    assert_eq!(mirrored.triangles(), FACES.map(|[a, b, c]| [a, c, b]));
    let strip = parse(Format::Gltf, gltf(&Gltf { mode: 5, ..Gltf::default() })).unwrap();
    assert_eq!(strip.triangles()[..3], [[0, 1, 2], [2, 1, 0], [2, 0, 3]]);
    let fan = parse(Format::Gltf, gltf(&Gltf { mode: 6, ..Gltf::default() })).unwrap();
    assert_eq!(fan.triangles()[..3], [[0, 1, 2], [0, 2, 0], [0, 0, 3]]);
    // A buffer in another file of the folder.
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a b.bin"), buffer()).unwrap();
    let path = folder.path().join("four.gltf");
    std::fs::write(&path, gltf(&Gltf { uri: "a%20b.bin", ..Gltf::default() })).unwrap();
    assert_eq!(read_mesh(&path, MemoryLimit::DEFAULT).unwrap().positions(), POSITIONS);
}

/// Files as other programs write them, with the right answers that `tests/data/README.md` names.
#[test]
fn files_of_other_programs_are_read() {
    let plane = |z: f32| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
    let two_solids = include_bytes!("data/cases/two-solids.stl").as_slice();
    let capitals = include_bytes!("data/cases/capitals.stl").as_slice();
    let comment = include_bytes!("data/cases/trailing-comment.obj").as_slice();
    let mut trailing = binary_stl(b"solid of 80 bytes, and bytes after the last facet", 4);
    trailing.extend([0; 6]);
    let path = "# C:\\models\\\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3 \\";
    let cases: [(Format, &[u8], &[f32]); 10] = [
        (Format::Stl, two_solids, &[1.0, 2.0]),
        (Format::Stl, include_bytes!("data/cases/nan-normal.stl"), &[1.0]),
        (Format::Stl, capitals, &[1.0]),
        (Format::Stl, &[b"\n \r\n".as_slice(), capitals].concat(), &[1.0]),
        (Format::Stl, &[b"\xef\xbb\xbf".as_slice(), two_solids].concat(), &[1.0, 2.0]),
        (Format::Obj, comment, &[1.0]),
        (Format::Obj, include_bytes!("data/cases/continuation.obj"), &[1.0]),
        (Format::Obj, &[b"\xef\xbb\xbf".as_slice(), comment].concat(), &[1.0]),
        (Format::Obj, &[b"# gr\xfcn\n".as_slice(), comment].concat(), &[1.0]),
        (Format::Obj, path.as_bytes(), &[1.0]),
    ];
    for (number, (format, bytes, planes)) in cases.into_iter().enumerate() {
        let expected: Vec<_> = planes.iter().map(|z| plane(*z)).collect();
        assert_eq!(parse(format, bytes).map(|mesh| corners(&mesh)), Ok(expected), "case {number}");
    }
    assert_tetrahedron(Format::Stl, trailing);
}

/// Files whose content takes more memory than the limit are errors that name the size, before the memory is taken.
#[test]
fn bombs_are_errors() {
    // 3,100 nodes share a mesh of 21,000 triangles.
    let (nodes, corners) = (3_100, 3 * 21_000);
    let (indices, length) = (2 * corners, 2 * corners + 36);
    let roots = (0..nodes).map(|node| node.to_string()).collect::<Vec<_>>().join(",");
    let (each, data) = (vec![r#"{"mesh": 0}"#; nodes].join(","), BASE64.encode(vec![0; length]));
    let bomb = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [{roots}]}}], "nodes": [{each}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 1}}, "indices": 0}}]}}],
        "buffers": [{{"uri": "data:;base64,{data}", "byteLength": {length}}}],
        "bufferViews": [{{"buffer": 0, "byteLength": {indices}}},
            {{"buffer": 0, "byteOffset": {indices}, "byteLength": 36}}],
        "accessors": [{{"bufferView": 0, "componentType": 5123, "count": {corners}, "type": "SCALAR"}},
            {{"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0]}}]
        }}"#
    );
    assert!(bomb.len() < 270_000, "{} bytes", bomb.len());
    // 2 GiB are 4,194,304 triangles of 512 bytes; the 200th mesh is the first with more.
    let expected =
        ["primitive 0: 600 vertices and 4200000 triangles take 2150424000 bytes", "at most 2GiB", "--max-memory"];
    assert_error(Format::Gltf, &bomb, &expected);
    let parse = |format, bytes: &[u8], limit| {
        parse_mesh(format, bytes, Path::new("a/file"), MemoryLimit::of(limit)).map_err(|problem| problem.to_string())
    };
    let takes = |format, bytes: &[u8], limit: u64, size: &str| {
        let problem = parse(format, bytes, limit - 1).unwrap_err();
        assert!(problem.starts_with("a/file: ") && problem.contains(size), "{problem}");
        assert_eq!(parse(format, bytes, limit).map(|mesh| mesh.triangles().len()), Ok(4), "{format:?}");
    };
    takes(Format::Obj, OBJ.as_bytes(), 4 * 512 + 4 * 40, "4 vertices and 4 triangles take 2208 bytes");
    // The corners of a triangle are merged after the check.
    let of_stl = 4 * 512 + 7 * 40;
    takes(Format::Stl, text_stl("solid").as_bytes(), of_stl, "7 vertices and 4 triangles take 2328 bytes");
    takes(Format::Stl, &binary_stl(b"", 4), of_stl, "7 vertices and 4 triangles take 2328 bytes");
    let ply = format!("{PLY}\n");
    takes(Format::Ply, ply.as_bytes(), 12 * ply.len() as u64, &format!("{} bytes of PLY take", ply.len()));
    let objects = gltf(&Gltf::default());
    let count = objects.matches('{').count() as u64;
    takes(Format::Gltf, objects.as_bytes(), 512 * count, &format!("{count} objects of JSON take"));
    let many = gltf(&Gltf { length: 1 << 40, ..Gltf::default() });
    let problem = parse(Format::Gltf, many.as_bytes(), 1 << 20).unwrap_err();
    assert!(problem.contains("1099511627776 bytes of buffers"), "{problem}");

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lines");
    std::fs::write(&path, "0 0 0 0 0 1 inf\n".repeat(100)).unwrap();
    let limit = |bytes| MemoryLimit::of(bytes);
    let message = |problem: ReadError| problem.to_string();
    assert_eq!(read_rays(&path, limit(25_600)).map(|rays| rays.len()), Ok(100));
    let problem = read_rays(&path, limit(25_599)).map_err(message).unwrap_err();
    assert!(problem.contains("lines: 100 lines take 25600 bytes of memory, expected at most 25599"), "{problem}");
    let problem = read_hits(&path, limit(100)).map_err(message).unwrap_err();
    assert!(problem.contains("lines: cannot read: 1600 bytes take 1600 bytes"), "{problem}");
    let problem = read_instances(&path, limit(100_000)).map_err(message).unwrap_err();
    assert!(problem.contains("100 lines take 102400 bytes"), "{problem}");
    let problem = read_mesh(&folder.path().join("lines.obj"), limit(9)).map_err(message).unwrap_err();
    assert!(problem.contains("cannot read: No such file"), "{problem}");
}

fn binary_ply(encoding: &str, number: fn(f32) -> [u8; 4], index: fn(i32) -> [u8; 4]) -> Vec<u8> {
    let (header, _) = PLY.split_once("end_header\n").unwrap();
    let mut bytes = (header.replace("ascii", encoding) + "end_header\n").into_bytes();
    bytes.extend(POSITIONS.iter().flatten().flat_map(|&x| number(x)));
    for face in FACES {
        bytes.push(3);
        bytes.extend(face.iter().flat_map(|&corner| index(corner as i32)));
    }
    bytes
}

fn text_stl(first: &str) -> String {
    let mut text = format!("{first}\n");
    for face in FACES {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in face.map(|index| POSITIONS[index as usize]) {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid\n"
}

fn binary_stl(header: &[u8], count: u32) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, 0);
    bytes.extend(count.to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        bytes.extend(face.iter().flat_map(|&index| POSITIONS[index as usize]).flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

/// The fields of a glTF that tests change.
#[derive(Clone, Copy)]
struct Gltf {
    length: u64,
    vertices: u64,
    offset: u64,
    stride: u64,
    mode: u32,
    children: &'static str,
    scale: &'static str,
    /// Empty for the binary chunk, "data" for a data URI.
    uri: &'static str,
}

impl Default for Gltf {
    fn default() -> Self {
        Self { length: 96, vertices: 4, offset: 48, stride: 12, mode: 4, children: "", scale: "[1, 1, 1]", uri: "data" }
    }
}

/// Indices, then positions.
fn buffer() -> Vec<u8> {
    let mut bytes: Vec<u8> = FACES.iter().flatten().flat_map(|&index| (index as u16).to_le_bytes()).collect();
    bytes.resize(48, 0);
    bytes.extend(POSITIONS.iter().flatten().flat_map(|x| x.to_le_bytes()));
    bytes
}

fn gltf(fields: &Gltf) -> String {
    let Gltf { length, vertices, offset, stride, mode, children, scale, uri } = *fields;
    let uri = match uri {
        "" => String::new(),
        "data" => format!(r#""uri": "data:application/octet-stream;base64,{}","#, BASE64.encode(buffer())),
        uri => format!(r#""uri": "{uri}","#),
    };
    let children = if children.is_empty() { String::new() } else { format!(r#""children": [{children}],"#) };
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
        "nodes": [{{ {children} "mesh": 0, "scale": {scale} }}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 1}}, "indices": 0, "mode": {mode} }}]}}],
        "buffers": [{{ {uri} "byteLength": {length} }}],
        "bufferViews": [{{"buffer": 0, "byteLength": 24}},
            {{"buffer": 0, "byteOffset": {offset}, "byteLength": 48, "byteStride": {stride} }}],
        "accessors": [{{"bufferView": 0, "componentType": 5123, "count": 12, "type": "SCALAR"}},
            {{"bufferView": 1, "componentType": 5126, "count": {vertices}, "type": "VEC3",
              "min": [0, 0, -2], "max": [1, 1.5, 0]}}]}}"#
    )
}

fn glb(fields: &Gltf) -> Vec<u8> {
    let mut json = gltf(fields).into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let binary = buffer();
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2_u32.to_le_bytes());
    bytes.extend((28 + json.len() as u32 + binary.len() as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend((binary.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(binary);
    bytes
}
