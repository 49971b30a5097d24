//! Every key of a case file: the one source of its validation, its JSON schema and its messages.

mod accuracy;
mod bolt;
mod contact;
mod coupling;
mod cyclic;
mod equation;
mod load;
mod material;
mod mesh;
mod obstacle;
mod solver;
mod step;

use super::kind::{ANY, Kind, POSITIVE, Rules, key};
use accuracy::ACCURACY;
pub(super) use accuracy::PART;
use bolt::BOLT;
use contact::CONTACT;
use coupling::COUPLING;
use cyclic::CYCLIC;
use equation::EQUATION;
use load::{FIX, LOAD, SPRING};
use material::MATERIAL;
use mesh::MESH;
use solver::SOLVER;
use step::STEP;

/// A whole case file.
pub(super) static CASE: Rules = Rules {
    doc: "A static or quasi-static problem of elastic bodies in frictional contact. Any consistent system of units will do.",
    one_of: &[],
    keys: &[
        key(
            "title",
            Kind::Text,
            "title = \"Brick on a rigid foundation\"",
            "Heading of the results; the file name if absent.",
        ),
        key("units", Kind::Text, "units = \"m, N, Pa\"", "Names of the units, a label only: nothing is converted."),
        key("mesh", Kind::Table(&MESH), "[mesh]", "The mesh: a block made here, a file, or several of them.")
            .required(),
        key(
            "materials",
            Kind::Named(&MATERIAL),
            "[materials.steel]",
            "The materials, each under a name of your choice.",
        )
        .required(),
        key("fix", Kind::Tables(&FIX), "[[fix]]", "Prescribed displacements."),
        key("spring", Kind::Tables(&SPRING), "[[spring]]", "Elastic foundations: springs to the ground."),
        key("load", Kind::Tables(&LOAD), "[[load]]", "Loads."),
        key("equation", Kind::Tables(&EQUATION), "[[equation]]", "Linear equations between displacements."),
        key("cyclic", Kind::Tables(&CYCLIC), "[[cyclic]]", "Cyclic symmetry: one sector stands for all."),
        key("coupling", Kind::Tables(&COUPLING), "[[coupling]]", "Faces that move with a reference point."),
        key("bolt", Kind::Tables(&BOLT), "[[bolt]]", "Bolts that are tightened."),
        key(
            "contact",
            Kind::Tables(&CONTACT),
            "[[contact]]",
            "Surfaces that may touch a rigid obstacle or one another.",
        ),
        key("solver", Kind::Table(&SOLVER), "[solver]", "Settings of the solver; the defaults need no tuning."),
        key(
            "accuracy",
            Kind::Table(&ACCURACY),
            "[accuracy]",
            "How accurate the answer has to be; the mesh is refined until it is.",
        ),
        key(
            "step",
            Kind::Tables(&STEP),
            "[[step]]",
            "Load steps: the time t of expressions goes from 0 through their ends, and friction remembers where each point has slid.",
        ),
    ],
};

const POINT: Kind = Kind::List { of: &Kind::Number(ANY), from: 3, to: 3 };
const VALUES: Kind = Kind::List { of: &Kind::Number(POSITIVE), from: 3, to: 3 };
const FIELDS: Kind = Kind::List { of: &Kind::Field, from: 3, to: 3 };
const NAMES: Kind = Kind::List { of: &Kind::Text, from: 1, to: usize::MAX };
const GROUPS: Kind = Kind::Either(&[Kind::Text, NAMES]);

const REGION: Kind = Kind::Either(&[Kind::Text, NAMES, Kind::Table(&PLACE)]);
const ON: &str = "on = \"z-max\"";
const ON_DOC: &str = "A group, a list of groups, { box = [[x0, y0, z0], [x1, y1, z1]] } (what lies inside) or { point = [x, y, z] } (the nearest node).";

static PLACE: Rules = Rules {
    doc: "A region given by coordinates.",
    one_of: &["box", "point"],
    keys: &[
        key(
            "box",
            Kind::List { of: &POINT, from: 2, to: 2 },
            "box = [[0, 0, 0], [1, 1, 0.1]]",
            "Lowest and highest corner; what lies inside or on the boundary.",
        )
        .unit("length"),
        key("point", POINT, "point = [0, 0, 0]", "The node nearest to this point.").unit("length"),
    ],
};
