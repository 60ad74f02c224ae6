//! Lists spectra/*.csv so that the library can embed them: the files are the only copy of the numbers.

use std::fmt::Write;
use std::path::Path;
use std::{env, fs};

fn main() {
    println!("cargo:rerun-if-changed=spectra");
    let root = env::var("CARGO_MANIFEST_DIR").expect("cargo sets it");
    let mut names: Vec<String> = fs::read_dir(Path::new(&root).join("spectra"))
        .expect("the folder spectra/ belongs to the source")
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter_map(|name| name.strip_suffix(".csv").map(str::to_string))
        .collect();
    names.sort();
    let mut code = String::from("&[\n");
    for name in names {
        let path = format!("{root}/spectra/{name}.csv");
        println!("cargo:rerun-if-changed={path}");
        writeln!(code, "({name:?}, include_str!({path:?})),").expect("writing to a string");
    }
    code.push_str("]\n");
    let out = env::var("OUT_DIR").expect("cargo sets it");
    fs::write(Path::new(&out).join("builtin.rs"), code).expect("cargo's output folder is writable");
}
