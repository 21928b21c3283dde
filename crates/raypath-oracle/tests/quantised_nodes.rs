//! Encoding of boxes into compressed nodes, compared with exact rationals.

use num_rational::BigRational;
use rand::{RngExt, SeedableRng};
use raypath_ops::operations::quantised_box::QuantisedNode;
use raypath_ops::{Aabb, Binary32, Word};

fn exact(number: f32) -> BigRational {
    BigRational::from_float(number).expect("finite")
}

#[test]
fn encoding_encloses_and_is_tight() {
    let mut rng = rand::rngs::ChaCha8Rng::from_seed([7; 32]);
    for round in 0..5000 {
        let spread = [0..1, -3..4, -60..60, -149..127][round % 4].clone();
        let count = rng.random_range(1..=4);
        let boxes: Vec<Aabb<Binary32>> = (0..count)
            .map(|_| {
                let mut number = |_| {
                    let sign = if rng.random() { 1.0 } else { -1.0 };
                    sign * rng.random_range(1.0_f32..2.0) * 2.0_f32.powi(rng.random_range(spread.clone()))
                };
                let [a, b] = [[0, 1, 2]; 2].map(|axes| axes.map(&mut number));
                let pick = |pick: fn(f32, f32) -> f32| std::array::from_fn(|k| pick(a[k], b[k]));
                Aabb::new(pick(f32::min), pick(f32::max))
            })
            .collect();
        let node = QuantisedNode::encode(&boxes).expect("a node");
        for axis in 0..3 {
            let [origin, scale] = [node.origin, node.scale].map(|of| <[f32; 3]>::from(of)[axis]);
            let fraction = scale.to_bits() & 0x7f_ffff;
            let (origin, scale) = (&exact(origin), &exact(scale));
            assert_eq!(fraction, 0, "a power of two");
            let offset = |word: Word<Binary32, 8>| BigRational::from_integer(u32::from(word).into());
            let one = exact(1.0);
            let mut greatest = BigRational::default();
            for (child, aabb) in node.child.iter().zip(&boxes) {
                let slab = [aabb.x, aabb.y, aabb.z][axis];
                let [min, max] = [slab.min, slab.max].map(|bound| exact(bound.into()));
                let slab = [child.x, child.y, child.z][axis];
                let [low, high] = [slab.min, slab.max].map(offset);
                assert!(origin + &low * scale <= min && min < origin + (&low + &one) * scale, "{boxes:?} {node:?}");
                assert!(max <= origin + &high * scale && origin + (&high - &one) * scale < max, "{boxes:?} {node:?}");
                greatest = greatest.max(max - origin);
            }
            let half = scale * exact(127.5);
            assert!(*scale <= exact(f32::MIN_POSITIVE) || greatest > half, "a smaller scale would do: {boxes:?}");
        }
    }
}

#[test]
fn invalid_boxes_are_errors() {
    let unit = Aabb::new([0.0; 3], [1.0; 3]);
    let said = |boxes: &[Aabb<Binary32>]| QuantisedNode::encode(boxes).expect_err("no node").to_string();
    assert_eq!(said(&[]), "0 boxes, expected 1 to 4");
    assert_eq!(said(&[unit; 5]), "5 boxes, expected 1 to 4");
    let reversed = Aabb::new([0.0, 2.0, 0.0], [1.0; 3]);
    assert_eq!(said(&[unit, reversed]), "box 1, axis 1: from 2 to 1, expected two finite numbers in order");
    assert!(said(&[Aabb::new([0.0; 3], [1.0, 1.0, f32::INFINITY])]).contains("axis 2: from 0 to inf"));
    assert!(said(&[Aabb::new([f32::NAN, 0.0, 0.0], [1.0; 3])]).contains("axis 0: from NaN to 1"));
}
