use super::{Parsed, RawMesh};
use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::Source;
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Gltf, Node, Primitive, Semantic};
use percent_encoding::percent_decode_str;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path};

/// The bytes that an object of the JSON takes, such as a node.
const OBJECT_BYTES: u64 = 512;

/// Parses glTF with the crate `gltf`. Accessors are read here, because those of the crate trust offsets and strides.
pub(super) fn parse(bytes: &[u8], path: &Path, raw: RawMesh) -> Parsed {
    check_binary_header(bytes)?;
    let objects = bytes.iter().filter(|&&byte| byte == b'{').count();
    raw.limit.check(objects as u64, "objects of JSON", OBJECT_BYTES)?;
    let not_gltf = |problem| format!("not glTF 2: {problem}");
    check_positions(&Gltf::from_slice_without_validation(bytes).map_err(not_gltf)?.document)?;
    let Gltf { document, blob } = Gltf::from_slice(bytes).map_err(not_gltf)?;
    // Several buffers can name one file.
    let lengths = document.buffers().map(|buffer| buffer.length() as u64);
    raw.limit.check(lengths.fold(0, u64::saturating_add), "bytes of buffers", 1)?;
    let buffers = buffers(&document, blob, path)?;
    let mut scene = SceneMesh { buffers, raw };
    let scenes = document.default_scene().or_else(|| document.scenes().next());
    let roots: Vec<Node> = match scenes {
        Some(scene) => scene.nodes().collect(),
        None => return Err("no scene, expected one with nodes".to_string()),
    };
    // A node has at most one parent. A node that occurs twice is in a cycle.
    let mut visited = vec![false; document.nodes().len()];
    let mut pending: Vec<(Node, Matrix)> = roots.into_iter().map(|node| (node, IDENTITY)).collect();
    while let Some((node, parent)) = pending.pop() {
        let index = node.index();
        if std::mem::replace(&mut visited[index], true) {
            return Err(format!("node {index} has two parents, expected a tree of nodes"));
        }
        let matrix = product(&parent, &node.transform().matrix().map(|column| column.map(f64::from)));
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            let location = format!("node {index}, primitive {}", primitive.index());
            scene.add(&primitive, &matrix).map_err(|problem| format!("{location}: {problem}"))?;
        }
        pending.extend(node.children().map(|child| (child, matrix)));
    }
    Ok(scene.raw)
}

/// A matrix by columns.
type Matrix = [[f64; 4]; 4];

const IDENTITY: Matrix = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|column| std::array::from_fn(|row| (0..4).map(|k| a[k][row] * b[column][k]).sum()))
}

fn transformed(matrix: &Matrix, [x, y, z]: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = [x, y, z].map(f64::from);
    std::array::from_fn(|row| (matrix[0][row] * x + matrix[1][row] * y + matrix[2][row] * z + matrix[3][row]) as f32)
}

fn mirrors([a, b, c, _]: &Matrix) -> bool {
    let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
    a[0] * minor(1, 2) + a[1] * minor(2, 0) + a[2] * minor(0, 1) < 0.0
}

/// Checks the length in the header of a binary file, which `gltf` does not.
fn check_binary_header(bytes: &[u8]) -> Result<(), String> {
    if !bytes.starts_with(b"glTF") {
        return Ok(());
    }
    let claimed = bytes.get(8..).and_then(<[u8]>::first_chunk).map(|length| u32::from_le_bytes(*length) as usize);
    match claimed {
        Some(claimed) if (12..=bytes.len()).contains(&claimed) => Ok(()),
        Some(claimed) => Err(format!("{} bytes, expected {claimed} by its header", bytes.len())),
        None => Err(format!("{} bytes, expected a header of 12", bytes.len())),
    }
}

/// Checks that the accessors of primitives exist; the validation of `gltf` panics otherwise.
fn check_positions(document: &Document) -> Result<(), String> {
    let json = document.as_json();
    let accessors = json.accessors.len();
    for (mesh, primitive) in
        json.meshes.iter().enumerate().flat_map(|(m, mesh)| mesh.primitives.iter().map(move |p| (m, p)))
    {
        for index in primitive.attributes.values().map(|accessor| accessor.value()) {
            if index >= accessors {
                return Err(format!(
                    "mesh {mesh} names accessor {index}, expected less than {accessors}, the number of accessors"
                ));
            }
        }
    }
    Ok(())
}

/// The content of each buffer, at least as long as the file states.
fn buffers(document: &Document, mut blob: Option<Vec<u8>>, path: &Path) -> Result<Vec<Vec<u8>>, String> {
    let content = |buffer: gltf::Buffer| {
        let content = match buffer.source() {
            Source::Bin => blob.take().ok_or_else(|| "no binary chunk, expected one".to_string()),
            Source::Uri(uri) => resource(uri, path, buffer.length()),
        };
        let content = content.and_then(|content| match content.len() {
            found if found < buffer.length() => Err(format!("{found} bytes, expected {}", buffer.length())),
            _ => Ok(content),
        });
        content.map_err(|problem| format!("buffer {}: {problem}", buffer.index()))
    };
    document.buffers().map(content).collect()
}

