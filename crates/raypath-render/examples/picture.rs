//! Renders a mesh, or the built-in scene: `picture [MESH] OUT.png`; the heat map goes beside it.

use raypath_render::{Camera, Scene, Shading, Tracing, builtin, read_mesh, render};
use std::error::Error;
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (mesh, out) = match arguments.as_slice() {
        [out] => (builtin()?, out),
        [mesh, out] => (read_mesh(Path::new(mesh))?, out),
        _ => return Err("expected: picture [MESH] OUT.png".into()),
    };
    let (width, height) = (960, 720);
    let camera = Camera::framing(&mesh, width as f32 / height as f32);
    let scene = Scene::for_origins(mesh, [camera.eye()])?;
    let tracing = Tracing { two_sided: arguments.len() == 2, ..Tracing::default() };
    let shading = Shading { tracing, shadows: true, ambient_occlusion: 8, samples: 2, ..Shading::default() };
    let start = Instant::now();
    let rendering = render(&scene, &camera, (width, height), &shading, &|_| true)?;
    println!(
        "{:?}: primary {:?}, shadow {:?}, occlusion {:?}",
        start.elapsed(),
        rendering.primary,
        rendering.shadow,
        rendering.occlusion
    );
    let out = Path::new(out);
    std::fs::write(out, rendering.picture.to_png()?)?;
    std::fs::write(out.with_extension("heat.png"), rendering.heatmap().to_png()?)?;
    Ok(())
}
