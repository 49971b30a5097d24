//! What the friction of a surface is at one of its points.
//!
//! Where the limit of friction rules it is the bound, with no slope in the normal force. The map from normal forces to
//! bounds keeps its Lipschitz constant, so contraction and uniqueness bound hold with a limit as without.

use super::obstacle::unit;
use super::{Across, Coefficient, Cohesion, CoulombLaw, Friction, SurfaceFriction};
use crate::Error;
use crate::mesh::v3::{V3, cross, dot, norm, scale, sub};

/// A direction of friction whose part along the surface is less than this says nothing there: it changes by as much as
/// the normals of neighbouring points do.
const LEAST_ALONG: f64 = 0.05;

/// A point that is about to get its law.
pub(super) struct At {
    pub node: u32,
    pub x: V3,
    /// The area it stands for.
    pub area: f64,
    pub normal: V3,
}

/// The law at a point, and friction across the first tangent over that along it. Where friction differs by direction the
/// tangents of `frame` are turned to the axes of its ellipse, the first to the larger.
///
/// A point that is free in one tangential direction only feels the ellipse's shadow on it: what lacks across is carried
/// by the support.
pub(super) fn law(friction: &SurfaceFriction, at: &At, frame: &mut [V3; 3]) -> Result<(Friction, f64), Error> {
    Ok(match friction {
        SurfaceFriction::None => (Friction::None, 1.0),
        SurfaceFriction::Bonded => (Friction::Bonded, 1.0),
        SurfaceFriction::Coulomb(coefficient) => (Friction::Coulomb { coefficient: *coefficient }, 1.0),
        SurfaceFriction::GivenStress(stress) => (Friction::Given { slip_bound: stress * at.area }, 1.0),
        SurfaceFriction::GivenForce(slip_bound) => (Friction::Given { slip_bound: *slip_bound }, 1.0),
        SurfaceFriction::Law(law) => coulomb(law, at, frame)?,
    })
}

fn coulomb(law: &CoulombLaw, at: &At, frame: &mut [V3; 3]) -> Result<(Friction, f64), Error> {
    let along = coefficient(&law.coefficient, "the coefficient of friction", at)?;
    if let Some(cohesion) = &law.cohesion {
        return Ok((cohesive(along, cohesion, at)?, 1.0));
    }
    let (coefficient, orthotropy, part) = match &law.across {
        None => (along, 1.0, 1.0),
        Some(other) => by_direction(along, other, at, frame)?,
    };
    let friction = match law.limit {
        Some(stress) => Friction::Limited { coefficient, limit: part * stress * at.area },
        None => Friction::Coulomb { coefficient },
    };
    Ok((friction, orthotropy))
}

fn cohesive(friction: f64, of: &Cohesion, at: &At) -> Result<Friction, Error> {
    let cohesion = at.area * coefficient(&of.shear, "the cohesion", at)?;
    let tension = at.area * coefficient(&of.tension, "the tensile strength", at)?;
    // No shear strength is left at the apex of the cone, and beyond it there is none.
    let apex = if friction > 0.0 { cohesion / friction } else { f64::INFINITY };
    Ok(Friction::Cohesive { coefficient: friction, cohesion, tension: tension.min(apex) })
}

/// The coefficient along the first tangent, that across over it, and the first over the largest of all directions.
fn by_direction(along: f64, other: &Across, at: &At, frame: &mut [V3; 3]) -> Result<(f64, f64, f64), Error> {
    let across = coefficient(&other.coefficient, "the coefficient of friction", at)?;
    let (n, d) = (at.normal, unit(other.direction).unwrap_or([0.0; 3]));
    let within = sub(d, scale(dot(d, n), n));
    if norm(within) < LEAST_ALONG {
        let what = format!(
            "the direction of friction {:?} is normal to the surface at node {} at {:?}",
            other.direction,
            at.node + 1,
            at.x
        );
        return Err(Error::new("", what, "give a direction along the surface, or one contact for each part of it"));
    }
    let first = unit(within).unwrap_or(within);
    let second = cross(n, first);
    let largest = along.max(across);
    if largest == 0.0 {
        return Ok((0.0, 1.0, 1.0));
    }
    if frame[2] != [0.0; 3] {
        let turned = if along >= across { [first, second] } else { [second, first] };
        (frame[1], frame[2]) = (turned[0], turned[1]);
        return Ok((largest, along.min(across) / largest, 1.0));
    }
    let shadow = (along * dot(frame[1], first)).hypot(across * dot(frame[1], second));
    Ok((shadow, 1.0, shadow / largest))
}

