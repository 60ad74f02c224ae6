//! What a lobe does to each wavelength, as data that a renderer applies to all its wavelengths at once.

use std::sync::Arc;

use glam::Vec3A;

use crate::material::kernel::incoherent;
use crate::optics::dipole::Dipole;
use crate::optics::reradiation::Reradiation;
use crate::optics::roughness::Rough;
use crate::optics::{film, fresnel};
use crate::simd;
use crate::spectral::Spectrum;

/// A spectrum that surfaces refer to by number; a renderer samples it once.
#[derive(Clone, Debug, PartialEq)]
pub enum Ink {
    /// Reflectance or transmittance, 0..1.
    Reflectance(Spectrum),
    /// Complex index of refraction n + ik, relative to what is outside.
    Index {
        /// Real part.
        n: Spectrum,
        /// Imaginary part.
        k: Spectrum,
    },
    /// Optical depth of a pane along its normal, or of a metre of a body, 0 and more.
    Depth(Spectrum),
    /// Thin films between two media, from the side that light comes from.
    Film(Arc<film::Stack>),
    /// A fluorescent surface.
    Reradiation {
        /// What keeps its wavelength.
        reflectance: Spectrum,
        /// What does not.
        dye: Arc<Reradiation>,
    },
    /// Rulings.
    Grating(Arc<Rulings>),
    /// A body by its dipole.
    Dipole {
        /// Reduced scattering coefficient, 1/m.
        scattering: Spectrum,
        /// Absorption coefficient, 1/m.
        absorption: Spectrum,
        /// Index inside over outside.
        eta: f64,
    },
}

/// A reflection grating: its period and where light goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Rulings {
    /// Period, nm.
    pub pitch_nm: f32,
    /// How light is shared between orders.
    pub shares: Shares,
    /// What all of them are tinted by.
    pub reflectance: Spectrum,
}

/// Shares of a grating's orders. What evanescent ones would have stays in the mirror's order, so that nothing is lost and light
/// takes the same way back.
#[derive(Clone, Debug, PartialEq)]
pub enum Shares {
    /// Of orders 1, 2, ... and the same of -1, -2, ...
    Given(Vec<f32>),
    /// Of rectangular grooves of this depth in nm, half as wide as their period, by scalar theory.
    Grooves(f32),
}

impl Shares {
    /// Share of an order that is not 0, between two cosines.
    #[inline]
    fn of(&self, order: i32, cosines: f32, nm: f32) -> f32 {
        match self {
            Shares::Given(all) => all.get(order.unsigned_abs() as usize - 1).copied().unwrap_or(0.0),
            Shares::Grooves(_) if order % 2 == 0 => 0.0,
            Shares::Grooves(depth_nm) => {
                let half = std::f32::consts::PI * depth_nm * cosines / nm;
                (std::f32::consts::FRAC_2_PI / order as f32 * half.sin()).powi(2)
            }
        }
    }

    /// The highest order with a share.
    pub fn most(&self) -> i32 {
        match self {
            Shares::Given(all) => all.len() as i32,
            // What 1, 3 and 5 do not carry, 7 % of it, stays with the mirror.
            Shares::Grooves(_) => 5,
        }
    }
}

impl Rulings {
    /// Share of an order for light that leaves along `out` = (x across the rulings, y along them).
    pub fn share(&self, order: i32, x: f32, y: f32, nm: f32) -> f32 {
        let step = nm / self.pitch_nm;
        let cos = |x: f32| 1.0 - x * x - y * y;
        let cos_out = cos(x).max(0.0).sqrt();
        // Where the light of this order comes from, and where it goes besides.
        let inc = order as f32 * step - x;
        let cos_inc = if order == 0 { cos(inc).max(0.0) } else { cos(inc) };
        if order != 0 && cos_inc <= 0.0 {
            return 0.0;
        }
        if order != 0 {
            return self.shares.of(order, cos_out + cos_inc.sqrt(), nm);
        }
        let most = self.shares.most();
        let others = (-most..=most).filter(|m| *m != 0);
        let sent = |m: i32| {
            let cos2 = cos(m as f32 * step - inc);
            if cos2 > 0.0 { self.shares.of(m, cos_inc.sqrt() + cos2.sqrt(), nm) } else { 0.0 }
        };
        (1.0 - others.map(sent).sum::<f32>()).max(0.0)
    }
}

/// A reflectance before anything lies on top of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Base {
    /// The same at every wavelength.
    Grey(f32),
    /// Number of a reflectance.
    Ink(u32),
    /// Linear sRGB under D65, spread over the wavelengths by three basis spectra [Mallett 2019].
    Rgb([f32; 3]),
}

