//! Units with quantised nodes: their layout, their hits, and their hardware.

use crate::common::{along_z, at};
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use raypath_model::Shape;
use raypath_ops::{Aabb, Binary32, Rules, Triangle};
use raypath_rtl::Config;
use raypath_traversal::blocks::wide8::Node8;
use raypath_traversal::blocks::{LeafTriangle, Node, NodeKind};
use raypath_traversal::traffic::{Behaviour, BlockScene as Scene, Environment, random_ray as ray};
use raypath_traversal::{
    BlockRequest, NetlistEngine, RayRequest, Reply, Response, StepParameters, Unit, UnitEngine, UnitFeatures,
    UnitInputs, UnitModel, UnitNetlist, UnitParameters, ray_flags,
};

const NODE: NodeKind = NodeKind::Quantised;
const QUIET: Behaviour = Behaviour { latency: (1, 20), stalls: [0; 4], errors: 0 };

/// The bounds of a box in the order of memory.
fn bounds(Aabb { x, y, z }: Aabb<Binary32>) -> [f32; 6] {
    [x.min, y.min, z.min, x.max, y.max, z.max].map(f32::from)
}

/// A bound by the document, in binary64, and the step of the grid: binary64 has more than twice the digits of binary32,
/// so that its sum, rounded once more, is the correctly rounded one.
fn bound(block: &[u8], nodes: NodeKind, child: usize, place: usize) -> (f32, f64) {
    let axis = place % 3;
    let base = f32::from_le_bytes(std::array::from_fn(|k| block[4 * axis + k]));
    let power = 2.0_f64.powi(i32::from(block[12 + axis]) - 127);
    let (addend, step) = match nodes {
        NodeKind::Wide8 => (power * f64::from(block[32 + 8 * (2 * axis + place / 3) + child]), power),
        _ => (power * (1.0 + f64::from(block[16 + 6 * child + place]) / 256.0), power / 256.0),
    };
    ((f64::from(base) + addend) as f32, step)
}

/// An interval of one of many magnitudes, at most half of the greatest number wide.
fn interval(centre: f32, random: &mut ChaCha8Rng) -> [f32; 2] {
    let mut number = |least: i32, greatest: i32| {
        let power = 2.0_f64.powi(random.random_range(least..=greatest));
        (random.random_range(-1.0..1.0) * power) as f32
    };
    let [a, b] = match number(0, 0) {
        wide if wide > 0.5 => [centre + number(-149, 124), centre + number(-149, 124)],
        near if near > -0.5 => [centre, centre * (1.0 + number(-24, 0))],
        _ => [centre; 2],
    };
    let within = |x: f32| x.clamp(-f32::MAX / 4.0, f32::MAX / 4.0);
    [within(a.min(b)), within(a.max(b))]
}

