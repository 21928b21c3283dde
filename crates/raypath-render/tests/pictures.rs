//! Cameras and pictures.

use crate::common::meshes;
use image::ImageReader;
use raypath_ops::Ray;
use raypath_render::{Camera, Mesh, RenderError, Rendering, Scene, Shading, Stopped, Tracing, heatmap, render, to_png};
use std::io::Cursor;

fn shaded(samples: u32) -> Shading {
    Shading { shadows: true, ambient_occlusion: 3, samples, ..Shading::default() }
}

fn rendered(mesh: &Mesh, size: (u32, u32), shading: &Shading) -> Rendering {
    let scene = Scene::new(mesh.clone()).unwrap();
    let camera = Camera::framing(mesh, size.0 as f32 / size.1 as f32);
    assert!(scene.reaches(camera.eye()));
    render(&scene, &camera, size, shading, &|_| true).unwrap()
}

#[test]
fn pictures_depend_on_their_arguments_only() {
    let mesh = meshes::real("truck").mesh;
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| rendered(&mesh, (60, 40), &shaded(2)))
    };
    let one = with(1);
    assert_eq!(one, with(3));
    let other = rendered(&mesh, (60, 40), &Shading { seed: 2, ..shaded(2) });
    assert_ne!(one.picture, other.picture);
    assert_eq!(one.primary, other.primary);
}

#[test]
fn costs_add_up() {
    let mesh = meshes::real("teapot").mesh;
    let plain = rendered(&mesh, (50, 30), &Shading::default());
    assert_eq!((plain.primary.rays, plain.shadow.rays, plain.occlusion.rays), (1_500, 0, 0));
    let full = rendered(&mesh, (50, 30), &shaded(2));
    assert_eq!((full.primary.rays, full.occlusion.rays), (6_000, 3 * full.primary.hits));
    assert!((1..full.primary.hits).contains(&full.shadow.rays));
    let jobs = [full.primary, full.shadow, full.occlusion].map(|costs| costs.counts.jobs()).iter().sum::<u64>();
    assert_eq!(full.jobs.iter().map(|&jobs| u64::from(jobs)).sum::<u64>(), jobs);
    assert!(plain.primary.hits > 200);
}

/// A sphere of radius 1 with all coordinates of its centre equal: it is convex, so secondary rays miss it.
fn sphere(centre: f32) -> Mesh {
    let (rings, sectors) = (40_u32, 80_u32);
    let mut positions = vec![[centre, centre + 1.0, centre], [centre, centre - 1.0, centre]];
    for ring in 1..rings {
        let polar = std::f32::consts::PI * ring as f32 / rings as f32;
        for sector in 0..sectors {
            let angle = std::f32::consts::TAU * sector as f32 / sectors as f32;
            let point = [polar.sin() * angle.sin(), polar.cos(), polar.sin() * angle.cos()];
            positions.push(point.map(|x| centre + x));
        }
    }
    let at = |ring: u32, sector: u32| 2 + (ring - 1) * sectors + sector % sectors;
    let mut triangles = Vec::new();
    for sector in 0..sectors {
        triangles.push([0, at(1, sector), at(1, sector + 1)]);
        triangles.push([1, at(rings - 1, sector + 1), at(rings - 1, sector)]);
        for ring in 1..rings - 1 {
            triangles.push([at(ring, sector), at(ring + 1, sector), at(ring + 1, sector + 1)]);
            triangles.push([at(ring, sector), at(ring + 1, sector + 1), at(ring, sector + 1)]);
        }
    }
    Mesh::new(positions, triangles).unwrap()
}

/// Secondary rays start far enough outside: a convex body casts no shadow on itself, anywhere in space.
#[test]
fn a_convex_body_does_not_shadow_itself() {
    for centre in [0.0, 30.0, 1_000.0] {
        for two_sided in [false, true] {
            let tracing = Tracing { two_sided, ..Tracing::default() };
            let rendering = rendered(&sphere(centre), (120, 120), &Shading { tracing, ..shaded(1) });
            assert!(rendering.primary.hits > 5_000 && rendering.shadow.rays > 2_000);
            // Far from 0 the vertices lie on a coarse grid, and the body is not exactly convex.
            let max = if centre < 100.0 { 0 } else { rendering.occlusion.rays / 100 };
            assert!(rendering.shadow.hits <= max, "{centre}: {:?}", rendering.shadow);
            assert!(rendering.occlusion.hits <= max, "{centre}: {:?}", rendering.occlusion);
        }
    }
}

/// A concave body has some points, but not most, in its own shadow.
#[test]
fn a_concave_body_shadows_itself() {
    let scene = meshes::real("suzanne").mesh;
    let shadowed = rendered(&scene, (60, 60), &shaded(1));
    assert!(shadowed.shadow.hits > shadowed.shadow.rays / 20 && shadowed.shadow.hits < shadowed.shadow.rays / 2);
    assert!(shadowed.occlusion.hits > shadowed.occlusion.rays / 20);
    let brightness = |rendering: &Rendering| rendering.picture.as_raw().iter().map(|&x| u64::from(x)).sum::<u64>();
    let open = rendered(&scene, (60, 60), &Shading { shadows: false, ..shaded(1) });
    assert!(brightness(&shadowed) < brightness(&open));
}