/// What happens to each wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tint {
    /// Nothing.
    None,
    /// A reflectance.
    Base(Base),
    /// A base R under a clear coat whose inner side sends the share k back: R (1 - k) / (1 - k R) [Saunderson 1942].
    Beneath(Base, f32),
    /// Fresnel reflectance of a metal.
    Metal {
        /// Number of its index.
        index: u32,
        /// Cosine between half vector and direction, once [`Tint::turned`].
        cos_half: f32,
    },
    /// Many reflections in a rough metal: E A^2 / (1 - A (1 - E)), A its mean Fresnel reflectance [Kulla 2017].
    Repeated {
        /// Number of the reflectance A.
        mean: u32,
        /// Mean albedo E of the roughness.
        albedo: f32,
    },
    /// Light that went through parallel panes, or was sent back by them.
    Panes {
        /// Number of the optical depth of one.
        depth: u32,
        /// Their Fresnel reflectances and how many.
        stack: fresnel::Stack,
        /// The part that is sent back.
        back: bool,
    },
    /// A clear boundary: what is reflected, or what comes through and is squeezed, (1 - R) / eta^2.
    Boundary {
        /// Number of the index behind the front.
        index: u32,
        /// Cosine of the way out with the normal.
        cos: f32,
        /// Light leaves to the front.
        front: bool,
        /// The part that comes through.
        through: bool,
    },
    /// A clear rough boundary's reflectance.
    Facet {
        /// Number of the index behind the front.
        index: u32,
        /// Light leaves to the front.
        front: bool,
        /// Cosine between half vector and direction, once [`Tint::turned`].
        cos_half: f32,
    },
    /// Radiance from beyond a clear boundary, 1 / eta^2.
    Squeezed {
        /// Number of the index behind the front.
        index: u32,
        /// Light leaves to the front.
        front: bool,
    },
    /// Thin films.
    Film {
        /// Number of the stack.
        film: u32,
        /// Cosine of the way out.
        cos: f32,
        /// The part that comes through; its radiance is not squeezed.
        through: bool,
    },
    /// A way through an absorbing body, or one of a medium on which nothing happened, over the chance of that: exp(-sigma_t m) / p.
    Inside {
        /// Number of the optical depth of a metre.
        depth: u32,
        /// Its length.
        metres: f32,
        /// 1 / p.
        over: f32,
    },
    /// Light scattered in a medium after a way through it, over the density with which the way was drawn: sigma_s exp(-sigma_t m) / p.
    Collision {
        /// Number of the extinction coefficient.
        depth: u32,
        /// Number of the scattering coefficient.
        scattering: u32,
        /// Length of the way, times its density.
        metres: f32,
        /// 1 / p, m: in thin air a path's products would else end beyond what floats can hold.
        over: f32,
    },
    /// What a medium of an even source function 1 gives off along a way, or scatters into it: the coefficient of either over sigma_t,
    /// times 1 - exp(-sigma_t m).
    Glow {
        /// Number of the extinction coefficient.
        depth: u32,
        /// Number of that coefficient: absorption's or scattering's.
        part: u32,
        /// Length of the way, times its density.
        metres: f32,
    },
    /// A null collision: 1 - sigma_t times the share.
    Null {
        /// Number of the extinction coefficient.
        depth: u32,
        /// Density there over the densest medium's extinction, m.
        share: f32,
    },
    /// Light that has gone below a surface: the dipole's R_d at a distance, 1/m2.
    Dipole {
        /// Number of the dipole.
        ink: u32,
        /// Distance between where light went in and comes out.
        metres: f32,
    },
    /// A fluorescent surface: its reflectance, and all that changes its wavelength.
    Fluorescent(u32),
    /// The mirror's part of a rough surface by wave optics, with a metal's reflectance.
    Coherent {
        /// Number of the index.
        index: u32,
        /// The surface as it is seen.
        rough: Rough,
        /// Cosine of the way out.
        cos: f32,
    },
    /// The rest of it, over the density that it is drawn with.
    Incoherent {
        /// Number of the index.
        index: u32,
        /// The surface.
        rough: Rough,
        /// Once [`Tint::turned`] the cosines of the way out, of where light comes from, and between the half vector and either.
        cosines: [f32; 3],
    },
    /// An order of a grating.
    Grating {
        /// Number of its rulings.
        rulings: u32,
        /// Number of the order.
        order: i32,
        /// Where light leaves to, across the rulings and along them.
        out: [f32; 2],
    },
    /// Some of the wavelengths: those of a path that has split.
    Window(Window),
    /// Diffraction at the eye's opening: v of the direction at 1 nm; each wavelength's density over the mean of all.
    Airy {
        /// pi D sin(angle) in nm.
        v_nm: f32,
    },
}

