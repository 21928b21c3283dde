//! Scenes whose vertices move while their tree stays.

use crate::common::meshes;
use crate::common::rays::{Kind, rays};
use raypath_ops::Rules;
use raypath_render::blocks::Blocks;
use raypath_render::{Mesh, RefitError, Scene, refit};
use raypath_traversal::blocks::NodeKind;
use raypath_traversal::{StepParameters, Unit};

/// The mesh, bent.
fn bent(mesh: &Mesh) -> Mesh {
    let size = mesh.bounds().longest_side();
    let bend = |[x, y, z]: [f32; 3]| [x + 0.2 * size * (5.0 * y / size).sin(), 1.5 * y, z - 0.1 * x];
    Mesh::new(mesh.positions().iter().map(|corner| bend(*corner)).collect(), mesh.triangles().to_vec()).unwrap()
}

fn blocks(mesh: &Mesh, nodes: NodeKind) -> Blocks {
    Scene::new(mesh.clone()).unwrap().through_unit_of(nodes).unwrap().blocks().unwrap().clone()
}

/// The hits are those of a tree that was built for the moved mesh, and without a move the bytes are the same.
#[test]
fn hits_are_those_of_a_new_tree() {
    for name in ["suzanne", "truck"] {
        let mesh = meshes::real(name).mesh;
        let moved = bent(&mesh);
        for nodes in NodeKind::ALL {
            let (old, new) = (blocks(&mesh, nodes), blocks(&moved, nodes));
            let mut bytes = old.bytes().to_vec();
            refit(&mut bytes, old.root(), nodes, &mesh).unwrap();
            assert!(bytes == old.bytes(), "{name}, {nodes}");
            refit(&mut bytes, old.root(), nodes, &moved).unwrap();
            let mut unit = Unit::new(Rules::Paper, StepParameters { node: nodes, ..StepParameters::default() });
            let mut hits = 0;
            for ray in rays(&moved, Kind::Random, 4_000, 2) {
                let request = new.request(&ray, false, true);
                let (expected, found) = (unit.trace(new.bytes(), &request), unit.trace(&bytes[..], &request));
                assert_eq!(format!("{:?}", found.hit), format!("{:?}", expected.hit), "{name}, {nodes}: {ray:?}");
                hits += u32::from(found.hit.is_some());
            }
            assert!(hits > 500, "{name}, {nodes}: {hits} hits");
        }
    }
}

#[test]
fn other_scenes_are_refused() {
    let mesh = meshes::real("suzanne").mesh;
    let old = blocks(&mesh, NodeKind::Wide4);
    let one = Mesh::new(mesh.positions().to_vec(), mesh.triangles()[..1].to_vec()).unwrap();
    let problem = |bytes: &[u8], root, mesh: &Mesh| refit(&mut bytes.to_vec(), root, NodeKind::Wide4, mesh).err();
    let found = problem(old.bytes(), old.root(), &one);
    assert!(matches!(found, Some(RefitError::Triangle { triangles: 1, .. })), "{found:?}");
    let found = problem(&old.bytes()[..1280], old.root(), &mesh);
    assert!(matches!(found, Some(RefitError::Address { bytes: 1280, .. })), "{found:?}");
    let found = problem(old.bytes(), 0x32, &mesh).map(|problem| problem.to_string()).unwrap_or_default();
    assert!(found.contains("0x00000032 has no valid kind"), "{found}");
    // A node that is its own child.
    let mut bytes = old.bytes().to_vec();
    bytes[96..100].copy_from_slice(&old.root().to_le_bytes());
    assert_eq!(problem(&bytes, old.root(), &mesh), Some(RefitError::Repeated(0)));
    // A mesh with one more triangle, and a scene with more than a tree.
    let more = Mesh::new(mesh.positions().to_vec(), [mesh.triangles(), &[[0, 1, 9]]].concat()).unwrap();
    let count = mesh.triangles().len();
    assert_eq!(problem(old.bytes(), old.root(), &more), Some(RefitError::Missing(count as u32)));
    let others = Some(RefitError::Others { blocks: old.len() + 1, found: old.len() });
    assert_eq!(problem(&[old.bytes(), &[0; 128]].concat(), old.root(), &mesh), others);
    assert_eq!(problem(old.bytes(), 33, &mesh), Some(RefitError::Content("an instance")));
    assert_eq!(problem(old.bytes(), 17, &mesh), Some(RefitError::Content("a procedural box")));
}

/// Each triangle has vertices of its own, and those at the same places move apart.
#[test]
fn vertices_that_leave_others_are_refused() {
    let shared = meshes::real("suzanne").mesh;
    let count = shared.triangles().len() as u32;
    let mesh = |step: f32| {
        let of = |index: u32| shared.corners(index).map(|[x, y, z]| [x + step * index as f32, y, z]);
        let triangles = (0..count).map(|index| [0, 1, 2].map(|corner| 3 * index + corner));
        Mesh::new((0..count).flat_map(of).collect(), triangles.collect()).unwrap()
    };
    let old = blocks(&mesh(0.0), NodeKind::Quantised);
    let refitted = |mesh: &Mesh| refit(&mut old.bytes().to_vec(), old.root(), NodeKind::Quantised, mesh);
    assert_eq!(refitted(&mesh(0.0)), Ok(()));
    let problem = refitted(&mesh(0.5));
    assert!(matches!(problem, Err(RefitError::Divided(_))), "{problem:?}");
}
