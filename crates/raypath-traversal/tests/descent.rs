//! The program that traces rays fast gives the replies of the hardware's steps, in all numbers and counts.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_ops::{BoxBits, Rules};
use raypath_traversal::blocks::NodeKind;
use raypath_traversal::traffic::{BlockScene, TwoLevelScene, random_ray, verdict_of};
use raypath_traversal::{Candidate, Front, NODE_LIMIT, Queries, RayRequest, StepParameters, Unit, UnitFeatures};

const RULES: [Rules; 3] = [Rules::Paper, Rules::Bounds(BoxBits(8)), Rules::Bounds(BoxBits::DEFAULT)];
const WEIGHTS: UnitFeatures = UnitFeatures { barycentrics: true, ..UnitFeatures::OFF };
const INSTANCES: UnitFeatures = UnitFeatures { instances: true, ..UnitFeatures::OFF };

#[test]
fn rays_take_the_way_of_the_steps() {
    let (mut ends, mut rereads, mut candidates) = ([0; 7], 0, 0);
    for seed in 0..120 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let node = NodeKind::ALL[random.random_range(0..3)];
        let (scene, root, features) = match random.random_range(0..6) {
            0 => {
                let scene = TwoLevelScene::random(node, 20, true, &mut random);
                (scene.blocks, scene.root, UnitFeatures { nested: random.random(), ..INSTANCES })
            }
            1..=3 => {
                let (scene, root) = BlockScene::random_of(node, 500, &mut random);
                (scene, root, WEIGHTS)
            }
            _ => {
                let (scene, root) = BlockScene::deep_of(node, 60, &mut random);
                (scene, root, UnitFeatures::OFF)
            }
        };
        let mut scene = scene;
        let queries = [Queries::None, Queries::Flags, Queries::Full, Queries::Full][random.random_range(0..4)];
        let root = scene.give_geometries(root, queries, &mut random);
        let front = [Front::CounterClockwise, Front::Clockwise][random.random_range(0..2)];
        let node_limit = if random.random_ratio(1, 4) { random.random_range(0..12) } else { NODE_LIMIT };
        let features = UnitFeatures { queries, ..features };
        let step = StepParameters { node: scene.1, front, node_limit, features, stack: 32 };
        let rules = RULES[random.random_range(0..RULES.len())];
        // Where the memory ends early, rays end with an error.
        let bytes = if random.random_ratio(1, 5) { &scene.0[..scene.0.len() / 2] } else { &scene.0[..] };
        let rays: Vec<RayRequest> = (0..100).map(|_| random_ray(root, &mut random)).collect();
        for stack in [2, 4, 8, 32] {
            let mut unit = Unit::new(rules, StepParameters { stack, ..step });
            let mut endless = Unit::new(rules, step);
            for ray in &rays {
                let mut asked = [Vec::new(), Vec::new()];
                let [mut first, mut second] = asked.each_mut().map(|asked| {
                    |candidate: &Candidate| {
                        asked.push(*candidate);
                        verdict_of(candidate)
                    }
                });
                let (found, expected) =
                    (unit.trace_with(bytes, ray, &mut first), unit.trace_by_steps(bytes, ray, &mut second));
                assert_eq!(format!("{:?}", asked[0]), format!("{:?}", asked[1]), "seed {seed}, {ray:?}");
                candidates += asked[0].len();
                assert_eq!(format!("{found:?}"), format!("{expected:?}"), "seed {seed}, stack {stack}, {ray:?}");
                ends[found.status as usize] += 1;
                rereads += u32::from(found.nodes > endless.trace_with(bytes, ray, &mut verdict_of).nodes);
            }
        }
    }
    let [misses, hits, procedural, refused, memory, scene, _] = ends;
    assert!(candidates > 1000 && procedural > 100, "{candidates} candidates, {ends:?}");
    assert!(misses > 1000 && hits > 1000 && refused > 100 && memory > 100 && scene > 50, "{ends:?}");
    assert!(rereads > 1000, "{rereads}");
}
