//! `type = "film"`: thin films whose reflections interfere: soap, oxide, oil, coatings. `layers`, from the front on, tables of
//! `index` (and `k`) with `thickness_nm`; below them a metal (`metal` = Ag, Al, Au, Cu, or spectra `n` and `k`), or a body
//! of an `index`, or, with neither, air: then light goes straight on.
//!
//! Each band of wavelengths sees its mean: fringes finer than the bands are grey. A body's dispersion turns no light apart here.

use std::sync::Arc;

use glam::Vec3A;

use crate::Result;
use crate::material::conductor::read_metal;
use crate::material::dielectric::read_index;
use crate::material::kernel::specular::Specular;
use crate::material::read::{Reader, spectrum};
use crate::material::{Ink, Lobe, Lobes, Material, Polar, Site, Tint};
use crate::optics::film::{Medium, Stack};
use crate::spectral::Spectrum;

static BACK: Specular = Specular::Mirror;
static ON: Specular = Specular::Straight;

/// A film is looked at for what it sends back, little as that is: so often at least a path is sent there, and through.
const OFTEN: f32 = 0.25;
/// Nodes of the tables by which lots are cast.
const NODES: usize = 33;

/// What is seen of the films from one side.
struct Side {
    ink: u32,
    on: Option<Specular>,
    polar: [Polar; 2],
    /// About the share that is thrown back, by cosine, and that goes through.
    shares: Vec<[f32; 2]>,
}

/// Films on something, or on nothing.
pub struct Films {
    sides: Vec<Side>,
    free: bool,
}

impl Films {
    /// `stack` from the front; numbers of it and of the same from behind, where that can be seen.
    pub fn new(stack: &Stack, inks: &[u32], free: bool) -> Films {
        let stacks = [stack.clone(), stack.reversed()];
        let side = |(i, ink): (usize, &u32)| {
            let eta = stacks[i].below.n.at(555.0) / stacks[i].outside.n.at(555.0);
            let on = match (free, stack.below.is_clear()) {
                (true, _) => Some(ON),
                (false, true) => Some(Specular::Bent { eta: eta as f32 }),
                (false, false) => None,
            };
            let node = |k: usize| {
                let shares = stacks[i].mean((k as f64 / (NODES - 1) as f64).max(1e-3), 420.0, 680.0);
                [shares.back.mean(), shares.through.mean()].map(|s| (s as f32).max(OFTEN))
            };
            let polar = [false, true].map(|through| Polar::Film { film: *ink, through });
            Side { ink: *ink, on, polar, shares: (0..NODES).map(node).collect() }
        };
        Films { sides: inks.iter().enumerate().map(side).collect(), free }
    }
}

impl Material for Films {
    fn lobes<'a>(&'a self, site: &Site, out: Vec3A, lobes: &mut Lobes<'a>) {
        let Some(side) = self.sides.get(usize::from(!site.front)) else { return };
        let [back, on] = side.shares[((out.z * (NODES - 1) as f32) as usize).min(NODES - 1)];
        let tint = |through| Tint::Film { film: side.ink, cos: out.z, through };
        let polar = side.polar.each_ref().map(Some);
        lobes.push(Lobe { kernel: &BACK, tint: tint(false), factor: 1.0, odds: back, polar: polar[0] });
        if let Some(kernel) = &side.on {
            lobes.push(Lobe { kernel, tint: tint(true), factor: 1.0, odds: on, polar: polar[1] });
        }
    }

    fn is_clear(&self) -> bool {
        self.free
    }
}

/// Reads one.
pub fn read(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let mut layers = Vec::new();
    let (folder, tables) = (r.folder, r.keys.array("layers")?);
    for mut k in tables {
        let Some((n, span)) = spectrum(&mut k, "index", folder)? else { return Err(k.wrong("key 'index' is missing")) };
        if n.range().0 <= 0.0 || n.range().1 > 10.0 {
            return Err(k.wrong_key("index", span, "must be above 0 and at most 10"));
        }
        let absorbs = spectrum(&mut k, "k", folder)?.map_or(Spectrum::Constant(0.0), |s| s.0);
        if absorbs.range().0 < 0.0 {
            return Err(k.wrong("k must not be below 0"));
        }
        let right = "must lie in 0 to 1e8";
        let thickness = k.number("thickness_nm", right, |x| (0.0..=1e8).contains(&x))?;
        let thickness = thickness.ok_or_else(|| k.wrong("key 'thickness_nm' is missing"))?;
        k.finish()?;
        layers.push((Medium { n: n.extended(), k: absorbs.extended() }, thickness));
    }
    if layers.is_empty() || layers.len() > 64 {
        return Err(r.keys.wrong("layers: expected 1 to 64 tables of index and thickness_nm"));
    }
    let has = |key: &str| r.keys.peek::<toml::Value>(key).is_some();
    let (on_metal, on_body) = (has("metal") || has("n"), has("index"));
    let below = match (on_metal, on_body) {
        (true, true) => return Err(r.keys.wrong("give a metal or an index, not both")),
        (true, false) => {
            let (n, k) = read_metal(r)?;
            Medium { n, k }
        }
        (false, true) => match read_index(r, 1.5)? {
            (n, None) => Medium::clear(n.into()),
            (_, Some((_, index))) => Medium { n: (*index.n).clone(), k: Spectrum::Constant(0.0) },
        },
        (false, false) => Medium::clear(1.0),
    };
    let stack = Stack { outside: Medium::clear(1.0), layers, below };
    let mut inks = vec![r.ink(Ink::Film(Arc::new(stack.clone())))];
    if stack.below.is_clear() {
        inks.push(r.ink(Ink::Film(Arc::new(stack.reversed()))));
    }
    Ok(Arc::new(Films::new(&stack, &inks, !on_metal && !on_body)))
}
