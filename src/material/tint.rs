//! What a lobe does to each wavelength, as data that a renderer applies to all its wavelengths at once.

use crate::material::fresnel;
use crate::spectral::Spectrum;

/// A spectrum that surfaces refer to by number; a renderer samples it once.
#[derive(Clone, Debug, PartialEq)]
pub enum Ink {
    /// Reflectance or transmittance, 0..1.
    Reflectance(Spectrum),
    /// Complex index of refraction n + ik of a metal, relative to the air outside.
    Index {
        /// Real part.
        n: Spectrum,
        /// Imaginary part.
        k: Spectrum,
    },
    /// Optical depth of a pane along its normal, 0 and more.
    Depth(Spectrum),
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
    /// Fresnel reflectance of a metal at the angle between half vector and direction.
    Metal(u32),
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
}

impl Tint {
    /// Depends on the direction that light comes from.
    pub fn turns(&self) -> bool {
        matches!(self, Tint::Metal(_))
    }

    /// The factor at one wavelength; `cos_half` only matters where [`Tint::turns`]. `rgb` are the basis spectra.
    pub fn at(&self, nm: f64, cos_half: f32, inks: &[Ink], rgb: &[Spectrum; 3]) -> f32 {
        let base = |b: Base| match b {
            Base::Grey(r) => r,
            Base::Ink(i) => inks[i as usize].reflectance(nm),
            Base::Rgb(c) => (0..3).map(|i| c[i] * rgb[i].at(nm) as f32).sum(),
        };
        match *self {
            Tint::None => 1.0,
            Tint::Base(b) => base(b),
            Tint::Beneath(b, k) => beneath(base(b), k),
            Tint::Metal(i) => match &inks[i as usize] {
                Ink::Index { n, k } => fresnel::conductor(cos_half, n.at(nm) as f32, k.at(nm) as f32),
                _ => 0.0,
            },
            Tint::Repeated { mean, albedo } => repeated(inks[mean as usize].reflectance(nm), albedo),
            Tint::Panes { depth, stack, back } => match &inks[depth as usize] {
                Ink::Depth(d) => stack.share(d.at(nm) as f32, back),
                _ => 0.0,
            },
        }
    }
}

impl Ink {
    fn reflectance(&self, nm: f64) -> f32 {
        match self {
            Ink::Reflectance(s) => s.at(nm) as f32,
            _ => 0.0,
        }
    }
}

/// See [`Tint::Beneath`].
#[inline(always)]
pub fn beneath(r: f32, k: f32) -> f32 {
    r * (1.0 - k) / (1.0 - k * r)
}

/// See [`Tint::Repeated`].
#[inline(always)]
pub fn repeated(mean: f32, albedo: f32) -> f32 {
    mean * mean * albedo / (1.0 - mean * (1.0 - albedo))
}
