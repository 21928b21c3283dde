//! Vectors in binary64, for cameras, shapes and lighting outside the datapath.

pub(crate) type Vector = [f64; 3];

pub(crate) fn vector(v: [f32; 3]) -> Vector {
    v.map(f64::from)
}

pub(crate) fn single(v: Vector) -> [f32; 3] {
    v.map(|x| x as f32)
}

pub(crate) fn add(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|k| a[k] + b[k])
}

pub(crate) fn subtract(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|k| a[k] - b[k])
}

pub(crate) fn scale(factor: f64, v: Vector) -> Vector {
    v.map(|x| factor * x)
}

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn length(v: Vector) -> f64 {
    dot(v, v).sqrt()
}

/// The unit vector; zero for a vector that is zero or not finite.
pub(crate) fn unit(v: Vector) -> Vector {
    // Scale first, so that squares neither overflow nor underflow.
    let greatest = v.iter().fold(0.0, |max: f64, x| max.max(x.abs()));
    if greatest == 0.0 || !greatest.is_finite() {
        return [0.0; 3];
    }
    let v = v.map(|x| x / greatest);
    scale(1.0 / length(v), v)
}
