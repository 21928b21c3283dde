//! The structure of the tree and its traversal, and of the built-in scene: closed bodies with outward faces.

use crate::common::meshes;
use crate::common::rays::{Kind, rays};
use raypath_model::Functional;
use raypath_ops::{Aabb, Binary32, BoxBits, Ray, Rules};
use raypath_render::bvh::{Reference, Target};
use raypath_render::{Bvh4, Goal, Mesh, Scene, Stopped, Tracer, Tracing, Traversal, builtin, trace_closest};
use raypath_timing::{Action, Agent};
use raypath_verify_datapath::geometry::visibility::exactly_towards;
use std::collections::{HashMap, VecDeque};

fn numbers(aabb: Aabb<Binary32>) -> [[f32; 2]; 3] {
    [aabb.x, aabb.y, aabb.z].map(|slab| [slab.min.into(), slab.max.into()])
}

/// Checks that every triangle is in one leaf unless its corners are on one line, and that every box is exactly around all below it.
fn check(mesh: &Mesh) {
    let tree = Bvh4::build(mesh).unwrap();
    let mut visits = vec![0; mesh.triangles().len()];
    let mut nodes = 0;
    let (mut deepest, mut levels) = (0, 0);
    let mut pending = vec![(Reference::ROOT, [[f32::NEG_INFINITY, f32::INFINITY]; 3], 0, 0)];
    while let Some((reference, around, kept, level)) = pending.pop() {
        match reference.target() {
            Target::Node(node) => {
                nodes += 1;
                levels = levels.max(level + 1);
                let node = tree.nodes()[node as usize];
                let mut children = 0;
                let before = pending.len();
                for (aabb, child) in node.boxes.map(numbers).into_iter().zip(node.children) {
                    if aabb == [[f32::INFINITY, f32::NEG_INFINITY]; 3] {
                        continue;
                    }
                    children += 1;
                    for axis in 0..3 {
                        assert!(around[axis][0] <= aabb[axis][0] && aabb[axis][1] <= around[axis][1]);
                    }
                    pending.push((child, aabb, 0, level + 1));
                }
                // If all children are hit, all but one are on the stack while that one is opened.
                deepest = deepest.max(kept + children);
                pending[before..].iter_mut().for_each(|below| below.2 = kept + children - 1);
            }
            Target::Leaf { first, count } => {
                assert!((1..=8).contains(&count));
                let mut exact = [[f32::INFINITY, f32::NEG_INFINITY]; 3];
                for slot in first..first + count {
                    let index = tree.index(slot);
                    visits[index as usize] += 1;
                    for corner in mesh.corners(index) {
                        for axis in 0..3 {
                            let [min, max] = &mut exact[axis];
                            (*min, *max) = (min.min(corner[axis]), max.max(corner[axis]));
                        }
                    }
                }
                assert_eq!(around, exact);
            }
        }
    }
    for (index, &count) in visits.iter().enumerate() {
        let [a, b, c] = mesh.corners(index as u32);
        let along = |axis| std::array::from_fn(|k| f32::from(u8::from(k == axis)));
        let is_flat = (0..3).all(|axis| exactly_towards(along(axis), [a, b, c]).sign().is_eq());
        assert_eq!(count, u32::from(!is_flat), "triangle {index}");
    }
    assert_eq!(nodes, tree.nodes().len());
    assert_eq!(levels, tree.levels());
    assert!(levels <= Bvh4::MAX_LEVELS, "{levels} levels");
    assert_eq!(deepest, tree.stack_size());
}

#[test]
fn trees_are_valid() {
    for meshes::Named { mesh, .. } in meshes::all() {
        check(&mesh);
    }
}

#[test]
fn trees_of_degenerate_meshes_are_valid() {
    let one = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    for copies in [1, 2, 3, 5, 9, 100, 5_000] {
        check(&Mesh::new(one.clone(), vec![[0, 1, 2]; copies]).unwrap());
        check(&Mesh::new(one.clone(), vec![[0, 0, 0]; copies]).unwrap());
    }
    // Triangles in a plane and on a line.
    let grid: Vec<[f32; 3]> = (0..1_000).map(|i| [(i % 40) as f32, (i / 40) as f32, 0.0]).collect();
    let line: Vec<[f32; 3]> = (0..1_000).map(|i| [i as f32, 0.0, 0.0]).collect();
    let triangles: Vec<[u32; 3]> = (0..950).map(|i| [i, i + 1, i + 40]).collect();
    check(&Mesh::new(grid, triangles.clone()).unwrap());
    check(&Mesh::new(line, triangles).unwrap());
    // Exponentially growing triangles give deep trees.
    let growing: Vec<[f32; 3]> =
        (0..234).map(|i| [(1.3_f32).powi(i / 3 - 40), (i % 3) as f32, (i % 2) as f32]).collect();
    check(&Mesh::new(growing, (0..78).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()).unwrap());
}

