//! Scenes made by hand: degenerate trees, and memories that are no trees.

use crate::common::{along_z, at};
use raypath_model::Shape;
use raypath_ops::{Aabb, Binary32, Rules, Triangle};
use raypath_traversal::blocks::{Child, LeafTriangle, NodeKind};
use raypath_traversal::state::status;
use raypath_traversal::traffic::{BlockScene, never};
use raypath_traversal::{
    BlockRequest, RayRequest, Reply, Response, StepParameters, Unit, UnitEngine, UnitFeatures, UnitInputs, UnitModel,
    UnitParameters, ray_flags,
};

const STACKS: [u32; 5] = [2, 4, 8, 16, 32];

fn trace(scene: &BlockScene, root: u32, stack: u32) -> Reply {
    Unit::new(Rules::Paper, StepParameters { stack, ..StepParameters::default() }).trace(&scene.0[..], &along_z(root))
}

fn around(near: f32, far: f32) -> Aabb<Binary32> {
    Aabb::new([-2.0, -2.0, near], [2.0, 2.0, far])
}

/// A path of nodes that is as deep as the unit allows. The nearest child of each is the next node, and its leaf lies
/// behind all that the next node has, so that every level is pending when the ray reaches the end of the path.
fn path(depth: u32, triangles: impl Fn(u32) -> Option<LeafTriangle>) -> (BlockScene, u32) {
    let mut memory = BlockScene::default();
    let mut next = None;
    for level in (0..depth).rev() {
        let far = 100.0 - level as f32;
        let (mut boxes, mut children) = ([never(); 4], [0; 4]);
        if let Some(triangle) = triangles(level) {
            (boxes[1], children[1]) = (around(far, far), memory.leaf(&[triangle]));
        }
        if let Some(next) = next {
            (boxes[2], children[2]) = (around(0.0, far - 0.5), next);
        }
        next = Some(memory.node(boxes, children));
    }
    (memory, next.expect("a node"))
}

#[test]
fn deep_paths_are_walked_to_their_end_and_back() {
    for depth in [1, 2, 33, 60, 64] {
        // Only the leaf of the root has a triangle that the ray hits: the others are aside.
        let aside = |z: f32, level| LeafTriangle {
            triangle: Triangle::new([5.0, 5.0, z], [6.0, 7.0, z], [7.0, 5.0, z]),
            index: level,
        };
        let (memory, root) =
            path(depth, |level| Some(if level == 0 { at(100.0, 7) } else { aside(100.0 - level as f32, level) }));
        for stack in STACKS {
            let reply = trace(&memory, root, stack);
            let hit = reply.hit.expect("a hit");
            assert_eq!((reply.status, hit.primitive, hit.t), (status::HIT, 7, 101.0), "depth {depth}, stack {stack}");
            assert_eq!(reply.triangles, depth, "every leaf is read once, depth {depth}, stack {stack}");
            let again = reply.nodes - depth;
            assert_eq!(again > 0, depth - 1 > stack, "depth {depth}, stack {stack}: {again} nodes are read again");
        }
    }
}

#[test]
fn the_closest_of_all_levels_wins() {
    for nearest in 0..60 {
        let (memory, root) = path(60, |level| (level >= nearest).then(|| at(100.0 - level as f32, level)));
        // The leaf of the deepest level is nearest to the ray.
        for stack in STACKS {
            let hit = trace(&memory, root, stack).hit.expect("a hit");
            assert_eq!((hit.primitive, hit.t), (59, 42.0), "stack {stack}");
        }
    }
}

/// Of equal distances the lowest index is reported, wherever the triangle is.
#[test]
fn ties_are_settled_by_the_index() {
    for rotation in 0..8 {
        let mut memory = BlockScene::default();
        let all: Vec<LeafTriangle> = (0..8).map(|place| at(3.0, (place + rotation) % 8)).collect();
        let leaf = memory.leaf(&all);
        let hit = trace(&memory, leaf, 2).hit.expect("a hit");
        assert_eq!((hit.primitive, hit.t), (0, 4.0));
        let reply = trace(&memory, leaf, 2);
        assert_eq!((reply.nodes, reply.triangles), (0, 8), "the root may be a leaf");
    }
}

