//! `raypath scene`: a mesh as the traversal unit reads it from memory.

use crate::CliError;
use crate::commands::full::write_and_name;
use clap::Args;
use raypath_render::{Blocks, Scene, builtin, read_mesh};
use raypath_unit::blocks::NodeKind;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct Arguments {
    /// The mesh as .obj, .gltf, .glb, .ply or .stl [default: a built-in scene]
    mesh: Option<PathBuf>,
    /// The nodes: boxes in binary32, or of 8 bits a bound
    #[arg(long, default_value = "wide4", value_name = "wide4|quantised")]
    node: NodeKind,
    /// The file to write: the blocks of the scene, from address 0 on
    #[arg(long, default_value = "build/scene.bin", value_name = "FILE")]
    out: PathBuf,
}

pub fn run(Arguments { mesh, node, out: path }: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let mesh = match mesh {
        Some(path) => read_mesh(path).map_err(CliError::unusable)?,
        None => builtin().map_err(CliError::unusable)?,
    };
    let scene = Scene::new(mesh).map_err(CliError::unusable)?;
    let blocks = Blocks::of(scene.bvh(), *node).map_err(CliError::unusable)?;
    let (triangles, nodes) = (scene.mesh().triangles().len(), scene.bvh().nodes().len());
    writeln!(out, "{triangles} triangles, {nodes} nodes: {} blocks, {} bytes", blocks.len(), blocks.bytes().len())?;
    let (root, reach) = (blocks.root(), scene.reach());
    writeln!(out, "root {root:#010x}, for ray origins within {reach} of every vertex along each axis")?;
    write_and_name(&[(path.clone(), blocks.bytes())], out)
}
