//! Keys of `[[contact]]` and of the laws of friction.

use super::super::kind::{ANY, Kind, Limits, NOT_NEGATIVE, POSITIVE, Rules, choice, key};
use super::obstacle::OBSTACLE;
use super::{NAMES, POINT, REGION};

pub(super) static CONTACT: Rules = Rules {
    doc: "A surface that may touch a rigid obstacle or another surface.",
    one_of: &[],
    keys: &[
        key("name", Kind::Text, "name = \"sole\"", "Name of the pair in the results; that of its group if absent."),
        key("on", REGION, "on = \"z-min\"", "The surface: a group, a list of groups or { box = [[x0, y0, z0], [x1, y1, z1]] }. Against another surface also groups of nodes that make up no face: each of these nodes then meets the other surface by itself, at the place nearest to it.").required(),
        key("against", Kind::Either(&[Kind::Table(&OBSTACLE), Kind::Text, NAMES]), "against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }", "A rigid obstacle, or another surface of the mesh: a group or a list of groups.")
            .required(),
        key("gap", Kind::Either(&[GAP_NAME, Kind::Number(ANY), Kind::Table(&CLOSED)]), "gap = \"closed\"", "Between two surfaces: how far apart they are before anything is loaded: \"as-meshed\", \"closed\", { closed_within = length }, { closed_at = \"group\" } or a number. A number holds wherever they meet; a negative one is an interference fit.")
            .default("\"as-meshed\"")
            .unit("length"),
        key("slave", SLAVE, "slave = \"on\"", "Between two surfaces: which of them carries the contact points; if absent that of a much softer body, or else the finer one, or else that of the softer body. Faces that are prescribed altogether never do if the other surface can."),
        key("search", Kind::Number(POSITIVE), "search = 0.1", "Between two surfaces: how far apart they may be, or overlap, and still meet; a quarter of the diagonal of the smaller one if absent.")
            .unit("length"),
        key("friction", Kind::Either(&[FRICTION_NAME, Kind::Table(&FRICTION)]), "friction = { coulomb = 0.3 }", "The law of friction: \"none\", \"bonded\", { coulomb = coefficient }, { coulomb = [0.1, 0.3], direction = [1, 0, 0] }, { coulomb = 0.6, cohesion = 2e5 }, { tresca = stress } or { tresca = force, nodal = true }.")
            .required(),
        key("stiffness", Kind::Table(&STIFFNESS), "stiffness = { normal = 1e12, tangential = 5e11 }", "How the interface yields, as gaskets and rock joints do: overlap is the pressure over `normal`. Hard contact if absent."),
        key("initial_stress", Kind::List { of: &Kind::Field, from: 6, to: 6 }, "initial_stress = [-2e6, -2e6, -5e6, 0, 0, 0]", "The stress xx, yy, zz, yz, xz, xy before anything is loaded, tension positive: numbers or expressions in x, y, z. What it presses and shears along the interface are contact forces the bodies are in equilibrium with; loads, displacements and stresses count from there, contact forces are the whole.")
            .unit("stress"),
        key("from", Kind::Text, "from = \"draw\"", "Name of the step with which the contact begins: gaps are those of the surfaces as they stand then, bonded ones stay as they are; the first if absent."),
        key("until", Kind::Text, "until = \"press\"", "Name of the step after which the contact is taken out; the last if absent."),
        key("without", NAMES, "without = [\"turn\"]", "Names of steps among these in which the contact is out."),
        key("bonded_until", Kind::Text, "bonded_until = \"pull\"", "Name of the step through which the surfaces stay as they are, whatever `friction` says: it holds afterwards."),
        key("wear", Kind::Number(POSITIVE), "wear = 1e-8", "Archard's coefficient of wear: the depth worn away is this times the pressure times the path slid, see `contact.csv` of load steps. It changes no other result: the surfaces stay as they are.")
            .unit("1/stress"),
    ],
};

const GAP_NAME: Kind =
    choice(&[("as-meshed", "what the meshes say, overlaps included"), ("closed", "none wherever they meet")]);