/// The first `length` bytes of what a URI names.
fn resource(uri: &str, path: &Path, length: usize) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, encoded) = data.split_once(";base64,").ok_or("data URI without ';base64,', expected it")?;
        return BASE64.decode(encoded).map_err(|problem| format!("data URI is not base64: {problem}"));
    }
    let name = percent_decode_str(uri).decode_utf8().map_err(|_| format!("'{uri}', expected UTF-8 when decoded"))?;
    // A file from elsewhere must not choose which file of the machine is read, nor name an endless one.
    if uri.contains("://")
        || !Path::new(&*name).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
    {
        return Err(format!("'{uri}', expected a data URI or a file in the same folder"));
    }
    let file = path.parent().unwrap_or(Path::new("")).join(&*name);
    let mut content = Vec::new();
    let read = File::open(&file).and_then(|file| file.take(length as u64).read_to_end(&mut content));
    read.map(|_| content).map_err(|problem| format!("{}: cannot read: {problem}", file.display()))
}

struct SceneMesh {
    buffers: Vec<Vec<u8>>,
    raw: RawMesh,
}

impl SceneMesh {
    /// Appends the triangles of a primitive; one of points or lines has none.
    fn add(&mut self, primitive: &Primitive, matrix: &Matrix) -> Result<(), String> {
        if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            return Ok(());
        }
        let accessor = primitive.get(&Semantic::Positions).ok_or("no POSITION, expected it")?;
        // Nodes can repeat meshes, so a small file can have many triangles.
        let corners = primitive.indices().map_or(accessor.count(), |indices| indices.count());
        let is_list = primitive.mode() == Mode::Triangles;
        self.raw.check(accessor.count(), if is_list { corners / 3 } else { corners.saturating_sub(2) })?;
        let positions = self.positions(&accessor).map_err(|problem| format!("POSITION: {problem}"))?;
        let indices = match primitive.indices() {
            Some(indices) => self.indices(&indices).map_err(|problem| format!("indices: {problem}"))?,
            None => (0..positions.len() as u32).collect(),
        };
        if let Some(index) = indices.iter().find(|&&index| index as usize >= positions.len()) {
            return Err(format!("index {index}, expected less than {}, the number of vertices", positions.len()));
        }
        let triangles = triangles(primitive.mode(), &indices);
        let first = u32::try_from(self.raw.positions.len()).map_err(|_| "more than 2^32 vertices".to_string())?;
        let mirrored = mirrors(matrix);
        self.raw.positions.extend(positions.into_iter().map(|position| transformed(matrix, position)));
        // A mirroring transform reverses the orientation of faces; exchanging two corners restores it.
        self.raw.triangles.extend(triangles.into_iter().map(|[a, b, c]| {
            if mirrored { [a, c, b].map(|index| first + index) } else { [a, b, c].map(|index| first + index) }
        }));
        Ok(())
    }

    fn positions(&self, accessor: &Accessor) -> Result<Vec<[f32; 3]>, String> {
        if (accessor.data_type(), accessor.dimensions()) != (DataType::F32, Dimensions::Vec3) {
            return Err(format!("{:?} of {:?}, expected Vec3 of F32", accessor.dimensions(), accessor.data_type()));
        }
        let number = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        Ok(self.items(accessor)?.map(|item| [number(&item[0..4]), number(&item[4..8]), number(&item[8..12])]).collect())
    }

    fn indices(&self, accessor: &Accessor) -> Result<Vec<u32>, String> {
        let index: fn(&[u8]) -> u32 = match (accessor.data_type(), accessor.dimensions()) {
            (DataType::U8, Dimensions::Scalar) => |item| item[0].into(),
            (DataType::U16, Dimensions::Scalar) => |item| u16::from_le_bytes([item[0], item[1]]).into(),
            (DataType::U32, Dimensions::Scalar) => |item| u32::from_le_bytes([item[0], item[1], item[2], item[3]]),
            (kind, dimensions) => return Err(format!("{dimensions:?} of {kind:?}, expected Scalar of U8, U16 or U32")),
        };
        Ok(self.items(accessor)?.map(index).collect())
    }

    fn items(&self, accessor: &Accessor) -> Result<impl Iterator<Item = &[u8]>, String> {
        if accessor.sparse().is_some() {
            return Err("a sparse accessor, expected a plain one".to_string());
        }
        let view = accessor.view().ok_or("no buffer view, expected one")?;
        let buffer = &self.buffers[view.buffer().index()];
        let end = view.offset().checked_add(view.length());
        let view_bytes = end.and_then(|end| buffer.get(view.offset()..end)).ok_or_else(|| {
            let (offset, length, found) = (view.offset(), view.length(), buffer.len());
            format!(
                "a view of {length} bytes at {offset}, expected them within the {found} of buffer {}",
                view.buffer().index()
            )
        })?;
        let (size, count) = (accessor.size(), accessor.count());
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            return Err(format!("a stride of {stride}, expected at least {size}, the size of an item"));
        }
        let bytes = view_bytes.get(accessor.offset()..).unwrap_or_default();
        let needed =
            count.checked_sub(1).map(|steps| steps.checked_mul(stride).and_then(|before| before.checked_add(size)));
        match needed {
            None => Err("0 items, expected at least 1".to_string()),
            Some(Some(needed)) if needed <= bytes.len() => {
                Ok(bytes.chunks(stride).take(count).map(move |item| &item[..size]))
            }
            Some(_) => {
                Err(format!("{count} items of {stride} bytes, expected no more than its {} bytes hold", bytes.len()))
            }
        }
    }
}

fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let oriented = |(index, corners): (usize, &[u32])| match index % 2 {
                0 => [corners[0], corners[1], corners[2]],
                _ => [corners[1], corners[0], corners[2]],
            };
            indices.windows(3).enumerate().map(oriented).collect()
        }
        Mode::TriangleFan => {
            let Some((first, others)) = indices.split_first() else { return Vec::new() };
            others.windows(2).map(|pair| [*first, pair[0], pair[1]]).collect()
        }
        _ => indices.as_chunks().0.to_vec(),
    }
}