#[test]
fn the_lowest_index_of_equal_triangles_is_hit() {
    let one = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let scene = Scene::new(Mesh::new(one, vec![[0, 1, 2]; 1_000]).unwrap()).unwrap();
    let front = Ray::new([0.25, 0.25, 5.0], [0.0, 0.0, -1.0], 5.0).unwrap();
    let behind = Ray::new([0.25, 0.25, -5.0], [0.0, 0.0, 1.0], f32::INFINITY).unwrap();
    let short = Ray::new([0.25, 0.25, 5.0], [0.0, 0.0, -1.0], 5.0_f32.next_down()).unwrap();
    let trace =
        |ray, two_sided| Tracer::new(&scene, Tracing { two_sided, rules: Rules::Paper }).trace(&ray, Goal::Closest);
    let hit = trace(front, false).unwrap();
    assert_eq!((hit.triangle, hit.t, hit.from_behind), (0, 5.0, false));
    assert_eq!(trace(short, true), None);
    assert_eq!(trace(behind, false), None);
    let hit = trace(behind, true).unwrap();
    assert_eq!((hit.triangle, hit.t, hit.from_behind), (0, 5.0, true));
}

/// A traversal that receives outcomes only when it waits gives the same result as one that receives them at once.
#[test]
fn the_latency_of_outcomes_does_not_matter() {
    let mesh = meshes::real("truck").mesh;
    let scene = Scene::new(mesh).unwrap();
    for two_sided in [false, true] {
        for rules in [Rules::Paper, Rules::Chisel, Rules::Bounds(BoxBits(10))] {
            let tracing = Tracing { two_sided, rules };
            let (mut at_once, mut late) = (Tracer::new(&scene, tracing), Traversal::new(scene.bvh(), tracing));
            assert!(matches!(Agent::<Functional>::next_action(&mut late), Action::Done));
            for ray in rays(scene.mesh(), Kind::Random, 2_000, 6) {
                for goal in [Goal::Closest, Goal::Any] {
                    let expected = at_once.trace(&ray, goal);
                    late.start(ray, goal);
                    let fetches = run_late(&mut late, rules);
                    let counts = late.counts();
                    assert_eq!(fetches, counts.nodes + counts.leaves);
                    assert_eq!(counts.nodes, counts.quadbox);
                    assert_eq!((late.hit(), counts), (expected, at_once.counts()));
                }
            }
        }
    }
}

/// Runs a traversal with the functional model, with outcomes as late as possible, and counts its fetches.
fn run_late(traversal: &mut Traversal, rules: Rules) -> u64 {
    let (mut datapath, mut pending, mut fetches) =
        (Functional::<16, 8>::new(rules).conservative(true), VecDeque::new(), 0);
    loop {
        match Agent::<Functional>::next_action(traversal) {
            Action::Fetch => fetches += 1,
            Action::Issue(job) => pending.push_back(job),
            Action::Wait => Agent::<Functional>::receive(traversal, &datapath.run(&pending.pop_front().unwrap())),
            Action::Done => {
                assert!(pending.is_empty());
                return fetches;
            }
        }
    }
}

#[test]
fn results_do_not_depend_on_threads_and_the_progress_callback_stops_tracing() {
    let scene = Scene::new(meshes::real("teapot").mesh).unwrap();
    let rays = rays(scene.mesh(), Kind::Random, 20_000, 7);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| trace_closest(&scene, &rays, Tracing::default(), &|_| true).unwrap())
    };
    assert_eq!(with(1), with(3));
    assert_eq!(trace_closest(&scene, &rays, Tracing::default(), &|done| done > 100_000), Err(Stopped.into()));
}

#[test]
fn bodies_are_closed_and_face_outwards() {
    let mesh = builtin().unwrap();
    assert_eq!(mesh.triangles().len(), 119_168);
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    let mut bodies: Vec<u32> = (0..mesh.positions().len() as u32).collect();
    for &[a, b, c] in mesh.triangles() {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            assert_ne!(from, to);
            *edges.entry((from, to)).or_default() += 1;
            let (one, other) = (first(&mut bodies, from), first(&mut bodies, to));
            bodies[one.max(other) as usize] = one.min(other);
        }
    }
    for (&(from, to), &count) in &edges {
        assert_eq!((count, edges.get(&(to, from))), (1, Some(&1)), "edge from {from} to {to}");
    }
    let mut volumes: HashMap<u32, f64> = HashMap::new();
    for (index, corners) in (0..).zip(mesh.triangles()) {
        let [a, b, c] = mesh.corners(index).map(|corner| corner.map(f64::from));
        let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
        let volume = (a[0] * minor(1, 2) + a[1] * minor(2, 0) + a[2] * minor(0, 1)) / 6.0;
        *volumes.entry(first(&mut bodies, corners[0])).or_default() += volume;
    }
    // The ground, the knot, 28 spheres and the bumpy sphere.
    assert_eq!(volumes.len(), 31);
    assert!(volumes.values().all(|&volume| volume > 0.0), "{volumes:?}");
}

/// The representative of the body of a vertex, in the union-find structure `bodies`.
fn first(bodies: &mut [u32], mut vertex: u32) -> u32 {
    while bodies[vertex as usize] != vertex {
        bodies[vertex as usize] = bodies[bodies[vertex as usize] as usize];
        vertex = bodies[vertex as usize];
    }
    vertex
}
