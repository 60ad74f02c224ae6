//! specplan: what a scene needs for a tolerance, and why; a plan for spectrace.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

use clap::{Args, ValueHint};
use serde::{Deserialize, Serialize};

use crate::filter::{Filter, Product, Run};
use crate::options::lossy;
use crate::plan::{Pilot, Plan, Wish, file};
use crate::scene::load;
use crate::stream::Picture;
use crate::stream::output::Output;
use crate::{Error, Result, clap_defaults};

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
    /// Write what was tried, for the eye, in place of the plan
    #[arg(long)]
    pub explain: bool,
}

clap_defaults!(Specplan);

impl Filter for Specplan {
    const NAME: &'static str = "specplan";
    const ABOUT: &'static str = "Find the fewest wavelengths that a scene needs for a colour tolerance";
    const EXAMPLE: &'static str = "specplan scenes/cornell.toml --tolerance 0.5 > cornell.plan && spectrace scenes/cornell.toml --plan cornell.plan > cornell.lux";
    const READS: bool = false;
    const FORMATS: bool = false;

    fn start(self, _: Option<Box<dyn Picture>>, _: &Run) -> Result<Product> {
        let path = self.scene.as_ref().ok_or_else(|| Error::Usage("expected a scene file".into()))?;
        let wish = Wish::new(self.tolerance, self.gain, self.pilot)?;
        let scene = Arc::new(load::load(path)?);
        let (plan, pilot) = wish.plan(&scene).map_err(|e| e.in_file(path))?;
        let text = match self.explain {
            true => explained(&plan, pilot.as_ref()),
            false => file::write(&scene, &path.display().to_string(), &plan, pilot.as_ref(), &wish),
        };
        let write = move |out: &mut Output| out.write_all(text.as_bytes()).map_err(|e| Error::io("standard output", e));
        Ok(Product::Bytes { binary: false, write: Box::new(write) })
    }
}

/// The ladder, rung by rung.
fn explained(plan: &Plan, pilot: Option<&Pilot>) -> String {
    let (spectra, products) = plan.counts;
    let mut text = format!(
        "{spectra} spectra, {products} products of up to four of them\nwavelengths  worst product  of more  bound\n"
    );
    for rung in &plan.tried {
        text += &format!("{:11}  {:13.3}  {:7.3}  {:5.3}\n", rung.asked, rung.worst, rung.deep, rung.bound());
    }
    let chosen = plan.chosen.as_ref().map_or("full bands".into(), |c| format!("{} wavelengths", c.rule.nodes_nm.len()));
    text += &format!("{chosen}: {}\n", plan.why);
    if let Some(p) = pilot {
        let share = 100.0 * p.share();
        text += &format!(
            "pilot: worst {:.3} of {} pixels, the same paths in full bands beside it; {share:.2} % of pixels are no worse, with 99 % confidence\n",
            p.worst, p.pixels
        );
    }
    text
}
