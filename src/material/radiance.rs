//! `type = "plastic"`, `"metal"`, `"trans"`: Radiance's materials by its published formulas, so that its models mean the
//! same. `reflectance` is Radiance's colour, `specular` and `roughness` its fourth and fifth number, `transmitted` and
//! `transmitted_specular` trans's sixth and seventh.
//!
//! | part | plastic | metal | trans |
//! |---|---|---|---|
//! | highlight | specular | specular x colour | specular |
//! | diffuse | colour (1 - specular) | the same | colour (1 - specular) (1 - t) |
//! | straight on | | | colour (1 - specular) t ts |
//! | diffuse on | | | colour (1 - specular) t (1 - ts) |
//!
//! The highlight is [`crate::material::kernel::ward`]'s; with roughness 0 it is a mirror's, and where `specular` is at least
//! 0.018 its colour c goes to c + F (1 - c), F = exp(-5.85 cos) - 0.00202943064, Radiance's approximation to Fresnel's. There the
//! rest stays as it is, so that light grows at grazing angles; here it pays, on the way in as on the way out:
//! [`crate::material::kernel::complement`]'s form with F for E.

use std::sync::{Arc, LazyLock};

use glam::Vec3A;

use crate::Result;
use crate::material::albedo::Albedo;
use crate::material::kernel::complement::Complement;
use crate::material::kernel::lambert::Lambert;
use crate::material::kernel::lobe::Onward;
use crate::material::kernel::specular::Specular;
use crate::material::kernel::ward::Ward;
use crate::material::read::{Paint, Reader};
use crate::material::{Kernel, Lobe, Lobes, Material, Site, Tint};

/// Radiance's FRESTHRESH: weaker highlights are not raised.
const RAISED_FROM: f32 = 0.017999;
/// Roughness below which Radiance takes a surface as smooth: its square at 1e-6.
const SMOOTH: f32 = 1e-3;

static UP: Lambert = Lambert { through: false };
static DOWN: Lambert = Lambert { through: true };
static BACK: Specular = Specular::Mirror;
static ON: Specular = Specular::Straight;

/// What a smooth highlight leaves to the rest, back and through.
static RAISED: LazyLock<[Complement; 2]> = LazyLock::new(|| {
    let back = Complement::new(Albedo::from_fn(raised));
    [back.clone(), Complement { through: true, ..back }]
});

/// What a smooth highlight is raised by at an angle.
fn raised(cos: f32) -> f32 {
    ((-5.85 * cos).exp() - 0.002_029_430_6).max(0.0)
}

/// Radiance's "normal" material.
pub struct Normal {
    paint: Paint,
    metal: bool,
    specular: f32,
    transmitted: f32,
    transmitted_specular: f32,
    ward: Option<Ward>,
    onward: Option<Onward>,
}

impl Normal {
    /// Plastic, or metal.
    pub fn opaque(paint: Paint, metal: bool, specular: f32, roughness: f32) -> Normal {
        let ward = (roughness > SMOOTH).then_some(Ward { roughness });
        Normal { paint, metal, specular, transmitted: 0.0, transmitted_specular: 0.0, ward, onward: None }
    }

    /// Trans: t and ts besides.
    pub fn trans(paint: Paint, specular: f32, roughness: f32, transmitted: f32, transmitted_specular: f32) -> Normal {
        let onward = (roughness > SMOOTH).then(|| Onward::new(roughness));
        Normal { transmitted, transmitted_specular, onward, ..Normal::opaque(paint, false, specular, roughness) }
    }
}

impl Material for Normal {
    fn lobes<'a>(&'a self, site: &Site, out: Vec3A, lobes: &mut Lobes<'a>) {
        let colour = Tint::Base(self.paint.at(site));
        let smooth = self.ward.is_none() && self.specular >= RAISED_FROM;
        let raise = if smooth { raised(out.z) } else { 0.0 };
        let rest = 1.0 - self.specular;
        let mut push = |kernel: &'a dyn Kernel, tint, factor, share: f32| {
            lobes.push(Lobe { kernel, tint, factor, odds: factor * share, polar: None });
        };
        let highlight = self.ward.as_ref().map_or(&BACK as &dyn Kernel, |w| w);
        push(highlight, if self.metal { colour } else { Tint::None }, self.specular * (1.0 - raise), 1.0);
        push(&BACK, Tint::None, raise, 1.0);
        let (up, down): (&dyn Kernel, &dyn Kernel) = if smooth { (&RAISED[0], &RAISED[1]) } else { (&UP, &DOWN) };
        push(up, colour, rest * (1.0 - self.transmitted), 1.0 - raise);
        let on = rest * self.transmitted;
        push(down, colour, on * (1.0 - self.transmitted_specular), 1.0 - raise);
        // Straight on both ends have one angle.
        let straight = on * self.transmitted_specular * (1.0 - raise);
        push(self.onward.as_ref().map_or(&ON as &dyn Kernel, |o| o), colour, straight, 1.0);
    }

    fn is_clear(&self) -> bool {
        self.onward.is_none() && self.transmitted * self.transmitted_specular > 0.0
    }

    fn looks_at_site(&self) -> bool {
        self.paint.varies()
    }
}

/// Reads a plastic.
pub fn read_plastic(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let (specular, roughness) = highlight(r, 0.0)?;
    Ok(Arc::new(Normal::opaque(r.paint()?, false, specular, roughness)))
}

/// Reads a metal.
pub fn read_metal(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let (specular, roughness) = highlight(r, 0.9)?;
    Ok(Arc::new(Normal::opaque(r.paint()?, true, specular, roughness)))
}

/// Reads a trans.
pub fn read_trans(r: &mut Reader) -> Result<Arc<dyn Material>> {
    let (specular, roughness) = highlight(r, 0.0)?;
    let (t, ts) = (r.within("transmitted", (0.0, 1.0), 0.5)?, r.within("transmitted_specular", (0.0, 1.0), 0.0)?);
    Ok(Arc::new(Normal::trans(r.paint()?, specular, roughness, t, ts)))
}

fn highlight(r: &mut Reader, specular: f64) -> Result<(f32, f32)> {
    Ok((r.within("specular", (0.0, 1.0), specular)?, r.within("roughness", (0.0, 1.0), 0.0)?))
}