/// Some of `count` wavelengths side by side, those whose place lies within `width` / 2 of `middle`, times what makes up for the
/// rest: one of a comb of such windows, `each` wavelengths apart, whose place is chosen by lot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Of the window, 0..count.
    pub middle: f32,
    /// At least 1.
    pub width: f32,
    /// Wavelengths from one window to the next.
    pub each: f32,
    /// All of them.
    pub count: f32,
}

impl Window {
    /// Factor of wavelength number `i`.
    #[inline]
    pub fn share(&self, i: usize) -> f32 {
        let (place, half) = (i as f32 + 0.5, 0.5 * self.width);
        // Open at one end, so that windows side by side share no wavelength.
        let off = place - self.middle;
        if off <= -half || off > half {
            return 0.0;
        }
        // The chance that one of the comb's windows holds it.
        let reach = (place + half).min(self.count) - (place - half).max(0.0);
        self.each / reach
    }
}

impl Tint {
    /// Takes in a way through the same medium that follows on it: one exponential for both. False where it is none.
    #[inline]
    pub fn lengthen(&mut self, by: &Tint) -> bool {
        let Tint::Inside { depth: other, metres: more, over: k } = *by else { return false };
        match self {
            Tint::Inside { depth, metres, over } | Tint::Collision { depth, metres, over, .. } if *depth == other => {
                *metres += more;
                *over *= k;
                true
            }
            _ => false,
        }
    }

    /// Depends on the direction that light comes from.
    pub fn turns(&self) -> bool {
        matches!(self, Tint::Metal { .. } | Tint::Facet { .. } | Tint::Incoherent { .. })
    }

    /// The same for a pair of directions, in the frame of [`crate::material`].
    #[inline]
    pub fn turned(&self, out: Vec3A, inc: Vec3A) -> Tint {
        match *self {
            Tint::Metal { index, .. } => Tint::Metal { index, cos_half: cos_half(out, inc) },
            Tint::Facet { index, front, .. } => Tint::Facet { index, front, cos_half: cos_half(out, inc) },
            Tint::Incoherent { index, rough, .. } => {
                Tint::Incoherent { index, rough, cosines: [out.z, inc.z, cos_half(out, inc)] }
            }
            other => other,
        }
    }

    /// The factor at one wavelength, of a tint that is turned where it [`Tint::turns`]. `rgb` are the basis spectra.
    pub fn at(&self, nm: f64, inks: &[Ink], rgb: &[Spectrum; 3]) -> f32 {
        let base = |b: Base| match b {
            Base::Grey(r) => r,
            Base::Ink(i) => inks[i as usize].reflectance(nm),
            Base::Rgb(c) => (0..3).map(|i| c[i] * rgb[i].at(nm) as f32).sum(),
        };
        let metal = |i: u32, cos: f32| match &inks[i as usize] {
            Ink::Index { n, k } => fresnel::conductor(cos, n.at(nm) as f32, k.at(nm) as f32),
            _ => 0.0,
        };
        match *self {
            Tint::None => 1.0,
            Tint::Base(b) => base(b),
            Tint::Beneath(b, k) => beneath(base(b), k),
            Tint::Metal { index, cos_half } => metal(index, cos_half),
            Tint::Repeated { mean, albedo } => repeated(inks[mean as usize].reflectance(nm), albedo),
            Tint::Panes { depth, stack, back } => match &inks[depth as usize] {
                Ink::Depth(d) => stack.share(d.at(nm) as f32, back),
                _ => 0.0,
            },
            Tint::Boundary { index, cos, front, through } => match &inks[index as usize] {
                Ink::Index { n, .. } => boundary(cos, n.at(nm) as f32, front, through),
                _ => 0.0,
            },
            Tint::Facet { index, front, cos_half } => match &inks[index as usize] {
                Ink::Index { n, .. } => boundary(cos_half, n.at(nm) as f32, front, false),
                _ => 0.0,
            },
            Tint::Squeezed { index, front } => match &inks[index as usize] {
                Ink::Index { n, .. } => squeezed(n.at(nm) as f32, front),
                _ => 0.0,
            },
            Tint::Film { film, cos, through } => match &inks[film as usize] {
                Ink::Film(stack) => {
                    let shares = stack.at(cos.into(), nm);
                    (if through { shares.through.mean() } else { shares.back.mean() }) as f32
                }
                _ => 0.0,
            },
            Tint::Inside { depth, metres, over } => over * simd::exp(-inks[depth as usize].depth(nm) * metres),
            Tint::Collision { depth, scattering, metres, over } => {
                over * inks[scattering as usize].depth(nm) * simd::exp(-inks[depth as usize].depth(nm) * metres)
            }
            Tint::Glow { depth, part, metres } => {
                glow(inks[depth as usize].depth(nm), inks[part as usize].depth(nm), metres)
            }
            Tint::Null { depth, share } => 1.0 - inks[depth as usize].depth(nm) * share,
            Tint::Dipole { ink, metres } => match &inks[ink as usize] {
                Ink::Dipole { scattering, absorption, eta } => {
                    Dipole::new(scattering.at(nm), absorption.at(nm), *eta).radial(metres.into()) as f32
                }
                _ => 0.0,
            },
            Tint::Fluorescent(i) => inks[i as usize].reflectance(nm),
            Tint::Coherent { index, rough, cos } => metal(index, cos) * rough.coherent(cos, nm as f32),
            Tint::Incoherent { index, rough, cosines } => {
                metal(index, cosines[2]) * Scattering::new(&rough, cosines).at(nm as f32)
            }
            Tint::Grating { rulings, order, out: [x, y] } => match &inks[rulings as usize] {
                Ink::Grating(r) => r.reflectance.at(nm) as f32 * r.share(order, x, y, nm as f32),
                _ => 0.0,
            },
            // Of many wavelengths only.
            Tint::Window(_) | Tint::Airy { .. } => 1.0,
        }
    }
}

