//! Every block of docs/cookbook.md, pasted into a shell: it succeeds, complains of nothing, and leaves what it names.

mod common;

use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

use common::{program, root};

/// The shell blocks of a page.
fn blocks(page: &str) -> Vec<&str> {
    page.split("```sh\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect()
}

/// The paths under out/cookbook that a block spells out; those with a variable or a star in them are not spelt out.
fn named(block: &str) -> Vec<&str> {
    let in_path = |c: char| c.is_ascii_alphanumeric() || "/._-".contains(c);
    let ends = |at: usize| block[at..].find(|c: char| !in_path(c)).map_or(block.len(), |length| at + length);
    let spelt = |end: usize| !block[end..].starts_with(['$', '*', '{']);
    let paths = block.match_indices("out/cookbook").map(|(at, _)| (at, ends(at)));
    paths.filter(|(_, end)| spelt(*end)).map(|(at, end)| block[at..end].trim_end_matches(['/', '.'])).collect()
}

/// All files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// A PNG that decodes and has more than one colour.
fn is_a_picture(file: &Path) {
    let bytes = fs::read(file).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    let size = reader.info().bytes_per_pixel();
    assert!(pixels.chunks_exact(size).any(|p| p != &pixels[..size]), "{} is of one colour", file.display());
}

/// Runs a block in a folder of its own, in which the repository's inputs are.
fn works(block: &str) {
    let folder = tempfile::tempdir().unwrap();
    for name in ["scenes", "tests", "spectra", "displays", "pipelines"] {
        symlink(root().join(name), folder.path().join(name)).unwrap();
    }
    let path = format!("{}:{}", program("luxpipe").parent().unwrap().display(), std::env::var("PATH").unwrap());
    let mut shell = Command::new("sh");
    let output = shell.args(["-eu", "-c", block]).env("PATH", path).current_dir(folder.path()).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{block}\n{message}");
    assert!(message.is_empty(), "{block}\n{message}");
    let names = named(block);
    assert!(!names.is_empty(), "{block}\nwrites nothing to out/cookbook");
    for name in names {
        assert!(folder.path().join(name).exists(), "{block}\nleft no {name}");
    }
    let left = files(&folder.path().join("out/cookbook"));
    assert!(!left.is_empty(), "{block}\nleft nothing");
    for file in &left {
        assert!(fs::metadata(file).unwrap().len() > 0, "{block}\nleft {} empty", file.display());
        if file.extension().is_some_and(|e| e == "png") {
            is_a_picture(file);
        }
    }
    let mut entries: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    entries.sort();
    assert_eq!(entries, ["displays", "out", "pipelines", "scenes", "spectra", "tests"], "{block}");
}

#[test]
fn every_block_works() {
    let page = fs::read_to_string(root().join("docs/cookbook.md")).unwrap();
    assert!(page.lines().filter(|line| line.starts_with("## ")).count() >= 10);
    let blocks = blocks(&page);
    assert!(blocks.len() >= 9);
    blocks.into_iter().for_each(works);
}

#[test]
fn paths_are_found_in_a_block() {
    let block = "mkdir -p out/cookbook/a\nx > out/cookbook/a/b.png\ny out/cookbook/$f.lux a/*.exr \"out/cookbook/c\"";
    assert_eq!(named(block), ["out/cookbook/a", "out/cookbook/a/b.png", "out/cookbook/c"]);
    assert_eq!(blocks("a\n```sh\nb\n```\n```toml\nc\n```\n```sh\nd\n```\n"), ["b\n", "d\n"]);
}
