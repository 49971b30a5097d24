//! Keys of `[accuracy]`.

use super::super::kind::{ANY, Kind, Limits, Rules, choice, key};

pub(super) static ACCURACY: Rules = Rules {
    doc: "Refines the mesh until the answer is as accurate as asked; without a goal, until the energy norm is at 5 %, and with `proven` alone not at all.",
    one_of: &[],
    keys: &[
        key(
            "energy",
            GOAL,
            "energy = \"2%\"",
            "Estimated error of the stresses in the mean, in the energy norm over that of the answer.",
        ),
        key("forces", GOAL, "forces = \"1%\"", "Error bar of each resultant of contact, over the largest of them."),
        key("displacement", GOAL, "displacement = \"1%\"", "Error bar of the largest displacement, over it."),
        key("pressure", GOAL, "pressure = \"5%\"", "Error bar of the largest pressure of each contact, over it."),
        key(
            "max_unknowns",
            Kind::Whole { from: 1, to: u32::MAX as i64 },
            "max_unknowns = 1000000",
            "No mesh with more displacements is solved; what the memory holds if absent.",
        ),
        key(
            "proven",
            Kind::Flag,
            "proven = true",
            "Proves a bound of the error on the last mesh; it decides the goal for `energy`, and alone refines nothing.",
        )
        .default("false"),
        key("element", ELEMENT, "element = \"tet10\"", "What the mesh is made of.").default("\"tet10\""),
    ],
};

/// A part of one, or a text with a percent sign.
const GOAL: Kind = Kind::Either(&[Kind::Number(PART), Kind::Text]);
pub(in super::super) const PART: Limits =
    Limits { low: 1e-4, low_included: true, high: 0.5, high_included: true, remedy: "0.02 is 2 %", part: true, ..ANY };
const ELEMENT: Kind = choice(&[
    ("tet10", "quadratic tetrahedra, which need far fewer unknowns"),
    ("tet4", "linear tetrahedra, for comparison"),
]);
