//! Lists spectra/*.csv, displays/*.toml and palettes/*.csv so that the library can embed them: the files are the only copy of the numbers.

use std::fmt::Write;
use std::path::Path;
use std::{env, fs};

fn main() {
    list("spectra", "csv");
    list("displays", "toml");
    list("palettes", "csv");
}

/// Writes OUT_DIR/FOLDER.rs: a slice of (name without suffix, text), sorted.
fn list(folder: &str, suffix: &str) {
    println!("cargo:rerun-if-changed={folder}");
    let root = env::var("CARGO_MANIFEST_DIR").expect("cargo sets it");
    let mut names: Vec<String> = fs::read_dir(Path::new(&root).join(folder))
        .expect("the folder belongs to the source")
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter_map(|name| name.strip_suffix(&format!(".{suffix}")).map(str::to_string))
        .collect();
    names.sort();
    let mut code = String::from("&[\n");
    for name in names {
        let path = format!("{root}/{folder}/{name}.{suffix}");
        println!("cargo:rerun-if-changed={path}");
        writeln!(code, "({name:?}, include_str!({path:?})),").expect("writing to a string");
    }
    code.push_str("]\n");
    let out = env::var("OUT_DIR").expect("cargo sets it");
    fs::write(Path::new(&out).join(format!("{folder}.rs")), code).expect("cargo's output folder is writable");
}
