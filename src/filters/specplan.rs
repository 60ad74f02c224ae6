//! specplan: what a scene needs for a tolerance, and why; a plan for spectrace.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

use clap::{Args, ValueHint};
use serde::{Deserialize, Serialize};

use crate::error::printable;
use crate::filter::{Filter, Product, Run};
use crate::filters::positive;
use crate::options::lossy;
use crate::plan::channels::Channels;
use crate::plan::{Model, Plan, Wish, file};
use crate::scene::load;
use crate::stream::Picture;
use crate::stream::output::Output;
use crate::{Error, Result, clap_defaults, usage};

/// Options of `specplan`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Specplan {
    /// Scene to look at (TOML)
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath, required = true)]
    #[serde(serialize_with = "lossy")]
    pub scene: Option<PathBuf>,
    /// Colour error of any pixel that is put up with, Delta E 2000
    #[arg(long, value_name = "DE", default_value_t = 0.5)]
    pub tolerance: f64,
    /// Dark pixels are looked at up to so many times brighter
    #[arg(long, value_name = "FACTOR", default_value_t = 10.0)]
    pub gain: f64,
    /// Pixels that the plan is tried on, full bands beside it; 0 for none
    #[arg(long, value_name = "N", default_value_t = 1000)]
    pub pilot: usize,
    /// Seconds that the picture may take: the plan then says how many paths a pixel
    #[arg(long, value_name = "SECONDS")]
    pub time: Option<f64>,
    /// What paths carry whatever its error: relative (colours), 4, 8, 12, 16 or so many wavelengths, bands; or literal, product, white, what
    /// renderers of RGB do (docs/plan.md)
    #[arg(long, value_name = "MODEL")]
    pub model: Option<String>,
    /// Wavelengths that are good under other lamps too: for spectrace --per-light and relight
    #[arg(long)]
    pub relight: bool,
    /// Write what was tried, for the eye, in place of the plan
    #[arg(long)]
    pub explain: bool,
}

clap_defaults!(Specplan);

/// Pixels of a pilot at most.
const MOST_PIXELS: usize = 1_000_000;

impl Filter for Specplan {
    const NAME: &'static str = "specplan";
    const ABOUT: &'static str =
        "Find the cheapest model that a scene needs for a colour tolerance: wavelengths, effects, depth";
    const EXAMPLE: &'static str = "specplan scenes/cornell.toml --tolerance 0.5 > cornell.plan && spectrace scenes/cornell.toml --plan cornell.plan > cornell.lux";
    const READS: bool = false;
    const FORMATS: bool = false;

    fn look_ahead(&self) -> Result<Option<usize>> {
        self.scene.as_deref().map(load::load).transpose().map(|_| None)
    }

    fn start(self, _: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let path = self.scene.as_ref().ok_or_else(|| Error::Usage("expected a scene file".into()))?;
        let mut wish = Wish::new(self.tolerance, self.gain, self.pilot)?;
        wish.time = self.time;
        wish.model = self.model.as_deref().map(model).transpose()?;
        wish.relit = self.relight;
        positive("--time", self.time)?;
        if self.time.is_some_and(|t| t >= 1e9) || self.pilot > MOST_PIXELS {
            return usage!("--time is below 1e9 seconds, --pilot at most {MOST_PIXELS} pixels");
        }
        let scene = Arc::new(load::load(path)?);
        run.notes.extend(&scene.remarks);
        let plan = wish.plan(&scene, &|without| load::load_without(path, without)).map_err(|e| e.in_file(path))?;
        let text = match self.explain {
            true => explained(&plan),
            false => file::write(&scene, &path.display().to_string(), &plan, &wish),
        };
        let write = move |out: &mut Output| out.write_all(text.as_bytes()).map_err(|e| Error::io("standard output", e));
        Ok(Product::Bytes { binary: false, write: Box::new(write) })
    }
}

/// A word of `--model`.
fn model(word: &str) -> Result<Option<Model>> {
    match (word, word.parse(), word.parse::<Channels>()) {
        ("bands", ..) => Ok(None),
        (_, Ok(k @ 1..=32), _) => Ok(Some(Model::Wavelengths(k))),
        (_, _, Ok(channels)) => Ok(Some(Model::Three(channels))),
        _ => usage!(
            "--model {}: relative, literal, product, white, 1 to 32 wavelengths or bands",
            printable(word.as_bytes())
        ),
    }
}

/// The ladder, rung by rung.
fn explained(plan: &Plan) -> String {
    let (spectra, products) = plan.counts;
    let mut text = String::new();
    for e in &plan.effects {
        text += &format!("{}: {}, without it {:.3}\n", e.name, if e.on { "on" } else { "off" }, e.bound);
    }
    text += &match &plan.depth {
        Some(d) => format!("depth: {} bounces; without paths of more than half of that {:.3}\n", d.max_bounces, d.tail),
        None => "depth: as deep as paths go\n".into(),
    };
    text += &format!("{spectra} spectra, {products} products of up to four of them\n");
    text += "carried      worst product  of more  bound\n";
    for rung in &plan.tried {
        let model = rung.model.to_string();
        text += &format!("{model:11}  {:13.3}  {:7.3}  {:5.3}\n", rung.worst, rung.deep, rung.bound());
    }
    text += &format!("{}: {}\n", plan.carried("full bands"), plan.why);
    if let Some(p) = &plan.flight {
        let share = 100.0 * p.share();
        text += &format!(
            "pilot: worst {:.3} of {} pixels, the same paths in full beside it; {share:.2} % of pixels are no worse, with 99 % confidence\n",
            p.worst, p.pixels
        );
    }
    if let Some(samples) = plan.samples {
        text += &format!("effort: {samples} paths a pixel\n");
    }
    text
}
