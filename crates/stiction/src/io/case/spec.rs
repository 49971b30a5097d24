//! Every key of a case file: the one source of its validation, its JSON schema and its messages.

use super::kind::{ANY, Key, Kind, Limits, NOT_NEGATIVE, POSITIVE, Rules, key};

const POINT: Kind = Kind::List { of: &Kind::Number(ANY), from: 3, to: 3 };
const FIELDS: Kind = Kind::List { of: &Kind::Field, from: 3, to: 3 };
const NAMES: Kind = Kind::List { of: &Kind::Text, from: 1, to: usize::MAX };
const GROUPS: Kind = Kind::Either(&[Kind::Text, NAMES]);

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
        key("load", Kind::Tables(&LOAD), "[[load]]", "Loads."),
        key(
            "contact",
            Kind::Tables(&CONTACT),
            "[[contact]]",
            "Surfaces that may touch a rigid obstacle or one another.",
        ),
        key("solver", Kind::Table(&SOLVER), "[solver]", "Settings of the solver; the defaults need no tuning."),
        key(
            "step",
            Kind::Tables(&STEP),
            "[[step]]",
            "Load steps: the time t of expressions goes from 0 through their ends, and friction remembers where each point has slid.",
        ),
    ],
};

static STEP: Rules = Rules {
    doc: "A stretch of the time axis, which begins at 0 or where the step before it ends.",
    one_of: &[],
    keys: &[
        key("name", Kind::Text, "name = \"press\"", "Name of the step in the results; \"step 1\" and so on if absent."),
        key("until", Kind::Number(POSITIVE), "until = 1", "The time t at its end.").required().unit("time"),
        key(
            "increments",
            Kind::Whole { from: 1, to: 100_000 },
            "increments = 4",
            "In how many equal increments of time it is solved; one that cannot be solved is halved.",
        )
        .default("1"),
    ],
};

static MESH: Rules = Rules {
    doc: "Where the mesh comes from.",
    one_of: &["block", "file", "parts"],
    keys: &[
        MESH_BLOCK,
        MESH_FILE,
        key(
            "parts",
            Kind::Named(&PART),
            "[mesh.parts.ring]",
            "Several meshes under names of your choice; the group z-max of the part ring is called ring.z-max, and ring are all its cells.",
        ),
        MESH_SCALE,
        MESH_TURN,
        MESH_MOVE,
    ],
};

static PART: Rules = Rules {
    doc: "A part of the mesh.",
    one_of: &["block", "file"],
    keys: &[MESH_BLOCK, MESH_FILE, MESH_SCALE, MESH_TURN, MESH_MOVE],
};

const MESH_BLOCK: Key = key(
    "block",
    Kind::Table(&BLOCK),
    "block = { size = [3, 1, 1], cells = [24, 8, 8] }",
    "A box of cells with the groups x-min, x-max, y-min, y-max, z-min, z-max and body.",
);
const MESH_FILE: Key = key(
    "file",
    Kind::Text,
    "file = \"part.msh\"",
    "A mesh file, .msh (Gmsh 2.2, 4.1), .inp (Abaqus, CalculiX) or .vtu, relative to the folder of the case file.",
);
const MESH_SCALE: Key =
    key("scale", Kind::Number(POSITIVE), "scale = 1e-3", "Factor on the coordinates of the file.").default("1");
const MESH_TURN: Key = key(
    "turn",
    Kind::Table(&TURN),
    "turn = { axis = [0, 0, 1], degrees = 30 }",
    "Turns the mesh about a line, after it was scaled.",
);
const MESH_MOVE: Key =
    key("move", POINT, "move = [0, 0, 1]", "Moves the mesh, after it was turned.").default("[0, 0, 0]").unit("length");

static TURN: Rules = Rules {
    doc: "A turn about a line.",
    one_of: &[],
    keys: &[
        key("axis", POINT, "axis = [0, 0, 1]", "The direction of the line, of any length.").required(),
        key("degrees", Kind::Number(ANY), "degrees = 30", "The angle, as a right-handed screw along the axis.")
            .required()
            .unit("degree"),
        key("point", POINT, "point = [0, 0, 0]", "A point of the line.").default("[0, 0, 0]").unit("length"),
    ],
};

