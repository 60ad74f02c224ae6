//! The paper's ways to carry colour, on rendered scenes: full spectra, RGB with white lights, RGB products, the relative colour
//! approximation by its wording and over white, beside a few wavelengths; under one, two and three kinds of lamp, with one to five bounces.
//!
//! `make paper-relative` writes docs/paper-relative-one.csv, -two.csv and -three.csv, and prints docs/paper-relative.md.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use luxpipe::compare::{Difference, Viewing};
use luxpipe::notes::Notes;
use luxpipe::parallel;
use luxpipe::plan::channels::Channels;
use luxpipe::plan::survey::Survey;
use luxpipe::plan::{Ladder, Model};
use luxpipe::render::estimate::{Effort, Quantity, What};
use luxpipe::render::few::{Few, RANGE_NM};
use luxpipe::render::method::Choice;
use luxpipe::render::path;
use luxpipe::render::picture::{Job, Work, render};
use luxpipe::scene::{Scene, load};
use luxpipe::spectral::Sampling;
use luxpipe::stream::Block;

const ROOM: &str = include_str!("room.toml");
const HEAD: &str = include_str!("head.md");
/// Lamps of the three places, by the number of kinds.
const LAMPS: [(&str, &str, [&str; 3]); 3] = [
    ("one", "One kind of lamp", ["A", "A", "A"]),
    ("two", "Two kinds of lamp", ["A", "A", "FL11"]),
    ("three", "Three kinds of lamp", ["A", "FL11", "D65"]),
];
const PATHS: u32 = 64;
const BOUNCES: u32 = 5;

/// What paths carry; the first is full.
const MODELS: [(&str, Option<Model>); 8] = [
    ("80 bands", None),
    ("white lights", Some(Model::Three(Channels::White))),
    ("RGB product", Some(Model::Three(Channels::Product))),
    ("relative, literal", Some(Model::Three(Channels::Literal))),
    ("relative, over white", Some(Model::Three(Channels::Relative))),
    ("4 wavelengths", Some(Model::Wavelengths(4))),
    ("8 wavelengths", Some(Model::Wavelengths(8))),
    ("12 wavelengths", Some(Model::Wavelengths(12))),
];

/// XYZ of all pixels, and the seconds that they took.
fn shot(scene: &Arc<Scene>, few: Option<Arc<Few>>, max_bounces: u32, paths: u32) -> (Vec<f32>, f64) {
    let quantity = match few {
        Some(few) => few.quantity(1).expect("a rule"),
        None => {
            let sampling = Sampling::bins(RANGE_NM.0, RANGE_NM.1, 80).expect("bands");
            Quantity { sampling, range_nm: RANGE_NM, what: What::Xyz, seed: 1, few: None }
        }
    };
    let rows = (0, scene.camera.as_ref().expect("a camera").height);
    let job = Job {
        quantity,
        method: Choice::Path(path::Options { max_bounces, split: 4, pool: false }),
        effort: Work::Each(Effort::Paths(paths)),
        rows,
        progress: false,
        checkpoint: None,
        notes: Notes::default(),
    };
    let begin = Instant::now();
    let mut picture = render(scene.clone(), job, |_| Vec::new()).expect("a render");
    let (mut all, mut block) = (Vec::new(), Block::default());
    while picture.next(&mut block).expect("rows") {
        all.extend_from_slice(&block.data);
    }
    (all, begin.elapsed().as_secs_f64())
}

/// Root mean square, and what 95 % stay below, of Delta E 2000 at the pixels that no lamp is seen in.
fn errors(viewing: &Viewing, got: &[f32], want: &[f32], lamps: &[f32]) -> [f64; 2] {
    let mut each: Vec<Difference> = Vec::new();
    viewing.differences(got, want, &mut each);
    let plain = each.iter().zip(lamps.chunks_exact(3)).filter(|(_, l)| l[1] == 0.0);
    let mut all: Vec<f64> = plain.map(|(d, _)| d.e2000).collect();
    all.sort_by(f64::total_cmp);
    let rms = (all.iter().map(|e| e * e).sum::<f64>() / all.len() as f64).sqrt();
    [rms, all[(all.len() - 1) * 95 / 100]]
}

fn main() -> std::io::Result<()> {
    let tables = std::env::args().nth(1).unwrap_or_else(|| "docs/paper-relative".into());
    parallel::set_threads(0);
    parallel::ready();
    let mut page = String::from(HEAD);
    for (kinds, title, lamps) in LAMPS {
        let text = (1..).zip(lamps).fold(ROOM.to_string(), |t, (i, lamp)| t.replace(&format!("LAMP{i}"), lamp));
        let mut csv = String::from("bounces,model,seconds,delta_e_rms,delta_e_95\n");
        let scene = Arc::new(load::parse(&text, Path::new(".")).expect("the room"));
        let survey = Survey::of(&scene).expect("spectra");
        let seen_lamps = shot(&scene, None, 0, 4).0;
        let _ = writeln!(page, "\n## {title}: {}\n", lamps.join(", "));
        let _ = writeln!(
            page,
            "| carried | {} | time of 64 paths, s |",
            (1..=BOUNCES).map(|b| format!("{b}")).collect::<Vec<_>>().join(" | ")
        );
        let _ = writeln!(page, "|{}", "---|".repeat(BOUNCES as usize + 2));
        let full: Vec<(Vec<f32>, f64)> = (1..=BOUNCES).map(|b| shot(&scene, None, b, PATHS)).collect();
        let mut ladder = Ladder::new(&survey, 10.0);
        for (name, model) in MODELS {
            let few = model.map(|m| {
                let rung = ladder.rung(m, 0.5).expect("a rung");
                Arc::new(rung.few(&survey, &scene).expect("a rule"))
            });
            let mut row = format!("| {name} ");
            let mut last_s = 0.0;
            for (bounces, (want, full_s)) in (1..).zip(&full) {
                let (got, seconds) = match &few {
                    Some(few) => shot(&scene, Some(few.clone()), bounces, PATHS),
                    None => (want.clone(), *full_s),
                };
                let white = scene.white().expect("white").expect("light").xyz();
                let mut y: Vec<f32> = want
                    .chunks_exact(3)
                    .zip(seen_lamps.chunks_exact(3))
                    .filter(|p| p.1[1] == 0.0)
                    .map(|p| p.0[1])
                    .collect();
                y.sort_by(f32::total_cmp);
                let white_y = f64::from(y[y.len() * 99 / 100]);
                let viewing = Viewing { white: white.map(|w| w * white_y), gain: 10.0, shown: None };
                let [rms, p95] = errors(&viewing, &got, want, &seen_lamps);
                let _ = write!(row, "| {rms:.2} / {p95:.2} ");
                let plain = name.replace(',', "");
                let _ = writeln!(csv, "{bounces},{plain},{seconds:.4},{rms:.5},{p95:.5}");
                last_s = seconds;
            }
            let _ = writeln!(page, "{row}| {last_s:.2} |");
        }
        std::fs::write(format!("{tables}-{kinds}.csv"), csv)?;
    }
    print!("{page}");
    Ok(())
}