impl Ink {
    fn depth(&self, nm: f64) -> f32 {
        if let Ink::Depth(s) = self { s.at(nm) as f32 } else { 0.0 }
    }

    fn reflectance(&self, nm: f64) -> f32 {
        match self {
            Ink::Reflectance(s) | Ink::Reradiation { reflectance: s, .. } => s.at(nm) as f32,
            _ => 0.0,
        }
    }
}

/// Cosine between the half vector of a reflection and its directions.
pub fn cos_half(out: Vec3A, inc: Vec3A) -> f32 {
    (out + inc).normalize_or_zero().dot(out).clamp(0.0, 1.0)
}

/// See [`Tint::Boundary`].
#[inline(always)]
pub fn boundary(cos: f32, n: f32, front: bool, through: bool) -> f32 {
    let eta = if front { n } else { 1.0 / n };
    let inside2 = 1.0 - (1.0 - cos * cos) / (eta * eta);
    let inside = inside2.max(0.0).sqrt();
    let s = (cos - eta * inside) / (cos + eta * inside);
    let p = (eta * cos - inside) / (eta * cos + inside);
    let back = if inside2 > 0.0 { 0.5 * (s * s + p * p) } else { 1.0 };
    if through { (1.0 - back) / (eta * eta) } else { back }
}

/// See [`Tint::Squeezed`].
#[inline(always)]
pub fn squeezed(n: f32, front: bool) -> f32 {
    if front { 1.0 / (n * n) } else { n * n }
}

/// See [`Tint::Incoherent`]: without the metal, for any wavelength.
pub struct Scattering {
    seen: Rough,
    cosines: [f32; 3],
    /// Shadowing over the density that the direction was drawn with.
    factor: f32,
}

impl Scattering {
    /// Between two directions by their cosines, and that of the half vector with either.
    pub fn new(rough: &Rough, cosines: [f32; 3]) -> Scattering {
        let [out, inc, half] = cosines;
        // Of |out + inc|^2 = 4 half^2 the plane sees what the normal does not.
        let across2 = (4.0 * half * half - (out + inc) * (out + inc)).max(0.0);
        let density = incoherent::density(rough, out, inc, across2);
        let shadow = rough.shadow(out) * rough.shadow(inc);
        // Where the lobe is next to nothing it is not drawn either.
        let factor = if density > 1e-30 { shadow / density } else { 0.0 };
        Scattering { seen: rough.seen(out, inc), cosines, factor }
    }

    /// At a wavelength in nm.
    #[inline(always)]
    pub fn at(&self, nm: f32) -> f32 {
        let [out, inc, half] = self.cosines;
        self.seen.incoherent_cos(out, inc, half, self.factor, nm)
    }
}

/// See [`Tint::Beneath`].
#[inline(always)]
pub fn beneath(r: f32, k: f32) -> f32 {
    r * (1.0 - k) / (1.0 - k * r)
}

/// See [`Tint::Glow`].
#[inline(always)]
pub fn glow(extinction: f32, part: f32, metres: f32) -> f32 {
    let depth = extinction * metres;
    // Where the difference would lose its digits, the series; chosen without a branch.
    let thin = part * metres * (1.0 - depth * (0.5 - depth * (1.0 / 6.0 - depth / 24.0)));
    let thick = part / extinction * (1.0 - simd::exp(-depth));
    if depth < 0.05 { thin } else { thick }
}

/// See [`Tint::Repeated`].
#[inline(always)]
pub fn repeated(mean: f32, albedo: f32) -> f32 {
    mean * mean * albedo / (1.0 - mean * (1.0 - albedo))
}
