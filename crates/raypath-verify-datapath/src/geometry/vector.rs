//! Vectors.

use std::ops::{Add, Mul, Sub};

pub type Point = [f64; 3];

pub fn sum(a: Point, b: Point) -> Point {
    std::array::from_fn(|i| a[i] + b[i])
}

pub fn minus<T: Copy + Sub<Output = T>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

pub fn scaled(a: Point, factor: f64) -> Point {
    a.map(|coordinate| coordinate * factor)
}

pub fn dot<T: Copy + Mul<Output = T> + Add<Output = T>>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross<T: Copy + Mul<Output = T> + Sub<Output = T>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

pub fn unit(a: Point) -> Point {
    scaled(a, 1.0 / dot(a, a).sqrt())
}
