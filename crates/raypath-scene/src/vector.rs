//! Vectors in binary64, for cameras, shapes and lighting outside the datapath.

/// A vector.
pub type Vector = [f64; 3];

/// The vector of numbers in binary32.
pub fn vector(v: [f32; 3]) -> Vector {
    v.map(f64::from)
}

/// The numbers in binary32, rounded.
pub fn single(v: Vector) -> [f32; 3] {
    v.map(|x| x as f32)
}

/// a + b.
pub fn add(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|k| a[k] + b[k])
}

/// a - b.
pub fn subtract(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|k| a[k] - b[k])
}

/// The vector times a factor.
pub fn scale(factor: f64, v: Vector) -> Vector {
    v.map(|x| factor * x)
}

/// The dot product.
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The cross product a × b.
pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The length.
pub fn length(v: Vector) -> f64 {
    dot(v, v).sqrt()
}

/// The unit vector; zero for a vector that is zero or not finite.
pub fn unit(v: Vector) -> Vector {
    // Scale first, so that squares neither overflow nor underflow.
    let greatest = v.iter().fold(0.0, |max: f64, x| max.max(x.abs()));
    if greatest == 0.0 || !greatest.is_finite() {
        return [0.0; 3];
    }
    let v = v.map(|x| x / greatest);
    scale(1.0 / length(v), v)
}