#[test]
fn boxes_are_contained_and_tight() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let special = [0.0, -0.0, f32::MIN_POSITIVE, f32::from_bits(1), -f32::from_bits(1), 1.0, -1.0, 1e38, -8e37];
    for case in 0..20_000 {
        let nodes = [NodeKind::Quantised, NodeKind::Wide8][case % 2];
        let centre: f32 = match random.random_range(0..4) {
            0 => special[random.random_range(0..special.len())],
            1 => f32::from_bits(random.random::<u32>() & !0x4000_0000),
            _ => random.random_range(-100.0..100.0),
        };
        let count = random.random_range(0..=nodes.children());
        let mut slab = || interval(centre, &mut random);
        let boxes: [Aabb<Binary32>; 8] = std::array::from_fn(|_| {
            let [[a, d], [b, e], [c, f]] = [slab(), slab(), slab()];
            Aabb::new([a, b, c], [d, e, f])
        });
        let word = |child: u32| if child < count as u32 { 0x1000 + nodes.block_bytes() * child + 1 } else { 0 };
        let children: [u32; 8] = std::array::from_fn(|child| word(child as u32));
        let (block, read) = match nodes {
            NodeKind::Wide8 => {
                let block = Node8 { boxes, children }.to_bytes().expect("boxes within a quarter");
                let Node8 { boxes, children: found } = Node8::of(&block);
                assert_eq!(found, children);
                (block.to_vec(), boxes.to_vec())
            }
            _ => {
                let (boxes, children) = ([0, 1, 2, 3].map(|k| boxes[k]), [0, 1, 2, 3].map(|k| children[k]));
                let block = Node { boxes, children }.to_quantised_bytes().expect("boxes within a quarter");
                let Node { boxes, children: found } = Node::of_quantised(&block);
                assert_eq!(found, children);
                (block.to_vec(), boxes.to_vec())
            }
        };
        for (child, found) in read.into_iter().map(bounds).enumerate() {
            let given = bounds(boxes[child]);
            if child >= count {
                assert_eq!((&found[..3], &found[3..]), (&[f32::INFINITY; 3][..], &[f32::NEG_INFINITY; 3][..]));
                continue;
            }
            for place in 0..6 {
                let (documented, step) = bound(&block, nodes, child, place);
                assert_eq!(found[place].to_bits(), documented.to_bits(), "{block:02x?}");
                let outside = if place < 3 { given[place] - found[place] } else { found[place] - given[place] };
                assert!(outside >= 0.0, "box {:?} becomes {found:?}", boxes[child]);
                // At most a step, and the rounding of the base and of the sum.
                let ulps = f64::from(found[place].abs().max(f32::MIN_POSITIVE)) * 2.0_f64.powi(-22);
                assert!(f64::from(outside) <= step + ulps, "{outside:e}, step {step:e}: {boxes:?}, {block:02x?}");
            }
        }
        for axis in 0..3 {
            let all = || (0..count).map(|child| bounds(boxes[child]));
            let least = all().map(|b| f64::from(b[axis])).fold(f64::INFINITY, f64::min);
            let greatest = all().map(|b| f64::from(b[axis + 3])).fold(f64::NEG_INFINITY, f64::max);
            let span = 255.0 * bound(&block, nodes, 0, axis).1;
            let is_least = block[12 + axis] <= 1 || span <= 2.02 * (greatest - least);
            assert!(count == 0 || is_least, "{span:e} for {least:e} to {greatest:e}");
        }
    }
}

#[test]
fn boxes_that_cannot_be_contained_are_named() {
    let error = |min: f32, max: f32| {
        let boxes = [Aabb::new([0.0, min, 0.0], [1.0, max, 1.0]); 4];
        let node = Node { boxes, children: [0, 0, 65, 0] };
        node.to_quantised_bytes().expect_err("no node").to_string()
    };
    for (min, max) in [(-3e38, 3e38), (f32::NAN, 1.0), (0.0, f32::INFINITY), (1.0, 0.0)] {
        let text = error(min, max);
        assert!(text.starts_with("box 2 from ") && text.contains(" along axis 1, expected finite bounds"), "{text}");
    }
}

fn step(stack: u32) -> StepParameters {
    let features = UnitFeatures { barycentrics: stack == 4, ..UnitFeatures::OFF };
    StepParameters { stack, node: NODE, features, ..StepParameters::default() }
}

fn expected(scene: &Scene, rays: &[RayRequest], step: StepParameters) -> Vec<Reply> {
    let mut model = Unit::new(Rules::Paper, step);
    rays.iter().map(|ray| model.trace(&scene.0[..], ray)).collect()
}

/// Quantised boxes are larger, so that a ray reads more. What it hits is the same in every bit.
#[test]
fn hits_are_those_of_wide_nodes() {
    let (mut hits, mut more) = (0, 0);
    for seed in 0..60 {
        let size = [1, 8, 9, 60, 400][seed as usize % 5];
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (wide, root) = Scene::random(size, &mut random);
        let (quantised, own) = Scene::random_of(NODE, size, &mut ChaCha8Rng::seed_from_u64(seed));
        // Which of several hits ends a ray depends on the order of boxes, which are larger.
        let closest = |ray: RayRequest| RayRequest { flags: ray.flags & !ray_flags::TERMINATE_ON_FIRST_HIT, ..ray };
        let rays: Vec<RayRequest> = (0..300).map(|_| closest(ray(root, &mut random))).collect();
        let own_rays: Vec<RayRequest> = rays.iter().map(|ray| RayRequest { root: own, ..*ray }).collect();
        let stack = [2, 4, 32][seed as usize % 3];
        let wide = expected(&wide, &rays, StepParameters { node: NodeKind::Wide4, ..step(stack) });
        for (place, (found, wide)) in expected(&quantised, &own_rays, step(stack)).into_iter().zip(wide).enumerate() {
            let bits = |reply: &Reply| {
                let bits = |hit: raypath_traversal::Hit| {
                    ([hit.t, hit.t_num, hit.t_denom].map(f32::to_bits), hit.primitive, hit.back_face)
                };
                (reply.status, reply.hit.map(bits))
            };
            assert_eq!(bits(&found), bits(&wide), "seed {seed}, {:?}", rays[place]);
            hits += usize::from(found.hit.is_some());
            more += usize::from(found.triangles > wide.triangles);
        }
    }
    assert!(hits > 1500 && more > 100, "{hits} hits, {more} rays that read more");
}

