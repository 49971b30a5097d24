//! The units that a case names: labels only, nothing is converted.

/// Labels of the units, empty where the case names none.
#[derive(Clone, Copy)]
pub(crate) struct Units<'a> {
    pub length: &'a str,
    pub force: &'a str,
    pub stress: &'a str,
}

const LENGTHS: &[&str] = &["nm", "um", "µm", "mm", "cm", "m", "km", "in", "ft"];
const FORCES: &[&str] = &["uN", "µN", "mN", "N", "kN", "MN", "lbf", "kip"];
const STRESSES: &[&str] = &["Pa", "kPa", "MPa", "GPa", "N/mm2", "N/mm^2", "N/m^2", "psi", "ksi"];

impl<'a> Units<'a> {
    /// From a text such as `m, N, Pa`; common units may come in any order.
    pub(crate) fn of(text: Option<&'a str>) -> Self {
        let parts: Vec<&str> = text.unwrap_or("").split(',').map(str::trim).collect();
        match parts[..] {
            [a, b, c] => {
                let known = |names: &[&str]| parts.iter().copied().find(|part| names.contains(part));
                match [LENGTHS, FORCES, STRESSES].map(known) {
                    [Some(length), Some(force), Some(stress)] => Units { length, force, stress },
                    _ => Units { length: a, force: b, stress: c },
                }
            }
            [length, force, stress, ..] => Units { length, force, stress },
            _ => Units { length: "", force: "", stress: "" },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn common_units_come_in_any_order_and_others_in_the_one_of_the_manual() {
        let of = |text| {
            let Units { length, force, stress } = Units::of(Some(text));
            [length, force, stress]
        };
        assert_eq!(of("mm, N, MPa"), ["mm", "N", "MPa"]);
        assert_eq!(of("N, mm, MPa"), ["mm", "N", "MPa"]);
        assert_eq!(of("GPa, kN, mm"), ["mm", "kN", "GPa"]);
        assert_eq!(of("L, F, S"), ["L", "F", "S"]);
        assert_eq!(of("mm"), ["", "", ""]);
    }
}
