//! Scenes of instances: the same hits as the mesh alone where a place changes nothing, and as all triangles of all
//! instances as one mesh where it does.

use crate::common::meshes::{self, Named};
use crate::common::rays::{Kind, rays};
use raypath_ops::{Binary32, Ray};
use raypath_render::{
    Camera, Goal, Mesh, Placement, Scene, Shading, Tracer, Tracing, draw, parse_instances, render, trace_closest,
};
use std::path::Path;

const IDENTITY: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Turned, mirrored, stretched, sheared, and far apart in size.
const PLACES: [[[f64; 4]; 3]; 5] = [
    IDENTITY,
    [[0.6, -0.8, 0.0, 3.0], [0.8, 0.6, 0.0, 0.5], [0.0, 0.0, 1.0, -1.0]],
    [[-1.0, 0.0, 0.0, -3.0], [0.0, 1.5, 0.0, 0.0], [0.0, 0.0, 0.5, 1.0]],
    [[0.3, 0.2, 0.0, 0.0], [0.0, 0.3, 0.1, 2.5], [0.0, 0.0, 0.3, 0.0]],
    [[0.01, 0.0, 0.0, 1.5], [0.0, 0.0, 0.01, 1.5], [0.0, -0.01, 0.0, 0.0]],
];

/// The instances as one mesh, with its triangles in the order of instances. Mirrored ones exchange two vertices.
fn flattened(mesh: &Mesh) -> Mesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for place in PLACES {
        let first = positions.len() as u32;
        let moved = |point: &[f32; 3]| {
            let [x, y, z] = point.map(f64::from);
            place.map(|row| (row[0] * x + row[1] * y + row[2] * z + row[3]) as f32)
        };
        positions.extend(mesh.positions().iter().map(moved));
        let is_mirrored = place == PLACES[2];
        triangles.extend(mesh.triangles().iter().map(|&[a, b, c]| {
            let [b, c] = if is_mirrored { [c, b] } else { [b, c] };
            [a, b, c].map(|vertex| first + vertex)
        }));
    }
    Mesh::new(positions, triangles).unwrap()
}

fn placements() -> Vec<Placement> {
    PLACES.into_iter().map(|place| Placement::new(place).unwrap()).collect()
}

/// A mesh at its own place: the transform of a ray is exact.
#[test]
fn an_instance_that_moves_nothing_has_the_hits_of_the_mesh() {
    let identity = [Placement::new(IDENTITY).unwrap()];
    for Named { name, mesh } in [meshes::real("suzanne"), meshes::real("truck")] {
        let plain = Scene::new(mesh.clone()).unwrap().through_unit().unwrap();
        let placed = Scene::of_instances(mesh.clone(), &identity, []).unwrap();
        for kind in Kind::ALL {
            let rays = rays(&mesh, kind, 2_000, 7);
            let tracing = Tracing { two_sided: true, ..Tracing::default() };
            let of = |scene: &Scene| trace_closest(scene, &rays, tracing, &|_| true).unwrap().0;
            let (expected, found) = (of(&plain), of(&placed));
            assert!(found.iter().flatten().all(|hit| hit.instance == Some(0)), "{name}, {kind:?}");
            let found: Vec<_> = found.into_iter().map(|hit| hit.map(|hit| (hit.triangle, hit.t.to_bits()))).collect();
            let expected: Vec<_> =
                expected.into_iter().map(|hit| hit.map(|hit| (hit.triangle, hit.t.to_bits()))).collect();
            assert!(found == expected, "{name}, {kind:?}");
        }
        let camera = Camera::framing(&mesh, 1.5);
        let picture = |scene: &Scene| render(scene, &camera, (60, 40), &Shading::default(), &|_| true).unwrap().picture;
        assert!(picture(&plain) == picture(&placed), "{name}: another picture");
    }
}

/// Rays from outside towards the centres of triangles.
fn aimed(mesh: &Mesh, count: usize) -> Vec<Ray<Binary32>> {
    let towards = |(index, ray): (usize, Ray<Binary32>)| {
        let corners = mesh.corners((index * 7919 % mesh.triangles().len()) as u32);
        let origin: [f32; 3] = ray.origin.into();
        let centre: [f32; 3] = std::array::from_fn(|axis| corners.iter().map(|corner| corner[axis]).sum::<f32>() / 3.0);
        Ray::new(origin, std::array::from_fn(|axis| centre[axis] - origin[axis]), f32::INFINITY).unwrap()
    };
    rays(mesh, Kind::Primary, count, 3).into_iter().enumerate().map(towards).collect()
}

/// The distances are those of the flattened mesh but for rounding, and the triangles are, unless two are as near.
#[test]
fn instances_have_the_hits_of_all_their_triangles() {
    let Named { mesh, .. } = meshes::real("suzanne");
    let flat = flattened(&mesh);
    let one_mesh = Scene::new(flat.clone()).unwrap();
    let placed = Scene::of_instances(mesh.clone(), &placements(), []).unwrap();
    let count = mesh.triangles().len() as u32;
    for two_sided in [false, true] {
        let tracing = Tracing { two_sided, ..Tracing::default() };
        let (mut tracer, mut reference) = (Tracer::new(&placed, tracing), Tracer::new(&one_mesh, tracing));
        let (mut hit_in, mut same, mut lost) = ([0; PLACES.len()], 0, 0);
        for ray in rays(&flat, Kind::Random, 6_000, 3).into_iter().chain(aimed(&flat, 6_000)) {
            let found = tracer.trace(&ray, Goal::Closest);
            match (found, reference.trace(&ray, Goal::Closest)) {
                (None, None) => same += 1,
                (Some(hit), Some(expected)) => {
                    let instance = hit.instance.unwrap();
                    hit_in[instance as usize] += 1;
                    if instance * count + hit.triangle == expected.triangle {
                        same += 1;
                        assert_eq!(hit.from_behind, expected.from_behind, "{ray:?}");
                        assert!((hit.t - expected.t).abs() <= 1e-3 * expected.t.max(0.01), "{hit:?} {expected:?}");
                    } else if (hit.t - expected.t).abs() > 1e-3 * expected.t {
                        lost += 1;
                    }
                }
                _ => lost += 1,
            }
        }
        // Rays that graze an outline, or pass an open edge, may differ.
        assert!(same > 11_900 && lost < 12, "two-sided {two_sided}: {same} of 12000 are the same, {lost} are not near");
        assert!(hit_in.iter().all(|&hits| hits > 100), "every instance is hit: {hit_in:?}");
    }
}

