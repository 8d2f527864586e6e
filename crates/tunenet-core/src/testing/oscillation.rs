//! A damped harmonic oscillation in closed form.

/// The solution of x'' = −ω² x − 2 γ x' from `(x, v)`, γ < ω: e^(−γt) (x cos ω't + (v + γ x)/ω' sin ω't), ω'² = ω² − γ².
pub(super) fn damped(omega: f64, gamma: f64, (x, v): (f64, f64), t: f64) -> f64 {
    let turned = (omega * omega - gamma * gamma).sqrt();
    let (sin, cos) = (turned * t).sin_cos();
    (-gamma * t).exp() * (x * cos + (v + gamma * x) / turned * sin)
}
