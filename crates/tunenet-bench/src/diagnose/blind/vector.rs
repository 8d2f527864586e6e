//! Three numbers and what is done with them.

pub type Vector = [f64; 3];

pub fn plus(a: Vector, b: Vector, factor: f64) -> Vector {
    std::array::from_fn(|i| b[i].mul_add(factor, a[i]))
}

pub fn times(a: Vector, factor: f64) -> Vector {
    a.map(|v| v * factor)
}

pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}
