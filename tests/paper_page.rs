//! The page of `make paper`: every claim once, nothing from outside, and a word on what is missing.

mod common;
#[path = "../examples/paper_page/page.rs"]
mod page;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use common::root;

fn is_refused(folder: &Path, words: &[&str]) {
    let message = page::run(folder).unwrap_err();
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(words.iter().all(|w| message.contains(w)), "{words:?} not in: {message}");
}

#[test]
fn the_page_has_every_claim_and_needs_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    // Lengths of every remainder by 3, for base64.
    for (i, name) in ["figure3.png", "figure4.png", "figure5.png"].iter().enumerate() {
        let mut bytes = fs::read(root().join("docs/cornell.png")).unwrap();
        bytes.extend(vec![0; i]);
        fs::write(place(name), bytes).unwrap();
    }
    let drawings = [
        "figure6",
        "figure7",
        "figure8",
        "blueflower",
        "tradeoff-cornell-colour",
        "tradeoff-caustic-colour",
        "tradeoff-spiky-plans",
    ];
    for name in drawings {
        fs::copy(root().join("docs/methods.svg"), place(&format!("{name}.svg"))).unwrap();
    }
    page::run(folder.path()).unwrap();
    let html = fs::read_to_string(place("index.html")).unwrap();
    let claims = fs::read_to_string(root().join("docs/claims.csv")).unwrap();
    let rows = claims.lines().filter(|l| !l.starts_with('#')).count() - 1;
    let verdicts = html.matches("<span class=\"verdict").count();
    // Each row has one, and each kind once more in the summary.
    assert!((rows + 3..=rows + 8).contains(&verdicts), "{verdicts} verdicts for {rows} claims");
    assert!(!html.contains("{{") && !html.contains("<script") && !html.contains("<link"));
    let sources = html.split(" src=\"").skip(1);
    assert!(sources.clone().count() >= 3 && sources.clone().all(|s| s.starts_with("data:")));
    let ids: BTreeSet<&str> = html.split(" id=\"").skip(1).filter_map(|s| s.split('"').next()).collect();
    for link in html.split(" href=\"").skip(1).filter_map(|s| s.split('"').next()) {
        match link.strip_prefix('#') {
            Some(id) => assert!(ids.contains(id), "no place {id}"),
            None if link.contains("://") => {}
            None => {
                let file = link.split('#').next().unwrap().trim_start_matches("../../");
                assert!(root().join(file).exists(), "{link} leads nowhere");
            }
        }
    }
    assert!(!place("index.html.part").exists());
    fs::remove_file(place("figure4.png")).unwrap();
    is_refused(folder.path(), &["figure4.png", "make paper-tone"]);
    fs::copy(place("figure3.png"), place("figure4.png")).unwrap();
    fs::remove_file(place("tradeoff-spiky-plans.svg")).unwrap();
    is_refused(folder.path(), &["tradeoff-spiky-plans.svg", "make"]);
    is_refused(&place("none"), &["none"]);
}
