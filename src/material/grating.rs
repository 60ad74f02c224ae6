//! `type = "grating"`: a mirror with rulings, as a CD or a spectrometer has. `pitch_nm` their period; `across`, a direction
//! of the scene at right angles to them, or `center`, a point about which they run in circles; `reflectance` (1) of the whole.
//! Light is shared between orders by `depth_nm` of rectangular grooves, half as wide as their period (scalar theory), or by
//! `orders`, the shares of order 1 and -1 each, of 2 and -2, and so on. The mirror's order has the rest, and what evanescent
//! orders cannot carry away.

use std::sync::Arc;

use glam::{DVec3, Vec3A};

use crate::Result;
use crate::material::kernel::order::Order;
use crate::material::kernel::specular::Specular;
use crate::material::read::Reader;
use crate::material::tint::{Rulings, Shares};
use crate::material::{Effects, Ink, Kernel, Lobe, Lobes, MOST_LOBES, Material, Site, Tint};
use crate::spectral::Spectrum;

static BACK: Specular = Specular::Mirror;

/// Which way the rulings run.
enum Run {
    /// The direction across them is the same everywhere.
    Across(DVec3),
    /// In circles about a point.
    About(DVec3),
}

/// A reflection grating.
pub struct Grating {
    ink: u32,
    rulings: Arc<Rulings>,
    /// All but the mirror's.
    orders: Vec<Order>,
    run: Run,
    two_sided: bool,
}

impl Material for Grating {
    fn lobes<'a>(&'a self, site: &Site, out: Vec3A, lobes: &mut Lobes<'a>) {
        if !(site.front || self.two_sided) {
            return;
        }
        let mut push = |kernel: &'a dyn Kernel, order| {
            let tint = Tint::Grating { rulings: self.ink, order, out: [out.x, out.y] };
            // Some wavelengths have an order that others have not: one that any has is looked at.
            let share = |i: u16| self.rulings.share(order, out.x, out.y, 300.0 + 30.0 * f32::from(i));
            let (sum, most) = (0..17).map(share).fold((0.0, 0.0f32), |(sum, most), s| (sum + s, most.max(s)));
            let odds = if most > 0.0 { (sum / 17.0).max(0.02) } else { 0.0 };
            lobes.push(Lobe { kernel, tint, factor: 1.0, odds, polar: None });
        };
        push(&BACK, 0);
        for order in &self.orders {
            push(order, order.m);
        }
    }

    fn looks_at_site(&self) -> bool {
        matches!(self.run, Run::About(_))
    }

    fn effects(&self) -> Effects {
        Effects { disperses: true, aligns: true, ..Effects::default() }
    }

    fn axis(&self, site: &Site) -> Option<DVec3> {
        Some(match self.run {
            Run::Across(direction) => direction,
            Run::About(center) => site.place - center,
        })
    }
}

/// Reads one.
pub fn read(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let pitch = r.keys.number("pitch_nm", "must be above 0 and at most 1e6", |x| x > 0.0 && x <= 1e6)?;
    let pitch_nm = pitch.ok_or_else(|| r.keys.wrong("key 'pitch_nm' is missing"))? as f32;
    let depth = r.keys.number("depth_nm", "must lie in 0 to 1e5", |x| (0.0..=1e5).contains(&x))?;
    let given: Option<Vec<f64>> = r.keys.get("orders")?;
    let shares = match (depth, given) {
        (Some(depth), None) => Shares::Grooves(depth as f32),
        (None, Some(all)) => {
            let fits = all.iter().all(|s| (0.0..=0.5).contains(s)) && 2.0 * all.iter().sum::<f64>() <= 1.0 + 1e-9;
            if all.is_empty() || 2 * all.len() + 1 > MOST_LOBES || !fits {
                return Err(r
                    .keys
                    .wrong("orders: one to five shares of order 1, 2, ..., twice whose sum is at most 1"));
            }
            Shares::Given(all.iter().map(|s| *s as f32).collect())
        }
        _ => return Err(r.keys.wrong("give depth_nm or orders")),
    };
    let (across, center) = (r.keys.get::<[f64; 3]>("across")?, r.keys.get::<[f64; 3]>("center")?);
    let run = match (across.map(DVec3::from), center.map(DVec3::from)) {
        (Some(d), None) if d.normalize_or_zero() != DVec3::ZERO => Run::Across(d.normalize()),
        (None, Some(c)) if c.is_finite() => Run::About(c * r.metres),
        _ => return Err(r.keys.wrong("give across, a direction, or center, a point")),
    };
    let reflectance = r.spectrum("reflectance")?.map_or(Spectrum::Constant(1.0), |s| s.0);
    if reflectance.range().0 < 0.0 || reflectance.range().1 > 1.0 {
        return Err(r.keys.wrong("reflectance must lie in 0 to 1"));
    }
    let most = shares.most();
    let rulings = Arc::new(Rulings { pitch_nm, shares, reflectance });
    let ink = r.ink(Ink::Grating(rulings.clone()));
    let order = |m: i32| Order { m, pitch_nm, nm: 555.0 };
    let orders = (1..=most).flat_map(|m| [order(m), order(-m)]).collect();
    Ok(Arc::new(Grating { ink, rulings, orders, run, two_sided: r.two_sided()? }))
}