#[test]
fn faces_and_ends_of_the_ray() {
    const BACK: u32 = ray_flags::CULL_BACK_FACING_TRIANGLES;
    const FRONT: u32 = ray_flags::CULL_FRONT_FACING_TRIANGLES;
    let mut memory = BlockScene::default();
    let LeafTriangle { triangle: Triangle { a, b, c }, .. } = at(3.0, 0);
    let back = LeafTriangle { triangle: Triangle { a, b: c, c: b }, index: 1 };
    let root = memory.leaf(&[at(5.0, 0), back]);
    let trace = |change: &dyn Fn(&mut RayRequest)| {
        let mut ray = along_z(root);
        change(&mut ray);
        let reply = Unit::new(Rules::Paper, StepParameters::default()).trace(&memory.0[..], &ray);
        (reply.status, reply.hit.map(|hit| (hit.primitive, hit.back_face)))
    };
    assert_eq!(trace(&|_| {}), (status::HIT, Some((1, true))));
    assert_eq!(trace(&|ray| ray.flags = BACK), (status::HIT, Some((0, false))));
    assert_eq!(trace(&|ray| ray.flags = FRONT), (status::HIT, Some((1, true))));
    assert_eq!(trace(&|ray| ray.flags = BACK | FRONT), (status::REFUSED, None));
    for none in [ray_flags::SKIP_TRIANGLES, ray_flags::CULL_OPAQUE] {
        assert_eq!(trace(&|ray| ray.flags = none), (status::MISS, None));
    }
    assert_eq!(trace(&|ray| ray.t_min = 4.5), (status::HIT, Some((0, false))));
    assert_eq!(trace(&|ray| ray.t_min = 4.0), (status::HIT, Some((0, false))), "the ends do not belong to the ray");
    assert_eq!(trace(&|ray| ray.t_max = 4.0), (status::MISS, None));
    assert_eq!(trace(&|ray| ray.t_max = 4.000_001), (status::HIT, Some((1, true))));
    assert_eq!(trace(&|ray| ray.t_max = 3.9), (status::MISS, None));
    assert_eq!(trace(&|ray| ray.direction = [0.0; 3]), (status::REFUSED, None));
    for (limit, refused) in [(f32::NAN, true), (-1.0, true), (-f32::MIN_POSITIVE, true), (-0.0, false)] {
        let of_max = if refused { (status::REFUSED, None) } else { (status::MISS, None) };
        let of_min = if refused { (status::REFUSED, None) } else { (status::HIT, Some((1, true))) };
        assert_eq!(trace(&|ray| ray.t_max = limit), of_max, "t_max {limit}");
        assert_eq!(trace(&|ray| ray.t_min = limit), of_min, "t_min {limit}");
    }
    assert_eq!(trace(&|ray| ray.t_min = f32::INFINITY), (status::MISS, None));
    assert_eq!(trace(&|ray| (ray.t_min, ray.t_max) = (7.0, 6.5)), (status::MISS, None), "no distance is in the range");
}

/// The weights are those from which the point of the hit was made.
#[test]
fn weights_of_vertices_give_the_point_of_the_hit() {
    let (front, mut memory) = (at(3.0, 0), BlockScene::default());
    let Triangle { a, b, c } = front.triangle;
    let back = LeafTriangle { triangle: Triangle { a, b: c, c: b }, index: 0 };
    let roots = [memory.leaf(&[front]), memory.leaf(&[back])];
    let [a, b, c] = [a, b, c].map(<[f32; 3]>::from);
    let features = UnitFeatures { barycentrics: true, ..UnitFeatures::OFF };
    let mut unit = Unit::new(Rules::Paper, StepParameters { features, ..StepParameters::default() });
    for (u, v) in [(0.25, 0.5), (0.5, 0.125), (0.0625, 0.75), (0.875, 0.0625), (0.3, 0.3)] {
        let w = 1.0 - u - v;
        let point: [f32; 3] = std::array::from_fn(|axis| w * a[axis] + u * b[axis] + v * c[axis]);
        for (root, [u, v]) in roots.into_iter().zip([[u, v], [v, u]]) {
            let ray = RayRequest { origin: [point[0], point[1], -1.0], ..along_z(root) };
            let [found_u, found_v] =
                unit.trace(&memory.0[..], &ray).hit.and_then(|hit| hit.barycentric).expect("weights");
            let error = (found_u - u).abs().max((found_v - v).abs());
            assert!(error < 1e-6, "{found_u} {found_v}, expected {u} {v}");
        }
    }
    let hit = Unit::new(Rules::Paper, StepParameters::default()).trace(&memory.0[..], &along_z(roots[0])).hit;
    assert_eq!(hit.expect("a hit").barycentric, None, "without the feature");
}

