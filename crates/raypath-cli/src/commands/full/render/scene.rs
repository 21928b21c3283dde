//! The scene and the camera.

use crate::error::CliError;
use clap::Args;
use raypath_render::{Camera, Mesh, Placement, Scene, builtin, read_instances, read_mesh};
use raypath_tools::MemoryLimit;
use raypath_traversal::blocks::NodeKind;
use std::fmt::Display;
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
    /// The requested camera, or one that sees the whole mesh or all instances of it.
    pub fn camera(&self, shown: &Shown, aspect: f32) -> Result<Camera, CliError> {
        match self.camera.as_deref() {
            None => Ok(shown.framing(aspect)),
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

/// What a scene shows: a mesh, or instances of it.
pub struct Shown {
    name: String,
    mesh: Mesh,
    instances: Option<Vec<Placement>>,
}

impl Shown {
    /// The mesh of a file, or the built-in one, and the instances of a file, if there is one.
    pub fn read(mesh: Option<&Path>, instances: Option<&Path>, limit: MemoryLimit) -> Result<Self, CliError> {
        let name = name(mesh);
        let mesh = match mesh {
            Some(path) => read_mesh(path, limit).map_err(CliError::unusable)?,
            None => builtin().map_err(CliError::unusable)?,
        };
        let instances = instances.map(|path| read_instances(path, limit)).transpose().map_err(CliError::unusable)?;
        Ok(Self { name, mesh, instances })
    }

    /// A camera that sees the whole mesh or all instances of it.
    pub fn framing(&self, aspect: f32) -> Camera {
        match &self.instances {
            Some(instances) => Camera::framing_instances(&self.mesh, instances, aspect),
            None => Camera::framing(&self.mesh, aspect),
        }
    }

    /// The mesh alone.
    pub fn mesh(self) -> Mesh {
        self.mesh
    }

    /// The scene for ray origins at these points.
    pub fn scene(self, origins: impl IntoIterator<Item = [f32; 3]>) -> Result<Scene, CliError> {
        match self.instances {
            Some(instances) => Scene::of_instances(self.mesh, &instances, origins).map_err(unusable(&self.name)),
            None => Scene::new(self.mesh).map_err(unusable(&self.name)),
        }
    }

    /// The same in memory, as the traversal unit reads it.
    pub fn through_unit(self, origins: impl IntoIterator<Item = [f32; 3]>, nodes: NodeKind) -> Result<Scene, CliError> {
        let name = self.name.clone();
        self.scene(origins)?.through_unit_of(nodes).map_err(unusable(&name))
    }
}

/// A problem of the scene with this name.
fn unusable<E: Display>(name: &str) -> impl Fn(E) -> CliError {
    move |problem| CliError::unusable(format!("{name}: {problem}"))
}

pub fn name(path: Option<&Path>) -> String {
    path.map_or_else(|| "built-in scene".to_string(), |path| path.display().to_string())
}

pub fn describe(path: Option<&Path>, scene: &Scene, out: &mut dyn Write) -> Result<(), CliError> {
    let name = name(path);
    let (nodes, boxes) = match scene.blocks() {
        Some(blocks) if blocks.nodes() == NodeKind::Wide8 => (blocks.node_count(), "eight"),
        _ => (scene.bvh().nodes().len(), "four"),
    };
    let triangles = scene.mesh().triangles().len();
    let instances = match scene.instances() {
        0 => String::new(),
        count => format!("{count} instances of "),
    };
    writeln!(out, "{name}: {instances}{triangles} triangles, a tree of {nodes} nodes with {boxes} boxes each\n")?;
    Ok(())
}
