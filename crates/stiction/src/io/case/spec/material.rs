//! Keys of `[materials.NAME]`.

use super::super::kind::{ANY, Kind, Limits, NOT_NEGATIVE, POSITIVE, Rules, choice, key};
use super::{GROUPS, POINT, VALUES};

pub(super) static MATERIAL: Rules = Rules {
    doc: "A linear elastic material: isotropic, or orthotropic where young, poisson and shear have three values each.",
    one_of: &[],
    keys: &[
        key("young", Kind::Either(&[Kind::Number(POSITIVE), VALUES]), "young = 210e9", "Young's modulus; of an orthotropic material [E1, E2, E3].")
            .required()
            .unit("stress"),
        key("poisson", Kind::Either(&[Kind::Number(POISSON), POINT]), "poisson = 0.3", "Poisson's ratio; of an orthotropic material [nu12, nu13, nu23], where nu12 is the contraction along axis 2 under tension along axis 1.")
            .required(),
        key("shear", VALUES, "shear = [5e9, 5e9, 3e9]", "Shear moduli [G12, G13, G23] of an orthotropic material.").unit("stress"),
        key("axes", AXES, "axes = [[1, 0, 0], [0, 1, 0]]", "Directions of axis 1 and, in the plane of both, of axis 2 of an orthotropic material; of any length.")
            .default("[[1, 0, 0], [0, 1, 0]]"),
        key("density", Kind::Number(NOT_NEGATIVE), "density = 7850", "Mass per volume, on which gravity acts.")
            .default("0")
            .unit("mass per volume"),
        key(
            "on",
            GROUPS,
            "on = \"body\"",
            "The volume group or groups of this material; may be left out if there is only one material.",
        ),
        key("formulation", FORMULATION, "formulation = \"auto\"", "How the strain of hexahedra is integrated.")
            .default("\"auto\""),
        key("expansion", Kind::Either(&[Kind::Number(ANY), POINT]), "expansion = 12e-6", "Thermal strain for each unit of temperature; [a1, a2, a3] along `axes` where it depends on the direction.")
            .unit("1/temperature"),
        key("reference_temperature", Kind::Number(ANY), "reference_temperature = 20", "The temperature without thermal strain.")
            .default("0")
            .unit("temperature"),
    ],
};

const POISSON: Limits = Limits {
    low: -1.0,
    high: 0.5,
    remedy: "most metals have about 0.3, rubber nearly 0.5",
    special: Some((
        0.5,
        "poisson = 0.5 is an incompressible material, whose pressure the displacements do not determine",
        "use a value just below, for instance 0.49 with hex8 cells, where formulation = \"b-bar\" avoids locking",
    )),
    ..ANY
};
const FORMULATION: Kind = choice(&[
    ("auto", "b-bar where poisson exceeds 0.45, full elsewhere"),
    ("full", "2 x 2 x 2 Gauss points"),
    ("b-bar", "the volumetric strain is averaged over the cell, which avoids locking"),
]);
const AXES: Kind = Kind::List { of: &POINT, from: 2, to: 2 };