/// A child word of 0 is no child, whatever its box, and a root of 0 is a scene without anything.
#[test]
fn where_nothing_is_a_ray_goes_on() {
    let everywhere = around(0.0, 100.0);
    let mut memory = BlockScene::default();
    let leaf = memory.leaf(&[at(3.0, 7)]);
    let nothing = memory.node([everywhere; 4], [0; 4]);
    let root = memory.node([everywhere; 4], [0, nothing, 0, leaf]);
    for stack in STACKS {
        let reply = trace(&memory, root, stack);
        assert_eq!((reply.hit.map(|hit| hit.primitive), reply.nodes), (Some(7), 2), "stack {stack}");
        for empty in [0, nothing] {
            assert_eq!(trace(&memory, empty, stack).status, status::MISS, "stack {stack}");
        }
    }
}

#[test]
fn memories_that_are_no_trees_end_the_ray() {
    let everywhere = around(0.0, 100.0);
    let error = |memory: &BlockScene, root: u32, expected: u32| {
        for stack in STACKS {
            assert_eq!(trace(memory, root, stack).status, expected, "stack {stack}");
        }
    };
    let mut memory = BlockScene::default();
    let leaf = memory.leaf(&[at(3.0, 0)]);
    let own = Child::Node { address: memory.address() }.word(NodeKind::Wide4).expect("a node");
    let cycle = memory.node([everywhere, never(), never(), never()], [own, 0, 0, 0]);
    error(&memory, cycle, status::SCENE);
    // A child outside of the memory, and kinds that are not valid.
    for child in [0x4000_0000 | 32, 9, 31, 33, 63, leaf | 64, 0x80] {
        let expected = if child >> 30 == 1 { status::MEMORY } else { status::SCENE };
        let root = memory.node([everywhere, never(), never(), never()], [child, 0, 0, 0]);
        error(&memory, root, expected);
        error(&memory, child, expected);
    }
    // One level too deep.
    let (memory, root) = path(65, |_| None);
    error(&memory, root, status::SCENE);
    // The same node four times at each level: more paths than a ray may walk.
    let mut memory = BlockScene::default();
    let mut next = memory.leaf(&[LeafTriangle { index: 0, ..at(-50.0, 0) }]);
    for _ in 0..20 {
        next = memory.node([everywhere; 4], [next; 4]);
    }
    assert_eq!(trace(&memory, next, 8).status, status::LIMIT);
}

/// The cycles from the last beat of a block to the next request of its ray, as `docs/reference/unit.md` has them.
#[test]
fn a_fetch_takes_as_many_cycles_as_documented() {
    let (scene, root) = {
        let mut scene = BlockScene::default();
        // The ray is not culled by its boxes: every block is read.
        let far: Vec<LeafTriangle> = (0..5).map(|index| LeafTriangle { index, ..at(-9.0, 0) }).collect();
        let leaf = scene.leaf(&far);
        let everywhere = around(0.0, 100.0);
        let inner = scene.node([everywhere, never(), never(), never()], [leaf, 0, 0, 0]);
        let root = scene.node([everywhere, never(), never(), never()], [inner, 0, 0, 0]);
        (scene, root)
    };
    let parameters = UnitParameters { memory_width: 1024, ..UnitParameters::default() };
    let mut unit = UnitModel::new(&Shape::default(), parameters);
    let (mut requested, mut ended) = (Vec::new(), 0);
    let mut response = None;
    for cycle in 0..1000 {
        let outputs = unit.outputs();
        if let Some(BlockRequest { address, tag }) = outputs.request {
            requested.push(cycle);
            response = Some((address, tag));
        }
        if outputs.hit.is_some() {
            ended = cycle;
            break;
        }
        // The block arrives in the cycle after its request.
        let due = response.filter(|_| requested.last() < Some(&cycle));
        let beat = due.map(|(address, tag)| {
            let beat = &scene.0[address as usize..][..128];
            Response { tag, is_error: false, beat }
        });
        response = response.filter(|_| due.is_none());
        let ray = (cycle == 0).then(|| (0, along_z(root)));
        unit.cycle(&UnitInputs { ray, hit_ready: true, request_ready: true, response: beat, ..UnitInputs::default() });
    }
    let gaps: Vec<i32> = requested.windows(2).map(|pair| pair[1] - pair[0] - 1).collect();
    // A ray's first request; nodes; three triangles.
    assert_eq!((requested[0], &gaps[..]), (23, &[21, 21, 35][..]));
    // Two triangles, and from the last step to the hit.
    assert_eq!(ended - requested[3] - 1, 35);
}
