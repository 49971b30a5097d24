//! What contact does to the surfaces over load steps: work of friction, amplitudes, the parameters of Ruiz, wear.
//!
//! Ruiz, Boddington and Chen 1984, "An investigation of fatigue and fretting in a dovetail joint"; Archard 1953, "Contact and
//! rubbing of flat surfaces".

use std::array::from_fn;

use serde::{Deserialize, Serialize};

use super::fields::{Side, SurfaceFields};
use crate::fem::Voigt;
use crate::mesh::v3::{V3, dot, norm, scale, sub};

/// What is known of a contact point at the end of a load step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PointStep {
    /// Work of friction in the step, and pressure times slip; energy per area.
    pub work: f64,
    pub pressed: f64,
    /// Force of the body on its counterpart along the surface, over area.
    pub shear: V3,
    /// What it slides in the step, length.
    pub slip: V3,
    /// What it has slid since the start, length.
    pub slid: V3,
    /// The largest principal stress along the surface; stress, not negative.
    pub tension: f64,
    /// Whether it touches.
    pub touching: bool,
}

/// What a contact point has been through since the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PointHistory {
    /// Work of friction in the last step, and pressure times slip there; per area.
    pub step_work: f64,
    pub step_pressed: f64,
    /// Work of friction since the start, per area.
    pub work: f64,
    /// What it has slid to and fro while it touched, length.
    pub path: f64,
    /// The integral of the pressure over that path, force over length.
    pub pressed_path: f64,
    /// The largest shear, stress.
    pub shear: f64,
    /// The largest tension along the surface, stress.
    pub tension: f64,
    /// Boxes around all that it had slid and all shears at the ends of the steps.
    slid: [V3; 2],
    shears: [V3; 2],
}

impl Default for PointHistory {
    fn default() -> Self {
        let empty = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        PointHistory {
            step_work: 0.0,
            step_pressed: 0.0,
            work: 0.0,
            path: 0.0,
            pressed_path: 0.0,
            shear: 0.0,
            tension: 0.0,
            slid: empty,
            shears: empty,
        }
    }
}

impl PointHistory {
    /// How many there are of [`Self::numbers`].
    pub(crate) const NUMBERS: usize = 19;

    /// All that is known, to be kept in a file.
    pub(crate) fn numbers(&self) -> [f64; Self::NUMBERS] {
        let PointHistory { step_work, step_pressed, work, path, pressed_path, shear, tension, slid, shears } = *self;
        let single = [step_work, step_pressed, work, path, pressed_path, shear, tension];
        let boxes = [slid, shears];
        from_fn(|k| if k < 7 { single[k] } else { boxes.as_flattened().as_flattened()[k - 7] })
    }

    /// The history of [`Self::numbers`].
    pub(crate) fn of_numbers(of: [f64; Self::NUMBERS]) -> Self {
        let [step_work, step_pressed, work, path, pressed_path, shear, tension, ..] = of;
        let [slid, shears] = [7, 13].map(|first| [0, 3].map(|place| from_fn(|c| of[first + place + c])));
        PointHistory { step_work, step_pressed, work, path, pressed_path, shear, tension, slid, shears }
    }

    /// Goes on by a step. Friction and pressure are those of its end, as in the law that is solved.
    pub(crate) fn add(&mut self, step: &PointStep) {
        (self.step_work, self.step_pressed) = (step.work, step.pressed);
        self.work += step.work;
        self.pressed_path += step.pressed;
        if step.touching {
            self.path += norm(step.slip);
        }
        self.shear = self.shear.max(norm(step.shear));
        self.tension = self.tension.max(step.tension);
        for (known, value) in [(&mut self.slid, step.slid), (&mut self.shears, step.shear)] {
            *known = [from_fn(|c| known[0][c].min(value[c])), from_fn(|c| known[1][c].max(value[c]))];
        }
    }

    /// Half of how far apart two places are, length: exact for sliding along a line.
    pub(crate) fn slip_amplitude(&self) -> f64 {
        amplitude(&self.slid)
    }

    /// The same of the shear, stress.
    pub(crate) fn shear_amplitude(&self) -> f64 {
        amplitude(&self.shears)
    }

    /// Ruiz's `tau delta` and `sigma tau delta`: the largest shear times the amplitude of slip, and that times the largest tension
    /// along the surface.
    pub(crate) fn ruiz(&self) -> [f64; 2] {
        let first = self.shear * self.slip_amplitude();
        [first, self.tension * first]
    }