/// Leaves of up to four triangles of seven vertices: the triangles of their blocks are those that were given, and there
/// are as few blocks as any order allows.
#[test]
fn triangles_that_share_vertices_share_blocks() {
    let mut counts = [0; 5];
    for seed in 0..8_000 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let vertex = |number: u32| [number as f32, (number * number) as f32, 1.0];
        let mut corners = [0, 1, 2, 3, 4, 5, 6];
        let leaf: Vec<([u32; 3], LeafTriangle)> = (0..random.random_range(1..=4))
            .map(|_| {
                corners.shuffle(&mut random);
                let [a, b, c, ..] = corners;
                let triangle = Triangle::new(vertex(a), vertex(b), vertex(c));
                ([a, b, c], LeafTriangle { triangle, index: random.random_range(0..3) })
            })
            .collect();
        let own: Vec<LeafTriangle> = leaf.iter().map(|(_, triangle)| *triangle).collect();
        let (blocks, places) = LeafTriangle::to_blocks(&own, 7, NODE);
        let mut found: Vec<String> = Vec::new();
        for place in 0..places as usize {
            let (block, place) = (&blocks[64 * (place / 2)..][..64], place % 2);
            assert_eq!(LeafTriangle::geometry(block, NODE), 7);
            if !LeafTriangle::is_empty_place(block, place, NODE) {
                found.push(format!("{:?}", LeafTriangle::of(block, place, NODE)));
            }
        }
        let mut expected: Vec<String> = own.iter().map(|triangle| format!("{triangle:?}")).collect();
        found.sort();
        expected.sort();
        assert_eq!(found, expected, "seed {seed}");
        let shares = |a: usize, b: usize| {
            let [a, b] = [a, b].map(|k| leaf.get(k).map(|(corners, _)| corners));
            a.zip(b).is_some_and(|(a, b)| a.iter().filter(|corner| b.contains(corner)).count() > 1)
        };
        let pairs = [[0, 1, 2, 3], [0, 2, 1, 3], [0, 3, 1, 2]]
            .map(|[a, b, c, d]| usize::from(shares(a, b)) + usize::from(shares(c, d)));
        let least = leaf.len() - pairs.into_iter().max().unwrap_or(0);
        assert_eq!((blocks.len() / 64, places as usize), (least, 2 * least - usize::from(2 * least > leaf.len())));
        counts[least] += 1;
    }
    assert!(counts[1..].iter().all(|count| *count > 10), "{counts:?}");
}

