//! Figures 1 and 2 of the paper: the polygon around the disc and the cross-section of the body.

use std::f64::consts::PI;

use super::study::Figure;
use stiction::io::plot::{Align, Drawing};

const INK: [u8; 3] = [34, 34, 34];
const QUIET: [u8; 3] = [150, 150, 150];
const BLUE: [u8; 3] = [0, 92, 158];
const RED: [u8; 3] = [192, 57, 43];
const ORANGE: [u8; 3] = [230, 159, 0];
const FILL: [u8; 3] = [222, 235, 246];
const TITLE: f64 = 36.0;
const BODY: f64 = 24.0;

/// Squares of figure 1.
const SQUARES: usize = 4;

/// Figure 1: the disc as an intersection of rotated squares.
pub fn polygon() -> Figure {
    let mut d = Drawing::new(1000, 940);
    let (center, radius) = ([480.0, 520.0], 250.0);
    let at = |angle: f64, r: f64| [center[0] + r * angle.cos(), center[1] - r * angle.sin()];
    let alpha = PI / (2 * SQUARES) as f64;
    // The tangents of the disc at multiples of alpha meet half way between, at radius / cos(alpha / 2).
    let corners = (0..4 * SQUARES).map(|k| at((k as f64 + 0.5) * alpha, radius / (0.5 * alpha).cos()));
    let corners: Vec<[f64; 2]> = corners.collect();
    d.polygon(corners.clone(), FILL, None);
    for i in 0..SQUARES {
        let corner = |k: usize| at(i as f64 * alpha + PI / 4.0 + k as f64 * PI / 2.0, radius * 2f64.sqrt());
        d.line((0..=4).map(corner).collect(), if i == 0 { 2.5 } else { 1.5 }, if i == 0 { INK } else { QUIET });
    }
    let circle: Vec<[f64; 2]> = (0..=180).map(|k| at(PI * f64::from(k) / 90.0, radius)).collect();
    d.line(corners.iter().chain(&corners[..1]).copied().collect(), 4.0, ORANGE);
    d.line(circle, 2.0, BLUE);
    d.arrow(at(PI, 400.0), at(0.0, 430.0), 1.5, 14.0, INK);
    d.arrow(at(-PI / 2.0, 375.0), at(PI / 2.0, 385.0), 1.5, 14.0, INK);
    d.text("λt1", at(0.0, 462.0), BODY, INK, Align::Center);
    d.text("λt2", [center[0] + 36.0, center[1] - 378.0], BODY, INK, Align::Left);
    d.line(vec![center, at(alpha, radius)], 2.0, RED);
    d.line((0..=20).map(|k| at(alpha * f64::from(k) / 20.0, 120.0)).collect(), 2.0, RED);
    d.text("α", at(0.5 * alpha, 150.0), BODY, RED, Align::Center);
    d.text("g", at(alpha + 0.14, 170.0), BODY, RED, Align::Center);
    d.text("Approximation of the circle for N = 4", [40.0, 42.0], TITLE, INK, Align::Left);
    let note = format!(
        "α = π/8; squares S₁ to S₄ grey, their intersection of {} sides orange, the disc C(g) blue",
        4 * SQUARES
    );
    d.text(&note, [40.0, 84.0], BODY, [95, 95, 95], Align::Left);
    let caption = "Four squares around the disc, each turned by π/8 against the one before.".to_string();
    Figure { number: 1, title: "Approximation of the circle for N = 4".into(), caption, drawing: d }
}

/// Figure 2: the cross-section at x2 = 0.5 with loads, clamp and foundation.
pub fn section() -> Figure {
    let mut d = Drawing::new(1400, 700);
    const LENGTH: f64 = 300.0;
    let at = |x: f64, z: f64| [200.0 + LENGTH * x, 560.0 - LENGTH * z];
    d.polygon(vec![at(0.0, 0.0), at(3.0, 0.0), at(3.0, 1.0), at(0.0, 1.0)], FILL, Some(INK));
    // The clamped end and the foundation, hatched.
    hatch(&mut d, at(0.0, 0.0), at(0.0, 1.0), [-18.0, 14.0]);
    hatch(&mut d, at(-0.15, 0.0), at(3.3, 0.0), [-14.0, 18.0]);
    // Tractions: the top's fades from 2e6 at the clamp to nothing at the free end, whose own points up.
    let top: Vec<f64> = (0..10).map(|k| 0.28 * f64::from(k) + 0.03).collect();
    let height = |x: f64| 0.11 * (3.0 - x);
    for &x in &top {
        d.arrow([at(x, 0.0)[0], at(0.0, 1.0 + height(x) + 0.03)[1]], at(x, 1.01), 2.0, 12.0, BLUE);
    }
    d.line(vec![at(0.0, 1.03 + height(0.0)), at(3.0, 1.03)], 1.5, BLUE);
    for k in 0..6 {
        let z = 0.08 + 0.15 * f64::from(k);
        d.arrow(at(3.08, z), at(3.08, z + 0.13), 2.0, 12.0, BLUE);
    }
    d.text("p₃ = −2/3·10⁶ (3 − x₁)", at(1.35, 1.32), BODY, BLUE, Align::Left);
    d.text("p₃ = 10⁶", at(3.16, 0.5), BODY, BLUE, Align::Left);
    d.text("Ω", at(1.5, 0.5), 40.0, INK, Align::Center);
    d.text("Γu", at(0.06, 0.5), BODY, INK, Align::Left);
    d.text("Γc", at(1.5, 0.07), BODY, INK, Align::Center);
    d.text("0", at(0.0, -0.15), BODY, INK, Align::Center);
    d.text("3", at(3.0, -0.15), BODY, INK, Align::Center);
    d.arrow(at(-0.45, -0.3), at(-0.15, -0.3), 2.0, 12.0, INK);
    d.arrow(at(-0.45, -0.3), at(-0.45, 0.0), 2.0, 12.0, INK);
    d.text("x₁", at(-0.1, -0.3), BODY, INK, Align::Left);
    d.text("x₃", at(-0.45, 0.08), BODY, INK, Align::Center);
    d.text("The cross-section of Ω by the plane x₂ = 0.5", [40.0, 42.0], TITLE, INK, Align::Left);
    d.text("clamped on Γu, pressed onto the rigid foundation along Γc", [40.0, 84.0], BODY, [95, 95, 95], Align::Left);
    let caption =
        "Clamped at x1 = 0, loaded on the top and the free end, supported unilaterally by x3 <= 0.".to_string();
    Figure { number: 2, title: "The cross-section of the body by the plane x2 = 0.5".into(), caption, drawing: d }
}

/// A line with short strokes to one side.
fn hatch(d: &mut Drawing, a: [f64; 2], b: [f64; 2], stroke: [f64; 2]) {
    const SPACING: f64 = 16.0;
    let length = (b[0] - a[0]).hypot(b[1] - a[1]);
    let count = (length / SPACING) as usize;
    for k in 0..=count {
        let t = k as f64 * SPACING / length;
        let p = [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
        d.line(vec![p, [p[0] + stroke[0], p[1] + stroke[1]]], 1.5, QUIET);
    }
    d.line(vec![a, b], 3.0, INK);
}
