//! The units that a case names: labels only, nothing is converted.

/// Labels of the units, empty where the case names none.
#[derive(Clone, Copy)]
pub(crate) struct Units<'a> {
    pub length: &'a str,
    pub force: &'a str,
    pub stress: &'a str,
}

impl<'a> Units<'a> {
    /// From a text such as `m, N, Pa`.
    pub(crate) fn of(text: Option<&'a str>) -> Self {
        let parts: Vec<&str> = text.unwrap_or("").split(',').map(str::trim).collect();
        match parts[..] {
            [length, force, stress, ..] => Units { length, force, stress },
            _ => Units { length: "", force: "", stress: "" },
        }
    }
}
