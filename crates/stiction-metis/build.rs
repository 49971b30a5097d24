//! Compiles the C files, which are one translation unit.

fn main() {
    println!("cargo:rerun-if-changed=c");
    cc::Build::new()
        .file("c/nested_dissection.c")
        .warnings(false)
        // The same arithmetic on all machines, and what METIS takes for granted.
        .flag_if_supported("-ffp-contract=off")
        .flag_if_supported("-fno-strict-aliasing")
        .flag_if_supported("-fwrapv")
        .define("_CRT_SECURE_NO_WARNINGS", None)
        .compile("stiction_metis");
}