    /// All that is written of the point: tension at the end of the step, work of the step, work, path, amplitudes of slip and
    /// shear, largest shear, largest tension, both of Ruiz's parameters, depth of wear (NaN without a coefficient, 1/stress), pressure
    /// times slip of the step.
    pub(crate) fn figures(&self, tension: f64, wear: Option<f64>) -> [f64; FIGURES] {
        let ([first, second], wear) = (self.ruiz(), wear.map_or(f64::NAN, |k| k * self.pressed_path));
        let (slip, shear) = (self.slip_amplitude(), self.shear_amplitude());
        let PointHistory { step_work, step_pressed, work, path, shear: most, tension: highest, .. } = *self;
        [tension, step_work, work, path, slip, shear, most, highest, first, second, wear, step_pressed]
    }
}

/// Numbers that [`PointHistory::figures`] gives.
pub(crate) const FIGURES: usize = 12;

/// Half the diagonal of a box.
fn amplitude([low, high]: &[V3; 2]) -> f64 {
    if low[0] > high[0] { 0.0 } else { 0.5 * norm(sub(*high, *low)) }
}

/// The largest principal value of a stress along the surface with the unit normal `n`; 0 where it is compression.
pub(crate) fn tension_along(stress: &Voigt, n: V3) -> f64 {
    let [xx, yy, zz, xy, yz, xz] = *stress;
    let times = |v: V3| [dot([xx, xy, xz], v), dot([xy, yy, yz], v), dot([xz, yz, zz], v)];
    // Any two axes along the surface: the first is that of the coordinates which is farthest from the normal, made level.
    let axis = (0..3).min_by(|&a, &b| n[a].abs().total_cmp(&n[b].abs())).unwrap_or(0);
    let unit = from_fn(|c| f64::from(u8::from(c == axis)));
    let level = sub(unit, scale(n[axis], n));
    let first = scale(1.0 / norm(level), level);
    let second = crate::mesh::v3::cross(n, first);
    let (a, b, c) = (dot(first, times(first)), dot(first, times(second)), dot(second, times(second)));
    (0.5 * (a + c) + (0.5 * (a - c)).hypot(b)).max(0.0)
}

/// The histories of all points, in the order of the surfaces and their nodes; nothing on nodes that carry no point.
#[derive(Debug, Clone, Default)]
pub(crate) struct Fretting {
    points: Vec<PointHistory>,
}

impl Fretting {
    /// Of these histories.
    pub(crate) fn of(points: Vec<PointHistory>) -> Self {
        Fretting { points }
    }

    /// Goes on by the step at whose end the surfaces are like this.
    pub(crate) fn add(&mut self, steps: impl Iterator<Item = Option<PointStep>>) {
        for (at, step) in steps.enumerate() {
            if at == self.points.len() {
                self.points.push(PointHistory::default());
            }
            step.iter().for_each(|step| self.points[at].add(step));
        }
    }

    /// The history of the node at this place.
    pub(crate) fn at(&self, place: usize) -> PointHistory {
        self.points.get(place).copied().unwrap_or_default()
    }
}

/// What is known of the nodes of surfaces, one after the other; `tension` at all of them.
pub(crate) fn point_steps<'a>(
    surfaces: &'a [SurfaceFields],
    tension: &'a [f64],
) -> impl Iterator<Item = Option<PointStep>> + 'a {
    let places = surfaces.iter().flat_map(|s| (0..s.nodes.len()).map(move |at| (s, at)));
    places.zip(tension).map(|((s, at), &tension)| {
        let known = s.side == Side::Slave && s.status[at] >= 0;
        known.then(|| PointStep {
            work: s.step_work[at],
            pressed: s.step_pressed[at],
            shear: s.shear[at],
            slip: s.slip[at],
            slid: s.slid[at],
            tension,
            touching: s.status[at] > 0,
        })
    })
}

/// What friction has done to the surface of a pair since the start of the load steps.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FrettingRecord {
    /// Name of the pair.
    pub name: String,
    /// Work of friction, energy.
    pub work: f64,
    /// The largest work of friction of a point, per area.
    pub max_work: f64,
    /// The largest amplitude of slip, length.
    pub max_slip_amplitude: f64,
    /// The largest amplitude of shear, stress.
    pub max_shear_amplitude: f64,
    /// The largest of Ruiz's first parameter, `tau delta`, per area an energy.
    pub max_ruiz_1: f64,
    /// The largest of Ruiz's second parameter, `sigma tau delta`.
    pub max_ruiz_2: f64,
    /// The largest depth of wear, length; none without a coefficient.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_wear: Option<f64>,
    /// The volume worn away, length cubed; none without a coefficient.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worn_volume: Option<f64>,
}

