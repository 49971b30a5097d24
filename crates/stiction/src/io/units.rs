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
const OTHERS: &[&str] = &["kg", "g", "t", "tonne", "s", "ms", "min", "h", "K", "C", "°C", "lb", "slug"];
const STRESSES: &[&str] = &["Pa", "kPa", "MPa", "GPa", "N/mm2", "N/mm^2", "N/m^2", "psi", "ksi"];

impl<'a> Units<'a> {
    /// From a text such as `m, N, Pa`; common units may come in any order, and among those of mass, time and temperature. Other labels are
    /// three, in this order.
    pub(crate) fn of(text: Option<&'a str>) -> Self {
        let parts: Vec<&str> = text.unwrap_or("").split(',').map(str::trim).collect();
        let known = |names: &[&str]| parts.iter().copied().find(|part| names.contains(part));
        let kinds = [LENGTHS, FORCES, STRESSES];
        let found = kinds.map(known);
        if let [Some(length), Some(force), Some(stress)] = found {
            return Units { length, force, stress };
        }
        let in_order = |parts: &[&str]| {
            parts.iter().zip(kinds).zip(found).all(|((part, kind), found)| found.is_none() || kind.contains(part))
        };
        match parts[..] {
            [length, force, stress] if known(OTHERS).is_none() && in_order(&parts) => Units { length, force, stress },
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
        assert_eq!(of("mm, kp, MPa"), ["mm", "kp", "MPa"]);
        for text in ["mm, t, s, N, MPa", "N, mm, MPa, t", "t, mm, s, N, MPa"] {
            assert_eq!(of(text), ["mm", "N", "MPa"], "{text}");
        }
        // What is no length, force or stress is not taken for one.
        for text in ["m, kg, s", "kg, m, s", "N, L, S", "a, b, c, d"] {
            assert_eq!(of(text), ["", "", ""], "{text}");
        }
        assert_eq!(of("mm"), ["", "", ""]);
    }
}
