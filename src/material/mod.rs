//! Materials: what a surface does to light, as lobes. A lobe is a [`Kernel`], how directions go, times a [`Tint`], what
//! happens to each wavelength, and a [`Polar`], what happens to its polarization. Directions are the same for all wavelengths, so that
//! geometry is computed once for all of them; kernels of which that is not true say what they are at one ([`Kernel::at`]).
//!
//! Frame: +z is the shading normal on the side that light leaves to. `out` is where light goes (to the eye), z > 0; `inc`
//! where it comes from: z > 0 for reflection, z < 0 for transmission. Radiance is transported: L(out) = integral of
//! f(out, inc) L(inc) |cos inc|.
//!
//! One material, one file whose head is its manual page; a new one also gets its line in [`read::KINDS`].

pub mod albedo;
pub mod boundary;
pub mod coated;
pub mod conductor;
pub mod dielectric;
pub mod diffuse;
pub mod film;
pub mod fluorescent;
pub mod glass;
pub mod grating;
pub mod kernel;
pub mod mirror;
pub mod mixture;
pub mod polar;
pub mod probe;
pub mod radiance;
pub mod read;
pub mod sheet;
pub mod subsurface;
pub mod texture;
pub mod tint;
pub mod translucent;
pub mod wavy;

use glam::{DVec3, Vec3A};

use kernel::lambert::Lambert;
pub use kernel::{Kernel, Turn, Value};
pub use polar::Polar;
pub use tint::{Base, Ink, Tint};

/// Where a material is asked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Site {
    /// Place in metres.
    pub place: DVec3,
    /// Texture coordinates.
    pub uv: [f32; 2],
    /// The mesh's own colour there, linear sRGB reflectance.
    pub colour: Option<[f32; 3]>,
    /// Light leaves to the front.
    pub front: bool,
}

/// One way in which a surface passes light on.
#[derive(Clone, Copy)]
pub struct Lobe<'a> {
    /// Where it goes.
    pub kernel: &'a dyn Kernel,
    /// What happens to each wavelength.
    pub tint: Tint,
    /// Factor of the whole lobe.
    pub factor: f32,
    /// About the share of light that it passes on, for choosing; 0 only where `factor` is.
    pub odds: f32,
    /// How it polarises; without, its light is unpolarised.
    pub polar: Option<&'a Polar>,
}

impl Lobe<'static> {
    /// Perfectly diffuse and reflects all: what irradiance is shown by.
    pub const WHITE: Lobe<'static> =
        Lobe { kernel: &Lambert { through: false }, tint: Tint::None, factor: 1.0, odds: 1.0, polar: None };
}

/// Most lobes of one surface: three parts of a mixture, four each.
pub const MOST_LOBES: usize = 12;

/// The lobes of a surface seen from one direction.
#[derive(Default)]
pub struct Lobes<'a> {
    list: [Option<Lobe<'a>>; MOST_LOBES],
    count: usize,
}

impl<'a> Lobes<'a> {
    /// Adds a lobe that passes on anything. There is room for [`MOST_LOBES`], more than any material that can be read has.
    pub fn push(&mut self, lobe: Lobe<'a>) {
        if lobe.factor > 0.0 && lobe.odds > 0.0 && self.count < MOST_LOBES {
            self.list[self.count] = Some(lobe);
            self.count += 1;
        }
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &Lobe<'a>> {
        self.list[..self.count].iter().flatten()
    }

    /// The lobes from the `from`-th on, their factors and odds times `k`.
    pub fn scale(&mut self, from: usize, k: f32) {
        for lobe in self.list[from..self.count].iter_mut().flatten() {
            lobe.factor *= k;
            lobe.odds *= k;
        }
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.count
    }

    /// A black surface.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Chooses one by lot with a number in 0..1, its factor divided by the chance; `None` for a black surface.
    pub fn choose(&self, lot: f32) -> Option<Lobe<'a>> {
        if self.count == 1 {
            return self.list[0];
        }
        let total: f32 = self.iter().map(|l| l.odds).sum();
        let mut left = lot * total;
        let mut chosen = None;
        for lobe in self.iter() {
            chosen = Some(Lobe { factor: lobe.factor * (total / lobe.odds), ..*lobe });
            if left < lobe.odds {
                break;
            }
            left -= lobe.odds;
        }
        chosen
    }
}

/// What a material needs of whoever follows light, beside lobes; most need none of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effects {
    /// Sends wavelengths into different directions ([`Kernel::at`]).
    pub disperses: bool,
    /// A medium fills its inside ([`Material::interior`]).
    pub fills: bool,
    /// Means nothing without polarization: a polariser, a retarder.
    pub polarises: bool,
    /// Light leaves it elsewhere than where it went in ([`Material::dipole`]).
    pub subsurface: bool,
    /// Has an axis in its surface ([`Material::axis`]).
    pub aligns: bool,
}

impl Effects {
    /// Those of both.
    pub fn or(self, o: Effects) -> Effects {
        Effects {
            disperses: self.disperses || o.disperses,
            fills: self.fills || o.fills,
            subsurface: self.subsurface || o.subsurface,
            polarises: self.polarises || o.polarises,
            aligns: self.aligns || o.aligns,
        }
    }

    /// Any.
    pub fn any(self) -> bool {
        self != Effects::default()
    }
}

/// What a surface is made of.
pub trait Material: Send + Sync {
    /// The lobes for light that leaves along `out` (see the module) at `site`.
    fn lobes<'a>(&'a self, site: &Site, out: Vec3A, lobes: &mut Lobes<'a>);

    /// Its one lobe, where it never has another: faster than a list.
    fn only(&self, _site: &Site) -> Option<Lobe<'_>> {
        None
    }

    /// Has lobes that go straight through ([`Kernel::is_straight`]): lamps are looked for behind it.
    fn is_clear(&self) -> bool {
        false
    }

    /// Number of the dipole by which a lobe's light has gone below the surface.
    fn dipole(&self, _lobe: &Lobe) -> Option<u32> {
        None
    }

    /// Does nothing to light: only what lies behind it differs.
    fn is_void(&self) -> bool {
        false
    }

    /// Needs the site's texture coordinates, colour or place.
    fn looks_at_site(&self) -> bool {
        false
    }

    /// What it needs beside.
    fn effects(&self) -> Effects {
        Effects::default()
    }

    /// Number of the medium behind its front.
    fn interior(&self) -> Option<u32> {
        None
    }

    /// A direction of the scene that the first tangent of the surface follows, where it has one.
    fn axis(&self, _site: &Site) -> Option<DVec3> {
        None
    }
}