static CLOSED: Rules = Rules {
    doc: "A gap that is closed in places; elsewhere it is that of the meshes.",
    one_of: &["closed_within", "closed_at"],
    keys: &[
        key(
            "closed_within",
            Kind::Number(NOT_NEGATIVE),
            "closed_within = 0.01",
            "Where the meshes are no farther apart than this, or overlap, they touch; 0 closes overlaps alone.",
        )
        .unit("length"),
        key(
            "closed_at",
            Kind::Either(&[Kind::Text, NAMES]),
            "closed_at = \"rim\"",
            "A group or a list of groups: their nodes touch. Only nodes of the surface that carries the contact points count.",
        ),
    ],
};
static STIFFNESS: Rules = Rules {
    doc: "Stiffness of an interface per area.",
    one_of: &[],
    keys: &[
        key("normal", Kind::Number(POSITIVE), "normal = 1e12", "Pressure over the overlap it causes.")
            .required()
            .unit("stress per length"),
        key(
            "tangential",
            Kind::Number(POSITIVE),
            "tangential = 5e11",
            "Shear over the elastic displacement along the interface it causes below the bound of friction; that of `normal` if absent.",
        )
        .unit("stress per length"),
    ],
};
const SLAVE: Kind = choice(&[("on", "the surface of `on`"), ("against", "the surface of `against`")]);

const FRICTION_NAME: Kind =
    choice(&[("none", "no friction"), ("bonded", "the surface sticks wherever it is: no slip, whatever the force")]);

static FRICTION: Rules = Rules {
    doc: "A law of friction.",
    one_of: &["coulomb", "tresca"],
    keys: &[
        key(
            "coulomb",
            Kind::Either(&[Kind::Number(COEFFICIENT), Kind::Field, COEFFICIENTS, Kind::Table(&ARRAY)]),
            "coulomb = 0.3",
            "Coefficient of friction; a number, an expression in x, y, z, and, if there is only one coefficient, t, { array = \"mu\" }, or two of these: along `direction` and across it.",
        ),
        key(
            "direction",
            POINT,
            "direction = [1, 0, 0]",
            "With two coefficients: where the first holds; of any length, its part along the surface counts.",
        ),
        key(
            "limit",
            Kind::Number(POSITIVE),
            "limit = 5e7",
            "With coulomb: the shear stress friction does not exceed, whatever the pressure; with two coefficients where friction is the largest.",
        )
        .unit("stress"),
        key(
            "cohesion",
            Kind::Either(&[Kind::Number(NOT_NEGATIVE), Kind::Field, Kind::Table(&ARRAY)]),
            "cohesion = 2e5",
            "With coulomb: the shear stress that the interface carries without pressure, where the surfaces touch; a number, an expression in x, y, z or { array = \"c\" }. With coulomb = 0 it is the whole strength in shear.",
        )
        .unit("stress"),
        key(
            "tension",
            Kind::Either(&[Kind::Number(NOT_NEGATIVE), Kind::Field, Kind::Table(&ARRAY)]),
            "tension = 1e5",
            "With cohesion: the tensile stress up to which the interface does not open; cohesion over coefficient, the apex of the cone, where that is less.",
        )
        .default("0")
        .unit("stress"),
        key(
            "cohesion_lost",
            COHESION_LOST,
            "cohesion_lost = \"on slip\"",
            "With cohesion: whether a point loses cohesion and tensile strength for good once it slips or opens.",
        )
        .default("\"never\""),
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

const COHESION_LOST: Kind = choice(&[
    ("on slip", "a point that slips or opens in a load step keeps friction alone from then on; needs load steps"),
    ("never", "ideally plastic: the strength stays; a point that has opened still carries the tension"),
]);

const COEFFICIENTS: Kind = Kind::List { of: &Kind::Either(&[Kind::Field, Kind::Table(&ARRAY)]), from: 2, to: 2 };

static ARRAY: Rules = Rules {
    doc: "A coefficient of friction or a strength from the mesh file.",
    one_of: &[],
    keys: &[key(
        "array",
        Kind::Text,
        "array = \"mu\"",
        "Name of an array of numbers of the mesh file. On points it is read at the contact points; on cells it holds for their faces, or for surface elements of the file, and a point has the mean of the faces around it by area. Between two surfaces it is read on that of `on`, or on the one that `slave` names.",
    )
    .required()],
};

const COEFFICIENT: Limits = Limits {
    remedy: "the direction of friction follows from the slip, the coefficient only says how much",
    ..NOT_NEGATIVE
};