fn coefficient(coefficient: &Coefficient, name: &str, at: &At) -> Result<f64, Error> {
    let (value, remedy) = match coefficient {
        Coefficient::Field(field) => {
            (field.finite_at(at.x, 0.0)?, "give an expression that is at least zero, such as \"max(0, ...)\"")
        }
        Coefficient::Array { values, .. } | Coefficient::OfTime { values, .. } => {
            let value = values.get(at.node as usize).copied().unwrap_or(f64::NAN);
            (value, "let it be a number of at least zero at every node of the surface")
        }
    };
    if value >= 0.0 && value.is_finite() {
        return Ok(value);
    }
    let what = format!("{name} is {value} at node {} at {:?}", at.node + 1, at.x);
    Err(Error::new("", what, remedy))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Field;

    fn law_at(coefficients: [f64; 2], direction: V3, frame: &mut [V3; 3]) -> Result<(Friction, f64), Error> {
        let [along, across] = coefficients.map(|c| Field::Constant(c).into());
        let across = Some(Across { coefficient: across, direction });
        let friction =
            SurfaceFriction::Law(CoulombLaw { coefficient: along, across, limit: Some(5.0), cohesion: None });
        law(&friction, &At { node: 6, x: [0.0; 3], area: 2.0, normal: [0.0, 0.0, -1.0] }, frame)
    }

    #[test]
    fn the_first_tangent_points_where_friction_is_the_larger() {
        let floor = [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        for (coefficients, along) in [([0.4, 0.1], [0.6, 0.8, 0.0]), ([0.1, 0.4], [0.8, -0.6, 0.0])] {
            let mut frame = floor;
            let found = law_at(coefficients, [3.0, 4.0, 1.0], &mut frame).unwrap();
            assert_eq!(found, (Friction::Limited { coefficient: 0.4, limit: 10.0 }, 0.25));
            assert!((dot(frame[1], along).abs() - 1.0).abs() < 1e-15 && dot(frame[1], frame[2]).abs() < 1e-15);
        }
    }

    #[test]
    fn a_guided_point_feels_the_shadow_of_the_ellipse() {
        let t = [0.6, 0.8, 0.0];
        let mut frame = [[0.0, 0.0, -1.0], t, [0.0; 3]];
        let (found, orthotropy) = law_at([0.4, 0.1], [1.0, 0.0, 0.0], &mut frame).unwrap();
        let Friction::Limited { coefficient, limit } = found else { panic!("{found:?}") };
        // The largest component along t of a force on the ellipse, by a look at all of them.
        let angles = (0..100_000).map(|i| f64::from(i) * std::f64::consts::TAU / 1e5);
        let largest = angles.map(|a| 0.4 * a.cos() * t[0] + 0.1 * a.sin() * t[1]).fold(0.0, f64::max);
        assert!((coefficient - largest).abs() < 1e-9 && orthotropy == 1.0 && frame[1] == t);
        assert!((limit - 10.0 * largest / 0.4).abs() < 1e-7);
    }

    #[test]
    fn a_direction_normal_to_the_surface_is_refused_with_its_node() {
        let mut frame = [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let error = law_at([0.4, 0.1], [0.0, 0.01, 1.0], &mut frame).unwrap_err();
        assert!(error.what.contains("normal to the surface at node 7"), "{error}");
        let error = law_at([0.4, -0.1], [1.0, 0.0, 0.0], &mut frame).unwrap_err();
        assert!(error.what.contains("is -0.1 at node 7"), "{error}");
    }
}
