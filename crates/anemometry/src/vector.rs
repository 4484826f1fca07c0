//! Vectors of three components: product, length, direction and angle.

/// Scalar product.
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Euclidean norm.
pub fn length(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}

/// Direction; NaN of zero.
pub fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = length(v);
    v.map(|x| x / length)
}

/// Angle between two vectors, °.
pub fn angle_deg(a: [f64; 3], b: [f64; 3]) -> f64 {
    libm::atan2(length(cross(a, b)), dot(a, b)).to_degrees()
}

/// The part of a vector that is across an axis of any length.
pub fn across(v: [f64; 3], axis: [f64; 3]) -> [f64; 3] {
    let along = dot(v, axis) / dot(axis, axis);
    std::array::from_fn(|k| v[k] - along * axis[k])
}
