//! `raypath scene`: a mesh as the traversal unit reads it from memory.

use crate::CliError;
use crate::commands::full::render::Shown;
use crate::commands::full::{MemoryArguments, write_and_name};
use clap::Args;
use raypath_render::refit;
use raypath_traversal::blocks::{Child, NodeKind};
use std::fmt::Display;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct Arguments {
    /// The mesh as .obj, .gltf, .glb, .ply or .stl [default: a built-in scene]
    mesh: Option<PathBuf>,
    /// The nodes: four boxes in binary32, four of 8 bits a bound, or eight of them
    #[arg(long, default_value = "wide4", value_name = "wide4|quantised|wide8")]
    node: NodeKind,
    /// Place the mesh in the scene as this file says: 12 numbers a line, of an affine matrix from the mesh to the
    /// scene, row by row. The unit needs instances (generate --unit --unit-features instances)
    #[arg(long, value_name = "FILE")]
    instances: Option<PathBuf>,
    /// Keep the tree of this scene, which was written without instances from a mesh with the same triangles and with the
    /// same nodes, and put the vertices of the mesh into it
    #[arg(long, value_name = "FILE", conflicts_with = "instances")]
    refit: Option<PathBuf>,
    /// The file to write: the blocks of the scene, from address 0 on
    #[arg(long, default_value = "build/scene.bin", value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    memory: MemoryArguments,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let Arguments { mesh, node, instances, refit: old, out: path, memory } = arguments;
    if let Some(old) = old {
        let unusable = |problem: &dyn Display| CliError::unusable(format!("{}: {problem}", old.display()));
        let mut bytes = memory.limit.read(old).map_err(|problem| unusable(&problem))?;
        let root = Child::Node { address: 0 }.word(*node).map_err(|problem| unusable(&problem))?;
        let mesh = Shown::read(mesh.as_deref(), None, memory.limit)?.mesh();
        refit(&mut bytes, root, *node, &mesh)
            .map_err(|problem| unusable(&format_args!("read with {node} nodes, {problem}")))?;
        writeln!(out, "{} triangles in the tree of {}", mesh.triangles().len(), old.display())?;
        writeln!(out, "root {root:#010x}")?;
        return write_and_name(&[(path.clone(), &bytes)], out);
    }
    let scene = Shown::read(mesh.as_deref(), instances.as_deref(), memory.limit)?.through_unit([], *node)?;
    let Some(blocks) = scene.blocks() else { return Ok(()) };
    let (triangles, nodes) = (scene.mesh().triangles().len(), blocks.node_count());
    let (count, bytes) = (blocks.len(), blocks.bytes().len());
    let of_instances = match scene.instances() {
        0 => String::new(),
        instances => format!(", {instances} instances"),
    };
    writeln!(out, "{triangles} triangles, {nodes} nodes{of_instances}: {count} blocks, {bytes} bytes")?;
    let origins = match scene.reach() {
        reach if reach.is_finite() => format!(", for ray origins within {reach} of every vertex along each axis"),
        _ => String::new(),
    };
    writeln!(out, "root {:#010x}{origins}", blocks.root())?;
    write_and_name(&[(path.clone(), blocks.bytes())], out)
}