/// The record of each pair from the figures of all nodes, see [`PointHistory::figures`].
pub(crate) fn records(surfaces: &[SurfaceFields], figures: &[[f64; FIGURES]]) -> Vec<FrettingRecord> {
    let (mut all, mut rest) = (Vec::new(), figures);
    for surface in surfaces {
        let (own, others) = rest.split_at(surface.nodes.len().min(rest.len()));
        rest = others;
        if surface.side == Side::Master {
            continue;
        }
        let known = own.iter().zip(&surface.area).filter(|(figures, _)| !figures[0].is_nan());
        let has_wear = known.clone().any(|(figures, _)| figures[10].is_finite());
        let points = known.map(|(figures, area)| (*figures, *area));
        all.push(FrettingRecord::of(&surface.name, has_wear, points));
    }
    all
}

impl FrettingRecord {
    /// That of points with these figures and areas.
    pub(crate) fn of(name: &str, has_wear: bool, points: impl Iterator<Item = ([f64; FIGURES], f64)>) -> Self {
        let none = has_wear.then_some(0.0);
        let mut r = FrettingRecord { name: name.into(), max_wear: none, worn_volume: none, ..Self::default() };
        for (figures, area) in points {
            let [_, _, work, _, slip, shear, _, _, first, second, wear, _] = figures;
            r.work += area * work;
            r.worn_volume = r.worn_volume.map(|volume| volume + area * wear);
            let most = r.maxima();
            let here = [work, slip, shear, first, second, wear];
            r = r.with_maxima(from_fn(|k| most[k].max(here[k])));
        }
        r
    }

    /// The largest values, those of wear the last.
    pub(crate) fn maxima(&self) -> [f64; 6] {
        let FrettingRecord { max_work, max_slip_amplitude, max_shear_amplitude, max_ruiz_1, max_ruiz_2, .. } = *self;
        let wear = self.max_wear.unwrap_or(0.0);
        [max_work, max_slip_amplitude, max_shear_amplitude, max_ruiz_1, max_ruiz_2, wear]
    }

    /// The record with other largest values.
    pub(crate) fn with_maxima(self, most: [f64; 6]) -> Self {
        let [max_work, max_slip_amplitude, max_shear_amplitude, max_ruiz_1, max_ruiz_2, wear] = most;
        let max_wear = self.max_wear.map(|_| wear);
        FrettingRecord { max_work, max_slip_amplitude, max_shear_amplitude, max_ruiz_1, max_ruiz_2, max_wear, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stress of 3 along (1, 1, 0)/√2, -5 along (1, -1, 0)/√2 and 7 along z.
    #[test]
    fn the_tension_along_a_surface_is_its_larger_principal_stress_there() {
        let (r, stress) = (0.5f64.sqrt(), [-1.0, -1.0, 7.0, 4.0, 0.0, 0.0]);
        for (normal, wanted) in
            [([0.0, 0.0, 1.0], 3.0), ([0.0, 0.0, -1.0], 3.0), ([r, r, 0.0], 7.0), ([r, -r, 0.0], 7.0)]
        {
            assert!((tension_along(&stress, normal) - wanted).abs() < 1e-14, "{normal:?}");
        }
        let pressed = stress.map(|s| -s);
        assert_eq!(tension_along(&[-1.0, -2.0, -3.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0]), 0.0);
        assert!((tension_along(&pressed, [0.0, 0.0, 1.0]) - 5.0).abs() < 1e-14);
    }

    #[test]
    fn amplitudes_are_half_the_distance_of_the_ends_in_any_direction() {
        let mut point = PointHistory::default();
        for part in [1.0, -1.0, 0.25] {
            let slid = [0.3 * part, 0.4 * part, 0.0];
            let (slip, shear) = ([0.0; 3], scale(10.0, slid));
            point.add(&PointStep { work: 0.0, pressed: 0.0, shear, slip, slid, tension: 2.0, touching: true });
        }
        assert!((point.slip_amplitude() - 0.5).abs() < 1e-15 && (point.shear_amplitude() - 5.0).abs() < 1e-14);
        let [first, second] = point.ruiz();
        assert!((first - 2.5).abs() < 1e-14 && (second - 5.0).abs() < 1e-14);
    }
}
