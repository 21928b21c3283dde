//! The built-in scene, for use without a mesh file.

use raypath_scene::mesh::{Mesh, MeshError};
use raypath_scene::vector::{Vector, add, cross, dot, scale, single, subtract, unit};
use std::collections::HashMap;
use std::f64::consts::{GOLDEN_RATIO, TAU};

/// The mesh of the built-in scene: a torus knot over rippled ground, with spheres around it. It has 119,168 triangles,
/// is about 7 wide, and +y is up. Bodies are closed: every edge belongs to two triangles with opposite directions.
///
/// # Errors
/// None occur: the mesh is valid.
pub fn builtin() -> Result<Mesh, MeshError> {
    let mut bodies = Bodies::default();
    bodies.ground(3.3, 96, 192);
    bodies.knot(640, 32);
    for step in 0..28 {
        let part = f64::from(step) / 27.0;
        let angle = TAU * (0.12 + 1.35 * part);
        let (distance, radius) = (2.75 - 0.45 * part, 0.34 - 0.22 * part);
        let height = 0.22 + radius + 3.1 * part * part;
        bodies.sphere([distance * angle.cos(), height, distance * angle.sin()], radius, 3, |_| 1.0);
    }
    let bumps = |[x, y, z]: Vector| 1.0 + 0.07 * ((9.0 * x).sin() * (9.0 * y + 1.0).sin() * (9.0 * z + 2.0).sin());
    bodies.sphere([0.0, 1.95, 0.0], 0.5, 4, bumps);
    Mesh::new(bodies.positions, bodies.triangles)
}

/// The mesh of the bodies added so far.
#[derive(Default)]
struct Bodies {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Bodies {
    /// Adds a disc with ripples, a flat underside and a rim.
    fn ground(&mut self, radius: f64, rings: u32, sectors: u32) {
        let bottom = self.vertex([0.0, -0.5, 0.0]);
        let top = self.vertex([0.0, ripple(0.0), 0.0]);
        let first = top + 1;
        let at = |ring: u32, sector: u32| first + (ring - 1) * sectors + sector % sectors;
        for ring in 1..=rings + 1 {
            // The last ring is the lower edge of the rim.
            let r = radius * f64::from(ring.min(rings)) / f64::from(rings);
            let height = if ring > rings { -0.5 } else { ripple(r) };
            for sector in 0..sectors {
                let angle = TAU * f64::from(sector) / f64::from(sectors);
                self.vertex([r * angle.cos(), height, r * angle.sin()]);
            }
        }
        for sector in 0..sectors {
            self.triangles.push([top, at(1, sector + 1), at(1, sector)]);
            self.triangles.push([bottom, at(rings + 1, sector), at(rings + 1, sector + 1)]);
            for ring in 1..=rings {
                self.quad(at(ring, sector), at(ring, sector + 1), at(ring + 1, sector + 1), at(ring + 1, sector));
            }
        }
    }

    /// Adds a tube along an upright (2, 3) torus knot.
    fn knot(&mut self, steps: u32, sides: u32) {
        let first = self.positions.len() as u32;
        let at = |step: u32, side: u32| first + step % steps * sides + side % sides;
        for step in 0..steps {
            let angle = TAU * f64::from(step) / f64::from(steps);
            let (centre, [out, sideways]) = (knot(angle), knot_frame(angle));
            for side in 0..sides {
                let turn = TAU * f64::from(side) / f64::from(sides);
                let spoke = add(scale(turn.cos(), out), scale(turn.sin(), sideways));
                self.vertex(add(centre, scale(0.3, spoke)));
            }
        }
        for step in 0..steps {
            for side in 0..sides {
                self.quad(at(step, side), at(step, side + 1), at(step + 1, side + 1), at(step + 1, side));
            }
        }
    }

    /// Adds a sphere, from an icosahedron with edges halved `halvings` times. `shape` scales the radius by direction.
    fn sphere(&mut self, centre: Vector, radius: f64, halvings: u32, shape: impl Fn(Vector) -> f64) {
        let (mut directions, mut faces) = icosahedron();
        for _ in 0..halvings {
            faces = halved(&mut directions, &faces);
        }
        let first = self.positions.len() as u32;
        for direction in directions {
            self.vertex(add(centre, scale(radius * shape(direction), direction)));
        }
        self.triangles.extend(faces.into_iter().map(|face| face.map(|vertex| first + vertex)));
    }

    fn vertex(&mut self, position: Vector) -> u32 {
        self.positions.push(single(position));
        self.positions.len() as u32 - 1
    }

    fn quad(&mut self, a: u32, b: u32, c: u32, d: u32) {
        self.triangles.push([a, b, c]);
        self.triangles.push([a, c, d]);
    }
}

/// The height of the ground at a distance from the centre.
fn ripple(r: f64) -> f64 {
    0.11 * (8.0 * r).cos() * (-0.35 * r).exp()
}

/// The centre line of the knot, which winds around the torus twice the long way and three times the short way.
fn knot(angle: f64) -> Vector {
    let ((s2, c2), (s3, c3)) = ((2.0 * angle).sin_cos(), (3.0 * angle).sin_cos());
    let r = 1.25 + 0.55 * c3;
    [r * c2, 2.0 + r * s2, 0.55 * s3]
}

/// Two directions across the centre line of the knot: away from the centre of the torus's tube, and sideways.
fn knot_frame(angle: f64) -> [Vector; 2] {
    let ((s2, c2), (s3, c3)) = ((2.0 * angle).sin_cos(), (3.0 * angle).sin_cos());
    let (r, dr) = (1.25 + 0.55 * c3, -1.65 * s3);
    let along = unit([dr * c2 - 2.0 * r * s2, dr * s2 + 2.0 * r * c2, 1.65 * c3]);
    let away = [c3 * c2, c3 * s2, s3];
    let out = unit(subtract(away, scale(dot(away, along), along)));
    [out, cross(along, out)]
}

fn icosahedron() -> (Vec<Vector>, Vec<[u32; 3]>) {
    let (a, b) = (1.0, GOLDEN_RATIO);
    let corners = [
        [-a, b, 0.0],
        [a, b, 0.0],
        [-a, -b, 0.0],
        [a, -b, 0.0],
        [0.0, -a, b],
        [0.0, a, b],
        [0.0, -a, -b],
        [0.0, a, -b],
        [b, 0.0, -a],
        [b, 0.0, a],
        [-b, 0.0, -a],
        [-b, 0.0, a],
    ];
    // Three corners form a face if each two of them are an edge apart.
    let adjacent = |i: usize, j: usize| {
        (dot(subtract(corners[i], corners[j]), subtract(corners[i], corners[j])) - 4.0).abs() < 1e-9
    };
    let mut faces = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if adjacent(i, j) && adjacent(j, k) && adjacent(k, i) {
                    let outwards = dot(corners[i], cross(corners[j], corners[k])) > 0.0;
                    let face = if outwards { [i, j, k] } else { [i, k, j] };
                    faces.push(face.map(|corner| corner as u32));
                }
            }
        }
    }
    (corners.map(unit).to_vec(), faces)
}

/// Divides each face into four. Faces on both sides of an edge share its new vertex.
fn halved(directions: &mut Vec<Vector>, faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            directions.push(unit(add(directions[a as usize], directions[b as usize])));
            directions.len() as u32 - 1
        })
    };
    let mut smaller = Vec::with_capacity(4 * faces.len());
    for &[a, b, c] in faces {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        smaller.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    smaller
}
