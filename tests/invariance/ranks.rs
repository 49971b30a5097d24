//! The same ranks give the same bits, in every run and on any number of threads in each of them.

use std::ops::ControlFlow;

use rayon::ThreadPoolBuilder;
use stiction::io::case;
use stiction::ranks::threads;
use stiction::run::solve_on_ranks;

#[test]
fn the_same_ranks_give_the_same_bits_on_any_number_of_threads() {
    let text = "[mesh]\nblock = { size = [3, 1, 1], cells = [30, 10, 10], element = \"hex8\" }\n\
                [materials.steel]\nyoung = 21.19e10\npoisson = 0.277\n[[fix]]\non = \"x-min\"\n\
                [[load]]\non = \"z-max\"\ntraction = [1e5, 2e5, -1e6]\n\
                [[contact]]\non = \"z-min\"\nagainst = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\n\
                friction = { coulomb = 0.35 }\n";
    let bodies = "[mesh.parts.a]\nblock = { size = [2, 1, 1], cells = [16, 8, 8], element = \"hex8\" }\n\
                  [mesh.parts.b]\nblock = { size = [2.2, 1.1, 0.5], cells = [13, 7, 4], element = \"tet4\" }\n\
                  move = [0, 0, -0.5]\n[materials.steel]\nyoung = 21.19e10\npoisson = 0.277\n[[fix]]\non = \"b.z-min\"\n\
                  [[load]]\non = \"a.z-max\"\ntraction = [2e5, 0, \"-1e6*(2 - x/2)\"]\n\
                  [[contact]]\non = \"a.z-min\"\nagainst = \"b.z-max\"\nfriction = { coulomb = 0.4 }\n";
    [text, bodies].into_iter().for_each(same_bits);
}

fn same_bits(text: &str) {
    let case = case::parse(text, "case.toml", &[]).unwrap();
    let run = |count: usize| {
        threads(4, |ranks| {
            let pool = ThreadPoolBuilder::new().num_threads(count).build().unwrap();
            pool.install(|| {
                let answer = solve_on_ranks(&case, &ranks, &mut |_| ControlFlow::Continue(())).unwrap();
                let bits = |(node, u): (u64, [f64; 3])| (node, u.map(f64::to_bits));
                let u: Vec<(u64, [u64; 3])> = answer.displacements().into_iter().map(bits).collect();
                (
                    u,
                    answer.summary.answer.counts.cycles,
                    answer.summary.answer.contact,
                    answer.summary.answer.certificate,
                )
            })
        })
    };
    let first = run(1);
    assert!(first[0].1 > 5 && first.iter().all(|part| !part.0.is_empty()));
    for count in [1, 3] {
        assert!(run(count) == first, "{count} threads");
    }
}