#[test]
fn pngs_survive_decoding() {
    let rendering = rendered(&meshes::real("teapot").mesh, (50, 30), &shaded(1));
    for picture in [&rendering.picture, &rendering.heatmap(), &heatmap(3, 2, &[0; 6])] {
        let png = to_png(picture).unwrap();
        let read = ImageReader::new(Cursor::new(png)).with_guessed_format().unwrap().decode().unwrap().into_rgb8();
        assert_eq!(read, *picture);
    }
}

#[test]
fn framing_cameras_see_the_whole_mesh() {
    for mesh in meshes::all().into_iter().map(|named| named.mesh).chain([sphere(1_000.0)]) {
        for (width, height) in [(400, 300), (100, 300), (300, 100)] {
            let camera = Camera::framing(&mesh, width as f32 / height as f32);
            let view = camera.view(width, height);
            let (w, h) = (f64::from(width), f64::from(height));
            let corner = |x, y| <[f32; 3]>::from(view.ray(x, y).unwrap().dir).map(f64::from);
            let corners = [corner(0.0, 0.0), corner(w, 0.0), corner(w, h), corner(0.0, h)];
            for &position in mesh.triangles().iter().flatten().map(|&vertex| &mesh.positions()[vertex as usize]) {
                let r: [f64; 3] = std::array::from_fn(|k| f64::from(position[k]) - f64::from(camera.eye()[k]));
                for k in 0..4 {
                    let (a, b) = (corners[k], corners[(k + 1) % 4]);
                    let minor = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
                    assert!(minor(1, 2) * r[0] + minor(2, 0) * r[1] + minor(0, 1) * r[2] > 0.0, "{position:?}");
                }
            }
        }
    }
}

#[test]
fn rays_pass_through_their_pixels() {
    let camera = Camera::new([1.0, 2.0, 3.0], [1.0, 2.0, -7.0], [0.0, 1.0, 0.0], 90.0).unwrap();
    let view = camera.view(4, 2);
    let along = |x, y| <[f32; 3]>::from(view.ray(x, y).unwrap().dir);
    assert_eq!(along(2.0, 1.0), [0.0, 0.0, -1.0]);
    // The upper edge is 45 degrees up; the left edge is twice as far from the centre.
    let half = 0.5_f32.sqrt();
    let near = |a: [f32; 3], b: [f32; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-6);
    assert!(near(along(2.0, 0.0), [0.0, half, -half]));
    assert!(near(along(0.0, 1.0), [-2.0 / 5.0_f32.sqrt(), 0.0, -1.0 / 5.0_f32.sqrt()]));
    assert_eq!(view.ray(0.5, 0.5).unwrap().extent, Ray::new([0.0; 3], [1.0; 3], f32::INFINITY).unwrap().extent);
    // At a distance of 1 the picture is 2 high, so pixels have sides of 1.
    let centres = [-0.5, 0.5].map(|down| [-1.5, -0.5, 0.5, 1.5].map(|right| [right, -down, -1.0]));
    let rays = camera.rays(4, 2).unwrap();
    assert_eq!(rays.len(), 8);
    for (ray, centre) in rays.iter().zip(centres.as_flattened()) {
        let length = centre.iter().map(|x: &f32| x * x).sum::<f32>().sqrt();
        assert_eq!(<[f32; 3]>::from(ray.origin), camera.eye());
        assert!(near(ray.dir.into(), centre.map(|x| x / length)), "{centre:?}");
    }
}

#[test]
fn invalid_cameras_and_pictures_are_errors() {
    let message = |eye, target, up, angle| Camera::new(eye, target, up, angle).unwrap_err().to_string();
    let (a, b, up) = ([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    assert_eq!(message(a, a, up, 40.0), "eye and target are both (0, 0, 0), expected different points");
    assert!(message(a, b, [-2.0, 0.0, 0.0], 40.0).starts_with("up (-2, 0, 0) is parallel to the viewing direction"));
    assert!(message(a, b, [0.0; 3], 40.0).starts_with("up (0, 0, 0)"));
    assert!(message([f32::NAN, 0.0, 0.0], b, up, 40.0).starts_with("eye (NaN, 0, 0) is not finite"));
    for angle in [0.0, 180.0, f32::NAN] {
        assert!(message(a, b, up, angle).contains("expected more than 0 and less than 180"));
    }
    let mesh = meshes::real("teapot").mesh;
    let (scene, camera) = (Scene::new(mesh.clone()).unwrap(), Camera::framing(&mesh, 1.0));
    for (width, height) in [(0, 5), (5, 0), (70_000, 1), (60_000, 60_000)] {
        let refused = render(&scene, &camera, (width, height), &Shading::default(), &|_| true);
        assert_eq!(refused, Err(RenderError::Size { width, height }));
    }
    let none = Shading { samples: 0, ..Shading::default() };
    assert_eq!(render(&scene, &camera, (1, 1), &none, &|_| true), Err(RenderError::Samples(0)));
    let stopped = render(&scene, &camera, (10, 10), &Shading::default(), &|done| done > 1_000);
    assert_eq!(stopped, Err(RenderError::Stopped(Stopped)));
}
