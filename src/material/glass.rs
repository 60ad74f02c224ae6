//! `type = "glass"`: thin parallel panes, light goes straight through. `index` (1.52), `depth` (0) the optical depth of one
//! pane along its normal (absorption coefficient x thickness, a spectrum), or `transmissivity` as Radiance's glass has it
//! (exp of minus that), `panes` (1) how many of them, with air between.
//!
//! All reflections between the surfaces add up without interference; s and p light keep apart on the way through
//! ([`crate::optics::fresnel::Stack`]).

use std::sync::Arc;

use glam::Vec3A;

use crate::Result;
use crate::material::kernel::specular::Specular;
use crate::material::read::Reader;
use crate::material::{Ink, Lobe, Lobes, Material, Polar, Site, Tint};
use crate::optics::fresnel::Stack;
use crate::spectral::Spectrum;

static BACK: Specular = Specular::Mirror;
static ON: Specular = Specular::Straight;

/// Thin panes.
pub struct Glass {
    /// Index of refraction.
    pub index: f32,
    /// Number of the optical depth.
    pub depth: u32,
    /// How many.
    pub panes: u32,
    /// Of what is sent back, and of what goes through.
    polar: [Polar; 2],
}

impl Material for Glass {
    fn lobes<'a>(&'a self, _: &Site, out: Vec3A, lobes: &mut Lobes<'a>) {
        let stack = Stack::new(out.z, self.index, self.panes);
        let sent = stack.share(0.0, true);
        for (kernel, back, odds) in [(&BACK, true, sent), (&ON, false, 1.0 - sent)] {
            let tint = Tint::Panes { depth: self.depth, stack, back };
            // An index of 1 sends nothing back; grazing light does not get through.
            let (factor, polar) = (if odds > 0.0 { 1.0 } else { 0.0 }, Some(&self.polar[usize::from(!back)]));
            lobes.push(Lobe { kernel, tint, factor, odds, polar });
        }
    }

    fn is_clear(&self) -> bool {
        true
    }
}

/// Reads one.
pub fn read(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let index = r.within("index", (1.0, 4.0), 1.52)?;
    let panes = r
        .keys
        .number("panes", "must be a whole number from 1 to 8", |x| (1.0..=8.0).contains(&x) && x.fract() == 0.0)?;
    let depth = match (r.spectrum("depth")?, r.spectrum("transmissivity")?) {
        (None, None) => Spectrum::Constant(0.0),
        (Some((depth, _)), None) if depth.range().0 >= 0.0 => depth,
        (Some((_, span)), None) => return Err(r.keys.wrong_key("depth", span, "must not be below 0")),
        (None, Some((t, span))) => {
            let (low, high) = t.range();
            if low <= 0.0 || high > 1.0 {
                let message = format!("runs from {low} to {high}; it must be above 0 and at most 1");
                return Err(r.keys.wrong_key("transmissivity", span, &message));
            }
            t.map(|t| -t.ln())
        }
        (Some(_), Some(_)) => return Err(r.keys.wrong("give depth or transmissivity, not both")),
    };
    let depth = r.ink(Ink::Depth(depth));
    let panes = panes.unwrap_or(1.0) as u32;
    let polar = [false, true].map(|through| Polar::Panes { depth, index, panes, through });
    Ok(Arc::new(Glass { index, depth, panes, polar }))
}
