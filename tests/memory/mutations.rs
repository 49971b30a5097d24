//! A short run of the fuzzer; the long one is `cargo run --release -p stiction-bench --bin fuzz -- --seconds N`.

use stiction_fixtures::fuzz;

use crate::ALONE;

#[test]
fn mutated_files_neither_panic_nor_take_memory_beyond_their_size() {
    let _alone = ALONE.lock();
    for target in fuzz::TARGETS {
        let seeds = (target.seeds)();
        assert!(seeds.iter().all(|seed| (target.read)(seed)), "{}: a seed is not read", target.name);
        let report = fuzz::fuzz(target, &seeds, 1, &|executions| executions == 4000);
        let told: Vec<&str> = report.findings.iter().map(|(what, _)| &what[..]).collect();
        assert!(told.is_empty(), "{}: {told:?}", target.name);
        // Mutations that all fail at the first byte, or change nothing, would find nothing.
        let share = report.read as f64 / report.executions as f64;
        assert!((0.005..0.9).contains(&share), "{}: {share} are still read", target.name);
    }
}
