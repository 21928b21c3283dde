//! `raypath scene`: a mesh as the traversal unit reads it from memory.

use crate::CliError;
use crate::commands::full::render::Shown;
use crate::commands::full::{MemoryArguments, write_and_name};
use clap::Args;
use raypath_traversal::blocks::NodeKind;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct Arguments {
    /// The mesh as .obj, .gltf, .glb, .ply or .stl [default: a built-in scene]
    mesh: Option<PathBuf>,
    /// The nodes: boxes in binary32, or of 8 bits a bound
    #[arg(long, default_value = "wide4", value_name = "wide4|quantised")]
    node: NodeKind,
    /// Place the mesh in the scene as this file says: 12 numbers a line, of an affine matrix from the mesh to the
    /// scene, row by row. The unit needs instances (generate --unit --unit-features instances)
    #[arg(long, value_name = "FILE")]
    instances: Option<PathBuf>,
    /// The file to write: the blocks of the scene, from address 0 on
    #[arg(long, default_value = "build/scene.bin", value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    memory: MemoryArguments,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let Arguments { mesh, node, instances, out: path, memory } = arguments;
    let scene = Shown::read(mesh.as_deref(), instances.as_deref(), memory.limit)?.through_unit([], *node)?;
    let Some(blocks) = scene.blocks() else { return Ok(()) };
    let (triangles, nodes) = (scene.mesh().triangles().len(), scene.bvh().nodes().len());
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
