//! The scene and the camera.

use crate::error::CliError;
use clap::Args;
use raypath_render::{Camera, Mesh, Scene, builtin, read_mesh};
use std::io::Write;
use std::path::Path;

#[derive(Debug, Args)]
pub struct CameraArguments {
    /// The position of the eye, and the point it looks at; up is +y [default: a view of the whole mesh]
    #[arg(
        long,
        num_args = 6,
        allow_negative_numbers = true,
        value_names = ["EX", "EY", "EZ", "TX", "TY", "TZ"]
    )]
    camera: Option<Vec<f32>>,
    /// The vertical field of view in degrees
    #[arg(long, default_value_t = Camera::FIELD_OF_VIEW, requires = "camera", value_name = "DEGREES")]
    fov: f32,
}

impl CameraArguments {
    /// The requested camera, or one that sees the whole mesh.
    pub fn camera(&self, mesh: &Mesh, aspect: f32) -> Result<Camera, CliError> {
        match self.camera.as_deref() {
            None => Ok(Camera::framing(mesh, aspect)),
            Some(&[ex, ey, ez, tx, ty, tz]) => {
                let camera = Camera::new([ex, ey, ez], [tx, ty, tz], [0.0, 1.0, 0.0], self.fov);
                camera.map_err(|problem| CliError::unusable(format!("--camera: {problem}")))
            }
            Some(_) => Err(CliError::unusable("--camera: expected six numbers")),
        }
    }
}

/// A parser of a size: pixels in a row, and rows.
pub fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=16_384).contains(side));
    let sides = text.split_once('x').and_then(|(width, height)| Some((side(width)?, side(height)?)));
    sides.ok_or_else(|| "expected two numbers from 1 to 16384 with an x between them, like 640x480".to_string())
}

pub fn mesh(path: Option<&Path>) -> Result<Mesh, CliError> {
    match path {
        Some(path) => read_mesh(path).map_err(CliError::unusable),
        None => builtin().map_err(CliError::unusable),
    }
}

pub fn name(path: Option<&Path>) -> String {
    path.map_or_else(|| "built-in scene".to_string(), |path| path.display().to_string())
}

pub fn describe(path: Option<&Path>, scene: &Scene, out: &mut dyn Write) -> Result<(), CliError> {
    let name = name(path);
    let (triangles, nodes) = (scene.mesh().triangles().len(), scene.bvh().nodes().len());
    writeln!(out, "{name}: {triangles} triangles, a tree of {nodes} nodes with four boxes each\n")?;
    Ok(())
}