/// Nodes of random bytes: exponents of 0 and 255, bases that are infinite or NaN, missing children anywhere.
#[test]
fn nodes_of_any_bytes_are_decoded_alike() {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let mut scene = Scene(Vec::new(), NODE);
    for number in 0..2000_u32 {
        let mut block: [u8; 64] = random.random();
        for axis in 0..3 {
            let base: f32 = match random.random_range(0..60) {
                0 => f32::from_bits(random.random()),
                1 => f32::NAN,
                2 => f32::NEG_INFINITY,
                3 => f32::INFINITY,
                _ => random.random_range(-6.5..-5.5),
            };
            block[4 * axis..][..4].copy_from_slice(&base.to_le_bytes());
            block[12 + axis] = if random.random_range(0..20) > 0 { 129 } else { [0, 1, 254, 255][number as usize % 4] };
        }
        for child in 0..4 {
            for axis in 0..3 {
                let [least, greatest] = [16, 19].map(|from| from + 6 * child + axis);
                if random.random_range(0..20) > 0 {
                    (block[least], block[greatest]) = (block[least] & 63, block[greatest] | 192);
                }
            }
            let word = (random.random_range(0..2000) * 64) | [0, 1, 2, 32, 32, 32][random.random_range(0..6)];
            block[40 + 4 * child..][..4].copy_from_slice(&u32::to_le_bytes(word));
        }
        assert_eq!(scene.0.len() as u32, 64 * number);
        scene.0.extend(block);
    }
    let rays: Vec<RayRequest> =
        (0..100).map(|_| ray((64 * random.random_range(0..2000_u32)) | 32, &mut random)).collect();
    let parameters = UnitParameters { contexts: 16, step: step(4), ..Default::default() };
    let unit = UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit");
    let (mut netlist, mut model) = (NetlistEngine::new(&unit).expect("a simulation"), UnitModel::of(&unit));
    let mut environment = Environment::new(&scene.0, parameters, rays.clone(), QUIET, 3);
    while !environment.is_done() {
        environment.cycle(&mut [&mut netlist, &mut model]).expect("the protocol");
        assert!(environment.cycles() < 1_000_000, "{} rays ended", environment.replies.len());
    }
    let text = |replies: Vec<Reply>| replies.iter().map(|reply| format!("{reply:?}\n")).collect::<String>();
    let found: Vec<Reply> = environment.replies.values().copied().collect();
    let nodes: u32 = found.iter().map(|reply| reply.nodes).sum();
    assert_eq!(text(found), text(expected(&scene, &rays, parameters.step)));
    assert!(nodes > 600, "{nodes} nodes were read");
}

/// The cycles from the last beat of a block to the next request of its ray, as `docs/reference/unit.md` has them: from
/// a node, and from the last triangle to the hit; with quantised nodes from a triangle to the next, too.
#[test]
fn a_fetch_takes_as_many_cycles_as_documented() {
    for (nodes, documented) in [(NodeKind::Quantised, &[23, 36, 36][..]), (NodeKind::Wide8, &[24, 38])] {
        let mut scene = Scene(Vec::new(), nodes);
        let leaf = scene.leaf(&[0, 1, 2].map(|index| at(3.0, index)));
        let aabb = Aabb::new([-2.0; 3], [4.0; 3]);
        let root = scene.node([aabb; 4], [leaf, 0, 0, 0]);
        let bytes = nodes.block_bytes();
        let step = StepParameters { node: nodes, ..StepParameters::default() };
        let parameters = UnitParameters { step, memory_width: 8 * bytes, ..Default::default() };
        let mut unit = UnitModel::new(&Shape::default(), parameters);
        let (mut events, mut due) = (Vec::new(), None);
        for cycle in 0..200 {
            let outputs = unit.outputs();
            let asked = outputs.request;
            if asked.is_some() || outputs.hit.is_some() {
                events.push(cycle);
            }
            let beat = due.take().map(|BlockRequest { address, tag }| {
                let beat = &scene.0[address as usize..][..bytes as usize];
                Response { tag, is_error: false, beat }
            });
            due = asked;
            let ray = (cycle == 0).then_some((0, along_z(root)));
            let inputs =
                UnitInputs { ray, hit_ready: true, request_ready: true, response: beat, ..UnitInputs::default() };
            unit.cycle(&inputs);
        }
        // The block arrives in the cycle after its request.
        let gaps: Vec<i32> = events.windows(2).map(|pair| pair[1] - pair[0] - 1).collect();
        assert_eq!((events[0], &gaps[..]), (23, documented), "{nodes}");
    }
}

#[test]
fn a_beat_is_at_most_a_block() {
    let parameters = UnitParameters { memory_width: 1024, step: step(8), ..Default::default() };
    let error = parameters.check().expect_err("no unit").to_string();
    let expected = "expected 128, 256 or 512 with quantised nodes, whose blocks have 512";
    assert!(error.starts_with("memory width is 1024, ") && error.ends_with(expected), "{error}");
}
