//! Complete decks on ranks: rank 0 reads them, and the answers are those of one machine.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use stiction::io::case::MeshSource;
use stiction::io::deck;
use stiction::ranks::threads;
use stiction::run::{case_of_deck, solve_on_ranks};

use super::ranks::{are_as_on_one, each_with_its_own};

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/decks").join(name)
}

fn overrides() -> Vec<(String, String)> {
    vec![("solver.tolerance".into(), "1e-10".into())]
}

/// Only rank 0 has a mesh, and its answer is the one of a run without ranks.
fn agrees(name: &str, sizes: &[usize]) {
    let (path, set) = (path(name), overrides());
    let read = |ranks: &dyn stiction::ranks::Ranks| {
        let (case, _) = case_of_deck(&path, &[], &set, ranks).unwrap_or_else(|error| panic!("{name}: {error}"));
        let MeshSource::Given(given) = &case.mesh.source else { panic!("{name}") };
        assert_eq!(given.0.nodes.is_empty(), ranks.rank() != 0);
        case
    };
    let case = deck::read(&path, &[]).unwrap().case(&set).unwrap();
    are_as_on_one(&case, sizes, &|size| each_with_its_own(&read, size));
}

#[test]
fn a_deck_on_ranks_is_that_on_one() {
    // Contact of nodes, of pairs that match and do not, adjusted, tied, in turned directions, of plane and revolved elements.
    for name in ["nodes", "clearance", "adjusted-set", "tied", "turned", "plane-stress", "revolved"] {
        agrees(&format!("{name}.inp"), &[1, 2]);
    }
    // Steps of other friction, and a bolt without contact.
    agrees("changed-friction.inp", &[1, 2]);
    agrees("bolt.inp", &[1, 2]);
}

#[test]
fn what_is_wrong_with_a_deck_is_told_by_all_ranks() {
    let refusal = |path: &Path, set: &[(String, String)], words: &str| {
        let errors = threads(3, |ranks| case_of_deck(path, &[], set, &*ranks).map(|_| ()).unwrap_err());
        assert!(errors.iter().all(|error| *error == errors[0]) && errors[0].to_string().contains(words), "{errors:?}");
    };
    refusal(&path("none.inp"), &[], "none.inp");
    // At its line of the deck, which ranks without the mesh know as well.
    refusal(&path("tied.inp"), &[("materials.none.young".into(), "1".into())], "materials.none.young");
    let errors = threads(2, |ranks| {
        let (case, _) = case_of_deck(&path("sector.inp"), &[], &[], &*ranks).unwrap();
        solve_on_ranks(&case, &ranks, &mut |_| ControlFlow::Continue(())).map(|_| ()).unwrap_err()
    });
    assert!(errors[0] == errors[1] && errors[0].place == "sector.inp, line 54", "{errors:?}");
}
