//! Visits of nodes and leaves of the rays of a picture, which boxes in fewer bits add to.

use crate::CliError;
use raypath_ops::Rules;
use raypath_render::{Camera, Costs, Scene, Shading, Tracing, builtin, read_mesh, render};
use raypath_tools::MemoryLimit;
use std::path::PathBuf;

/// The size of the pictures.
pub const SIZE: (u32, u32) = (320, 240);

/// A scene with its name and camera.
pub struct Shown {
    pub name: String,
    scene: Scene,
    camera: Camera,
}

/// The built-in scene, and those of the files.
pub fn scenes(paths: &[PathBuf], limit: MemoryLimit) -> Result<Vec<Shown>, CliError> {
    let mut meshes = vec![("built-in scene".to_string(), builtin().map_err(CliError::unusable)?)];
    for path in paths {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        meshes.push((name, read_mesh(path, limit).map_err(CliError::unusable)?));
    }
    let shown = |(name, mesh)| {
        let camera = Camera::framing(&mesh, SIZE.0 as f32 / SIZE.1 as f32);
        let scene = Scene::new(mesh).map_err(CliError::unusable)?;
        Ok(Shown { name, scene, camera })
    };
    meshes.into_iter().map(shown).collect()
}

/// The visits of nodes and leaves in a picture with a shadow ray and some ambient-occlusion rays per hit.
pub fn visits(shown: &Shown, rules: Rules, ambient_occlusion: u32) -> Result<u64, CliError> {
    let tracing = Tracing { rules, ..Tracing::default() };
    let shading = Shading { tracing, shadows: true, ambient_occlusion, ..Shading::default() };
    let rendering = render(&shown.scene, &shown.camera, SIZE, &shading, &|_| true).map_err(CliError::unusable)?;
    let visits = |costs: &Costs| costs.counts.nodes + costs.counts.leaves;
    Ok([&rendering.primary, &rendering.shadow, &rendering.occlusion].map(visits).iter().sum())
}