/// The picture of instances is that of their hits, with shadows and light from the sky on every instance.
#[test]
fn a_picture_of_instances() {
    let Named { mesh, .. } = meshes::real("suzanne");
    let camera = Camera::framing_instances(&mesh, &placements(), 1.5);
    let one_mesh = Scene::new(flattened(&mesh)).unwrap();
    let placed = Scene::of_instances(mesh, &placements(), [camera.eye()]).unwrap();
    let shading = Shading { shadows: true, ambient_occlusion: 2, ..Shading::default() };
    let picture = |scene: &Scene, shading: &Shading| render(scene, &camera, (90, 60), shading, &|_| true).unwrap();
    let [found, expected] = [&placed, &one_mesh].map(|scene| picture(scene, &shading));
    let different = found
        .picture
        .pixels()
        .zip(expected.picture.pixels())
        .filter(|(a, b)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 3));
    assert!(different.count() < 100, "shading differs");
    assert!(found.primary.hits > 300 && found.shadow.hits > 20, "{:?}", found.shadow);

    let plain = picture(&placed, &Shading::default()).picture;
    let rays = camera.rays(90, 60).unwrap();
    let (mut hits, _) = trace_closest(&placed, &rays, Tracing::default(), &|_| true).unwrap();
    assert!(draw(&placed, &camera, (90, 60), &hits).unwrap() == plain, "the picture of the hits");
    let pixel = hits.iter().position(Option::is_some).unwrap();
    for instance in [None, Some(5)] {
        hits[pixel].as_mut().unwrap().instance = instance;
        let problem = draw(&placed, &camera, (90, 60), &hits).unwrap_err().to_string();
        assert!(problem.starts_with(&format!("pixel {pixel} shows ")) && problem.contains("5 instances"), "{problem}");
    }
}

#[test]
fn files_of_instances() {
    let parse = |text: &str| parse_instances(text, Path::new("a/places.txt"));
    let row = "1 0 0 0 0 1 0 0 0 0 1 0";
    let read = parse(&format!("# two\n\n{row} # here\n0.5 0 0 1e3 0 -2 0 0 0 0 1 -7.25\n")).unwrap();
    let second = [[0.5, 0.0, 0.0, 1e3], [0.0, -2.0, 0.0, 0.0], [0.0, 0.0, 1.0, -7.25]];
    assert_eq!(read, [Placement::new(IDENTITY).unwrap(), Placement::new(second).unwrap()]);
    for (line, words) in [
        ("1 2 3", "a/places.txt:2: 3 numbers, expected 12: xx xy xz xt"),
        (&format!("{row} 1"), "a/places.txt:2: 13 numbers, expected 12"),
        ("1 0 0 0 0 1 0 y 0 0 1 0", "a/places.txt:2: yt = 'y', expected a decimal number"),
        ("1 0 0 0 0 1 0 0 0 0 nan 0", "a/places.txt:2: zz = NaN, expected a number of magnitude at most 2^40"),
        ("1 0 0 0 0 1 0 2e12 0 0 1 0", "a/places.txt:2: yt = 2000000000000, expected a number of magnitude"),
        ("1 0 0 0 1 0 0 0 0 0 1 0", "a/places.txt:2: the matrix has no inverse"),
        ("1e-39 0 0 0 0 1 0 0 0 0 1 0", "a/places.txt:2: the matrix has no inverse"),
    ] {
        let problem = parse(&format!("{row}\n{line}\n")).unwrap_err().to_string();
        assert!(problem.starts_with(words), "{problem}");
    }
    assert!(parse("# none\n").unwrap_err().to_string().contains("no instance, expected a line of 12 numbers"));
}

#[test]
fn instances_that_are_too_far_away_are_named() {
    let Named { mesh, .. } = meshes::real("teapot");
    let at = |x: f64, size: f64| {
        let [mut a, mut b, mut c] = IDENTITY;
        (a[0], a[3], b[1], c[2]) = (size, x, size, size);
        Placement::new([a, b, c]).unwrap()
    };
    let problem = |placements: &[Placement]| {
        let scene = Scene::of_instances(mesh.clone(), placements, []);
        scene.err().map_or("no error".to_string(), |error| error.to_string())
    };
    assert!(problem(&[at(2e12, 1.0)]).starts_with("instance 0 has a coordinate beyond 2^40"));
    // In the mesh of a tiny instance, a large one is far away.
    assert!(problem(&[at(0.0, 1e5), at(0.0, 1e-5)]).starts_with("instance 1 has"));
    // The longest side of this scene is not a number.
    assert!(problem(&[at(1e42, 1e5)]).starts_with("instance 0 has"));
    assert_eq!(problem(&[]), "0 instances, expected at least 1");
}
