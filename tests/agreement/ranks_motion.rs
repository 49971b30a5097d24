//! Obstacles that move, on several ranks against the same case on one.

use std::ops::ControlFlow;

use super::ranks::{agrees, case_of, on_ranks};
use stiction::ranks::threads;
use stiction::run::{prepare, solve_on_ranks};

/// A block held at its top on a plane that rises and then moves to the side and part of the way back; without steps it stands
/// where it is at the end.
fn on_a_plane_that_moves(element: &str, steps: bool) -> String {
    let motion = if steps {
        "[\"1e-5*min(max(t - 1, 0), 3 - t)\", \"2e-6*t\", \"1e-5*min(t, 1)\"]"
    } else {
        "[1e-5, 4e-6, 1.2e-5]"
    };
    let step = "[[step]]\nname = \"press\"\nuntil = 1\n[[step]]\nname = \"push\"\nuntil = 2.5\nincrements = 3\n";
    format!(
        "[mesh]\nblock = {{ size = [2, 1, 1], cells = [16, 8, 8], {element} }}\n\
         [materials.steel]\nyoung = 21.19e10\npoisson = 0.277\n[[fix]]\non = \"z-max\"\n\
         [[load]]\non = \"x-max\"\ntraction = [0, 1e5, 0]\n[[contact]]\non = \"z-min\"\n\
         against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }}, motion = {motion} }}\n\
         friction = {{ coulomb = 0.15 }}\n{}",
        if steps { step } else { "" }
    )
}

#[test]
fn obstacles_that_move_are_the_same_on_ranks() {
    agrees(&on_a_plane_that_moves("element = \"hex8\"", true), &[1, 2, 3, 4, 8]);
    agrees(&on_a_plane_that_moves("element = \"tet4\"", false), &[2, 4]);
}

/// A plane that the mesh overlaps pushes the body out in the first step, on ranks too.
#[test]
fn what_overlaps_in_the_mesh_is_pushed_out_by_load_steps_on_ranks_too() {
    let moves = on_a_plane_that_moves("element = \"hex8\"", true).replace("point = [0, 0, 0]", "point = [0, 0, 1e-6]");
    agrees(&moves, &[1, 2, 4]);
    let rests = moves.replace(", motion = [\"1e-5*min(max(t - 1, 0), 3 - t)\", \"2e-6*t\", \"1e-5*min(t, 1)\"]", "");
    assert!(rests != moves);
    agrees(&rests, &[2]);
}

/// Only what moves relative to the other side loads a body: a block that is pushed down on a plane at rest has the forces of one at
/// rest that the plane is pushed up to.
#[test]
fn a_plane_that_rises_presses_as_a_body_that_sinks() {
    let rises = on_a_plane_that_moves("element = \"hex8\"", false).replace("[1e-5, 4e-6, 1.2e-5]", "[0, 0, 1.2e-5]");
    let sinks = rises
        .replace(", motion = [0, 0, 1.2e-5]", "")
        .replace("on = \"z-max\"\n", "on = \"z-max\"\nvalue = [0, 0, -1.2e-5]\n");
    let [a, b] = [rises, sinks].map(|text| on_ranks(&case_of(&text, "1e-10"), 3).1.answer.contact.normal_force);
    assert!(a > 0.0 && (a - b).abs() <= 1e-9 * a, "{a} {b}");
}

#[test]
fn an_obstacle_that_gets_to_nodes_that_are_held_is_refused_by_ranks_too() {
    let text = on_a_plane_that_moves("element = \"hex8\"", true).replace("on = \"z-max\"", "on = \"x-min\"");
    let case = case_of(&text, "1e-8");
    let expected = prepare(&case).unwrap_err().to_string();
    assert!(expected.contains("gets") && expected.contains("into the obstacle"), "{expected}");
    for found in threads(3, |ranks| {
        solve_on_ranks(&case, &ranks, &mut |_| ControlFlow::Continue(())).map(|_| ()).unwrap_err().to_string()
    }) {
        assert_eq!(found, expected);
    }
}
