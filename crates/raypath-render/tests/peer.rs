//! Comparison with obvhs: an independent tree and triangle test.

use crate::common::meshes;
use crate::common::rays::{Kind, rays};
use crate::unit::of_one;
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::ray::{Ray as PeerRay, RayHit};
use raypath_ops::Rules;
use raypath_render::blocks::Blocks;
use raypath_render::bvh::peer_triangles;
use raypath_render::compare::compare;
use raypath_render::{Scene, Stopped, Tracing};
use raypath_traversal::blocks::wide8::Node8;
use raypath_traversal::blocks::{LeafTriangle, NodeKind};
use raypath_traversal::{StepParameters, Unit};
use std::time::Duration;

#[test]
fn obvhs_hits_the_same() {
    for named in meshes::all() {
        let scene = Scene::new(named.mesh).unwrap();
        for kind in [Kind::Primary, Kind::Random] {
            let rays = rays(scene.mesh(), kind, 20_000, 8);
            let tracing = Tracing { two_sided: true, ..Tracing::default() };
            let comparison = compare(&scene, &rays, tracing, 1, &|_| true).unwrap();
            println!("{} {kind:?}: {comparison:?}", named.name);
            assert!(comparison.our_hits > 2_000);
            // The test of obvhs is not watertight and differs at edges.
            assert!(comparison.differences <= 4, "{}, {kind:?}: {comparison:?}", named.name);
        }
    }
}

/// Of two trees, the one that we build and the one that obvhs builds, both units read the nodes of the other: obvhs
/// finds ours valid, and the same distances with our triangle test; we find in theirs the boxes that obvhs reads, and
/// the hits that wide nodes have.
#[test]
fn compressed_wide_nodes_are_those_of_obvhs() {
    let unit = |node| Unit::new(Rules::Paper, StepParameters { node, ..StepParameters::default() });
    let (mut of_eight, mut of_four) = (unit(NodeKind::Wide8), unit(NodeKind::Wide4));
    for meshes::Named { name, mesh } in meshes::all() {
        let scene = Scene::new(mesh.clone()).unwrap();
        let [wide, ours] = [NodeKind::Wide4, NodeKind::Wide8]
            .map(|nodes| scene.clone().through_unit_of(nodes).unwrap().blocks().unwrap().clone());
        let all: Vec<u32> = (0..mesh.triangles().len() as u32).collect();
        let peers = peer_triangles(&mesh, &all);
        let peer = build_cwbvh_from_tris(&peers, BvhBuildParams::medium_build(), &mut Duration::default());
        let nodes: Vec<[u8; 80]> = bytemuck::cast_slice(&peer.nodes).as_chunks().0.to_vec();
        let theirs = Blocks::of_cwbvh(&nodes, &peer.primitive_indices, &mesh).unwrap();
        for ((block, bytes), node) in theirs.bytes().as_chunks().0.iter().zip(&nodes).zip(&peer.nodes) {
            assert_eq!((&block[..20], &block[24..80]), (&bytes[..20], &bytes[24..]), "{name}");
            for (k, aabb) in Node8::of(block).boxes.iter().enumerate().filter(|(k, _)| !node.is_child_empty(*k)) {
                let slabs = [aabb.x, aabb.y, aabb.z];
                let corners: [[f32; 3]; 2] = [slabs.map(|slab| slab.min.into()), slabs.map(|slab| slab.max.into())];
                let peers: [[f32; 3]; 2] = [node.child_aabb(k).min.into(), node.child_aabb(k).max.into()];
                assert_eq!(corners, peers, "{name}");
            }
        }
        let read = as_peer(&ours);
        read.validate(&peers, false);
        for (tree, blocks, is_theirs) in [(read, ours, false), (peer, theirs, true)] {
            let (mut hits, mut differences) = (0, [0; 2]);
            for ray in [Kind::Primary, Kind::Random].into_iter().flat_map(|kind| rays(&mesh, kind, 2_000, 5)) {
                let distance = |hit: Option<raypath_traversal::Hit>| hit.map_or(f32::INFINITY, |hit| hit.t);
                let expected = distance(of_four.trace(wide.bytes(), &wide.request(&ray, false, true)).hit);
                let found = distance(of_eight.trace(blocks.bytes(), &blocks.request(&ray, false, true)).hit);
                let mut closest = RayHit::none();
                let test = |_: &PeerRay, slot: usize| {
                    of_one(&mesh, &ray, tree.primitive_indices[slot]).unwrap_or(f32::INFINITY)
                };
                let (origin, direction): ([f32; 3], [f32; 3]) = (ray.origin.into(), ray.dir.into());
                let peer = PeerRay::new(origin.into(), direction.into(), 0.0, ray.extent.into());
                tree.ray_traverse(peer, &mut closest, test);
                hits += u32::from(expected.is_finite());
                differences[0] += u32::from(found != expected);
                differences[1] += u32::from(closest.t != expected);
            }
            assert!(hits > 1000 && differences == [0; 2], "{name}, {is_theirs}: {hits} hits, {differences:?}");
        }
    }
}

/// Nodes that make no tree are refused.
#[test]
fn wrong_nodes_are_refused() {
    let mesh = meshes::real("teapot").mesh;
    let refused = |change: &dyn Fn(&mut [u8; 80]), problem: &str| {
        let mut node = [0; 80];
        node[24] = 0b0010_0000;
        change(&mut node);
        let error = Blocks::of_cwbvh(&[node], &[3, 992, 4], &mesh).map(|blocks| blocks.len()).unwrap_err();
        assert_eq!(error.to_string(), format!("node 0: {problem}"));
    };
    refused(&|node| node[25] = 0b0011_1001, "1 nodes from 0 on, expected ones after it, up to 0");
    refused(&|node| node[24] = 0b0100_0000, "a child of kind 0b01000000, expected 001, 011 or 111 first");
    refused(&|node| node[20] = 3, "1 primitives from 3 on, expected some of the 3");
    refused(&|node| node[24] = 0b0110_0000, "triangle 992, expected less than 992, as the mesh has");
}

/// Our blocks as a tree of obvhs.
fn as_peer(blocks: &Blocks) -> CwBvh {
    let (all, mut tree) = (blocks.bytes().as_chunks::<128>().0, CwBvh::default());
    for block in &all[..blocks.node_count()] {
        let mut node: CwBvhNode = bytemuck::pod_read_unaligned(&block[..80]);
        let leaves = &all[node.primitive_base_idx as usize..];
        node.primitive_base_idx = tree.primitive_indices.len() as u32;
        let counts = (0..8).filter(|k| node.is_leaf(*k)).map(|k| node.child_primitives(k).1).filter(|count| *count > 0);
        for (count, leaf) in counts.zip(leaves) {
            let index = |place| LeafTriangle::of(leaf, place, NodeKind::Wide8).index;
            tree.primitive_indices.extend((0..count as usize).map(index));
        }
        tree.nodes.push(node);
    }
    tree
}

#[test]
fn the_progress_callback_stops_comparisons() {
    let scene = Scene::new(meshes::real("teapot").mesh).unwrap();
    let rays = rays(scene.mesh(), Kind::Random, 10, 9);
    assert_eq!(compare(&scene, &rays, Tracing::default(), 5, &|done| done < 2), Err(Stopped));
}
