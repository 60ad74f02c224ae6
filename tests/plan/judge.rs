//! A plan held against full bands on the same paths.

use std::path::Path;
use std::sync::Arc;

use crate::common;
use luxpipe::compare::Viewing;
use luxpipe::plan::survey::Survey;
use luxpipe::plan::{Wish, products};
use luxpipe::render::few::Few;
use luxpipe::render::method::Choice;
use luxpipe::render::path;
use luxpipe::scene::load;

/// What came of it.
pub struct Verdict {
    /// Wavelengths; `None` for bands.
    pub wavelengths: Option<usize>,
    /// Where paths end.
    pub depth: Option<u32>,
    /// What the plan said the error would stay below.
    pub bound: f64,
    /// Largest Delta E 2000 of the picture.
    pub worst: f64,
    /// Seconds that the plan took.
    pub seconds: f64,
}

/// XYZ of all pixels, by so many paths each.
fn picture(text: &str, few: Option<&Arc<Few>>, paths: u32, max_bounces: Option<u32>) -> Vec<[f64; 3]> {
    let scene = load::parse(text, Path::new(".")).unwrap();
    let mut job = common::job(&scene, 80, paths, 1);
    if let Some(few) = few {
        job.quantity = few.clone().quantity(job.quantity.seed).unwrap();
    }
    if let Some(max_bounces) = max_bounces {
        job.method = Choice::Path(path::Options { max_bounces, split: 1, pool: false });
    }
    common::rendered(scene, job).chunks_exact(3).map(|p| [0, 1, 2].map(|c| f64::from(p[c]))).collect()
}

/// Plans a scene, renders it both ways, and looks at it as a viewer would that lifts dark pixels ten times.
pub fn judge(text: &str, tolerance: f64, pilot: usize, paths: u32) -> Verdict {
    let scene = Arc::new(load::parse(text, Path::new(".")).unwrap());
    let start = std::time::Instant::now();
    let again = |without| load::parse_without(text, Path::new("."), without);
    let plan = Wish::new(tolerance, 10.0, pilot).unwrap().plan(&scene, &again).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    let survey = Survey::of(&scene).unwrap();
    let bound = plan.bound();
    let depth = plan.depth.map(|d| d.max_bounces);
    let few = plan.chosen.as_ref().map(|c| &c.1);
    let wavelengths = plan.chosen.as_ref().map(|c| c.0.rule.nodes_nm.len());
    let (want, got) = (picture(text, None, paths, None), picture(text, few, paths, depth));
    // Lamps that are seen say nothing of what they light.
    let lamps = picture(text, None, 16, Some(0));
    let seen: Vec<usize> = (0..want.len()).filter(|i| lamps[*i][1] == 0.0 && want[*i][1] > 0.0).collect();
    let mut luminances: Vec<f64> = seen.iter().map(|i| want[*i][1]).collect();
    luminances.sort_by(f64::total_cmp);
    let mean = products::viewing(&survey, 10.0).white;
    let yn = luminances[luminances.len() * 99 / 100];
    let viewing = Viewing { white: mean.map(|w| w / mean[1] * yn), gain: 10.0, shown: None };
    let worst = seen.iter().map(|i| products::error(&viewing, got[*i], want[*i])).fold(0.0, f64::max);
    Verdict { wavelengths, depth, bound, worst, seconds }
}