static BLOCK: Rules = Rules {
    doc: "A box of cells.",
    one_of: &[],
    keys: &[
        key("size", Kind::List { of: &Kind::Number(POSITIVE), from: 3, to: 3 }, "size = [3, 1, 1]", "Lengths of the edges along x, y, z.")
            .required()
            .unit("length"),
        key("cells", Kind::List { of: &Kind::Whole { from: 1, to: 100_000 }, from: 3, to: 3 }, "cells = [24, 8, 8]", "Number of cells (boxes, before any cut into tetrahedra) along x, y, z.")
            .required(),
        key("element", ELEMENT, "element = \"tet4\"", "The element.").default("\"tet4\""),
        key("split", SPLIT, "split = \"five\"", "How each box is cut into tetrahedra; only for tet4, where \"five\" is the default."),
        key("parity", Kind::Whole { from: 0, to: 1 }, "parity = 0", "For split = \"five\": at 0 (the default) the central tetrahedron of the cell at the origin stands on the corners 100 010 001 111, at 1 on the other four."),
        key("origin", POINT, "origin = [0, 0, 0]", "The lowest corner.").default("[0, 0, 0]").unit("length"),
        key("grading", Kind::List { of: &Kind::Number(GRADING), from: 3, to: 3 }, "grading = [1, 1, 5]", "Length of the last cell over that of the first along x, y, z; between them the lengths form a geometric sequence.")
            .default("[1, 1, 1]"),
    ],
};

const GRADING: Limits = Limits { low: 1e-3, low_included: true, high: 1e3, high_included: true, ..ANY };

const ELEMENT: Kind = Kind::Choice {
    names: &[("tet4", "linear tetrahedra"), ("hex8", "trilinear hexahedra")],
    absent: &[("tet10", "use \"tet4\" or \"hex8\" with more cells"), ("hex20", "use \"hex8\" with more cells")],
};
const SPLIT: Kind = Kind::Choice {
    names: &[
        ("five", "five tetrahedra, mirrored from box to box"),
        ("six", "six tetrahedra around the diagonal from the lowest to the highest corner"),
    ],
    absent: &[],
};

