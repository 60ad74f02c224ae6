//! What a plan says, or one made on the way: it takes the place of options.

use std::sync::Arc;

use super::{Effect, Quantity, Solver, Spectrace};
use crate::material::read::Without;
use crate::notes::Notes;
use crate::plan::{Wish, file};
use crate::render::few::Few;
use crate::scene::Scene;
use crate::{Result, usage};

/// Pixels that a plan made on the way is tried on.
const PILOT: usize = 1000;

/// The options to render by, the scene and what it is read without, and what paths carry in place of bands.
type Planned = (Spectrace, Without, Arc<Scene>, Option<Arc<Few>>);

impl Spectrace {
    /// Effects that the options leave out.
    pub(super) fn without(&self) -> Result<Without> {
        let out = |effect| self.without.contains(&effect);
        let without = Without {
            polarization: out(Effect::Polarization),
            fluorescence: out(Effect::Fluorescence),
            dispersion: out(Effect::Dispersion),
        };
        if without.polarization && self.quantity == Quantity::Stokes {
            return usage!("--output stokes is of nothing but polarization: not --without it");
        }
        Ok(without)
    }

    /// As a plan has it.
    pub(super) fn planned(
        &self,
        scene: Arc<Scene>,
        load: &dyn Fn(Without) -> Result<Scene>,
        notes: &Notes,
    ) -> Result<Planned> {
        let own = self.without()?;
        if self.plan.is_none() && self.tolerance.is_none() {
            return Ok((self.clone(), own, scene, None));
        }
        if self.quantity != Quantity::Xyz || self.report {
            return usage!("--plan and --tolerance go with --output xyz: a few wavelengths are no spectrum");
        }
        let (orders, few) = match &self.plan {
            Some(path) => (file::read(path, &scene)?, None),
            None => {
                let mut wish = Wish::new(self.tolerance.unwrap_or_default(), self.gain, PILOT)?;
                wish.relit = self.per_light;
                let plan = wish.plan(&scene, &|without| load(own.or(without)))?;
                notes.add(format!("--tolerance {}: {}", wish.tolerance, plan.told(self.bands)));
                let few = plan.chosen.map(|c| c.1);
                let max_bounces = plan.depth.map(|d| d.max_bounces);
                (file::Orders { without: plan.without, max_bounces, ..file::Orders::default() }, few)
            }
        };
        let without = own.or(orders.without);
        let scene = if without == own { scene } else { Arc::new(load(without)?) };
        let few = match few {
            None => orders.wavelengths.few(&scene)?.map(Arc::new),
            few => few,
        };
        if self.per_light && few.as_ref().is_some_and(|f| f.converted.is_some()) {
            return usage!(
                "--per-light: the plan's channels are no wavelengths, and other lamps cannot be told by them"
            );
        }
        let mut planned = self.clone();
        // Where the other methods end is their own.
        if self.method == Solver::Path {
            planned.max_bounces = self.max_bounces.or(orders.max_bounces);
        }
        if self.samples == Spectrace::default().samples && self.error.is_none() && self.time.is_none() {
            planned.samples = orders.samples.unwrap_or(self.samples);
            orders.samples.iter().for_each(|n| notes.add(format!("{n} paths a pixel, by the plan")));
        }
        Ok((planned, without, scene, few))
    }
}