static MATERIAL: Rules = Rules {
    doc: "An isotropic linear elastic material.",
    one_of: &[],
    keys: &[
        key("young", Kind::Number(POSITIVE), "young = 210e9", "Young's modulus.").required().unit("stress"),
        key("poisson", Kind::Number(POISSON), "poisson = 0.3", "Poisson's ratio.").required(),
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
        key("expansion", EXPANSION, "expansion = 12e-6", "Thermal expansion."),
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
const FORMULATION: Kind = Kind::Choice {
    names: &[
        ("auto", "b-bar where poisson exceeds 0.45, full elsewhere"),
        ("full", "2 x 2 x 2 Gauss points"),
        ("b-bar", "the volumetric strain is averaged over the cell, which avoids locking"),
    ],
    absent: &[],
};
const EXPANSION: Kind = Kind::Absent {
    what: "thermal expansion is not available in this version",
    remedy: "take `expansion` out, or prescribe the displacement it would cause in a [[fix]]",
};

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

static FIX: Rules = Rules {
    doc: "Prescribed displacements of a region.",
    one_of: &[],
    keys: &[
        key("on", REGION, ON, ON_DOC).required(),
        key("components", Kind::Text, "components = \"xy\"", "The components held, some of x, y, z in any order.").default("\"xyz\""),
        key("value", Kind::Either(&[Kind::List { of: &Kind::Field, from: 1, to: 3 }, Kind::Field]), "value = [0, 0, \"-1e-3*t\"]", "Their values, one for each of `components` in its order: numbers or expressions in x, y, z, t; 0 if absent. A single component needs no list.")
            .unit("length"),
    ],
};

static LOAD: Rules = Rules {
    doc: "A load on a region.",
    one_of: &["traction", "pressure", "force", "gravity"],
    keys: &[
        key(
            "on",
            REGION,
            ON,
            "Where it acts: boundary faces, or for gravity volume groups (everywhere if absent). A group, a list of groups or { box = [[x0, y0, z0], [x1, y1, z1]] }.",
        ),
        key(
            "traction",
            FIELDS,
            "traction = [0, 0, \"-1e6*x\"]",
            "Force per area; numbers or expressions in x, y, z, t.",
        )
        .unit("stress"),
        key(
            "pressure",
            Kind::Field,
            "pressure = 1e5",
            "Force per area against the outward normal; a number or an expression.",
        )
        .unit("stress"),
        key(
            "force",
            FIELDS,
            "force = [0, 0, -1000]",
            "Total force, spread evenly over the area; numbers or expressions in t.",
        )
        .unit("force"),
        key("gravity", FIELDS, "gravity = [0, 0, -9.81]", "Acceleration, acting on the density of the materials.")
            .unit("acceleration"),
        key("temperature", TEMPERATURE, "temperature = 80", "Temperature."),
    ],
};

const TEMPERATURE: Kind = Kind::Absent {
    what: "thermal loads are not available in this version",
    remedy: "use traction, pressure, force or gravity",
};

static CONTACT: Rules = Rules {
    doc: "A surface that may touch a rigid obstacle or another surface.",
    one_of: &[],
    keys: &[
        key("name", Kind::Text, "name = \"sole\"", "Name of the pair in the results; that of its group if absent."),
        key("on", REGION, "on = \"z-min\"", "The surface: a group, a list of groups or { box = [[x0, y0, z0], [x1, y1, z1]] }.").required(),
        key("against", Kind::Either(&[Kind::Table(&OBSTACLE), Kind::Text, NAMES]), "against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }", "A rigid obstacle, or another surface of the mesh: a group or a list of groups.")
            .required(),
        key("gap", Kind::Either(&[GAP_NAME, Kind::Number(ANY)]), "gap = \"closed\"", "Between two surfaces: how far apart they are before anything is loaded. A number holds wherever they meet; a negative one is an interference fit.")
            .default("\"as-meshed\"")
            .unit("length"),
        key("slave", SLAVE, "slave = \"on\"", "Between two surfaces: which of them carries the contact points; if absent the finer one, or else that of the softer body."),
        key("search", Kind::Number(POSITIVE), "search = 0.1", "Between two surfaces: how far apart they may be, or overlap, and still meet; a quarter of the diagonal of the smaller one if absent.")
            .unit("length"),
        key("friction", Kind::Either(&[FRICTION_NAME, Kind::Table(&FRICTION)]), "friction = { coulomb = 0.3 }", "The law of friction: \"none\", \"bonded\", { coulomb = coefficient }, { tresca = stress } or { tresca = force, nodal = true }.")
            .required(),
    ],
};

const GAP_NAME: Kind = Kind::Choice {
    names: &[("as-meshed", "what the meshes say, overlaps included"), ("closed", "none wherever they meet")],
    absent: &[],
};
const SLAVE: Kind =
    Kind::Choice { names: &[("on", "the surface of `on`"), ("against", "the surface of `against`")], absent: &[] };

static OBSTACLE: Rules = Rules {
    doc: "A rigid obstacle.",
    one_of: &["plane", "sphere", "cylinder"],
    keys: &[
        key("plane", Kind::Table(&PLANE), "plane = { point = [0, 0, 0], normal = [0, 0, 1] }", "A half space."),
        key("sphere", Kind::Table(&SPHERE), "sphere = { center = [0, 0, -1], radius = 1 }", "A sphere."),
        key(
            "cylinder",
            Kind::Table(&CYLINDER),
            "cylinder = { point = [0, 0, -1], axis = [0, 1, 0], radius = 1 }",
            "A cylinder without ends.",
        ),
        key(
            "motion",
            FIELDS,
            "motion = [0, 0, \"-0.1*t\"]",
            "Translation of the obstacle from where it is given; numbers or expressions in t. Small: the gap changes along its normal.",
        )
        .unit("length"),
    ],
};

static PLANE: Rules = Rules {
    doc: "A rigid half space.",
    one_of: &[],
    keys: &[
        key("point", POINT, "point = [0, 0, 0]", "A point of its surface.").required().unit("length"),
        key(
            "normal",
            POINT,
            "normal = [0, 0, 1]",
            "The normal that points out of the obstacle, towards the body; of any length.",
        )
        .required(),
    ],
};

const RADIUS: Key = key("radius", Kind::Number(POSITIVE), "radius = 1", "The radius.").required().unit("length");
const SIDE: Key = key(
    "side",
    Kind::Choice {
        names: &[("outside", "the body lies outside"), ("inside", "the body lies inside, as in a bore")],
        absent: &[],
    },
    "side = \"outside\"",
    "On which side of the surface the body lies.",
)
.default("\"outside\"");

static SPHERE: Rules = Rules {
    doc: "A rigid sphere.",
    one_of: &[],
    keys: &[key("center", POINT, "center = [0, 0, -1]", "The centre.").required().unit("length"), RADIUS, SIDE],
};

static CYLINDER: Rules = Rules {
    doc: "A rigid cylinder without ends.",
    one_of: &[],
    keys: &[
        key("point", POINT, "point = [0, 0, -1]", "A point of the axis.").required().unit("length"),
        key("axis", POINT, "axis = [0, 1, 0]", "The direction of the axis, of any length.").required(),
        RADIUS,
        SIDE,
    ],
};

const FRICTION_NAME: Kind = Kind::Choice {
    names: &[("none", "no friction"), ("bonded", "the surface sticks wherever it is: no slip, whatever the force")],
    absent: &[],
};

static FRICTION: Rules = Rules {
    doc: "A law of friction.",
    one_of: &["coulomb", "tresca"],
    keys: &[
        key("coulomb", Kind::Number(COEFFICIENT), "coulomb = 0.3", "Coefficient of friction."),
        key(
            "tresca",
            Kind::Number(NOT_NEGATIVE),
            "tresca = 5e4",
            "Given friction: the shear stress at which a point slips, whatever its pressure.",
        )
        .unit("stress; force where nodal = true"),
        key(
            "nodal",
            Kind::Flag,
            "nodal = true",
            "Whether `tresca` is the force of each contact point instead of a stress.",
        )
        .default("false"),
    ],
};

const COEFFICIENT: Limits = Limits {
    remedy: "the direction of friction follows from the slip, the coefficient only says how much",
    ..NOT_NEGATIVE
};

static SOLVER: Rules = Rules {
    doc: "Settings of the solver.",
    one_of: &[],
    keys: &[
        key(
            "tolerance",
            Kind::Number(TOLERANCE),
            "tolerance = 1e-8",
            "What every number of the certificate is held against.",
        )
        .default("1e-8"),
        key(
            "max_iterations",
            Kind::Whole { from: 1, to: 1_000_000 },
            "max_iterations = 100",
            "Most outer iterations; 100 if absent, for methods other than \"newton\" 10000.",
        ),
        key("method", METHOD, "method = \"newton\"", "How the case is solved; the default needs no tuning.")
            .default("\"newton\""),
        key(
            "inner",
            INNER,
            "inner = \"alg2\"",
            "For msa1 and msa2: what solves the problems with given friction (\"alg2\" if absent; \"discs\" only for msa1).",
        ),
        key(
            "variant",
            Kind::Whole { from: 1, to: 2 },
            "variant = 2",
            "For alg1: 1 sweeps over the copies until they rest, 2 sweeps once a step; if absent, 1 for alg1 and msa1, 2 for msa2.",
        ),
        key(
            "splitting",
            SPLITTING,
            "splitting = \"complete\"",
            "For alg1, alg2 and cfs1: how the multipliers are split by Gauss-Seidel.",
        )
        .default("\"no\""),
        key(
            "squares",
            Kind::Whole { from: 1, to: 1000 },
            "squares = 4",
            "For methods with squares: how many, turned against one another, stand for the disc of friction.",
        )
        .default("2"),
        key(
            "coupling",
            COUPLING,
            "coupling = \"star\"",
            "For methods with squares: which copies of the multipliers are compared.",
        )
        .default("\"star\""),
        key(
            "rho",
            Kind::Number(POSITIVE),
            "rho = 1e-8",
            "For methods with squares: the penalty on the disagreement of the copies.",
        )
        .unit("length/force"),
        key(
            "rho_factor",
            Kind::Number(POSITIVE),
            "rho_factor = 2",
            "The same over the largest eigenvalue of B K⁻¹ Bᵀ; 0.01 for alg1 and cfs1, else 2, if absent.",
        ),
        key(
            "inner_tolerance",
            Kind::Number(TOLERANCE),
            "inner_tolerance = 1e-10",
            "For alg1, alg2, cfs1 and cfs2: accuracy of each quadratic program; a hundredth of `tolerance` if absent.",
        ),
        key(
            "memory",
            Kind::Number(POSITIVE),
            "memory = 8",
            "Most memory for stored matrices; what is there if absent.",
        )
        .unit("gigabyte"),
        key("path", PATH, "path = \"auto\"", "How Newton's method gets at the solution.").default("\"auto\""),
    ],
};

const TOLERANCE: Limits = Limits { low: 1e-14, low_included: true, high: 0.1, high_included: true, ..ANY };
const METHOD: Kind = Kind::Choice {
    names: &[
        ("newton", "Newton's method on the law itself"),
        ("alg1", "given friction: squares one by one"),
        ("alg2", "given friction: all squares in one quadratic program"),
        ("smalbe", "given friction: the same with adaptive accuracy"),
        ("discs", "given friction: the discs themselves"),
        ("msa1", "Coulomb: successive approximations"),
        ("msa2", "Coulomb: the same with inexact inner problems"),
        ("cfs1", "msa2 with alg1"),
        ("cfs2", "msa2 with alg2"),
    ],
    absent: &[],
};
const INNER: Kind = Kind::Choice {
    names: &[
        ("alg1", "squares one by one"),
        ("alg2", "all squares in one quadratic program"),
        ("smalbe", "the same with adaptive accuracy"),
        ("discs", "the discs themselves"),
    ],
    absent: &[],
};
const SPLITTING: Kind = Kind::Choice {
    names: &[
        ("no", "all at once"),
        ("partial", "normal, then tangential"),
        ("complete", "normal, first tangential, second tangential"),
    ],
    absent: &[],
};
const COUPLING: Kind = Kind::Choice {
    names: &[("star", "each with the first"), ("chain", "each with the next, as printed in the source paper")],
    absent: &[],
};
const PATH: Kind = Kind::Choice {
    names: &[
        ("auto", "the cheaper one that fits the memory"),
        ("dense", "B K⁻¹ Bᵀ as a dense factor"),
        ("solves", "B K⁻¹ Bᵀ by triangular solves"),
        ("multigrid", "the displacements themselves, without a factor"),
    ],
    absent: &[],
};
